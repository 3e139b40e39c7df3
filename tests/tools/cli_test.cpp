#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "capture/capture.h"
#include "capture/image/image_io.h"
#include "pipeline/portrait/result_io.h"
#include "tests/pipeline/portrait/synthetic.h"
#include "tests/scenes/people/toy_people.h"
#include "tests/temporary_folder.h"
#include "tests/tools/run_command.h"

namespace dualpixel {
namespace {

TEST(Cli, EachSubcommandHasHelpWithAnExample) {
  const Outcome program = run_command("--help");
  EXPECT_EQ(program.status, 0);
  for (const std::string name : {"simulate", "portrait", "score", "report", "info", "bench"}) {
    EXPECT_NE(program.out.find("\n  " + name), std::string::npos) << program.out;
    const Outcome command = run_command(name + " --help");
    EXPECT_EQ(command.status, 0) << name;
    EXPECT_NE(command.out.find("dualpixel " + name + " "), std::string::npos) << command.out;
    EXPECT_NE(command.out.find("Example"), std::string::npos) << command.out;
    EXPECT_EQ(command.err, "");
  }
}

TEST(Cli, SeedsOutOfRangeAreRefused) {
  for (const char* arguments : {"simulate x.json -o y --seed=-1", "simulate x.json -o y --seed=1x",
                                "portrait x -o y --seed=18446744073709551616", "people -o /dev/null/y --seed=-1"}) {
    const Outcome outcome = run_command(arguments);
    expect_one_line_refusal(outcome);
    EXPECT_NE(outcome.err.find("--seed"), std::string::npos) << outcome.err;
  }
}

TEST(Cli, SaysItsVersion) {
  const Outcome outcome = run_command("--version");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.out, "dualpixel " DUALPIXEL_VERSION "\n");
}

TEST(Cli, BadUsageIsOneLineAndStatus2) {
  for (const char* arguments : {"", "frobnicate", "info", "info --frobnicate x", "info $'x\\n--y'"}) {
    SCOPED_TRACE(arguments);
    expect_one_line_refusal(run_command(arguments));
  }
  EXPECT_NE(run_command("simulat").err.find("'simulat' is not a command; did you mean 'simulate'?"), std::string::npos);
  EXPECT_NE(run_command("experiment failure").err.find("'failure' is not a command; did you mean 'failures'?"),
            std::string::npos);
  EXPECT_EQ(run_command("info").err.find("is not a command"), std::string::npos);
}

TEST(Cli, MisspeltOptionsNameTheNearest) {
  const auto expect = [](const std::string& arguments, const std::string& message) {
    const Outcome outcome = run_command(arguments);
    expect_one_line_refusal(outcome);
    EXPECT_EQ(outcome.err, "dualpixel: " + message + "\n");
  };
  expect("simulate x.json -o y --noise-fractoin 3",
         "--noise-fractoin: no such option; did you mean '--noise-fraction'? (see 'dualpixel simulate --help')");
  expect("portrait x --mtcher=split",  // though -o is missing, too
         "--mtcher: no such option; did you mean '--matcher'? (see 'dualpixel portrait --help')");
  expect("experiment failures --outptu x",
         "--outptu: no such option; did you mean '--output'? (see 'dualpixel experiment failures --help')");
  expect("--max-tim 3 info x", "--max-tim: no such option; did you mean '--max-time'? (see 'dualpixel info --help')");
  expect("--versoin", "--versoin: no such option; did you mean '--version'? (see 'dualpixel --help')");
  expect("bench rendr", "bench rendr: is no scene and no benchmark; did you mean 'render'?");
  expect("info x --frobnicate", "--frobnicate: no such option (see 'dualpixel info --help')");
}

TEST(CliInfo, DescribesACapture) {
  const TemporaryFolder folder;
  Capture capture;
  capture.camera = {.name = "toy",
                    .width_px = 16,
                    .height_px = 8,
                    .pixel_pitch_um = 1.4,
                    .focal_length_mm = 4.4,
                    .f_number = 1.8,
                    .focus_distance_m = 1.25};
  capture.exposure = {.bits = 10, .black_level_dn = 64, .white_level_dn = 1023};
  capture.frames.push_back({.left = ImageU16(8, 2, 1, 100), .right = ImageU16(8, 2, 1, 100)});
  write_capture(capture, folder / "capture");

  const Outcome text = run_command("info '" + (folder / "capture") + "'");
  EXPECT_EQ(text.status, 0) << text.err;
  EXPECT_NE(text.out.find("toy"), std::string::npos);
  const Outcome as_json = run_command("info --json '" + (folder / "capture") + "'");
  EXPECT_EQ(as_json.status, 0);
  const auto description = nlohmann::json::parse(as_json.out);
  EXPECT_EQ(description["kind"], "capture");
  EXPECT_EQ(description["camera"]["focus_distance_m"], 1.25);
  EXPECT_EQ(description["frames"]["count"], 1);
  EXPECT_EQ(description["frames"]["dp_width_px"], 8);
  EXPECT_EQ(description["truth"], false);
  EXPECT_EQ(description["manifest"], "verified");

  write_bytes(folder / "capture/frames/000_left.png", "x");
  expect_one_line_refusal(run_command("info '" + (folder / "capture") + "'"));
}

TEST(CliInfo, DescribesPicturesScenesAndGltf) {
  const TemporaryFolder folder;
  write_png8(folder / "a.png", Image(5, 3, 3, 0.5f));
  const auto picture = nlohmann::json::parse(run_command("info --json '" + (folder / "a.png") + "'").out);
  EXPECT_EQ(picture["kind"], "picture");
  EXPECT_EQ(picture["width_px"], 5);
  EXPECT_EQ(picture["height_px"], 3);
  EXPECT_EQ(picture["channels"], nlohmann::json({"R", "G", "B"}));

  const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  write_bytes(folder / "a.bin", std::string(reinterpret_cast<const char*>(positions), sizeof(positions)));
  write_bytes(folder / "a.gltf", R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                   "min": [0, 0, 0], "max": [1, 1, 0]}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": "a.bin", "byteLength": 36}]})");
  const Outcome gltf = run_command("info --json '" + (folder / "a.gltf") + "'");
  ASSERT_EQ(gltf.status, 0) << gltf.err;
  EXPECT_EQ(nlohmann::json::parse(gltf.out)["triangles"], 1);
}

