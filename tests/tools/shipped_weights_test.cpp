// The weights in the library, on people drawn by a fixed seed from kinds that training never draws.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "capture/error.h"
#include "evaluation/metrics/mask_metrics.h"
#include "evaluation/metrics/score_people.h"
#include "pipeline/segmentation/network.h"
#include "pipeline/segmentation/person_mask.h"
#include "scenes/people/data_set/read_people_set.h"
#include "tests/pipeline/segmentation/toy_network.h"
#include "tests/temporary_folder.h"
#include "tests/tools/run_command.h"

namespace dualpixel::tools {
namespace {

using nlohmann::json;
using pipeline::Face;

bool has_shipped_network() {
  try {
    pipeline::built_in_weights();
  } catch (const InputError&) {
    return false;
  }
  return pipeline::has_person_network();
}

#define NEEDS_SHIPPED_NETWORK() \
  if (!has_shipped_network()) GTEST_SKIP() << "built without oneDNN or without weights"

/// A held-out people set; each rendered picture comes with one composite at most.
std::string make_set(const TemporaryFolder& folder, int count) {
  std::string set = folder / "people";
  const Outcome outcome =
      run_command("people -o '" + set + "' --count " + std::to_string(count) + " --seed 1 --held-out --composites 1");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  return set;
}

/// The shipped weights with normal noise on each kernel, of `share` of the kernel's own root mean square.
pipeline::NetworkWeights perturbed_weights(double share) {
  pipeline::NetworkWeights weights = pipeline::built_in_weights();
  std::mt19937 random(1);
  std::normal_distribution<double> noise;
  for (auto& [name, layer] : weights.layers) {
    double sum = 0;
    for (const float value : layer.weight) sum += value * value;
    const double rms = std::sqrt(sum / static_cast<double>(layer.weight.size()));
    for (float& value : layer.weight) value += static_cast<float>(share * rms * noise(random));
  }
  return weights;
}

/// "samples" of `experiment segmentation --people SET`, by name.
std::map<std::string, json> scores_of(const std::string& set, const TemporaryFolder& folder,
                                      const std::string& options = "") {
  const Outcome outcome =
      run_command("experiment segmentation --people '" + set + "' -o '" + (folder / "scores") + "'" + options);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  std::map<std::string, json> rows;
  const json written = json::parse(read_bytes(folder / "scores/segmentation.json"));
  for (const json& row : written["samples"]) rows[row["name"]] = row;
  return rows;
}

// 1700 held-out samples give a mean IoU of .951 and .961 for pictures of one person (docs/segmentation.md). These 160
// have a standard error of .007, and .004 the 105 of one person: a build whose compiler draws other people lies within
// three of them. By the same measure weights that score .890 or .921 would fail.
TEST(SweepShippedWeights, FindPeopleOfKindsThatTrainingNeverDraws) {
  NEEDS_SHIPPED_NETWORK();
  const TemporaryFolder folder;
  const std::string set = make_set(folder, 160);
  constexpr double kFloor = 0.951 - 3 * 0.007, kFloorOfOne = 0.961 - 3 * 0.004;
  const auto shipped = scores_of(set, folder);
  EXPECT_EQ(shipped.at("all")["samples"], 160);
  EXPECT_GT(shipped.at("all")["iou"], kFloor);
  EXPECT_GT(shipped.at("one person")["iou"], kFloorOfOne);
  // The seed decides: where the face's channel is black, hardly anything is drawn.
  EXPECT_LT(shipped.at("all")["iou_without_face_channel"], 0.1);
  // The floors would notice: weights that are off by a tenth fall below both.
  write_bytes(folder / "worse.safetensors", pipeline::as_safetensors(perturbed_weights(0.1)));
  const auto worse = scores_of(set, folder, " --weights '" + (folder / "worse.safetensors") + "'");
  EXPECT_LT(worse.at("all")["iou"], kFloor);
  EXPECT_LT(worse.at("one person")["iou"], kFloorOfOne);
}

/// A person of the set with the square that shows them.
struct Person {
  Image picture;  // linear RGB, 256 x 256
  Image mask;
  Face face;  // in the square
};

/// The first `count` people who are alone in their pictures, each once.
std::vector<Person> people_alone(const std::string& folder, std::size_t count) {
  const scenes::PeopleSet set({folder}, true);
  std::vector<Person> people;
  std::set<std::uint64_t> scenes_taken;  // a composite shows its rendered picture's person
  for (std::size_t i = 0; i < set.size() && people.size() < count; ++i) {
    const scenes::PersonSample& sample = set[i];
    if (sample.people > 1 || !scenes_taken.insert(sample.seed).second) continue;
    const float* const face = sample.face;
    people.push_back(
        {evaluation::picture_of(sample), evaluation::mask_of(sample), {face[0], face[1], face[2], face[3]}});
  }
  return people;
}

void paste(const Image& part, int left, int top, Image& whole) {
  for (int y = 0; y < part.height; ++y) {
    for (int x = 0; x < part.width; ++x) {
      for (int c = 0; c < part.channels; ++c) whole.at(left + x, top + y, c) = part.at(x, y, c);
    }
  }
}

Face moved(Face face, double x, double y) {
  face.x += x;
  face.y += y;
  return face;
}

/// Means over blocks of 2 x 2.
Image halved(const Image& image) {
  Image half(image.width / 2, image.height / 2, image.channels);
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      for (int c = 0; c < half.channels; ++c) {
        half.at(x, y, c) = (image.at(2 * x, 2 * y, c) + image.at(2 * x + 1, 2 * y, c) + image.at(2 * x, 2 * y + 1, c) +
                            image.at(2 * x + 1, 2 * y + 1, c)) /
                           4;
      }
    }
  }
  return half;
}

