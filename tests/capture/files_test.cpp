#include "capture/files.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include "capture/error.h"
#include "tests/temporary_folder.h"

namespace dualpixel {
namespace {

namespace fs = std::filesystem;

std::string new_folder_refusal(const std::string& path) {
  return message_of<InputError>([&] { NewFolder(path, "capture.json").commit(); });
}

TEST(NewFolder, AppearsWholeOrNotAtAll) {
  const TemporaryFolder folder;
  {
    NewFolder output(folder / "out", "capture.json");
    write_file(output.path() + "/a", "bytes");
    EXPECT_FALSE(fs::exists(folder / "out"));
    EXPECT_EQ(fs::path(output.path()).parent_path(), folder.path);
  }
  EXPECT_TRUE(folder.names().empty());
  {
    NewFolder output(folder / "out/", "capture.json");
    write_file(output.path() + "/a", "bytes");
    output.commit();
  }
  EXPECT_EQ(folder.names(), std::set<std::string>{"out"});
  EXPECT_EQ(read_bytes(folder / "out/a"), "bytes");
}

TEST(NewFolder, ReplacesItsOwnKindAndEmptyFoldersOnly) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "empty");
  fs::create_directory(folder / "ours");
  write_bytes(folder / "ours/capture.json", "{}");
  write_bytes(folder / "ours/old", "old");
  for (const char* name : {"empty", "ours"}) {
    NewFolder output(folder / name, "capture.json");
    write_file(output.path() + "/new", "new");
    output.commit();
  }
  EXPECT_EQ(folder.names(), (std::set<std::string>{"empty", "ours", "ours.old"}));
  EXPECT_TRUE(fs::exists(folder / "ours/new"));
  EXPECT_FALSE(fs::exists(folder / "ours/old"));
  EXPECT_TRUE(fs::exists(folder / "ours.old/old"));

  fs::create_directory(folder / "precious");
  write_bytes(folder / "precious/thesis", "text");
  write_bytes(folder / "file", "text");
  EXPECT_NE(new_folder_refusal(folder / "precious").find("will not be overwritten"), std::string::npos);
  EXPECT_EQ(new_folder_refusal(folder / "file"), folder / "file" + ": exists and is not a folder");
  EXPECT_EQ(read_bytes(folder / "precious/thesis"), "text");
  EXPECT_EQ(read_bytes(folder / "file"), "text");
}

TEST(NewFolder, WhatWouldBeLostIsKeptEachTimeOrNothingIsReplaced) {
  const TemporaryFolder folder;
  const auto write = [&](const std::string& name, const std::string& extra) {
    NewFolder output(name, "capture.json");
    write_file(output.path() + "/capture.json", extra);
    output.commit();
    write_bytes(name + "/notes", extra);
  };
  for (const char* extra : {"1", "2", "3"}) write(folder / "out", extra);
  EXPECT_EQ(folder.names(), (std::set<std::string>{"out", "out.old", "out.old2"}));
  EXPECT_EQ(read_bytes(folder / "out.old/notes"), "1");
  EXPECT_EQ(read_bytes(folder / "out.old2/notes"), "2");
  // within its folders, too
  fs::create_directories(folder / "out/truth");
  fs::remove(folder / "out/notes");
  {
    NewFolder output(folder / "out", "capture.json");
    write_file(output.path() + "/capture.json", "4");
    fs::create_directory(output.path() + "/truth");
    write_bytes(folder / "out/truth/notes", "3");
    output.commit();
  }
  EXPECT_EQ(read_bytes(folder / "out.old3/truth/notes"), "3");
  EXPECT_EQ(read_bytes(folder / "out/capture.json"), "4");
  const std::string longest = folder / std::string(255, 'a');  // there is no longer name
  write(longest, "4");
  EXPECT_THROW(write(longest, "5"), InputError);
  EXPECT_EQ(read_bytes(longest + "/notes"), "4");
  EXPECT_EQ(read_bytes(longest + "/capture.json"), "4");
}

TEST(NewFolder, ChecksAgainBeforeItReplaces) {
  const TemporaryFolder folder;
  NewFolder output(folder / "out", "capture.json");
  fs::create_directory(folder / "out");
  write_bytes(folder / "out/thesis", "text");
  EXPECT_THROW(output.commit(), InputError);
  EXPECT_EQ(read_bytes(folder / "out/thesis"), "text");
}

TEST(NewFolder, TwoWritersAtOnceLeaveOneWholeFolder) {
  const TemporaryFolder folder;
  {
    NewFolder first(folder / "out", "capture.json"), second(folder / "out", "capture.json");
    write_file(first.path() + "/capture.json", "1");
    write_file(second.path() + "/capture.json", "2");
    second.commit();
    first.commit();
  }
  EXPECT_EQ(folder.names(), std::set<std::string>{"out"});
  EXPECT_EQ(read_bytes(folder / "out/capture.json"), "1");
}

TEST(NewFolder, RefusesPathsThatCannotBeWritten) {
  const TemporaryFolder folder;
  write_bytes(folder / "file", "text");
  for (const std::string& path :
       {folder / "file/out", folder / "file/new/out", folder / (std::string(1000, 'x') + "/out"),
        std::string("/proc/dualpixel_out"), std::string(), folder / std::string(1000, 'x')}) {
    const std::string message = new_folder_refusal(path);
    EXPECT_NE(message, "") << path;
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
  EXPECT_EQ(folder.names(), std::set<std::string>{"file"});
}

TEST(NewFolder, MakesTheFoldersOnTheWay) {
  const TemporaryFolder folder;
  NewFolder output(folder / "a/b/out", "capture.json");
  write_file(output.path() + "/capture.json", "1");
  output.commit();
  EXPECT_EQ(read_bytes(folder / "a/b/out/capture.json"), "1");
  replace_file(folder / "c/d/page.html", "2");
  EXPECT_EQ(read_bytes(folder / "c/d/page.html"), "2");
}

TEST(NewFolder, FollowsALinkToItsTarget) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "real");
  fs::create_directory_symlink("real", folder / "link");
  NewFolder output(folder / "link", "capture.json");
  write_file(output.path() + "/a", "x");
  output.commit();
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_TRUE(fs::exists(folder / "real/a"));
}