TEST(CliInfo, TellsALensFromOtherJsonAndVerifiesIt) {
  const TemporaryFolder folder;
  write_bytes(folder / "lens.json", R"({"version": 1, "model": "thin", "focal_length_mm": 4.4, "f_number": 1.8})");
  write_bytes(folder / "on_it.json", R"({"version": 1, "file": "lens.json", "f_number": 4})");
  write_bytes(folder / "bad.json", R"({"version": 1, "model": "thin", "focal_length_mm": -1, "f_number": 1.8})");
  for (const char* name : {"lens.json", "on_it.json"}) {
    const Outcome info = run_command("info --json '" + (folder / name) + "'");
    ASSERT_EQ(info.status, 0) << info.err;
    EXPECT_EQ(nlohmann::json::parse(info.out)["kind"], "lens");
  }
  expect_one_line_refusal(run_command("info '" + (folder / "bad.json") + "'"));
}

TEST(CliInfo, VerifiesAResultsPictures) {
  const TemporaryFolder folder;
  const Capture capture = pipeline::synthetic_capture();
  pipeline::write_result(pipeline::synthetic_result(capture), {{"mode", "dp"}}, folder / "r");
  const std::string info = "info '" + (folder / "r") + "'";
  EXPECT_EQ(run_command(info).status, 0);
  for (const std::string name : {"portrait.png", "input.exr", "maps.exr"}) {
    const std::string path = folder / "r/" + name, whole = read_bytes(path);
    for (const std::string& bytes : {std::string(), whole.substr(0, whole.size() / 2)}) {
      write_bytes(path, bytes);
      const Outcome outcome = run_command(info);
      expect_one_line_refusal(outcome);
      EXPECT_NE(outcome.err.find(name), std::string::npos) << outcome.err;
    }
    write_bytes(path, whole);
  }
  std::filesystem::remove(folder / "r/portrait.exr");
  expect_one_line_refusal(run_command(info));
}

