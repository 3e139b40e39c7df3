#include <gtest/gtest.h>

#include <fmt/format.h>
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <set>
#include <string>

#include "capture/error.h"
#include "capture/image/npy.h"
#include "scenes/people/data_set/read_people_set.h"
#include "scenes/people/data_set/write_people_set.h"
#include "tests/run_program.h"

namespace dualpixel::scenes {
namespace {

TEST(WritePeopleSet, NpyHasVersionOnesHeader) {
  const std::string bytes = npy_bytes("<f4", {3, 4}, std::string(48, 'x'));
  EXPECT_EQ(bytes.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
  const std::size_t length = static_cast<unsigned char>(bytes[8]) + 256u * static_cast<unsigned char>(bytes[9]);
  EXPECT_EQ((10 + length) % 64, 0u);
  EXPECT_EQ(bytes.size(), 10 + length + 48);
  EXPECT_EQ(bytes[9 + length], '\n');
  EXPECT_NE(bytes.find("{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }"), std::string::npos);
  EXPECT_NE(npy_bytes("|u1", {5}, "12345").find("(5, )"), std::string::npos);
}

TEST(SlowWritePeopleSet, BadOptionsAreRefused) {
  expect_one_line_refusal(run_program("people"));
  for (const auto& [count, composites] : {std::pair{0, 4}, {-1, 4}, {kMostSamples + 1, 4}, {1, -1}, {1, 101}}) {
    EXPECT_THROW(check_people_options({.count = count, .composites = composites}), InputError);
  }
  expect_one_line_refusal(run_program("people -o /dev/null/x --count 1"));
  EXPECT_THROW(write_people_set({.count = 1}, ""), InputError);
}

TEST(SlowWritePeopleSet, APreviewThatIsNoPngIsRefusedBeforeTheWork) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "sub.png");
  for (const std::string name : {"a.jpg", "a", "sub.png"}) {
    const Outcome outcome = run_program("people --preview '" + (folder / name) + "' -o '" + (folder / "set") + "'");
    expect_one_line_refusal(outcome);
    EXPECT_NE(outcome.err.find("/" + name + ": "), std::string::npos) << outcome.err;
  }
  EXPECT_EQ(folder.names(), (std::set<std::string>{"sub.png"}));
}

TEST(SlowWritePeopleSet, SetsAreReadAsTheyWereMade) {
  const TemporaryFolder folder;
  const PeopleOptions options{.count = 3, .seed = 4, .held_out = true, .composites = 1};
  write_people_set(options, folder / "set");
  const PeopleSet set({folder / "set"}, true);
  const std::vector<PeopleSample> made = make_people_shard(options, 0, 3);
  ASSERT_EQ(set.size(), made.size());
  for (std::size_t i = 0; i < made.size(); ++i) {
    EXPECT_TRUE(std::equal(made[i].picture.begin(), made[i].picture.end(), set[i].picture));
    EXPECT_TRUE(std::equal(made[i].mask.begin(), made[i].mask.end(), set[i].mask));
    for (int k = 0; k < kKeypoints; ++k) {
      for (int c = 0; c < 3; ++c) EXPECT_EQ(made[i].keypoints[k][c], set[i].keypoints[3 * k + c]);
    }
    for (int c = 0; c < 4; ++c) EXPECT_EQ(made[i].face[c], set[i].face[c]);
    EXPECT_EQ(made[i].tags, set[i].tags);
    EXPECT_EQ(made[i].people, set[i].people);
    EXPECT_EQ(made[i].composite, set[i].composite);
  }
  EXPECT_THROW(PeopleSet({folder / "set"}, false), InputError);
  folder.write("set/shard_00000/samples.json", "[]");
  EXPECT_THROW(PeopleSet({folder / "set"}, true), InputError);
}

TEST(SlowPeopleForFaces, HoldFacesAtAnyTurnAndPicturesOfNobody) {
  const TemporaryFolder folder;
  write_people_set({.count = 6, .seed = 2, .composites = 0, .faces = true}, folder / "set");
  const PeopleSet set({folder / "set"}, false, PeopleSetKind::faces);
  int nobody = 0, turned = 0, away = 0;
  for (std::size_t i = 0; i < set.size(); ++i) {
    const auto turn = std::find_if(set[i].tags.begin(), set[i].tags.end(),
                                   [](const std::string& tag) { return tag.rfind("turn:", 0) == 0; });
    ASSERT_EQ(turn == set[i].tags.end(), set[i].people == 0);
    if (set[i].people == 0) {
      ++nobody;
      EXPECT_EQ(set[i].face[2], 0);
      EXPECT_EQ(*std::max_element(set[i].mask, set[i].mask + 256 * 256), 0);
      continue;
    }
    const int degrees = std::stoi(turn->substr(5));
    const bool hidden = std::count(set[i].tags.begin(), set[i].tags.end(), "face:hidden") > 0;
    EXPECT_TRUE(hidden || degrees <= 101) << degrees;  // 1.75 radians
    turned += degrees > 45 && !hidden;
    away += degrees > 101;
  }
  EXPECT_GT(nobody, 0);
  EXPECT_GT(turned, 0);
  EXPECT_GT(away, 0);
  EXPECT_THROW(PeopleSet({folder / "set"}, false), InputError);  // masks are not learned from these
  EXPECT_THROW(write_people_set({.count = 6, .seed = 2, .composites = 0}, folder / "set"), InputError);
}

TEST(SlowPeopleForFaces, NoPictureIsCut) {
  PeopleOptions options{.count = 2, .seed = 4, .composites = 0, .faces = true};
  const std::vector<PeopleSample> two = make_people_shard(options, 0, 2);
  ASSERT_EQ(two[0].seed, two[1].seed);  // its first picture shows two people
  const std::vector<PeopleSample> one = make_people_shard(options, 0, 1);
  ASSERT_EQ(one.size(), 1U);
  EXPECT_NE(one[0].seed, two[0].seed);
}

TEST(SlowWritePeopleSet, ASignalEndsItAfterTheShardThatIsBeingMade) {
  const TemporaryFolder folder;
  const PeopleOptions options{.count = kShardSamples + 1, .seed = 4, .composites = 100};
  std::atomic<int> stopped = 0;
  int made = 0;
  const auto stop = [&](double) { stopped = 2; };
  const auto count = [&](const auto&) { ++made; };
  EXPECT_FALSE(write_people_set(options, folder / "set", stop, count, &stopped));
  EXPECT_EQ(made, 1);
  EXPECT_EQ((std::filesystem::exists(folder / "set/shard_00000/shard.json")), true);
  EXPECT_FALSE(std::filesystem::exists(folder / "set/people.json"));
  EXPECT_FALSE(write_people_set(options, folder / "set", {}, count, &stopped));  // the first shard is kept
  EXPECT_EQ(made, 1);
  stopped = 0;
  EXPECT_TRUE(write_people_set(options, folder / "set", {}, count, &stopped));
  EXPECT_EQ(made, 2);
}

TEST(SlowWritePeopleSet, ARunThatEndsBeforeItsFirstShardLeavesNothing) {
  const TemporaryFolder folder;
  const auto end = [](double) { throw std::runtime_error("ended"); };
  EXPECT_THROW(write_people_set({.count = 1, .seed = 4, .composites = 0}, folder / "set", end), std::runtime_error);
  EXPECT_TRUE(folder.names().empty());
}

TEST(SlowWritePeopleSet, AnInterruptedRunResumes) {
  const TemporaryFolder folder;
  const PeopleOptions options{.count = 2, .seed = 4, .composites = 0};
  int made = 0;
  const auto count = [&](const std::vector<PeopleSample>&) { ++made; };
  std::filesystem::create_directories(folder / "set/.dualpixel-1-0.tmp");  // of a killed run
  write_people_set(options, folder / "set", {}, count);
  const std::string masks = read_bytes(folder / "set/shard_00000/masks.npy");
  write_people_set(options, folder / "set", {}, count);
  EXPECT_EQ(made, 1);
  const auto refusal_of = [&](const PeopleOptions& other) {
    try {
      write_people_set(other, folder / "set", {}, count);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  // a set, complete or not, is not replaced by another, and no other folder is written into
  const std::string index = read_bytes(folder / "set/people.json");
  for (const bool whole : {true, false}) {
    if (!whole) std::filesystem::remove(folder / "set/people.json");
    EXPECT_THROW(write_people_set({.count = 2, .seed = 5, .composites = 0}, folder / "set", {}, count), InputError);
    EXPECT_THROW(write_people_set({.count = 2, .seed = 4, .composites = 1}, folder / "set", {}, count), InputError);
    EXPECT_THROW(
        write_people_set({.count = 2, .seed = 4, .held_out = true, .composites = 0}, folder / "set", {}, count),
        InputError);
  }
  // of other figures; damaged, by a run that was ended by force; nested beyond what is read
  const std::string shard = read_bytes(folder / "set/shard_00000/shard.json");
  std::string changed_shard = shard;
  const std::string none = "\"makehuman\": \"\"";
  ASSERT_NE(shard.find(none), std::string::npos);
  folder.write("set/shard_00000/shard.json",
               changed_shard.replace(shard.find(none), none.size(), "\"makehuman\": \"a\""));
  EXPECT_NE(refusal_of(options).find("other figures"), std::string::npos);
  const std::string deep = std::string(1000000, '[') + std::string(1000000, ']') + "}";
  folder.write("set/shard_00000/shard.json", R"({"format": "dualpixel people shard", "seed": )" + deep);
  folder.write("set/people.json", R"({"alice": 1})");
  EXPECT_NE(refusal_of(options).find("not a set of people"), std::string::npos);
  EXPECT_EQ(read_bytes(folder / "set/people.json"), R"({"alice": 1})");
  std::filesystem::remove(folder / "set/people.json");
  folder.write("set/shard_00000/shard.json", shard);
  try {
    const PeopleSet set({folder / "set"}, false);
    FAIL() << "an unfinished set is read";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("not finished"), std::string::npos) << error.what();
  }
  write_people_set(options, folder / "set", {}, count);
  EXPECT_EQ(read_bytes(folder / "set/people.json"), index);
  EXPECT_THROW(write_people_set(options, folder.path.string(), {}, count), InputError);
  const std::string generator = fmt::format("\"generator\": {}", kTrainingGenerator);
  ASSERT_NE(index.find(generator), std::string::npos);
  const std::string nothing;  // from before it was written
  for (const std::string& another : {nothing, fmt::format("\"generator\": {},", kTrainingGenerator + 1)}) {
    std::string changed = index;
    folder.write("set/people.json", changed.replace(changed.find(generator), generator.size() + 1, another));
    EXPECT_THROW(write_people_set(options, folder / "set", {}, count), InputError) << another;
  }
  folder.write("set/people.json", index);
  PeopleOptions fewer = options;
  fewer.count -= 1;
  EXPECT_THROW(write_people_set(fewer, folder / "set", {}, count), InputError);
  EXPECT_EQ(made, 1);
  // a changed file, and one of another length, are noticed
  const std::string faces = folder / "set/shard_00000/faces.npy", whole = read_bytes(faces);
  std::string broken = whole;
  broken.back() ^= 1;
  for (const std::string& bytes : {broken, whole.substr(0, 10)}) {
    folder.write("set/shard_00000/faces.npy", bytes);
    bool was_there = true;
    write_people_set(options, folder / "set",
                     [&](double) { was_there = was_there && std::filesystem::exists(folder / "set/people.json"); });
    EXPECT_FALSE(was_there);  // while a shard was made
    EXPECT_EQ(read_bytes(faces), whole);
  }
  folder.write("set/shard_00001/shard.json", "{}");
  EXPECT_THROW(write_people_set(options, folder / "set"), InputError);
  EXPECT_EQ(read_bytes(folder / "set/shard_00000/masks.npy"), masks);
  EXPECT_EQ(folder.names().size(), 1u);  // nothing temporary is left
}

}  // namespace
}  // namespace dualpixel::scenes
