#include "capture/image/demosaic.h"

#include <algorithm>
#include <vector>

#include "capture/image/rows.h"

namespace dualpixel {
namespace {

enum Color { kRed, kGreen, kBlue };

Color color_at(const std::string& cfa, int x, int y) {
  switch (cfa[2 * (y & 1) + (x & 1)]) {
    case 'R':
      return kRed;
    case 'G':
      return kGreen;
    default:
      return kBlue;
  }
}

/// Index of the sample that mirroring about the first and the last of `size` samples puts at `i`.
int mirrored(int i, int size) {
  if (size == 1) return 0;
  const int period = 2 * (size - 1);
  const int phase = ((i % period) + period) % period;
  return std::min(phase, period - phase);
}

constexpr int kReach = 2;

/// One row with kReach mirrored samples on either side.
void load_row(const Image& mosaic, int y, std::vector<float>& padded) {
  const float* row = mosaic.row(mirrored(y, mosaic.height));
  std::copy(row, row + mosaic.width, padded.begin() + kReach);
  for (int k = 1; k <= kReach; ++k) {
    padded[kReach - k] = row[mirrored(-k, mosaic.width)];
    padded[kReach + mosaic.width - 1 + k] = row[mirrored(mosaic.width - 1 + k, mosaic.width)];
  }
}

}  // namespace

double balanced_white(const std::array<double, 3>& gains) { return *std::min_element(gains.begin(), gains.end()); }

Image white_balanced(Image mosaic, const std::string& cfa, const std::array<double, 3>& gains) {
  const float ceiling = static_cast<float>(balanced_white(gains));
  for_rows(mosaic.height, [&](int y) {
    float* row = mosaic.row(y);
    const float gain[2] = {static_cast<float>(gains[color_at(cfa, 0, y)]),
                           static_cast<float>(gains[color_at(cfa, 1, y)])};
    for (int x = 0; x < mosaic.width; ++x) row[x] = std::min(row[x] * gain[x & 1], ceiling);
  });
  return mosaic;
}

Image demosaic(const Image& mosaic, const std::string& cfa) {
  Image rgb(mosaic.width, mosaic.height, 3);
  tbb::parallel_for(tbb::blocked_range<int>(0, mosaic.height, 32), [&](const tbb::blocked_range<int>& rows) {
    std::vector<float> padded[2 * kReach + 1];
    for (std::vector<float>& row : padded) row.resize(mosaic.width + 2 * kReach);
    for (int y = rows.begin(); y < rows.end(); ++y) {
      for (int k = -kReach; k <= kReach; ++k) load_row(mosaic, y + k, padded[k + kReach]);
      const float* n2 = padded[0].data() + kReach;
      const float* n1 = padded[1].data() + kReach;
      const float* at = padded[2].data() + kReach;
      const float* s1 = padded[3].data() + kReach;
      const float* s2 = padded[4].data() + kReach;
      const bool green_first = color_at(cfa, 0, y) == kGreen;
      const int row_color = color_at(cfa, green_first ? 1 : 0, y);  // red or blue: the other color of this row
      const int other_color = kBlue - row_color;
      float* out = rgb.row(y);
      for (int x = 0; x < mosaic.width; ++x) {
        const float center = at[x];
        const float diagonal = n1[x - 1] + n1[x + 1] + s1[x - 1] + s1[x + 1];
        const float beside = at[x - 1] + at[x + 1];
        const float above_below = n1[x] + s1[x];
        const float beside2 = at[x - 2] + at[x + 2];
        const float above_below2 = n2[x] + s2[x];
        if (((x & 1) == 0) == green_first) {
          out[3 * x + row_color] = (5 * center + 4 * beside - diagonal - beside2 + 0.5f * above_below2) * 0.125f;
          out[3 * x + kGreen] = center;
          out[3 * x + other_color] = (5 * center + 4 * above_below - diagonal - above_below2 + 0.5f * beside2) * 0.125f;
        } else {
          const float cross2 = beside2 + above_below2;
          out[3 * x + row_color] = center;
          out[3 * x + kGreen] = (4 * center + 2 * (beside + above_below) - cross2) * 0.125f;
          out[3 * x + other_color] = (6 * center + 2 * diagonal - 1.5f * cross2) * 0.125f;
        }
      }
    }
  });
  return rgb;
}

Image in_srgb(Image rgb, const std::optional<Matrix3>& color_matrix) {
  if (!color_matrix) return rgb;
  std::array<float, 9> m;
  for (int i = 0; i < 9; ++i) m[i] = static_cast<float>((*color_matrix)[i]);
  for_rows(rgb.height, [&](int y) {
    float* pixel = rgb.row(y);
    for (int x = 0; x < rgb.width; ++x, pixel += 3) {
      const float r = pixel[0], g = pixel[1], b = pixel[2];
      for (int c = 0; c < 3; ++c) pixel[c] = m[3 * c] * r + m[3 * c + 1] * g + m[3 * c + 2] * b;
    }
  });
  return rgb;
}

}  // namespace dualpixel
