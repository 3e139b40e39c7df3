#include "tools/train_segmentation/augment.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "simulator/sampling/hash.h"

namespace dualpixel::tools {
namespace {

constexpr int kSize = scenes::kPictureSide_px, kHeat = kSize / 4;
constexpr double kFaceSigma_px = 21;      // paper section 3.2
constexpr double kHeatSigma_px = 1.5;     // of the 64 x 64 map
constexpr double kHalveBelowScale = 0.6;  // scaled down further, a picture is halved first: bilinear reading aliases

// COCO's order: nose, eyes, ears, shoulders, elbows, wrists, hips, knees, ankles; left before right.
constexpr std::array<int, scenes::kKeypoints> kMirrored = {0, 2, 1, 4, 3, 6, 5, 8, 7, 10, 9, 12, 11, 14, 13, 16, 15};

using Planes = std::vector<float>;

/// The photograph's frame: what is left of the picture without its black rows and columns.
struct Frame {
  int left = 0, top = 0, right = kSize, bottom = kSize;
};

Frame frame_of(const std::uint8_t* picture) {
  const auto black_row = [&](int y) {
    const std::uint8_t* row = picture + y * kSize * 3;
    return std::all_of(row, row + kSize * 3, [](std::uint8_t v) { return v == 0; });
  };
  const auto black_column = [&](int x) {
    for (int y = 0; y < kSize; ++y) {
      const std::uint8_t* p = picture + (y * kSize + x) * 3;
      if ((p[0] | p[1] | p[2]) != 0) return false;
    }
    return true;
  };
  Frame frame;
  while (frame.top < frame.bottom && black_row(frame.top)) ++frame.top;
  while (frame.bottom > frame.top && black_row(frame.bottom - 1)) --frame.bottom;
  while (frame.left < frame.right && black_column(frame.left)) ++frame.left;
  while (frame.right > frame.left && black_column(frame.right - 1)) --frame.right;
  return frame;
}

Planes relit(const scenes::PersonSample& sample, const Augmentation& a) {
  std::array<std::array<float, 256>, 3> curve;
  for (int c = 0; c < 3; ++c) {
    for (int v = 0; v < 256; ++v) {
      const double value = (std::pow(a.gain[c] * v / 255, a.gamma) - 0.5) * a.contrast + 0.5;
      curve[c][v] = static_cast<float>(std::clamp(value, 0.0, 1.0));
    }
  }
  const auto saturation = static_cast<float>(a.saturation);
  const Frame frame = frame_of(sample.picture);
  Planes planes(kSize * kSize * kPlanes);
  // the mask of every pixel: a photograph's own border may be black, too
  for (int i = 0; i < kSize * kSize; ++i) planes[kPlanes * i + 3] = static_cast<float>(sample.mask[i]) / 255;
  for (int y = frame.top; y < frame.bottom; ++y) {
    for (int x = frame.left; x < frame.right; ++x) {
      const int i = y * kSize + x;
      const std::uint8_t* p = sample.picture + 3 * i;
      const float r = curve[0][p[0]], g = curve[1][p[1]], b = curve[2][p[2]];
      const float gray = 0.299F * r + 0.587F * g + 0.114F * b;
      float* out = planes.data() + kPlanes * i;
      out[0] = std::clamp(gray + saturation * (r - gray), 0.F, 1.F);
      out[1] = std::clamp(gray + saturation * (g - gray), 0.F, 1.F);
      out[2] = std::clamp(gray + saturation * (b - gray), 0.F, 1.F);
      out[4] = 1;
    }
  }
  return planes;
}

/// Means of 2 x 2 pixels.
Planes halved(const Planes& planes, int size) {
  const int half = size / 2;
  Planes result(half * half * kPlanes);
  for (int y = 0; y < half; ++y) {
    for (int x = 0; x < half; ++x) {
      const float* p = planes.data() + kPlanes * (2 * y * size + 2 * x);
      const float* q = p + kPlanes * size;
      float* out = result.data() + kPlanes * (y * half + x);
      for (int c = 0; c < kPlanes; ++c) out[c] = (p[c] + p[kPlanes + c] + q[c] + q[kPlanes + c]) / 4;
    }
  }
  return result;
}

/// Reads bilinearly, black outside.
Planes warped(const Planes& source, int source_size, const Warp& warp) {
  const double per_px = static_cast<double>(source_size) / kSize;
  const auto [x0, y0] = warp.back(0.5, 0.5);
  const auto [x1, y1] = warp.back(1.5, 0.5);
  const auto [x2, y2] = warp.back(0.5, 1.5);
  const auto along_x = static_cast<float>(per_px * (x1 - x0)), along_y = static_cast<float>(per_px * (y1 - y0));
  Planes result(kSize * kSize * kPlanes);
  for (int y = 0; y < kSize; ++y) {
    const auto row_x = static_cast<float>(per_px * (x0 + y * (x2 - x0)) - 0.5);
    const auto row_y = static_cast<float>(per_px * (y0 + y * (y2 - y0)) - 0.5);
    for (int x = 0; x < kSize; ++x) {
      const float fx = row_x + x * along_x, fy = row_y + x * along_y;
      const int ix = static_cast<int>(std::floor(fx)), iy = static_cast<int>(std::floor(fy));
      if (ix < -1 || iy < -1 || ix >= source_size || iy >= source_size) continue;
      float* out = result.data() + kPlanes * (y * kSize + x);
      const float wx = fx - static_cast<float>(ix), wy = fy - static_cast<float>(iy);
      const std::array<float, 4> weights = {(1 - wx) * (1 - wy), wx * (1 - wy), (1 - wx) * wy, wx * wy};
      for (int corner = 0; corner < 4; ++corner) {
        const int sx = ix + corner % 2, sy = iy + corner / 2;
        if (sx < 0 || sy < 0 || sx >= source_size || sy >= source_size) continue;
        const float* p = source.data() + kPlanes * (sy * source_size + sx);
        for (int c = 0; c < kPlanes; ++c) out[c] += weights[corner] * p[c];
      }
    }
  }
  return result;
}

/// A binomial blur of the colors, [1 2 1] / 4 along each axis in place; the border's pixels keep their values.
void blur_colors(Planes& planes) {
  for (const int step : {kPlanes, kPlanes * kSize}) {
    for (int line = 0; line < kSize; ++line) {
      float* const first = planes.data() + line * (step == kPlanes ? kPlanes * kSize : kPlanes);
      std::array<float, 3> before = {first[0], first[1], first[2]};
      for (int i = 1; i + 1 < kSize; ++i) {
        float* p = first + i * step;
        for (int c = 0; c < 3; ++c) {
          const float here = p[c];
          p[c] = (before[c] + 2 * here + p[step + c]) / 4;
          before[c] = here;
        }
      }
    }
  }
}

/// About a standard normal deviate from 64 random bits: the sum of four uniform ones.
float normal(std::uint64_t bits) {
  const std::uint64_t sum = (bits & 0xffff) + (bits >> 16 & 0xffff) + (bits >> 32 & 0xffff) + (bits >> 48);
  return (static_cast<float>(sum) / 65536 - 2) * 1.7320508F;
}

void draw_heatmaps(const scenes::PersonSample& sample, bool mirror, const Warp& warp, float* heatmaps) {
  std::fill_n(heatmaps, kHeat * kHeat * scenes::kKeypoints, 0.F);
  constexpr double kPerHeat = static_cast<double>(kSize) / kHeat;
  constexpr int kReach = 5;
  for (int k = 0; k < scenes::kKeypoints; ++k) {
    const float* point = sample.keypoints + 3 * (mirror ? kMirrored[k] : k);
    if (point[2] < 0.5F) continue;
    const auto [px, py] = warp.forward(point[0], point[1]);
    if (!(px >= 0 && py >= 0 && px < kSize && py < kSize)) continue;
    const double hx = px / kPerHeat, hy = py / kPerHeat;
    for (int y = std::max(0, static_cast<int>(hy) - kReach); y <= std::min(kHeat - 1, static_cast<int>(hy) + kReach);
         ++y) {
      for (int x = std::max(0, static_cast<int>(hx) - kReach); x <= std::min(kHeat - 1, static_cast<int>(hx) + kReach);
           ++x) {
        const double d2 = (x + 0.5 - hx) * (x + 0.5 - hx) + (y + 0.5 - hy) * (y + 0.5 - hy);
        heatmaps[(y * kHeat + x) * scenes::kKeypoints + k] =
            static_cast<float>(std::exp(-d2 / (2 * kHeatSigma_px * kHeatSigma_px)));
      }
    }
  }
}

/// To the photograph's colors, not to its padding.
void add_noise(Planes& planes, const Augmentation& a) {
  const auto noise = static_cast<float>(a.noise);
  for (int i = 0; i < kSize * kSize; ++i) {
    float* p = planes.data() + kPlanes * i;
    for (int c = 0; c < 3; ++c) {
      p[c] = std::clamp(p[c] + p[4] * noise * normal(simulator::hash(a.noise_key + 3 * i + c)), 0.F, 1.F);
    }
  }
}

}  // namespace

Warp::Warp(const Augmentation& a)
    : cos_scaled_(a.scale * std::cos(a.rotation_rad)),
      sin_scaled_(a.scale * std::sin(a.rotation_rad)),
      flip_(a.mirror ? -1 : 1),
      shift_x_(a.shift_x_px),
      shift_y_(a.shift_y_px) {}

std::array<double, 2> Warp::forward(double x, double y) const {
  const double u = flip_ * (x - kSize / 2.0), v = y - kSize / 2.0;
  return {cos_scaled_ * u - sin_scaled_ * v + shift_x_ + kSize / 2.0,
          sin_scaled_ * u + cos_scaled_ * v + shift_y_ + kSize / 2.0};
}

std::array<double, 2> Warp::back(double x, double y) const {
  const double u = x - shift_x_ - kSize / 2.0, v = y - shift_y_ - kSize / 2.0;
  const double scale2 = cos_scaled_ * cos_scaled_ + sin_scaled_ * sin_scaled_;
  return {flip_ * (cos_scaled_ * u + sin_scaled_ * v) / scale2 + kSize / 2.0,
          (cos_scaled_ * v - sin_scaled_ * u) / scale2 + kSize / 2.0};
}

double Draws::operator()(double low, double high) {
  return low + (high - low) * simulator::unit_float(static_cast<std::uint32_t>(simulator::hash(key, count++) >> 32));
}

std::vector<float> varied_picture(const scenes::PersonSample& sample, const Augmentation& a) {
  const Warp warp(a);
  Planes planes = relit(sample, a);
  planes = a.scale < kHalveBelowScale ? warped(halved(planes, kSize), kSize / 2, warp) : warped(planes, kSize, warp);
  for (int i = 0; i < a.blur_passes; ++i) blur_colors(planes);
  if (a.noise > 0) add_noise(planes, a);
  return planes;
}

Augmentation draw_augmentation(std::uint64_t key) {
  Draws draw{key};
  Augmentation a;
  a.mirror = draw(0, 1) < 0.5;
  a.rotation_rad = draw(-10, 10) * M_PI / 180;
  a.scale = draw(0.4, 1.2);
  a.shift_x_px = draw(-0.1, 0.1) * kSize;
  a.shift_y_px = draw(-0.1, 0.1) * kSize;
  a.face_shift_x = draw(-0.15, 0.15);
  a.face_shift_y = draw(-0.15, 0.15);
  const double exposure = std::exp(draw(-0.3, 0.3));
  for (double& gain : a.gain) gain = exposure * std::exp(draw(-0.12, 0.12));
  a.gamma = std::exp(draw(-0.35, 0.35));
  a.contrast = draw(0.75, 1.25);
  a.saturation = draw(0, 1) < 0.05 ? 0 : draw(0.5, 1.4);
  a.blur_passes = std::max(0, static_cast<int>(draw(-3, 3)));  // none two times in three
  a.noise = draw(0, 1) < 0.5 ? 0 : 0.06 * std::pow(draw(0, 1), 2);
  a.noise_key = simulator::hash(key, draw.count);
  return a;
}

void make_example(const scenes::PersonSample& sample, const Augmentation& a, float* input, float* mask,
                  float* heatmaps) {
  const Warp warp(a);
  const Planes planes = varied_picture(sample, a);

  const double face_x = sample.face[0] + (0.5 + a.face_shift_x) * sample.face[2];
  const double face_y = sample.face[1] + (0.5 + a.face_shift_y) * sample.face[3];
  const auto [cx, cy] = warp.forward(face_x, face_y);
  std::array<float, kSize> across, down;  // the Gaussian is a product of the two
  for (int i = 0; i < kSize; ++i) {
    const double dx = i + 0.5 - cx, dy = i + 0.5 - cy;
    across[i] = static_cast<float>(std::exp(-dx * dx / (2 * kFaceSigma_px * kFaceSigma_px)));
    down[i] = static_cast<float>(std::exp(-dy * dy / (2 * kFaceSigma_px * kFaceSigma_px)));
  }

  for (int i = 0; i < kSize * kSize; ++i) {
    const float* p = planes.data() + kPlanes * i;
    for (int c = 0; c < 3; ++c) input[4 * i + c] = p[c] - 0.5F;
    input[4 * i + 3] = across[i % kSize] * down[i / kSize];
    mask[i] = p[3];
  }
  if (heatmaps != nullptr) draw_heatmaps(sample, a.mirror, warp, heatmaps);
}

}  // namespace dualpixel::tools
