#include "simulator/scene/environment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string_view>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/image_io.h"
#include "simulator/scene/scene.h"

namespace dualpixel::simulator {
namespace {

constexpr int kLargestWidth = 16384;
constexpr int kLargestHeight = 8192;
constexpr float kMostNits = 1e12f;  // the sun's disc has 1.6e9; sums of squares stay far from float's limit

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw InputError(printable(path) + ": " + why);
}

bool is_exr_or_hdr(const std::string& path) {
  require_regular_file(path);
  char head[10] = {};
  std::ifstream(path, std::ios::binary).read(head, sizeof(head));
  const std::string_view bytes(head, sizeof(head));
  return bytes.starts_with("\x76\x2f\x31\x01") || bytes.starts_with("#?RADIANCE") || bytes.starts_with("#?RGBE");
}

/// A color of luminance 1 (Rec. 709).
glm::vec3 of_luminance_one(glm::vec3 rgb) { return rgb / glm::dot(rgb, glm::vec3(0.2126f, 0.7152f, 0.0722f)); }

}  // namespace

Environment read_environment(const std::string& path, float nits_per_unit) {
  if (!is_exr_or_hdr(path)) fail(path, "is no EXR or HDR picture, as an environment must be");
  const Image image = read_image(path);
  if (image.width > kLargestWidth || image.height > kLargestHeight) {
    fail(path, fmt::format("{} x {} pixels: an environment has at most {} x {}", image.width, image.height,
                           kLargestWidth, kLargestHeight));
  }
  if (image.channels == 2) fail(path, "2 channels: an environment has 1 or at least 3 (R, G, B)");
  Environment environment{image.width, image.height, {}};
  environment.radiance_nits.resize(image.pixel_count());
  for (std::size_t i = 0; i < environment.radiance_nits.size(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const float value = image.data[i * image.channels + (image.channels == 1 ? 0 : c)];
      const float nits = value * nits_per_unit;
      if (!(nits >= 0 && nits <= kMostNits)) {
        fail(path, fmt::format("pixel ({}, {}) holds {}, {:g} nits: must lie in [0, {:g}] nits", i % image.width,
                               i / image.width, value, nits, kMostNits));
      }
      environment.radiance_nits[i][c] = nits;
    }
  }
  return environment;
}

Environment make_sky(const SkyOptions& options, int width) {
  constexpr double kRadians = std::numbers::pi / 180;
  const glm::vec3 zenith = options.zenith_nits * of_luminance_one({0.45f, 0.9f, 2.0f});
  const glm::vec3 horizon = options.horizon_nits * of_luminance_one({1.1f, 1.0f, 0.9f});
  const glm::vec3 ground = options.ground_nits * of_luminance_one({1.1f, 1.0f, 0.8f});
  const glm::vec3 glow = options.sun_glow_nits * of_luminance_one({1.1f, 1.0f, 0.85f});
  const auto direction = [&](double elevation, double azimuth) {
    return glm::dvec3(std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                      -std::cos(elevation) * std::cos(azimuth));
  };
  const glm::dvec3 sun = direction(options.sun_elevation_deg * kRadians, options.sun_azimuth_deg * kRadians);

  Environment sky{width, width / 2, {}};
  sky.radiance_nits.reserve(static_cast<std::size_t>(width) * sky.height);
  for (int y = 0; y < sky.height; ++y) {
    const double elevation = (0.5 - (y + 0.5) / sky.height) * std::numbers::pi;
    // Haze: the path through it grows towards the horizon. A few degrees there blend sky into ground.
    const float haze = static_cast<float>(std::pow(1 - std::max(std::sin(elevation), 0.0), 4));
    const float above = glm::smoothstep(-2.0f, 2.0f, static_cast<float>(elevation / kRadians));
    const glm::vec3 clear = glm::mix(zenith, horizon, haze);
    for (int x = 0; x < width; ++x) {
      const double azimuth = ((x + 0.5) / width - 0.5) * 2 * std::numbers::pi;
      const double cosine = glm::dot(direction(elevation, azimuth), sun);
      const double widths = std::acos(std::clamp(cosine, -1.0, 1.0)) / (options.sun_glow_width_deg * kRadians);
      const glm::vec3 lobe = glow * static_cast<float>(std::exp(-0.5 * widths * widths));
      sky.radiance_nits.push_back(glm::mix(ground, clear + lobe, above));
    }
  }
  return sky;
}

}  // namespace dualpixel::simulator