constexpr std::size_t kFew = 5;  // people, of whom a mean is asked for: as many as are alone in a set of 24

// Two squares side by side: whoever's face is the seed is drawn, and the other is not. Mean IoU .93 with the person who
// is meant, 0 with the other, .94 with both where both are seeds.
TEST(SlowShippedWeights, TheSeedSaysWhoIsMeant) {
  NEEDS_SHIPPED_NETWORK();
  const TemporaryFolder folder;
  const std::vector<Person> people = people_alone(make_set(folder, 24), kFew);
  ASSERT_EQ(people.size(), kFew);
  pipeline::PersonNetwork network;
  double meant = 0, other = 0, both = 0;
  for (std::size_t i = 0; i < kFew; ++i) {
    const Person &left = people[i], &right = people[(i + 1) % kFew];
    Image picture(512, 256, 3), left_truth(512, 256), right_truth(512, 256), both_truth(512, 256);
    paste(left.picture, 0, 0, picture);
    paste(right.picture, 256, 0, picture);
    paste(left.mask, 0, 0, left_truth);
    paste(right.mask, 256, 0, right_truth);
    paste(left.mask, 0, 0, both_truth);
    paste(right.mask, 256, 0, both_truth);
    const Face left_face = left.face, right_face = moved(right.face, 256, 0);
    const Image mask = pipeline::find_people(picture, {left_face}, network).mask;
    meant += evaluation::mask_iou(mask, halved(left_truth));
    other += evaluation::mask_iou(mask, halved(right_truth));
    both +=
        evaluation::mask_iou(pipeline::find_people(picture, {left_face, right_face}, network).mask, halved(both_truth));
  }
  RecordProperty("meant", std::to_string(meant / kFew));
  RecordProperty("other", std::to_string(other / kFew));
  RecordProperty("both", std::to_string(both / kFew));
  EXPECT_GT(meant / kFew, 0.85);
  EXPECT_LT(other / kFew, 0.05);
  EXPECT_GT(both / kFew, 0.85);
}

// Mean IoU .88, of people half as large as those that the network learns from. A picture within the picture: nothing in
// one photograph tells a poster from a person behind a window.
TEST(SlowShippedWeights, APosterOfAPersonIsTakenForOne) {
  NEEDS_SHIPPED_NETWORK();
  const TemporaryFolder folder;
  const std::vector<Person> people = people_alone(make_set(folder, 24), kFew);
  ASSERT_EQ(people.size(), kFew);
  pipeline::PersonNetwork network;
  double iou = 0;
  for (const Person& person : people) {
    Image wall(512, 512, 3, 0.25F), truth(512, 512);
    paste(person.picture, 128, 128, wall);
    paste(person.mask, 128, 128, truth);
    const pipeline::FoundPeople found = pipeline::find_people(wall, {moved(person.face, 128, 128)}, network);
    EXPECT_TRUE(anybody_seen(found));
    iou += evaluation::mask_iou(found.mask, halved(truth)) / kFew;
  }
  RecordProperty("iou", std::to_string(iou));
  EXPECT_GT(iou, 0.8);
}

}  // namespace
}  // namespace dualpixel::tools
