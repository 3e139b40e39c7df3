#include "evaluation/metrics/flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "capture/error.h"

namespace dualpixel::evaluation {
namespace {

Image uniform_picture(float r, float g, float b) {
  Image image(48, 40, 3);
  for (std::size_t i = 0; i < image.data.size(); i += 3) {
    image.data[i] = r, image.data[i + 1] = g, image.data[i + 2] = b;
  }
  return image;
}

TEST(Flip, IsZeroForEqualPictures) {
  EXPECT_EQ(mean_flip(uniform_picture(0.3f, 0.5f, 0.2f), uniform_picture(0.3f, 0.5f, 0.2f)), 0);
}

// Even pictures have no features, and filters leave them as they are. By hand, from the formulas of CIELAB: blue is L*
// 32.30, a* 79.19, b* -107.86, green L* 87.73, a* -86.18, b* 83.18; Hunt-adjusted (25.58, -34.84) and (-75.61, 72.97);
// HyAB 55.43 + 147.97 = 203.4, to the power of .7: 41.30. Black to white is 100^.7 = 25.12 = .6082 of that, beyond the
// knee at .4: .95 + (.6082 - .4) / .6 * .05 = .9674. Black to gray of L* 20 is 20^.7 = 8.142, .1971 of it, below the
// knee: .95 / .4 * .1971 = .4682.
TEST(Flip, EvenPicturesDifferByTheClosedForm) {
  EXPECT_NEAR(mean_flip(uniform_picture(0, 0, 0), uniform_picture(1, 1, 1)), 0.9674, 5e-4);
  EXPECT_NEAR(mean_flip(uniform_picture(0, 1, 0), uniform_picture(0, 0, 1)), 1, 1e-4);
  // L* 20 is a luminance of ((20 + 16) / 116)^3 = .02989, in sRGB 1.055 .02989^(1/2.4) - .055 = .1896
  EXPECT_NEAR(mean_flip(uniform_picture(0, 0, 0), uniform_picture(0.1896f, 0.1896f, 0.1896f)), 0.4682, 2e-3);
}

// Far from a thin line nothing differs; at it, edges and points amplify the difference beyond that of colors.
TEST(Flip, FeaturesAmplify) {
  const Image even = uniform_picture(0.5f, 0.5f, 0.5f);
  Image line = even;
  for (int y = 0; y < 40; ++y) std::fill_n(&line.at(24, y), 3, 0.9f);
  const Image map = flip_map(even, line);
  EXPECT_LT(map.at(3, 20), 1e-4);
  EXPECT_GT(map.at(24, 20), 0.2);
  Image broad = even;
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 48; ++x) std::fill_n(&broad.at(x, y), 3, 0.52f);
  }
  EXPECT_GT(map.at(24, 20), flip_map(even, broad).at(24, 20));
}

TEST(Flip, OtherSizesAreRefused) {
  EXPECT_THROW(mean_flip(Image(4, 4, 3), Image(5, 4, 3)), InputError);
  EXPECT_THROW(mean_flip(Image(4, 4, 1), Image(4, 4, 1)), InputError);
}

}  // namespace
}  // namespace dualpixel::evaluation
