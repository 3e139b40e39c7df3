#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "pipeline/segmentation/weights.h"
#include "tests/scenes/people/toy_people.h"
#include "tests/temporary_folder.h"
#include "tools/train_segmentation/face_examples.h"
#include "tools/train_segmentation/train_faces.h"

namespace dualpixel::tools {
namespace {

using Json = nlohmann::json;

/// A toy set for a face detector; `samples` changes what samples.json says.
void write_toy_faces(const std::string& folder, int count, std::uint64_t seed, bool held_out,
                     const std::function<void(Json& samples)>& change = {}) {
  scenes::write_toy_people(folder, count, seed, held_out);
  Json index = read_json_file(folder + "/people.json");
  index["faces"] = true;
  replace_file(folder + "/people.json", index.dump());
  Json samples = read_json_file(folder + "/shard_00000/samples.json");
  for (int i = 0; i < count; ++i) {
    samples[i]["seed"] = i;
    samples[i]["tags"] = {"turn:30"};
  }
  if (change) change(samples);
  replace_file(folder + "/shard_00000/samples.json", samples.dump());
}

TEST(FacePictures, HaveTheFacesOfTheirScene) {
  const TemporaryFolder folder;
  write_toy_faces(folder / "set", 6, 1, false, [](Json& samples) {
    samples[1]["seed"] = 0;  // 0 and 1 are two people in one picture
    samples[1]["tags"] = {"turn:80", "face:hidden"};
    samples[2]["seed"] = 0;  // and 2 is it in front of another background
    samples[2]["composite"] = true;
    samples[3]["tags"] = {"turn:106"};
    samples[4]["people"] = 0;
    samples[4]["tags"] = Json::array();
  });
  const scenes::PeopleSet set({folder / "set"}, false, scenes::PeopleSetKind::faces);
  const std::vector<FacePicture> pictures = face_pictures(set);
  std::vector<std::pair<std::size_t, std::size_t>> found;
  for (const FacePicture& picture : pictures) found.emplace_back(picture.sample, picture.faces.size());
  EXPECT_EQ(found, (std::vector<std::pair<std::size_t, std::size_t>>{{0, 2}, {2, 2}, {3, 0}, {4, 0}, {5, 1}}));
  const std::vector<TrueFace>& two = pictures[0].faces;
  EXPECT_EQ(two[0].x, set[0].face[0]);
  EXPECT_EQ(two[0].side, set[0].face[2]);
  EXPECT_EQ(two[0].turn_deg, 30);
  EXPECT_TRUE(two[0].certain);
  EXPECT_EQ(two[1].turn_deg, 80);
  EXPECT_FALSE(two[1].certain);
}

TEST(FaceAugmentations, AreWhatTheHeaderSays) {
  const std::vector<TrueFace> faces = {{60, 70, 40, 0, true}, {150, 90, 20, 0, true}};
  constexpr int kKeys = 4000;
  int close = 0, behind = 0, patched = 0;
  for (std::uint64_t key = 0; key < kKeys; ++key) {
    const FaceAugmentation a = draw_face_augmentation(key, faces);
    EXPECT_LE(std::abs(a.picture.rotation_rad), 30 * M_PI / 180);
    behind += a.has_behind ? 1 : 0;
    patched += a.patch[2] > 0 ? 1 : 0;
    bool fills = false;
    for (const TrueFace& face : faces) {  // 0.15 of the side off its middle at most
      const auto [x, y] = Warp(a.picture).forward(face.x + face.side / 2, face.y + face.side / 2);
      const double share = a.picture.scale * face.side / 256;
      const bool middle = std::abs(x - 128) <= 0.15 * 256 + 1e-6 && std::abs(y - 128) <= 0.15 * 256 + 1e-6;
      fills = fills || (middle && share >= 0.35 && share <= 0.95);
    }
    close += fills ? 1 : 0;
    EXPECT_TRUE(fills || (a.picture.scale >= 0.3 && a.picture.scale <= 1.5)) << key;
    const FaceAugmentation same = draw_face_augmentation(key, faces);
    EXPECT_EQ(same.picture.scale, a.picture.scale);
    EXPECT_EQ(same.picture.shift_x_px, a.picture.shift_x_px);
    EXPECT_EQ(same.patch, a.patch);
  }
  // shares of .25, .6 and .35, to three standard errors
  EXPECT_NEAR(close, 0.25 * kKeys, 3 * std::sqrt(0.25 * 0.75 * kKeys));
  EXPECT_NEAR(behind, 0.6 * kKeys, 3 * std::sqrt(0.6 * 0.4 * kKeys));
  EXPECT_NEAR(patched, 0.35 * kKeys, 3 * std::sqrt(0.35 * 0.65 * kKeys));
  EXPECT_LE(draw_face_augmentation(1, {}).picture.scale, 1.5);  // nobody to come close to
}

TEST(SlowFaceTraining, WritesARunThatIsTheSameAgain) {
  const TemporaryFolder folder;
  write_toy_faces(folder / "train", 8, 1, false);
  write_toy_faces(folder / "held_out", 4, 2, true, [](Json& samples) { samples[3]["tags"] = {"face:hidden"}; });
  TrainOptions options;
  options.data = {folder / "train"};
  options.held_out = {folder / "held_out"};
  options.samples = 64;  // two batches
  options.threads = 1;
  const auto never = [](std::uint64_t) { return false; };
  for (const char* run : {"a", "b"}) {
    options.output = folder / run;
    train_faces(options, never);
  }
  const std::string weights = read_file(folder / "a/faces.safetensors");
  EXPECT_EQ(weights, read_file(folder / "b/faces.safetensors"));
  EXPECT_NO_THROW(pipeline::parse_weights(weights, "a", pipeline::NetworkKind::faces));
  const Json log = read_json_file(folder / "a/log.json");
  EXPECT_EQ(log["training_pictures"], 8);
  EXPECT_EQ(log["points"].back()["samples"], 64);
  std::istringstream table(read_file(folder / "a/scores.csv"));
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line, "picture,is_face,turn_deg,side_px,score");
  int faces = 0;
  while (std::getline(table, line)) faces += line.find(",1,30,") != std::string::npos ? 1 : 0;
  EXPECT_EQ(faces, 3);  // the certain ones, whatever the network has learned in two steps

  const auto refusal = [&] {
    try {
      train_faces(options, never);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(refusal().find("b: holds a run; name another folder"), std::string::npos) << refusal();
  EXPECT_EQ(read_file(folder / "b/faces.safetensors"), weights);
  options.output = "/dev/null/run";
  EXPECT_NE(refusal().find("/dev/null/run: cannot be made a folder"), std::string::npos) << refusal();
}

}  // namespace
}  // namespace dualpixel::tools
