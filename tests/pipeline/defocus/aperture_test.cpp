#include "pipeline/defocus/aperture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "capture/error.h"
#include "pipeline/defocus/render.h"
#include "pipeline/defocus/scatter.h"

namespace dualpixel::pipeline {
namespace {

constexpr double kPi = std::numbers::pi;

/// By lines; where one misses a part of a flat side, by less than 2e-4 for what is measured here.
double area_of(const BlurShape& shape, double radius) {
  constexpr int kLines = 200000;
  const double top = shape.extent * radius;
  double area = 0;
  for (int line = 0; line < kLines; ++line) {
    const auto [begin, end] = chord(shape, radius, ((line + 0.5) / kLines * 2 - 1) * top);
    area += std::max(end - begin, 0.0) * 2 * top / kLines;
  }
  return area;
}

BlurShape shape_at(const Aperture& aperture, double field_x, double field_y) {
  BlurShape shape = blur_shape(aperture, false);
  cut_to_cats_eye(shape, aperture, field_x, field_y);
  return shape;
}

TEST(Aperture, PolygonsHaveTheDiscsArea) {
  for (int blades = 3; blades <= 16; ++blades) {
    for (const bool in_front : {false, true}) {
      EXPECT_NEAR(area_of(blur_shape({blades}, in_front), 2.5), kPi * 6.25, 2e-4) << blades;
    }
  }
  EXPECT_NEAR(area_of(blur_shape({}, false), 2.5), kPi * 6.25, 2e-4);
}

// Two circles of radius r whose middles lie 2 s r apart have 2 r^2 (acos s - s sqrt(1 - s^2)) in common.
TEST(Aperture, CatsEyesHaveTheAreaOfTwoCirclesInCommon) {
  for (const double field : {0.0, 0.25, 0.5, 1.0}) {
    for (const double direction : {0.0, 0.7, 2.0}) {
      const double s = 0.8 * field;
      const BlurShape shape = shape_at({0, 0.8}, field * std::cos(direction), field * std::sin(direction));
      EXPECT_NEAR(area_of(shape, 3), 18 * (std::acos(s) - s * std::sqrt(1 - s * s)), 2e-4) << field;
    }
  }
}

TEST(Aperture, DepthAndChordsAgree) {
  for (const Aperture& aperture : {Aperture{}, Aperture{5, 0}, Aperture{6, 0.5}, Aperture{0, 0.9}}) {
    const BlurShape shape = shape_at(aperture, -0.6, 0.5);
    for (double y = -1.7; y < 1.7; y += 0.0937) {
      const auto [begin, end] = chord(shape, 1, y);
      for (double x = -1.7; x < 1.7; x += 0.0871) {
        EXPECT_EQ(depth_inside(shape, 1, x, y) > 0, x > begin && x < end) << x << ' ' << y;
      }
    }
  }
}

/// Blurs one pixel of a picture.
Image impulse(int side, int x, int y, float radius, const Aperture& aperture, bool in_front, bool direct) {
  Layer layer{Image(side, side, 4), Image(side, side, 1, radius), in_front};
  std::fill_n(&layer.rgba.at(x, y), 4, 1.0f);
  Image out(side, side, 4);
  (direct ? scatter_direct : scatter_gradient)(layer, out, aperture);
  return out;
}

/// Share of the square of side 1 around (x, y) within a regular polygon of area pi r^2, a corner of which lies on the
/// y axis, at negative y for `up`: by the sign of cross products with its corners.
double polygon_coverage(int blades, double radius, bool up, int x, int y) {
  const double corner = radius * std::sqrt(2 * kPi / (blades * std::sin(2 * kPi / blades)));
  int inside = 0;
  for (int i = 0; i < 64; ++i) {
    const int column = i % 8, line = i / 8;
    const double u = x + (column + 0.5) / 8 - 0.5;
    const double v = (y + (line + 0.5) / 8 - 0.5) * (up ? 1 : -1);
    bool in = true;
    for (int k = 0; k < blades; ++k) {
      const double a = 2 * kPi * k / blades, b = 2 * kPi * (k + 1) / blades;
      const double ax = corner * std::sin(a), ay = -corner * std::cos(a);
      const double bx = corner * std::sin(b), by = -corner * std::cos(b);
      in &= (bx - ax) * (v - ay) - (by - ay) * (u - ax) >= 0;
    }
    inside += in;
  }
  return inside / 64.0;
}

TEST(Aperture, ImpulsesBecomePolygons) {
  constexpr int kSide = 47, kMiddle = 23;
  constexpr float kRadius = 12;
  for (const int blades : {3, 5, 6, 9}) {
    for (const bool in_front : {false, true}) {
      Image ideal(kSide, kSide);
      for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
          const double covered = polygon_coverage(blades, kRadius, !in_front, x - kMiddle, y - kMiddle);
          ideal.at(x, y) = static_cast<float>(covered / (kPi * kRadius * kRadius));
        }
      }
      for (const bool direct : {false, true}) {
        const Image shape = impulse(kSide, kMiddle, kMiddle, kRadius, {blades, 0}, in_front, direct);
        double energy = 0, both = 0, either = 0;
        for (int y = 0; y < kSide; ++y) {
          for (int x = 0; x < kSide; ++x) {
            energy += shape.at(x, y, 3);
            both += std::min(shape.at(x, y, 3), ideal.at(x, y));
            either += std::max(shape.at(x, y, 3), ideal.at(x, y));
          }
        }
        EXPECT_NEAR(energy, 1, 1e-4);
        EXPECT_GT(both / either, 0.9) << blades << (direct ? " direct" : " gradient");
      }
    }
  }
}