TEST(CliInfo, DescribesAPeopleSetAndVerifiesIt) {
  const TemporaryFolder folder;
  const std::string path = folder / "set", info = "info --json '" + path + "'";
  constexpr std::size_t kPixels = std::size_t{scenes::kPictureSide_px} * scenes::kPictureSide_px;
  const scenes::PeopleArrays arrays = {std::vector<std::uint8_t>(9 * kPixels),
                                       std::vector<std::uint8_t>(3 * kPixels),
                                       std::vector<float>(std::size_t{3 * 3} * scenes::kKeypoints),
                                       {9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9},
                                       R"([{"people": 2, "composite": true, "tags": [], "seed": 1},)"
                                       R"({"people": 1, "composite": true, "tags": [], "seed": 1},)"
                                       R"({"people": 1, "composite": false, "tags": [], "seed": 2}])"};
  for (const bool held_out : {false, true}) {
    scenes::write_people_arrays(path, arrays, 1, held_out);
    const Outcome outcome = run_command(info);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto set = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(set["kind"], "people set");
    EXPECT_EQ(set["count"], 3);
    EXPECT_EQ(set["held_out"], held_out);
    EXPECT_EQ(set["composite_samples"], 2);
    EXPECT_EQ(set["samples_of_groups"], 1);
  }
  const auto refused_for = [&](const char* word) {
    const Outcome outcome = run_command(info);
    expect_one_line_refusal(outcome);
    EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
  };
  const std::string masks = read_file(path + "/shard_00000/masks.npy");
  replace_file(path + "/shard_00000/masks.npy", masks.substr(0, masks.size() - 1) + '\1');
  refused_for("masks.npy: is not as it was written");
  const Outcome scored = run_command("experiment segmentation --people '" + path + "'");
  expect_one_line_refusal(scored);
  EXPECT_NE(scored.err.find("masks.npy: is not as it was written"), std::string::npos) << scored.err;
  replace_file(path + "/shard_00000/masks.npy", masks);
  EXPECT_EQ(run_command(info).status, 0);
  const std::string index = read_file(path + "/people.json");
  std::string changed = index;
  replace_file(path + "/people.json", changed.replace(changed.find("true"), 4, "\"no\""));
  refused_for("/held_out: \"no\": must be true or false");
  changed = index;
  replace_file(path + "/people.json", changed.replace(changed.find('{'), 1, R"({"comment": 1, )"));
  refused_for("people.json: /comment: unknown field");
  std::filesystem::remove(path + "/people.json");
  refused_for("is not finished");
}

TEST(Cli, BinaryGltfInPlaceOfASceneFileIsNamedAsThat) {
  const TemporaryFolder folder;
  write_bytes(folder / "a.glb", std::string("glTF\x02\0\0\0", 8));
  const Outcome outcome = run_command("plan '" + (folder / "a.glb") + "'");
  expect_one_line_refusal(outcome);
  EXPECT_NE(outcome.err.find("binary glTF"), std::string::npos) << outcome.err;
}

TEST(CliInfo, RefusesWhatItDoesNotKnow) {
  const TemporaryFolder folder;
  write_bytes(folder / "a.txt", "hello");
  write_bytes(folder / "a.json", "{\"a\": 1, \"a\": 2}");
  write_bytes(folder / "a.glb", "glTF");
  for (const char* name : {"none", "", "a.txt", "a.json", "a.glb", "new\nline", "\xff"}) {
    SCOPED_TRACE(name);
    expect_one_line_refusal(run_command("info '" + (folder / name) + "'"));
  }
}

// Zeros deflate a thousandfold: a file of some kilobytes is a picture of gigabytes.
TEST(SlowCli, APictureBeyondMemoryIsRefusedByName) {
#ifdef DUALPIXEL_SANITIZED
  GTEST_SKIP() << "sanitizers need the addresses that are taken away here";
#endif
  const TemporaryFolder folder;
  write_png8(folder / "huge.png", Image(9000, 9000, 1));
  const std::string pair =
      fmt::format("portrait --left '{0}/huge.png' --right '{0}/huge.png' -o '{0}/out'", folder.path.string());
  // the program itself takes more where OpenBLAS is installed
  const std::string refusal = run_program("--max-memory 1 info x").err, least = "must be at least ";
  ASSERT_NE(refusal.find(least), std::string::npos) << refusal;
  const int least_mb = std::stoi(refusal.substr(refusal.find(least) + least.size()));
  for (const int more_mb : {100, 1200}) {
    const Outcome outcome = run_program(fmt::format("{} --max-memory {}", pair, least_mb + more_mb));
    expect_one_line_refusal(outcome);
    EXPECT_NE(outcome.err.find("huge.png"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("not enough memory"), std::string::npos) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "out"));
  }
}