// In a process of its own, which must end afterwards.
TEST(StopOutputsDeathTest, NoneIsBegunOrFinishedAndRemovalLeavesNothing) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto end = [] {
    const TemporaryFolder folder;
    NewFolder output(folder / "out", "capture.json");
    std::atomic<bool> stopped = false;
    const auto afterwards = [&](const std::function<void()>& work) {
      std::thread([&stopped, work] {
        while (!stopped) std::this_thread::yield();
        work();
      }).detach();
    };
    afterwards([&] {
      write_file(output.path() + "/a", "x");
      output.commit();
    });
    afterwards([&] { replace_file(folder / "file", "x"); });
    afterwards([&] { NewFolder(folder / "another", "capture.json").commit(); });
    stop_outputs();
    stopped = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    remove_unfinished_outputs();
    const bool is_empty = folder.names().empty();
    fs::remove_all(folder.path);
    _exit(is_empty ? 0 : 1);
  };
  EXPECT_EXIT(end(), testing::ExitedWithCode(0), "");
}

TEST(HashOf, IsXxh64) {
  // The reference implementation's values for seed 0.
  EXPECT_EQ(hash_of(""), "ef46db3751d8e999");
  EXPECT_EQ(hash_of("abc"), "44bc2cf5ad770999");
}

TEST(ReplaceFile, ReplacesWholeOrNotAtAll) {
  const TemporaryFolder folder;
  replace_file(folder / "report.html", "one");
  replace_file(folder / "report.html", "two");
  EXPECT_EQ(read_bytes(folder / "report.html"), "two");
  fs::create_directory(folder / "sub");
  EXPECT_THROW(replace_file(folder / "sub", "x"), InputError);
  EXPECT_THROW(replace_file(folder / "report.html/x", "x"), InputError);
  EXPECT_THROW(replace_file("/dev/full", "x"), InputError);
  EXPECT_EQ(folder.names(), (std::set<std::string>{"report.html", "sub"}));
}

TEST(ReplaceFile, WhatAKilledProcessOfTheSameNumberLeftIsNotInTheWay) {
  const TemporaryFolder folder;
  for (int i = 0; i < 200; ++i) fs::create_directory(folder / fmt::format(".dualpixel-{}-{}.tmp", getpid(), i));
  replace_file(folder / "a", "one");
  EXPECT_EQ(read_bytes(folder / "a"), "one");
}

TEST(HoldsNothing, ButWhatKilledProgramsLeft) {
  const TemporaryFolder folder;
  EXPECT_TRUE(holds_nothing(folder.path.string()));
  fs::create_directory(folder / ".dualpixel-1-0.tmp");
  EXPECT_TRUE(holds_nothing(folder.path.string()));
  write_bytes(folder / "a", "x");
  EXPECT_FALSE(holds_nothing(folder.path.string()));
  EXPECT_FALSE(holds_nothing(folder / "a"));
  EXPECT_FALSE(holds_nothing(folder / "none"));
}

TEST(RequireWritable, RefusesWhatReplaceFileWouldAndLeavesNothing) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "sub");
  fs::create_symlink("loop", folder / "loop");
  require_writable(folder / "new.png");
  for (const std::string& path : {folder / "sub", folder / "loop", folder / (std::string(300, 'a') + ".png"),
                                  std::string("/dev/full"), std::string("/proc/x.png"), std::string()}) {
    SCOPED_TRACE(path);
    EXPECT_THROW(require_writable(path), InputError);
  }
  EXPECT_EQ(folder.names(), (std::set<std::string>{"sub", "loop"}));
}

TEST(FinalPath, IsWhereTheFolderWillBe) {
  const TemporaryFolder folder;
  std::string temporary;
  {
    const NewFolder out(folder / "out", "marker");
    temporary = out.path();
    EXPECT_NE(temporary, folder / "out");
    EXPECT_EQ(final_path(temporary), folder / "out");
    const NewFolder inner(temporary + "/inner", "marker");
    EXPECT_EQ(final_path(inner.path() + "/a.txt"), folder / "out/inner/a.txt");
    EXPECT_EQ(final_path(folder / "elsewhere"), folder / "elsewhere");
  }
  EXPECT_EQ(final_path(temporary), temporary) << "nothing is being written there any more";
}

TEST(NewFolder, MessagesNameThePathThatWasAskedFor) {
  const TemporaryFolder folder;
  const NewFolder out(folder / "out", "marker");
  const std::string direct = message_of<InputError>([&] { write_file(out.path() + "/none/a.txt", "x"); });
  EXPECT_TRUE(direct.starts_with((folder / "out") + "/none/a.txt: ")) << direct;
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small = {.rlim_cur = 1000, .rlim_max = before.rlim_max};
  signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string replaced = message_of<InputError>([&] { replace_file(out.path() + "/b", std::string(9999, 'x')); });
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(replaced, (folder / "out") + "/b: cannot be written: File too large");
}

}  // namespace
}  // namespace dualpixel