// Spreads along the line to the picture's middle and across it, against what two discs have in common.
TEST(Aperture, CatsEyesNarrowTowardsTheMiddle) {
  constexpr int kSide = 320;
  constexpr float kRadius = 12;
  for (const int at : {60, 160, 300}) {
    const Image shape = impulse(kSide, at, at, kRadius, {0, 0.6}, false, false);
    // what two discs have in common, on a grid of tenths of a pixel
    const double field = (at + 0.5 - kSide / 2.0) / (kSide / 2.0), cut = 0.6 * field * kRadius / std::sqrt(2);
    double area = 0, true_along = 0, true_across = 0, along = 0, across = 0;
    for (double v = -kRadius; v < kRadius; v += 0.1) {
      for (double u = -kRadius; u < kRadius; u += 0.1) {
        if (std::hypot(u - cut, v - cut) > kRadius || std::hypot(u + cut, v + cut) > kRadius) continue;
        area += 1;
        true_along += (u + v) * (u + v) / 2;
        true_across += (u - v) * (u - v) / 2;
      }
    }
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        along += shape.at(x, y, 0) * std::pow(x - at + y - at, 2) / 2;
        across += shape.at(x, y, 0) * std::pow(x - y, 2) / 2;
      }
    }
    // a pixel's square adds 1/12; two lines a row instead of the integral, some per cent of a row at either end
    EXPECT_NEAR(along, true_along / area + 1.0 / 12, 0.02 * true_along / area) << at;
    EXPECT_NEAR(across, true_across / area + 1.0 / 12, 0.02 * true_across / area) << at;
  }
}

// However small and narrow a cat's eye is, it has all of its pixel's light.
TEST(Aperture, SmallCatsEyesKeepTheirLight) {
  constexpr int kSide = 64;
  for (const double cut : {0.5, 0.9, 1.0}) {
    for (const float radius : {0.0f, 0.3f, 0.5f, 1.0f, 2.5f}) {
      for (const auto& [x, y] : {std::pair{5, 5}, {32, 5}, {31, 58}, {5, 32}}) {
        const Image shape = impulse(kSide, x, y, radius, {0, cut}, false, false);
        double light = 0;
        for (const float value : shape.data) light += value / 4;
        EXPECT_NEAR(light, 1, 1e-4) << cut << ' ' << radius << ' ' << x << ' ' << y;
      }
    }
  }
}

// As a cat's eye fades, its shape approaches the polygon; a transposed picture transposes the shape.
TEST(Aperture, ShapesFadeIntoEachOtherAndAreTransposed) {
  const BlurShape plain = blur_shape({3}, false), faint = shape_at({3, 1e-6}, 0.7, 0.7);
  EXPECT_NEAR(area_of(faint, 2), area_of(plain, 2), 1e-3);
  const BlurShape transposed = blur_shape({5, 0, true}, false), upright = blur_shape({5}, false);
  for (double y = -1.3; y < 1.3; y += 0.17) {
    for (double x = -1.3; x < 1.3; x += 0.13) {
      EXPECT_NEAR(depth_inside(transposed, 1, x, y), depth_inside(upright, 1, y, x), 1e-12);
    }
  }
}

