#include "simulator/lens/split/split_sampler.h"

#include <algorithm>
#include <cmath>

namespace dualpixel::simulator {
namespace {

constexpr int kTableSteps = 1024;

/// How much steeper an ideal lens's chief ray is than the one the microlens was shifted for.
float excess_slope(const SplitPixel& split, float x_m, float chief_slope) {
  const double design_m = split.microlens.design_exit_pupil_mm * 1e-3;
  if (split.kind != SplitKind::microlens || design_m == 0) return 0;
  return static_cast<float>(chief_slope - x_m / design_m);
}

}  // namespace

SplitSampler::SplitSampler(const SplitPixel& split, double rim_slope) : split_(split), rim_slope_(rim_slope) {
  if (split.kind != SplitKind::microlens && split.kind != SplitKind::table) return;
  double reach = 1;
  if (split.kind == SplitKind::microlens) {
    const SplitPixel::Microlens& m = split.microlens;
    const double spot = m.radius * std::abs(1 - m.height / m.focal_length);
    reach = (m.diode_width + spot + std::abs(m.shift)) / std::max(m.height, 1e-3) + 1e-3;
  }
  table_.low = static_cast<float>(-reach);
  table_.per_step = static_cast<float>(kTableSteps / (2 * reach));
  for (int i = 0; i <= kTableSteps + 1; ++i) {
    const double at = -reach + 2 * reach * std::min(i, kTableSteps) / kTableSteps;
    const SplitPixel::Shares s = split.shares(at, at);
    table_.left.push_back(static_cast<float>(s.left));
    table_.right.push_back(static_cast<float>(s.right));
  }
}

void SplitSampler::weigh_by_table(const PixelFrame& f, const PupilPacket& pupil, LensPacket& out) const {
  const bool microlens = split_.kind == SplitKind::microlens;
  const float offset = pupil.split_offset;
  const float excess = excess_slope(split_, f.x_m, pupil.chief_slope);
  const auto rim = static_cast<float>(rim_slope_);
  for (int i = 0; i < kPacket; ++i) {
    const float at = microlens ? pupil.t[i] - offset * rim + excess : pupil.p[i] - offset;
    const float u = std::clamp((at - table_.low) * table_.per_step, 0.0f, static_cast<float>(kTableSteps));
    const int k = static_cast<int>(u);
    const float fraction = u - static_cast<float>(k);
    out.left[i] = table_.left[k] + fraction * (table_.left[k + 1] - table_.left[k]);
    out.right[i] = table_.right[k] + fraction * (table_.right[k + 1] - table_.right[k]);
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
    case SplitKind::table:
      weigh_by_table(f, pupil, out);
      break;
  }
  for (int i = 0; i < kPacket; ++i) {
    out.left[i] *= pupil.left_gain * pupil.weight[i];
    out.right[i] *= pupil.right_gain * pupil.weight[i];
  }
}

}  // namespace dualpixel::simulator
