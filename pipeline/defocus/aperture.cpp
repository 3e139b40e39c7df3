#include "pipeline/defocus/aperture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "capture/error.h"

namespace dualpixel::pipeline {
namespace {

constexpr double kPi = std::numbers::pi;

}  // namespace

void require_valid(const Aperture& aperture) {
  if (aperture.blades != 0 && !(aperture.blades >= 3 && aperture.blades <= 16)) {
    throw InputError(fmt::format("aperture: blades: {}: must be 0 (round) or 3 to 16", aperture.blades));
  }
  if (!(aperture.cats_eye >= 0 && aperture.cats_eye <= 0.9)) {
    throw InputError(fmt::format("aperture: cats_eye: {}: must lie in [0, 0.9]", aperture.cats_eye));
  }
}

BlurShape blur_shape(const Aperture& aperture, bool in_front_of_focus) {
  BlurShape shape;
  if (aperture.blades > 0) {
    const double sector = 2 * kPi / aperture.blades;
    shape.extent = std::sqrt(sector / std::sin(sector));  // n triangles of half this squared times the sine make pi
    shape.side_distance = shape.extent * std::cos(sector / 2);
    const double up = in_front_of_focus ? 1 : -1;  // y is down
    for (int side = 0; side < aperture.blades; ++side) {
      const double angle = (side + 0.5) * sector;
      shape.normals.push_back({std::sin(angle), up * std::cos(angle)});
      if (aperture.transposed) std::swap(shape.normals.back()[0], shape.normals.back()[1]);
    }
  }
  return shape;
}

void cut_to_cats_eye(BlurShape& shape, const Aperture& aperture, double field_x, double field_y) {
  const double shift = shape.extent * aperture.cats_eye;
  shape.cut = {shift * field_x, shift * field_y};
}

Chord chord(const BlurShape& shape, double radius, double y) {
  const double rim = shape.extent * radius;
  Chord common{-rim, rim};
  const auto cut_circle = [&](double middle_x, double middle_y) {
    const double squared = rim * rim - (y - middle_y) * (y - middle_y);
    const double half = squared > 0 ? std::sqrt(squared) : -rim;
    common = {std::max(common.begin, middle_x - half), std::min(common.end, middle_x + half)};
  };
  for (const auto& [nx, ny] : shape.normals) {
    const double left = shape.side_distance * radius - ny * y;  // x nx <= left
    if (std::abs(nx) < 1e-9) {
      if (left < 0) common.end = common.begin;
    } else if (nx > 0) {
      common.end = std::min(common.end, left / nx);
    } else {
      common.begin = std::max(common.begin, left / nx);
    }
  }
  const bool lens = shape.cut[0] != 0 || shape.cut[1] != 0;
  if (shape.normals.empty() || lens) cut_circle(radius * shape.cut[0], radius * shape.cut[1]);
  if (lens) cut_circle(-radius * shape.cut[0], -radius * shape.cut[1]);
  return common;
}

double depth_inside(const BlurShape& shape, double radius, double x, double y) {
  double depth = shape.extent * radius;
  for (const auto& [nx, ny] : shape.normals) {
    depth = std::min(depth, shape.side_distance * radius - nx * x - ny * y);
  }
  const double cut_x = radius * shape.cut[0], cut_y = radius * shape.cut[1];
  const bool lens = cut_x != 0 || cut_y != 0;
  if (shape.normals.empty() || lens) {
    const double rim = shape.extent * radius;
    depth = std::min({depth, rim - std::hypot(x - cut_x, y - cut_y), rim - std::hypot(x + cut_x, y + cut_y)});
  }
  return depth;
}

}  // namespace dualpixel::pipeline
