#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/files.h"
#include "scenes/people/data_set/people_format.h"
#include "scenes/people/data_set/shard_files.h"
#include "simulator/sampling/hash.h"

namespace dualpixel::scenes {

/// Writes a people set of one shard.
inline void write_people_arrays(const std::string& folder, const PeopleArrays& arrays, std::uint64_t seed,
                                bool held_out) {
  const std::string shard = folder + "/shard_00000";
  std::filesystem::create_directories(shard);
  const int count = static_cast<int>(arrays.faces.size() / 4);
  write_shard_files(shard, arrays, {{"seed", seed}, {"count", count}});
  write_file(folder + "/" + kSetFile, people_index(count, {{"seed", seed}, {"held_out", held_out}}, 1).dump(2) + "\n");
}

/// A people set of `count` figures, each an ellipse for a body and one for a head, before a mottled wall with a
/// bystander of the same kind who is in no mask: only the face says which person the mask is of.
inline void write_toy_people(const std::string& folder, int count, std::uint64_t seed, bool held_out = false) {
  constexpr int kSize = kPictureSide_px;
  std::vector<std::uint8_t> pictures(count * kSize * kSize * 3), masks(count * kSize * kSize);
  std::vector<float> keypoints(count * 17 * 3), faces(count * 4);
  for (int n = 0; n < count; ++n) {
    std::uint64_t drawn = 0;
    const auto draw = [&](double low, double high) {
      return low +
             (high - low) * simulator::unit_float(static_cast<std::uint32_t>(simulator::hash(seed, n, drawn++) >> 32));
    };
    struct ToyFigure {
      double x, head_y, head, body;
      std::array<double, 3> skin, cloth;
    };
    std::array<ToyFigure, 2> figures{};
    const double seat = draw(0, 1) < 0.5 ? 70 : 186;  // the person's position; the bystander has the other
    for (int f = 0; f < 2; ++f) {
      const double head = draw(18, 26);
      figures[f] = {(f == 0 ? seat : kSize - seat) + draw(-10, 10), draw(80, 120), head, head * draw(1.6, 2.2), {}, {}};
      for (double& c : figures[f].skin) c = draw(60, 230);
      for (double& c : figures[f].cloth) c = draw(20, 240);
    }
    std::array<double, 3> wall{};
    for (double& c : wall) c = draw(20, 240);
    const auto inside = [&](const ToyFigure& f, double x, double y, bool is_head) {
      const double cy = is_head ? f.head_y : f.head_y + f.head * 1.2 + 110;
      const double rx = is_head ? f.head * 0.8 : f.body, ry = is_head ? f.head : 110;
      return std::hypot((x - f.x) / rx, (y - cy) / ry) < 1;
    };
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const std::size_t i = (static_cast<std::size_t>(n) * kSize + y) * kSize + x;
        const std::array<double, 3>* color = &wall;
        for (const int f : {1, 0}) {  // the person stands in front
          if (inside(figures[f], x + 0.5, y + 0.5, false)) color = &figures[f].cloth;
          if (inside(figures[f], x + 0.5, y + 0.5, true)) color = &figures[f].skin;
        }
        const double mottle = static_cast<double>(simulator::hash(seed + n, x / 4, y / 4) % 40) - 20;
        for (int c = 0; c < 3; ++c) {
          pictures[3 * i + c] = static_cast<std::uint8_t>(std::clamp((*color)[c] + mottle, 1.0, 255.0));
        }
        const ToyFigure& person = figures[0];
        masks[i] = inside(person, x + 0.5, y + 0.5, false) || inside(person, x + 0.5, y + 0.5, true) ? 255 : 0;
      }
    }
    const ToyFigure& person = figures[0];
    const std::array<float, 4> face = {static_cast<float>(person.x - 0.7 * person.head),
                                       static_cast<float>(person.head_y - 0.6 * person.head),
                                       static_cast<float>(1.4 * person.head), static_cast<float>(1.4 * person.head)};
    std::copy(face.begin(), face.end(), faces.begin() + 4 * n);
    const auto set_keypoint = [&](int k, double x, double y) {
      const std::array<float, 3> point = {static_cast<float>(x), static_cast<float>(y), 2};
      std::copy(point.begin(), point.end(), keypoints.begin() + (17 * n + k) * 3);
    };
    set_keypoint(0, person.x, person.head_y);                      // nose
    set_keypoint(5, person.x + person.body, person.head_y + 130);  // left shoulder: right in the picture
    set_keypoint(6, person.x - person.body, person.head_y + 130);
  }
  std::string samples;
  for (int i = 0; i < count; ++i) samples += R"({"people": 1, "composite": false, "tags": [], "seed": 1},)";
  samples.back() = ']';
  write_people_arrays(folder, {pictures, masks, keypoints, faces, "[" + samples}, seed, held_out);
}

}  // namespace dualpixel::scenes
