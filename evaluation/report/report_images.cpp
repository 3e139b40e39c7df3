#include "evaluation/report/report_images.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "capture/image/image_io.h"
#include "capture/image/jpeg.h"

namespace dualpixel::evaluation {
namespace {

constexpr float kMissingGray = 0.5f;
constexpr float kLightnessOfZero = 0.96f;
constexpr float kLightnessOfLimit = 0.48f;
constexpr float kChromaOfLimit = 0.125f;
constexpr float kBlueHueDegrees = 255;
constexpr float kOrangeHueDegrees = 55;

using Color = std::array<float, 3>;

/// sRGB of a color in Oklab; matrices of Ottosson 2020.
Color srgb_from_oklab(float lightness, float a, float b) {
  const auto cube = [](float v) { return v * v * v; };
  const float l = cube(lightness + 0.3963377774f * a + 0.2158037573f * b);
  const float m = cube(lightness - 0.1055613458f * a - 0.0638541728f * b);
  const float s = cube(lightness - 0.0894841775f * a - 1.2914855480f * b);
  return {srgb_from_linear(4.0767416621f * l - 3.3077115913f * m + 0.2309699292f * s),
          srgb_from_linear(-1.2684380046f * l + 2.6097574011f * m - 0.3413193965f * s),
          srgb_from_linear(-0.0041960863f * l - 0.7034186147f * m + 1.7076147010f * s)};
}

Color diverging_color(float t) {
  if (!std::isfinite(t)) return {kMissingGray, kMissingGray, kMissingGray};
  const float strength = std::min(std::abs(t), 1.0f);
  const float hue = (t < 0 ? kBlueHueDegrees : kOrangeHueDegrees) * std::numbers::pi_v<float> / 180;
  const float chroma = kChromaOfLimit * strength;
  return srgb_from_oklab(std::lerp(kLightnessOfZero, kLightnessOfLimit, strength), chroma * std::cos(hue),
                         chroma * std::sin(hue));
}

}  // namespace

Image resized(const Image& image, int width, int height) {
  Image out(width, height, image.channels);
  const double step_x = static_cast<double>(image.width) / width, step_y = static_cast<double>(image.height) / height;
  // How much of the source pixel [i, i + 1] lies in [begin, end].
  const auto overlap = [](int i, double begin, double end) {
    return std::min(i + 1.0, end) - std::max<double>(i, begin);
  };
  tbb::parallel_for(0, height, [&](int y) {
    const double top = y * step_y, bottom = top + step_y;
    for (int x = 0; x < width; ++x) {
      const double left = x * step_x, right = left + step_x;
      for (int c = 0; c < image.channels; ++c) {
        double sum = 0, area = 0;
        for (int sy = static_cast<int>(top); sy < std::min<double>(bottom, image.height); ++sy) {
          for (int sx = static_cast<int>(left); sx < std::min<double>(right, image.width); ++sx) {
            const float value = image.at(sx, sy, c);
            if (!std::isfinite(value)) continue;
            const double part = overlap(sx, left, right) * overlap(sy, top, bottom);
            sum += part * value;
            area += part;
          }
        }
        out.at(x, y, c) = area > 0 ? static_cast<float>(sum / area) : std::numeric_limits<float>::quiet_NaN();
      }
    }
  });
  return out;
}

Image diverging_colors(const Image& values, float limit) {
  Image colors(values.width, values.height, 3);
  tbb::parallel_for(0, values.height, [&](int y) {
    for (int x = 0; x < values.width; ++x) {
      const Color color = diverging_color(values.at(x, y) / limit);
      std::copy(color.begin(), color.end(), &colors.at(x, y));
    }
  });
  return colors;
}

Image gray_levels(const Image& values, float limit) {
  Image gray = values;
  for (float& value : gray.data) value = std::isfinite(value) ? std::clamp(value / limit, 0.0f, 1.0f) : kMissingGray;
  return gray;
}

float percentile(const Image& image, double share) {
  std::vector<float> finite;
  std::copy_if(image.data.begin(), image.data.end(), std::back_inserter(finite),
               [](float v) { return std::isfinite(v); });
  if (finite.empty()) return 0;
  const auto nth = finite.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(finite.size() - 1));
  std::nth_element(finite.begin(), nth, finite.end());
  return *nth;
}

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

std::string jpeg_data_uri(const Image& srgb, int quality) {
  return "data:image/jpeg;base64," + base64(jpeg(srgb, quality));
}

}  // namespace dualpixel::evaluation
