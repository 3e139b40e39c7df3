#include "simulator/lens/prescription/pupil_reach.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace dualpixel::simulator {
namespace {

// Places where the region is looked at: those of the table and between them.
constexpr int kFineNodes = 2 * PupilBounds::kNodes - 1, kFineDirections = 2 * PupilReach::kDirections - 1;

/// Directions are told apart by y / (|x| + |y|), which needs no arc functions.
float place_of(float x, float y) {
  constexpr float kNone = 1e-30f;  // at the center
  return 0.5f * (1 + y / (std::abs(x) + std::abs(y) + kNone)) * (PupilReach::kDirections - 1);
}

/// How far light passes in one direction, to 1/65536 and no less: the last sixteenth in which it does, refined.
float reach_towards(const PassesPupil& passes, double r_mm, float x, float y) {
  float from = 0, step = 1.0f / kPacket;
  for (int round = 0; round < 4; ++round) {
    PupilPositions at{};
    for (int i = 0; i < kPacket; ++i) {
      const float t = from + static_cast<float>(i + 1) * step;
      at.x[i] = t * x, at.y[i] = t * y, at.area[i] = 1;
    }
    bool passing[kPacket];
    passes(r_mm, at, passing);
    int last = kPacket - 1;
    while (last >= 0 && !passing[last]) --last;
    if (last == kPacket - 1) return from + kPacket * step;
    from += static_cast<float>(last + 1) * step;
    step /= kPacket;
  }
  return from + kPacket * step;
}

using FineReaches = std::vector<std::array<float, kFineDirections>>;

/// By how much the places around one of the table, between it and the next, lie beyond the line through both.
float bulge_around(const FineReaches& fine, int k, int j) {
  float most = 0;
  for (int near_k = std::max(k - 1, 0); near_k <= std::min(k + 1, kFineNodes - 1); ++near_k) {
    for (int near_j = std::max(j - 1, 0); near_j <= std::min(j + 1, kFineDirections - 1); ++near_j) {
      const int odd_k = near_k % 2, odd_j = near_j % 2;
      const float line = 0.25f * (fine[near_k - odd_k][near_j - odd_j] + fine[near_k - odd_k][near_j + odd_j] +
                                  fine[near_k + odd_k][near_j - odd_j] + fine[near_k + odd_k][near_j + odd_j]);
      most = std::max(most, fine[near_k][near_j] - line);
    }
  }
  return most;
}

}  // namespace

void PupilReach::draw_in(PupilPositions& p) const {
  for (int i = 0; i < kPacket; ++i) {
    const float place = place_of(p.x[i], p.y[i]);
    const int k = std::min(static_cast<int>(place), kDirections - 2);
    const float reaches = reach[k] + (place - static_cast<float>(k)) * (reach[k + 1] - reach[k]);
    p.x[i] *= reaches;
    p.y[i] *= reaches;
    p.area[i] *= reaches * reaches;
  }
}

PupilReach PupilReaches::at(double r_mm, double image_radius_mm) const {
  const double u = std::clamp(r_mm / image_radius_mm, 0.0, 1.0) * (PupilBounds::kNodes - 1);
  const int k = std::min(static_cast<int>(u), PupilBounds::kNodes - 2);
  const auto t = static_cast<float>(u - k);
  PupilReach between;
  for (int i = 0; i < PupilReach::kDirections; ++i) {
    between.reach[i] = nodes[k].reach[i] + t * (nodes[k + 1].reach[i] - nodes[k].reach[i]);
  }
  return between;
}

PupilReaches find_reaches(const PupilBounds& bounds, const PassesPupil& passes) {
  constexpr float kMargin = 1.0002f;
  FineReaches fine(kFineNodes);
  tbb::parallel_for(0, kFineNodes, [&](int k) {
    const double r_mm = bounds.image_radius_mm * k / (kFineNodes - 1);
    for (int j = 0; j < kFineDirections; ++j) {
      const float y = 2.0f * static_cast<float>(j) / (kFineDirections - 1) - 1, x = 1 - std::abs(y);
      const float length = std::hypot(x, y);
      fine[k][j] = reach_towards(passes, r_mm, x / length, y / length);
    }
  });
  PupilReaches reaches;
  for (int k = 0; k < PupilBounds::kNodes; ++k) {
    for (int j = 0; j < PupilReach::kDirections; ++j) {
      reaches.nodes[k].reach[j] = kMargin * (fine[2 * k][2 * j] + bulge_around(fine, 2 * k, 2 * j));
    }
  }
  return reaches;
}

}  // namespace dualpixel::simulator
