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

/// An even gray picture whose columns [first, end) are lighter.
Image with_columns(int first, int end) {
  Image image = uniform_picture(0.5f, 0.5f, 0.5f);
  for (int y = 0; y < image.height; ++y) std::fill(&image.at(first, y), &image.at(first, y) + 3 * (end - first), 0.9f);
  return image;
}

// Gray .5 and .9 are luminances .2140 and .7874, .5734 apart. At 67 pixels a degree the weights of the luminance filter
// are exp(-.4675 k^2), .3858 of their sum in the middle.
//
// Just beside a step the filter sees (1 - .3858) / 2 of it, L* 68.76 beside 53.39: 15.37^.7 = 6.771, .1639 of the
// largest, .3894 beyond the knee's slope. All weights of one sign of the edge filter lie on one side: the edge is
// .5734, and .3894^(1 - sqrt(.5734 / sqrt 2)) = .7099. The point filter sees less.
//
// On a line of one pixel the filter sees .3858 of it, L* 71.91: .4437. There the edge filter, which is odd, sees
// nothing, and the point filter the share of its middle among its negative weights, .2989 (sigma 2.748 pixels):
// .4437^(1 - sqrt(.2989 .5734 / sqrt 2)) = .5887. Far from both nothing differs.
TEST(Flip, EdgesAndPointsAmplifyByTheClosedForm) {
  const Image even = uniform_picture(0.5f, 0.5f, 0.5f);
  EXPECT_NEAR(flip_map(even, with_columns(24, 48)).at(23, 20), 0.7099, 1e-3);
  const Image line = flip_map(even, with_columns(24, 25));
  EXPECT_NEAR(line.at(24, 20), 0.5887, 1e-3);
  EXPECT_LT(line.at(3, 20), 1e-4);
}

TEST(Flip, OtherSizesAreRefused) {
  EXPECT_THROW(mean_flip(Image(4, 4, 3), Image(5, 4, 3)), InputError);
  EXPECT_THROW(mean_flip(Image(4, 4, 1), Image(4, 4, 1)), InputError);
}

}  // namespace
}  // namespace dualpixel::evaluation
