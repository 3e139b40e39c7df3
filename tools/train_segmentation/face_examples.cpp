#include "tools/train_segmentation/face_examples.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "pipeline/segmentation/face_map.h"
#include "simulator/sampling/hash.h"
#include "tools/train_segmentation/network.h"

namespace dualpixel::tools {
namespace {

constexpr int kSide = kNetworkSize_px, kCells = kSide / pipeline::kFaceCell_px;
constexpr double kTurnedAway_deg = 105;  // an eye and the nose are seen up to about there
constexpr double kLeastSigma_cells = 0.7, kSigma_sides = 0.1;

TrueFace face_of(const scenes::PersonSample& sample) {
  const bool hidden = std::find(sample.tags.begin(), sample.tags.end(), "face:hidden") != sample.tags.end();
  return {sample.face[0], sample.face[1], sample.face[2], sample.turn_deg,
          !hidden && sample.face[2] >= kSmallestFace_px};
}

/// Sets what one face asks of the cells.
void draw_target(const TrueFace& face, float* targets) {
  constexpr double kCell = pipeline::kFaceCell_px;
  constexpr int kPlane = kCells * kCells;
  const double center_x = face.x + face.side / 2, center_y = face.y + face.side / 2;
  const int peak_x = static_cast<int>(std::floor(center_x / kCell)),
            peak_y = static_cast<int>(std::floor(center_y / kCell));
  const double sigma = std::max(kLeastSigma_cells, kSigma_sides * face.side / kCell);
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const double px = kCell * (x + 0.5), py = kCell * (y + 0.5);
      float* const cell = targets + y * kCells + x;
      const bool inside = px > face.x && px < face.x + face.side && py > face.y && py < face.y + face.side;
      if (!face.certain) {
        if (inside) cell[5 * kPlane] = 0;
        continue;
      }
      const double d2 = ((px - center_x) * (px - center_x) + (py - center_y) * (py - center_y)) / (kCell * kCell);
      const bool peak = x == peak_x && y == peak_y;
      const auto heat = static_cast<float>(peak ? 1 : std::exp(-d2 / (2 * sigma * sigma)));
      if (!(heat > cell[0])) continue;
      cell[0] = heat;
      cell[kPlane] = static_cast<float>((center_x - px) / face.side);
      cell[2 * kPlane] = static_cast<float>((center_y - py) / face.side);
      cell[3 * kPlane] = static_cast<float>(std::log2(face.side / pipeline::kFaceUnit_px));
      constexpr float kLeastHeat = 0.4F;
      cell[4 * kPlane] = heat > kLeastHeat ? heat : 0;
      if (peak) cell[5 * kPlane] = 1;  // also within an uncertain face
    }
  }
}

}  // namespace

std::vector<FacePicture> face_pictures(const scenes::PeopleSet& set) {
  std::map<std::uint64_t, std::vector<TrueFace>> faces;  // of a scene
  for (std::size_t i = 0; i < set.size(); ++i) {
    std::vector<TrueFace>& of_scene = faces[set[i].seed];
    if (set[i].people == 0 || set[i].composite || set[i].turn_deg > kTurnedAway_deg) continue;
    of_scene.push_back(face_of(set[i]));
  }
  std::vector<FacePicture> pictures;
  std::map<std::uint64_t, bool> rendered;  // the samples of a rendered picture show the same
  for (std::size_t i = 0; i < set.size(); ++i) {
    if (!set[i].composite && !rendered.emplace(set[i].seed, true).second) continue;
    pictures.push_back({i, faces[set[i].seed]});
  }
  return pictures;
}

FaceAugmentation draw_face_augmentation(std::uint64_t key, const std::vector<TrueFace>& faces) {
  Draws draw{key};
  FaceAugmentation a;
  for (Augmentation* part : {&a.picture, &a.behind}) {
    *part = draw_augmentation(simulator::hash(key, part == &a.picture ? 1 : 2));
    const double exposure = std::exp(draw(-0.5, 0.5));
    for (double& gain : part->gain) gain = exposure * std::exp(draw(-0.2, 0.2));
    part->contrast = draw(0.6, 1.3);
    part->saturation = draw(0, 1) < 0.15 ? 0 : draw(0.4, 1.5);
  }
  a.picture.rotation_rad = draw(0, 1) < 0.7 ? draw(-12, 12) * M_PI / 180 : draw(-30, 30) * M_PI / 180;
  a.picture.scale = std::exp(draw(std::log(0.3), std::log(1.5)));
  const double room = 0.12 + 0.35 * std::max(0.0, 1 - a.picture.scale);
  a.picture.shift_x_px = draw(-room, room) * kSide;
  a.picture.shift_y_px = draw(-room, room) * kSide;
  if (!faces.empty() && draw(0, 1) < 0.25) {
    const TrueFace& face = faces[std::min(faces.size() - 1, static_cast<std::size_t>(draw(0, 1) * faces.size()))];
    a.picture.scale = draw(0.35, 0.95) * kSide / face.side;
    const double room_px = 0.15 * kSide, middle = kSide / 2.0;
    a.picture.shift_x_px = a.picture.shift_y_px = 0;
    const auto [x, y] = Warp(a.picture).forward(face.x + face.side / 2, face.y + face.side / 2);
    a.picture.shift_x_px = middle - x + draw(-room_px, room_px);
    a.picture.shift_y_px = middle - y + draw(-room_px, room_px);
  }
  a.picture.blur_passes = std::max(0, static_cast<int>(draw(-4, 5)));
  a.has_behind = draw(0, 1) < 0.6;
  a.behind.rotation_rad = 0;
  a.behind.shift_x_px = a.behind.shift_y_px = 0;
  a.behind.scale = 1;
  if (draw(0, 1) < 0.35) {
    const double width = draw(0.03, 0.35), height = draw(0.03, 0.35);
    a.patch = {draw(-width / 2, 1 - width / 2), draw(-height / 2, 1 - height / 2), width, height};
    for (float& c : a.patch_color) c = static_cast<float>(draw(-0.5, 0.5));
  }
  return a;
}