TEST(SlowCli, EndsAtItsTimeLimitAndLeavesNothing) {
  const TemporaryFolder folder;
  const Outcome outcome = run_program(
      fmt::format("--max-time 1 simulate '" DUALPIXEL_SCENES_DIR "/portrait.json' -o '{}'", folder / "out"));
  expect_one_line_refusal(outcome);
  EXPECT_EQ(outcome.err, "dualpixel: --max-time: not done after 1 s\n");
  EXPECT_EQ(folder.names(), std::set<std::string>());
  // where new files are begun all the time, two moments of it
  for (const int seconds : {1, 3}) {
    const Outcome drawing = run_program(fmt::format(
        "--max-time {} experiment scenes chart --count 1000 --width 64 --samples 4 -o '{}'", seconds, folder / "out"));
    EXPECT_EQ(drawing.err, fmt::format("dualpixel: --max-time: not done after {} s\n", seconds));
    EXPECT_EQ(folder.names(), std::set<std::string>());
  }
  // a signal while it ends
  const Outcome both = run_program("--version >/dev/null; timeout -s KILL 60 '" DUALPIXEL_PROGRAM
                                   "' --max-time 1 simulate '" DUALPIXEL_SCENES_DIR "/portrait.json' -o '" +
                                   (folder / "out") + "' & sleep 1.7; kill -TERM $!; wait $!");
  EXPECT_TRUE(both.status == 2 || both.status == 143 || both.status == 124) << both.status;
  EXPECT_EQ(folder.names(), std::set<std::string>());
  EXPECT_EQ(run_program("--max-time 600 experiment --help").status, 0);
  EXPECT_NE(run_program("--max-time 9 inf x").err.find("did you mean 'info'"), std::string::npos);
  expect_one_line_refusal(run_program("--max-time 0 info '" DUALPIXEL_SCENES_DIR "/portrait.json'"));
}

TEST(SlowCli, TheFirstSignalSaysThatTheSetGoesOnToItsNextWholeShard) {
  const TemporaryFolder folder;
  const std::string out = "'" + (folder / "set") + "' 2>'" + (folder / "said") + "'";
  // once it has computed for three seconds, six times what it takes to start, it is drawing people
  run_program("--version >/dev/null; '" DUALPIXEL_PROGRAM "' people --count 64 -o " + out +
              " & for i in $(seq 600); do [ $(cut -d' ' -f14 /proc/$!/stat) -gt $((3 * $(getconf CLK_TCK))) ] && "
              "break; sleep 0.05; done; kill -TERM $!; wait $!");
  EXPECT_EQ(read_bytes(folder / "said"),
            "dualpixel: stopping when what is being made is whole; a second signal ends it at once\n");
}

#ifndef DUALPIXEL_SANITIZED  // sanitizers need the addresses that are taken away here
TEST(Cli, LessMemoryThanTheProgramItselfTakesIsRefused) {
  const Outcome little = run_program("--max-memory 50 info '" DUALPIXEL_SCENES_DIR "/portrait.json'");
  expect_one_line_refusal(little);
  EXPECT_NE(little.err.find("memory is limited to 50 MB"), std::string::npos) << little.err;
}
#endif

// OpenBLAS starts threads before main() that block no signal: any of them may be the one that is interrupted.
TEST(SlowCli, SignalsThatEndATerminalOrASessionLeaveNothing) {
  for (const auto& [signal, status] : {std::pair{"HUP", 129}, {"INT", 130}, {"QUIT", 131}, {"XCPU", 152}}) {
    const TemporaryFolder folder;
    const Outcome outcome = run_program(fmt::format(
        "--version >/dev/null; '" DUALPIXEL_PROGRAM
        "' experiment scenes chart --count 1000 --width 64 --samples 4 -o '{}' & for i in $(seq 600); do ls -A '{}' | "
        "grep -q dualpixel && break; sleep 0.05; done; kill -{} $!; wait $!",
        folder / "out", folder.path.string(), signal));
    EXPECT_EQ(outcome.status, status) << signal;
    EXPECT_EQ(folder.names(), std::set<std::string>()) << signal;
  }
}

