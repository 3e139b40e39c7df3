#include "pipeline/segmentation/face_map.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace dualpixel::pipeline {
namespace {

constexpr double kMostOverlap = 0.3;
constexpr float kSmallest = -4, kLargest = 6;  // logarithms of sides: an absurd network must not overflow

/// Whether no neighbor has a higher score; of equal ones the first counts.
bool is_peak(const float* scores, int cells, int x, int y) {
  const float here = scores[y * cells + x];
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, cells - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, cells - 1); ++u) {
      const float other = scores[v * cells + u];
      if (other > here || (other == here && (v < y || (v == y && u < x)))) return false;
    }
  }
  return true;
}

}  // namespace

double overlap(const Face& a, const Face& b) {
  const double width = std::min(a.x + a.width, b.x + b.width) - std::max(a.x, b.x);
  const double height = std::min(a.y + a.height, b.y + b.height) - std::max(a.y, b.y);
  if (!(width > 0 && height > 0)) return 0;
  return width * height / (a.area() + b.area() - width * height);
}

std::vector<ScoredFace> faces_of_map(const float* map, int cells, double least_score) {
  const std::ptrdiff_t plane = std::ptrdiff_t{cells} * cells;
  std::vector<ScoredFace> found;
  for (int y = 0; y < cells; ++y) {
    for (int x = 0; x < cells; ++x) {
      const float* const cell = map + y * cells + x;
      const double score = 1 / (1 + std::exp(-static_cast<double>(cell[0])));
      if (!(score >= least_score) || !is_peak(map, cells, x, y)) continue;
      const double side = kFaceUnit_px * std::exp2(std::clamp(cell[3 * plane], kSmallest, kLargest));
      const double center_x = kFaceCell_px * (x + 0.5) + cell[plane] * side;
      const double center_y = kFaceCell_px * (y + 0.5) + cell[2 * plane] * side;
      found.push_back({{center_x - side / 2, center_y - side / 2, side, side}, score});
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const ScoredFace& a, const ScoredFace& b) { return a.score > b.score; });
  std::vector<ScoredFace> kept;
  for (const ScoredFace& face : found) {
    const bool covered = std::any_of(kept.begin(), kept.end(), [&](const ScoredFace& better) {
      return overlap(better.face, face.face) > kMostOverlap;
    });
    if (!covered) kept.push_back(face);
  }
  return kept;
}

}  // namespace dualpixel::pipeline