std::vector<TrueFace> make_face_example(const scenes::PersonSample& sample, const std::vector<TrueFace>& faces,
                                        const scenes::PersonSample* behind, const FaceAugmentation& a, float* input,
                                        float* targets) {
  const std::vector<float> planes = varied_picture(sample, a.picture);
  std::vector<float> around;
  if (behind != nullptr) around = varied_picture(*behind, a.behind);
  for (int i = 0; i < kSide * kSide; ++i) {
    const float* const p = planes.data() + kPlanes * i;
    for (int c = 0; c < 3; ++c) {
      const float beyond = around.empty() ? 0 : (1 - p[4]) * around[kPlanes * i + c];
      input[c * kSide * kSide + i] = p[c] + beyond - 0.5F;
    }
  }
  for (int y = 0; y < kSide; ++y) {
    if (!(y >= a.patch[1] * kSide && y < (a.patch[1] + a.patch[3]) * kSide)) continue;
    for (int x = 0; x < kSide; ++x) {
      if (!(x >= a.patch[0] * kSide && x < (a.patch[0] + a.patch[2]) * kSide)) continue;
      for (int c = 0; c < 3; ++c) input[(c * kSide + y) * kSide + x] = a.patch_color[c];
    }
  }

  const Warp warp(a.picture);
  std::vector<TrueFace> moved;
  for (const TrueFace& face : faces) {
    const auto [x, y] = warp.forward(face.x + face.side / 2, face.y + face.side / 2);
    if (!(x >= 0 && y >= 0 && x < kSide && y < kSide)) continue;
    const double side = face.side * a.picture.scale;
    // what is in front covers a part of the face, at most as much as it does of the square
    const double covered_x =
        std::min(x + side / 2, (a.patch[0] + a.patch[2]) * kSide) - std::max(x - side / 2, a.patch[0] * kSide);
    const double covered_y =
        std::min(y + side / 2, (a.patch[1] + a.patch[3]) * kSide) - std::max(y - side / 2, a.patch[1] * kSide);
    constexpr double kMostCovered = 0.4;
    const bool seen = !(covered_x > 0 && covered_y > 0 && covered_x * covered_y > kMostCovered * side * side);
    moved.push_back(
        {x - side / 2, y - side / 2, side, face.turn_deg, face.certain && seen && side >= kSmallestFace_px});
  }
  constexpr int kPlane = kCells * kCells;
  std::fill_n(targets, 5 * kPlane, 0.F);
  std::fill_n(targets + 5 * kPlane, kPlane, 1.F);
  for (const bool certain : {false, true}) {
    for (const TrueFace& face : moved) {
      if (face.certain == certain) draw_target(face, targets);
    }
  }
  return moved;
}

FaceExamples::FaceExamples(const scenes::PeopleSet& set) : set_(set), pictures_(face_pictures(set)) {
  for (std::size_t i = 0; i < pictures_.size(); ++i) {
    if (set[pictures_[i].sample].people == 0) of_nobody_.push_back(pictures_[i].sample);
  }
}

namespace {

Batch empty_batch(std::size_t count) {
  const auto n = static_cast<std::int64_t>(count);
  return {torch::empty({n, 3, kSide, kSide}), {}, torch::empty({n, kFaceTargets, kCells, kCells})};
}

}  // namespace

Batch FaceExamples::augmented(const std::vector<Draw>& draws) const {
  Batch batch = empty_batch(draws.size());
  float* const inputs = batch.input.data_ptr<float>();
  float* const targets = batch.heatmaps.data_ptr<float>();
  tbb::parallel_for(std::size_t{0}, draws.size(), [&](std::size_t i) {
    const FacePicture& picture = pictures_[draws[i].index];
    const FaceAugmentation a = draw_face_augmentation(draws[i].key, picture.faces);
    const scenes::PersonSample* behind = nullptr;
    if (a.has_behind && !of_nobody_.empty()) {
      behind = &set_[of_nobody_[simulator::hash(draws[i].key, 3) % of_nobody_.size()]];
    }
    make_face_example(set_[picture.sample], picture.faces, behind, a, inputs + i * 3 * kSide * kSide,
                      targets + i * kFaceTargets * kCells * kCells);
  });
  return batch;
}

Batch FaceExamples::plain(std::size_t first, std::size_t count) const {
  Batch batch = empty_batch(count);
  for (std::size_t i = 0; i < count; ++i) {
    const FacePicture& picture = pictures_[first + i];
    make_face_example(set_[picture.sample], picture.faces, nullptr, {},
                      batch.input.data_ptr<float>() + i * 3 * kSide * kSide,
                      batch.heatmaps.data_ptr<float>() + i * kFaceTargets * kCells * kCells);
  }
  return batch;
}

}  // namespace dualpixel::tools