TEST(Cli, OptionsOfAnotherMatcherAreRefused) {
  const Outcome other = run_program("portrait x -o y --matcher likelihood --set match.range_px=5");
  expect_one_line_refusal(other);
  EXPECT_NE(other.err.find("match.range_px: matcher likelihood does not use it; its options begin with "
                           "likelihood_match.; matcher paper does"),
            std::string::npos)
      << other.err;
  for (const char* fits :
       {"split --set likelihood_match.range_px=5", "paper --set match.range_px=5", "split --set smooth.strength=1"}) {
    const Outcome taken = run_program(fmt::format("portrait x -o y --matcher {}", fits));
    EXPECT_EQ(taken.err.find("does not use it"), std::string::npos) << taken.err;
  }
}

// What is opened first must not take the numbers of streams that are closed.
TEST(Cli, WithoutStandardStreamsTheStatusTellsThatNothingWasPrinted) {
  for (const char* closed : {">&-", ">&- 2>&-", "<&- >&-", "<&- >&- 2>&-"}) {
    const Outcome outcome = run_program(fmt::format("--version >/dev/null; '" DUALPIXEL_PROGRAM
                                                    "' info '" DUALPIXEL_SCENES_DIR "/portrait.json' {}; exit $?; :",
                                                    closed));
    EXPECT_EQ(outcome.status, 1) << closed;
  }
}

TEST(Cli, OutputsThatCannotBeWrittenAreRefusedBeforeTheWork) {
  const TemporaryFolder folder;
  const Outcome chart = run_program("--max-time 60 chart --quick -o '" + folder.path.string() + "'");
  expect_one_line_refusal(chart);
  EXPECT_NE(chart.err.find("exists and is not a regular file"), std::string::npos) << chart.err;
}

TEST(Cli, AChartOfLargerPicturesIsNoneToCompareAQuickOneWith) {
  const TemporaryFolder folder;
  const std::string older = folder / "older.json";
  write_bytes(
      older,
      R"({"format": "dualpixel-chart", "version": 5, "program": "0.1", "libraries": "", "machine": "m", "quick": false,
                         "complete": true, "sections": [], "bars": [], "growths": [], "left_out": []})");
  const Outcome chart =
      run_program("--max-time 60 chart --quick -o '" + (folder / "new.html") + "' --compare '" + older + "'");
  expect_one_line_refusal(chart);
  EXPECT_NE(chart.err.find("older.json: was measured without --quick"), std::string::npos) << chart.err;
}

TEST(Cli, InfoDoesNotTakeACapturesFileForAScene) {
  const TemporaryFolder folder;
  write_bytes(folder / "capture.json", R"({"format": "dualpixel-capture", "camera": {}})");
  EXPECT_NE(run_program("info '" + (folder / "capture.json") + "'").out.find("give its folder"), std::string::npos);
}

TEST(Cli, AFullDiskOnStandardOutputIsNoSuccess) {
  const TemporaryFolder folder;
  write_png8(folder / "a.png", Image(5, 3, 3, 0.5f));
  const std::string more_than_is_buffered = "info '" DUALPIXEL_SOURCE_DIR "/lens_models/lens.schema.json'";
  for (const std::string& words : {"info '" + (folder / "a.png") + "'", more_than_is_buffered, std::string("--help"),
                                   std::string("scene --options")}) {
    const std::string command = "'" DUALPIXEL_PROGRAM "' " + words + " 2>'" + (folder / "err") + "' >/dev/full";
    EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 1);
    EXPECT_EQ(read_bytes(folder / "err"), "dualpixel: standard output cannot be written\n") << words;
  }
}

TEST(SlowCli, AFilePastTheShellsLimitIsRefusedAndLeavesNothing) {
  const TemporaryFolder folder;
  const std::string command = "ulimit -f 4; '" DUALPIXEL_PROGRAM "' people --count 1 --composites 0 --preview '" +
                              (folder / "a.png") + "' 2>&1 | grep -q 'a.png: cannot be written: File too large'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  EXPECT_EQ(folder.names(), (std::set<std::string>{}));
}

}  // namespace
}  // namespace dualpixel
