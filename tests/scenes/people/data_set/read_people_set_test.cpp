#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "capture/error.h"
#include "capture/files.h"
#include "scenes/people/data_set/read_people_set.h"
#include "tests/run_program.h"
#include "tests/scenes/people/toy_people.h"

namespace dualpixel::scenes {
namespace {

TEST(ReadPeopleSet, DamageIsOneClearLine) {
  const TemporaryFolder folder;
  write_toy_people(folder / "toy", 6, 1);
  const std::string toy = folder / "toy", shard = toy + "/shard_00000";
  const auto error = [&] {
    try {
      PeopleSet set({toy}, false);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_EQ(error(), "");
  const std::vector<std::tuple<std::string, std::string, std::string>> cases = {
      {"/people.json", R"({"format": "dualpixel people", "version": 2, "size_px": 256, "count": 6})",
       "must be \"dualpixel people\", 1, 256"},
      {"/people.json", R"({"format": "dualpixel people", "version": 1, "size_px": 256, "count": 7, "held_out": false})",
       "/count: 7"},
      {"/people.json", "[1]", "must be \"dualpixel people\", 1, 256"},
      {"/people.json", R"({"format": "dualpixel people", "version": 1, "size_px": 256, "count": 6, "held_out": true})",
       "/held_out: true: must be false"},
      {"/shard_00000/samples.json", "[{}]", "a list of 6 samples"},
      {"/shard_00000/samples.json", "[{}, {}, {}, {}, {}, {}]", "/0/people"},
      {"/shard_00000/samples.json", R"([{"people": 0}, {}, {}, {}, {}, {}])", "/0/people: 0"},
      {"/shard_00000/samples.json", R"([{"people": 1, "composite": 2}, {}, {}, {}, {}, {}])", "/0/composite: 2"},
      {"/shard_00000/masks.npy", std::string("\x93NUMPY\x01\x00\xf6\x7f", 10) + std::string(40000, ' '),
       "its header is not that of"},
      {"/shard_00000/samples.json", R"([{"people": 1, "composite": false, "tags": [1]}, {}, {}, {}, {}, {}])",
       "/0/tags: must be a list of words"},
      {"/shard_00000/samples.json", R"([{"people": 1, "composite": false, "tags": []}, {}, {}, {}, {}, {}])",
       "/0/seed"},
      {"/shard_00000/samples.json", R"([{"people": 1, "composite": false, "tags": ["turn:x"]}, {}, {}, {}, {}, {}])",
       "/0/tags: turn:x: must be turn: and degrees, 0 to 180"},
      {"/shard_00000/samples.json", R"([{"people": 1, "composite": false, "tags": ["turn:181"]}, {}, {}, {}, {}, {}])",
       "/0/tags: turn:181: must be turn: and degrees, 0 to 180"},
      {"/shard_00000/faces.npy", "", "is empty"},
      {"/shard_00000/faces.npy", "\x93NUMPY", "no NumPy file"},
      {"/shard_00000/masks.npy", "xxxxxxxxxxxxxxxxxxxx", "no NumPy file"},
  };
  for (const auto& [file, bytes, said] : cases) {
    const std::string before = read_file(toy + file);
    replace_file(toy + file, bytes);
    EXPECT_NE(error().find(said), std::string::npos) << error();
    EXPECT_EQ(error().find('\n'), std::string::npos);
    replace_file(toy + file, before);
  }
  const std::string masks = read_file(shard + "/masks.npy"), faces = read_file(shard + "/faces.npy");
  const std::vector<std::array<const char*, 3>> headers = {
      {"6, 256, 256", "5, 256, 256", "its header says"},
      {"6, 256, 256)", "6, 65536,  )", "its header is not that of"},
      {"6, 256, 256), }", "393216, ), }   ", "its header is not that of"},  // NumPy has no space there
      {"6, 256, 256), }", "393216,), }    ", "shape (393216): must be '|u1' of shape (N, 256, 256)"},
      {"6, 256, 256), }", "6, 65536), }   ", "shape (6, 65536): must be '|u1' of shape (N, 256, 256)"},
      {"256, 256), }     ", "99999, 99999), }", "items of more than 1073741824 values"},
      {"|u1", "<f4", "its header says"},
      {"False", "True ", "its header is not that of"}};
  for (const auto& [from, to, said] : headers) {
    std::string bytes = masks;
    ASSERT_NE(bytes.find(from), std::string::npos) << from;
    bytes.replace(bytes.find(from), std::strlen(to), to);
    replace_file(shard + "/masks.npy", bytes);
    EXPECT_NE(error().find(std::string("masks.npy: ")), std::string::npos) << error();
    EXPECT_NE(error().find(said), std::string::npos) << error();
  }
  replace_file(shard + "/masks.npy", masks);
  std::string not_finite = faces;
  not_finite.replace(not_finite.size() - 4, 4, std::string("\0\0\xc0\x7f", 4));
  replace_file(shard + "/faces.npy", not_finite);
  EXPECT_NE(error().find("not finite"), std::string::npos) << error();
  for (const float outside : {-1000.0f, 1000.0f}) {
    std::string bytes = faces;
    std::memcpy(bytes.data() + bytes.size() - 16, &outside, 4);  // x of the last face
    replace_file(shard + "/faces.npy", bytes);
    EXPECT_NE(error().find("faces.npy: face 5"), std::string::npos) << error();
  }
  replace_file(shard + "/faces.npy", faces);
  std::filesystem::remove(shard + "/shard.json");
  EXPECT_NE(error().find("shard.json"), std::string::npos) << error();
}

}  // namespace
}  // namespace dualpixel::scenes
