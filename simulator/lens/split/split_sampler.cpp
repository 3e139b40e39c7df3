#include "simulator/lens/split/split_sampler.h"

#include <algorithm>
#include <cmath>

namespace dualpixel::simulator {
namespace {

constexpr int kTableSteps = 4096, kDiscSteps = 1024;

/// How much steeper an ideal lens's chief ray is than the one the microlens was shifted for.
float excess_slope(const SplitPixel& split, float x_m, float chief_slope) {
  const double design_m = split.microlens.design_exit_pupil_mm * 1e-3;
  if (design_m == 0) return 0;
  return static_cast<float>(chief_slope - x_m / design_m);
}

/// The share of an evenly lit disc of radius 1 that lies left of v, in kDiscSteps steps from 0 at -1 to 1 at 1.
const float* left_parts_of_disc() {
  static const std::vector<float> parts = [] {
    std::vector<float> table;
    for (int i = 0; i <= kDiscSteps + 1; ++i) {
      const double x = std::min(2.0 * i / kDiscSteps - 1, 1.0);
      table.push_back(static_cast<float>(0.5 + (x * std::sqrt(1 - x * x) + std::asin(x)) / M_PI));
    }
    return table;
  }();
  return parts.data();
}

/// Between the steps of left_parts_of_disc(), to 1e-5.
float left_part_of_disc(const float* parts, float v) {
  const float u = std::clamp((v + 1) * (0.5f * kDiscSteps), 0.0f, static_cast<float>(kDiscSteps));
  const int k = static_cast<int>(u);
  return parts[k] + (u - static_cast<float>(k)) * (parts[k + 1] - parts[k]);
}

}  // namespace

SplitSampler::SplitSampler(const SplitPixel& split, double rim_slope) : split_(split), rim_slope_(rim_slope) {
  if (split.kind != SplitKind::table) return;
  const double low = split.table.p.front(), high = split.table.p.back();
  table_.low = static_cast<float>(low);
  table_.per_step = static_cast<float>(kTableSteps / (high - low));
  for (int i = 0; i <= kTableSteps + 1; ++i) {
    const SplitPixel::Shares s = split.shares(low + (high - low) * std::min(i, kTableSteps) / kTableSteps, 0);
    table_.left.push_back(static_cast<float>(s.left));
    table_.right.push_back(static_cast<float>(s.right));
  }
}

void SplitSampler::weigh_by_table(const PupilPacket& pupil, LensPacket& out) const {
  for (int i = 0; i < kPacket; ++i) {
    const float p = pupil.p[i] - pupil.split_offset;
    const float u = std::clamp((p - table_.low) * table_.per_step, 0.0f, static_cast<float>(kTableSteps));
    const int k = static_cast<int>(u);
    const float fraction = u - static_cast<float>(k);
    out.left[i] = table_.left[k] + fraction * (table_.left[k + 1] - table_.left[k]);
    out.right[i] = table_.right[k] + fraction * (table_.right[k + 1] - table_.right[k]);
  }
}

/// SplitPixel::shares(), which would take three arc sines for each ray.
void SplitSampler::weigh_by_microlens(const PixelFrame& f, const PupilPacket& pupil, LensPacket& out) const {
  const SplitPixel::Microlens& m = split_.microlens;
  const double spot = std::max(m.radius * std::abs(1 - m.height / m.focal_length), 1e-9);
  const auto per_slope = static_cast<float>(m.height / spot), shift = static_cast<float>(m.shift / spot);
  const auto width = static_cast<float>(m.diode_width / spot), crosstalk = static_cast<float>(split_.crosstalk);
  const float middle =
      excess_slope(split_, f.x_m, pupil.chief_slope) - pupil.split_offset * static_cast<float>(rim_slope_);
  const float* parts = left_parts_of_disc();
  for (int i = 0; i < kPacket; ++i) {
    const float v = shift - per_slope * (pupil.t[i] + middle);  // of the border between the diodes, in spot radii
    const float below = left_part_of_disc(parts, v);
    const float left = below - left_part_of_disc(parts, v - width);
    const float right = left_part_of_disc(parts, v + width) - below;
    out.left[i] = left + crosstalk * (right - left);
    out.right[i] = right + crosstalk * (left - right);
  }
}

void SplitSampler::weigh(const PixelFrame& f, const PupilPacket& pupil, LensPacket& out) const {
  const auto crosstalk = static_cast<float>(split_.crosstalk);
  const float offset = pupil.split_offset;
  switch (split_.kind) {
    case SplitKind::hard:
      for (int i = 0; i < kPacket; ++i) {
        const float right = pupil.p[i] >= offset ? 1 - crosstalk : crosstalk;
        out.right[i] = right;
        out.left[i] = 1 - right;
      }
      break;
    case SplitKind::ramp: {
      const auto slope = static_cast<float>(0.5 / split_.k);
      for (int i = 0; i < kPacket; ++i) {
        const float s = std::clamp(0.5f + slope * (pupil.p[i] - offset), 0.0f, 1.0f);
        out.right[i] = s + crosstalk * (1 - 2 * s);
        out.left[i] = 1 - out.right[i];
      }
      break;
    }
    case SplitKind::microlens:
      weigh_by_microlens(f, pupil, out);
      break;
    case SplitKind::table:
      weigh_by_table(pupil, out);
      break;
  }
  for (int i = 0; i < kPacket; ++i) {
    out.left[i] *= pupil.left_gain * pupil.weight[i];
    out.right[i] *= pupil.right_gain * pupil.weight[i];
  }
}

}  // namespace dualpixel::simulator
