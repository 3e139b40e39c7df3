#include "simulator/render/shading/environment_light.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "simulator/render/shading/radiometry.h"

namespace dualpixel::simulator::testing {
namespace {

glm::vec3 direction_of(double down, double around) {
  const double theta = M_PI * down, phi = 2 * M_PI * (around - 0.5), r = std::sin(theta);
  return {static_cast<float>(r * std::sin(phi)), static_cast<float>(std::cos(theta)),
          static_cast<float>(-r * std::cos(phi))};
}

constexpr int kSkyWidth = 256, kSkyHeight = 128;

/// A clear sky over gray ground, and the sun in one pixel.
Environment sky_with_sun(int row, int column) {
  Environment sky{kSkyWidth, kSkyHeight, {}};
  const glm::vec3 to_sun = direction_of((row + 0.5) / kSkyHeight, (column + 0.5) / kSkyWidth);
  for (int y = 0; y < kSkyHeight; ++y) {
    for (int x = 0; x < kSkyWidth; ++x) {
      const glm::vec3 d = direction_of((y + 0.5) / kSkyHeight, (x + 0.5) / kSkyWidth);
      const float degrees = std::acos(std::min(glm::dot(d, to_sun), 1.0f)) * 180 / kPi;
      sky.radiance_nits.emplace_back(d.y > 0 ? 4000 * (1 - 0.5f * d.y) + 8000 * std::exp(-degrees / 15) : 500);
    }
  }
  sky.radiance_nits[row * kSkyWidth + column] = glm::vec3(1.8e8f);  // 1.6e9 over half a degree
  return sky;
}

/// Standard deviation over mean of one sample of the irradiance of an unshaded surface, by the integral of
/// (radiance times cosine)^2 over the density, on a grid of eight points to a pixel's side.
double deviation_of_sample(const Environment& sky, const EnvironmentLight& light, glm::vec3 normal) {
  constexpr int kFiner = 8;
  const int rows = sky.height * kFiner, columns = sky.width * kFiner;
  const EnvironmentLight::Choice choice{light.table_of(normal.x, normal.y, normal.z)};
  double lux = 0, squares = 0;
  for (int y = 0; y < rows; ++y) {
    const double steradians = 2 * M_PI / columns * (std::cos(M_PI * y / rows) - std::cos(M_PI * (y + 1) / rows));
    for (int x = 0; x < columns; ++x) {
      const glm::vec3 d = direction_of((y + 0.5) / rows, (x + 0.5) / columns);
      const double cosine = glm::dot(normal, d);
      if (cosine <= 0) continue;
      const double arriving = environment_radiance(sky, d).y * cosine;
      lux += arriving * steradians;
      squares += arriving * arriving / light.pdf(choice, d) * steradians;
    }
  }
  return std::sqrt(squares / (lux * lux) - 1);
}

// .86 to .95 were found; cells of 16 x 32 without bins give 8. Bins that miss the light that reaches into them from the
// sun's pixel give 2.2 where its row lies badly.
TEST(SlowEnvironmentLight, FindsASunOfOnePixel) {
  for (const int row : {20, 23, 26, 29}) {
    const Environment sky = sky_with_sun(row, 130 + row);
    EXPECT_LT(deviation_of_sample(sky, EnvironmentLight(sky), {0, 1, 0}), 1) << row;
  }
}

// Bins at the pole are several pixels high: the sun may stand in any of them. .66 to .91 were found; where one is
// stepped over, thousands.
TEST(SlowEnvironmentLight, FindsASunNearTheZenith) {
  for (const int row : {0, 1, 2, 3, 5}) {
    const Environment sky = sky_with_sun(row, 37);
    EXPECT_LT(deviation_of_sample(sky, EnvironmentLight(sky), {0, 1, 0}), 1) << row;
  }
}

}  // namespace
}  // namespace dualpixel::simulator::testing