// Tenths of a pixel of difference between neighbors: no cells show.
TEST(Aperture, CatsEyesChangeSmoothly) {
  constexpr int kSide = 200;
  const Aperture aperture{0, 0.9};
  for (int at = 150; at < 190; ++at) {
    const Image one = impulse(kSide, at, 100, 15, aperture, false, false);
    const Image next = impulse(kSide, at + 1, 100, 15, aperture, false, false);
    double difference = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 1; x < kSide; ++x) difference += std::abs(next.at(x, y, 0) - one.at(x - 1, y, 0));
    }
    // both rims move by 0.9 * 15 / 141 px = 0.1: of the area, about 0.2 px * 30 px over 700 px^2 minus what is cut
    EXPECT_LT(difference, 0.06) << at;
  }
}

TEST(Aperture, ConstantPicturesStayConstant) {
  Image disparity(70, 50), radius(70, 50);
  for (int y = 0; y < 50; ++y) {
    for (int x = 0; x < 70; ++x) disparity.at(x, y) = 0.03f * static_cast<float>(x - 35);
  }
  const BlurMapping mapping = make_blur_mapping(1, 0, 2688, false);
  radius = blur_radii(disparity, mapping);
  for (const Aperture& aperture : {Aperture{5, 0}, Aperture{0, 0.7}, Aperture{7, 0.9}}) {
    const Image out = render_defocus(Image(70, 50, 3, 0.4f), disparity, radius, mapping, {}, {aperture}).rgb;
    for (const float value : out.data) ASSERT_NEAR(value, 0.4f, 1e-5);
  }
}

TEST(Aperture, RefusesWhatCannotBe) {
  const Image rgb(8, 8, 3), map(8, 8);
  for (const Aperture& aperture : {Aperture{2, 0}, Aperture{17, 0}, Aperture{-1, 0}, Aperture{0, 0.95},
                                   Aperture{0, -0.1}, Aperture{0, std::nan("")}}) {
    EXPECT_THROW(render_defocus(rgb, map, map, BlurMapping(), {}, {aperture}), InputError);
  }
}

// A blurred layer behind what is there: it fills what is open, as far as it goes, and nothing shines through where
// discs pile up.
TEST(Scatter, LayersAreLaidBehindWhatIsInFront) {
  constexpr int kSide = 40;
  constexpr float kFront = 0.4f;  // of the light is the front's
  Layer layer{Image(kSide, kSide, 4), Image(kSide, kSide, 1, 4.0f)};
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide / 2; ++x) {
      layer.radius_px.at(x, y) = x < 12 ? 1 : 6;  // piles up between
      std::fill_n(&layer.rgba.at(x, y), 4, 0.9f);
    }
  }
  for (const auto& scatter : {scatter_direct, scatter_gradient}) {
    Image alone(kSide, kSide, 4), both(kSide, kSide, 4);
    for (int i = 0; i < kSide * kSide; ++i) {
      both.data[4 * i + 1] = 0.25f * kFront;
      both.data[4 * i + 3] = kFront;
    }
    scatter(layer, alone, {});
    scatter(layer, both, {});
    for (int x = 0; x < kSide; ++x) {
      const float alpha = alone.at(x, 20, 3), seen = std::min(alpha, 1 - kFront);
      EXPECT_NEAR(both.at(x, 20, 3), kFront + seen, 1e-5) << x;
      EXPECT_NEAR(both.at(x, 20, 0), seen, 1e-5) << x;  // the layer's red is its alpha
      EXPECT_NEAR(both.at(x, 20, 1), 0.25f * kFront + seen, 1e-5) << x;
    }
  }
}

// Two halves of a picture, blurred alike: neither hides the other at their border, where each is blurred to a half.
TEST(Scatter, HalvesOfAPictureMakeAWhole) {
  constexpr int kSide = 40, kBorder = 7;  // px from the picture's own
  Layer left{Image(kSide, kSide, 4), Image(kSide, kSide, 1, 5.0f)}, right = left;
  for (int y = 0; y < kSide; ++y) {
    std::fill_n(&left.rgba.at(0, y), 4 * kSide / 2, 1.0f);
    std::fill_n(&right.rgba.at(kSide / 2, y), 4 * kSide / 2, 1.0f);
  }
  for (const auto& scatter : {scatter_direct, scatter_gradient}) {
    Image halves(kSide, kSide, 4);
    scatter(left, halves, {});
    scatter(right, halves, {});
    for (int x = kBorder; x < kSide - kBorder; ++x) EXPECT_NEAR(halves.at(x, 20, 3), 1, 1e-5) << x;
  }
}

}  // namespace
}  // namespace dualpixel::pipeline
