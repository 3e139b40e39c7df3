#include "pipeline/disparity/kernel_skew.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/disparity/split/split_shape.h"

namespace dualpixel::pipeline {
namespace {

float polynomial(const SkewCurve::Coefficients& c, float d) {
  float sum = 0;
  for (std::size_t i = c.size(); i-- > 0;) sum = sum * d + c[i];
  return sum;
}

float slope_of_polynomial(const SkewCurve::Coefficients& c, float d) {
  float sum = 0;
  for (std::size_t i = c.size(); i-- > 1;) sum = sum * d + static_cast<float>(i) * c[i];
  return sum;
}

/// a + share (b - a).
SkewCurve mixed(SkewCurve a, const SkewCurve& b, float share) {
  const auto mix = [share](float& to, float from) { to += share * (from - to); };
  for (std::size_t i = 0; i < a.xxx.size(); ++i) {
    mix(a.xxx[i], b.xxx[i]);
    mix(a.xyy[i], b.xyy[i]);
  }
  mix(a.farthest_dp_px, b.farthest_dp_px);
  return a;
}

struct Interval {
  int first = 0, second = 0;
  float share = 0;  ///< of the second
};

Interval interval(double fraction, int count) {
  const double at = std::clamp(fraction, 0.0, 1.0) * (count - 1);
  const int first = std::min(static_cast<int>(at), std::max(count - 2, 0));
  return {first, std::min(first + 1, count - 1), static_cast<float>(at - first)};
}

double fraction_of_node(int i, int count) { return count > 1 ? static_cast<double>(i) / (count - 1) : 0; }

}  // namespace

KernelSkew SkewCurve::at(float disparity_dp_px) const {
  const float d = std::clamp(disparity_dp_px, -farthest_dp_px, farthest_dp_px);
  return {polynomial(xxx, d), polynomial(xyy, d)};
}

KernelSkew SkewCurve::slope_at(float disparity_dp_px) const {
  if (std::abs(disparity_dp_px) > farthest_dp_px) return {};
  return {slope_of_polynomial(xxx, disparity_dp_px), slope_of_polynomial(xyy, disparity_dp_px)};
}

SkewCurve skew_of_split(double alpha, double pixel_height) {
  constexpr double kFarthestBlur_px = 6, kExact = 0.15;  // cycles a pixel
  const double farthest = kFarthestBlur_px * alpha, radius = kFarthestBlur_px / 2;
  const split::ShapeSkew narrow = split::skew_at(alpha, 0.1);
  const split::ShapeSkew wide = split::skew_at(alpha, 2 * std::numbers::pi * kExact * radius);
  const auto fit = [&](double narrow_skew, double wide_skew) {
    const double at_farthest = std::pow(radius, 3);
    SkewCurve::Coefficients coefficients{};
    coefficients[3] = static_cast<float>(at_farthest * narrow_skew / std::pow(farthest, 3));
    coefficients[5] = static_cast<float>(at_farthest * (wide_skew - narrow_skew) / std::pow(farthest, 5));
    return coefficients;
  };
  const double square_height = pixel_height * pixel_height;
  return {fit(narrow.xxx, wide.xxx), fit(narrow.xyy / square_height, wide.xyy / square_height),
          static_cast<float>(farthest)};
}

SkewCurve SkewField::at(double x, double y) const {
  if (nodes.empty()) return {};
  const Interval across = interval(x, columns), down = interval(y, rows);
  const auto row = [&](int j) {
    const SkewCurve* at = nodes.data() + static_cast<std::ptrdiff_t>(j) * columns;
    return mixed(at[across.first], at[across.second], across.share);
  };
  return mixed(row(down.first), row(down.second), down.share);
}

SkewCurve in_larger_pixels(const SkewCurve& curve, int side) {
  SkewCurve larger = curve;
  for (SkewCurve::Coefficients* coefficients : {&larger.xxx, &larger.xyy}) {
    for (std::size_t i = 0; i < coefficients->size(); ++i) {
      (*coefficients)[i] *= static_cast<float>(std::pow(side, static_cast<double>(i) - 3));
    }
  }
  larger.farthest_dp_px /= static_cast<float>(side);
  return larger;
}

SkewField mixed(const SkewField& a, const SkewField& b, float share) {
  SkewField field = a;
  for (std::size_t i = 0; i < field.nodes.size(); ++i) field.nodes[i] = mixed(a.nodes[i], b.nodes[i], share);
  return field;
}

SkewField of_part(const SkewField& whole, double x, double y, double width, double height) {
  SkewField part = whole;
  for (int row = 0; row < whole.rows; ++row) {
    for (int column = 0; column < whole.columns; ++column) {
      part.nodes[static_cast<std::size_t>(row) * whole.columns + column] =
          whole.at(x + width * fraction_of_node(column, whole.columns), y + height * fraction_of_node(row, whole.rows));
    }
  }
  return part;
}

}  // namespace dualpixel::pipeline
