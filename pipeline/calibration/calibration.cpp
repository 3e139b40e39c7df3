#include "pipeline/calibration/calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "capture/error.h"
#include "pipeline/rows.h"

namespace dualpixel::pipeline {
namespace {

constexpr int kColumns = kCalibrationColumns, kRows = kCalibrationRows;
constexpr int kFewestTargets = 3;
constexpr double kSmallestSpan_per_m = 0.2;  ///< of the targets' inverse depth
constexpr float kLeastSlope = 0.2f;          ///< of the middle's
constexpr double kFocusReach_per_m = 0.5;
constexpr double kTiltWarning_deg = 0.7;

Image node_image(float fill = 0) { return Image(kColumns, kRows, 1, fill); }

/// Bilinear between pixel centres, at a place given as a fraction of the picture.
float sample(const Image& image, double x, double y) {
  const double u = std::clamp(x * image.width - 0.5, 0.0, image.width - 1.0);
  const double v = std::clamp(y * image.height - 0.5, 0.0, image.height - 1.0);
  const int i = std::min(static_cast<int>(u), std::max(image.width - 2, 0));
  const int j = std::min(static_cast<int>(v), std::max(image.height - 2, 0));
  const int right = std::min(i + 1, image.width - 1), below = std::min(j + 1, image.height - 1);
  const auto a = static_cast<float>(u - i), b = static_cast<float>(v - j);
  const float top = image.at(i, j) + a * (image.at(right, j) - image.at(i, j));
  const float bottom = image.at(i, below) + a * (image.at(right, below) - image.at(i, below));
  return top + b * (bottom - top);
}

/// Catmull-Rom weights of the nodes before, at, after and behind the interval that `t` is in.
std::array<float, 4> cubic(float t) {
  const float t2 = t * t, t3 = t2 * t;
  return {0.5f * (-t + 2 * t2 - t3), 0.5f * (2 - 5 * t2 + 3 * t3), 0.5f * (t + 4 * t2 - 3 * t3), 0.5f * (t3 - t2)};
}

/// The interval of `count` nodes that a fraction of the picture lies in, and how far along.
struct Interval {
  int first = 0;
  float t = 0;
};
Interval interval(double fraction, int count) {
  const double at = std::clamp(fraction, 0.0, 1.0) * (count - 1);
  const int first = std::min(static_cast<int>(at), count - 2);
  return {first, static_cast<float>(at - first)};
}

/// Nodes beyond the border go on as a straight line.
float beyond(const float* nodes, int stride, int count, int i) {
  if (i < 0) return 2 * nodes[0] - nodes[stride];
  if (i >= count) return 2 * nodes[(count - 1) * stride] - nodes[(count - 2) * stride];
  return nodes[i * stride];
}

double bicubic(const Image& nodes, double x, double y) {
  const Interval column = interval(x, kColumns), row = interval(y, kRows);
  const std::array<float, 4> wx = cubic(column.t), wy = cubic(row.t);
  float lines[kColumns];
  for (int i = 0; i < kColumns; ++i) {
    lines[i] = 0;
    for (int k = 0; k < 4; ++k) lines[i] += wy[k] * beyond(nodes.data.data() + i, kColumns, kRows, row.first - 1 + k);
  }
  double sum = 0;
  for (int k = 0; k < 4; ++k) sum += wx[k] * beyond(lines, 1, kColumns, column.first - 1 + k);
  return sum;
}

FocusCalibration fit_lines(const std::vector<const TargetMeasurement*>& targets) {
  FocusCalibration fit{
      targets.front()->focus_distance_m, node_image(), node_image(), node_image(), node_image(), node_image()};
  for (std::size_t i = 0; i < fit.count.data.size(); ++i) {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    for (const TargetMeasurement* target : targets) {
      if (target->usable.data[i] == 0) continue;
      const double inverse = 1 / target->target_distance_m, d = target->disparity_dp_px.data[i];
      n += 1, x += inverse, y += d, xx += inverse * inverse, xy += inverse * d, yy += d * d;
    }
    fit.count.data[i] = static_cast<float>(n);
    if (n < kFewestTargets) continue;
    xx -= x * x / n, xy -= x * y / n, yy -= y * y / n;
    if (!(std::sqrt(xx) > kSmallestSpan_per_m / 2)) continue;  // what was usable lies too close together
    const double slope = xy / xx;
    const double left = std::max(yy - slope * xy, 0.0);
    fit.slope_dp_px_m.data[i] = static_cast<float>(slope);
    fit.intercept_dp_px.data[i] = static_cast<float>((y - slope * x) / n);
    fit.residual_dp_px.data[i] = static_cast<float>(std::sqrt(left / n));
    fit.r_squared.data[i] = yy > 0 ? static_cast<float>(1 - left / yy) : 0.0f;
  }
  return fit;
}

std::string metres(double distance) { return fmt::format("{:g} m", distance); }

void require_span(const std::vector<const TargetMeasurement*>& targets) {
  std::vector<double> inverse;
  for (const TargetMeasurement* target : targets) inverse.push_back(1 / target->target_distance_m);
  std::sort(inverse.begin(), inverse.end());
  inverse.erase(std::unique(inverse.begin(), inverse.end()), inverse.end());
  const std::string focus = "calibration: focus distance " + metres(targets.front()->focus_distance_m);
  if (inverse.size() < kFewestTargets) {
    throw InputError(
        fmt::format("{}: {} target distances: a line needs at least {}", focus, inverse.size(), kFewestTargets));
  }
  if (inverse.back() - inverse.front() < kSmallestSpan_per_m) {
    throw InputError(
        fmt::format("{}: targets from {} to {}: too close together; their inverses must differ by {:g} / m", focus,
                    metres(1 / inverse.back()), metres(1 / inverse.front()), kSmallestSpan_per_m));
  }
}

float middle(const Image& nodes) { return nodes.at(kColumns / 2, kRows / 2); }

float mirrored(const Image& nodes, int i, int j) { return nodes.at(kColumns - 1 - i, kRows - 1 - j); }

double median(std::vector<double> values) {
  const auto centre = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), centre, values.end());
  return *centre;
}

}  // namespace

TargetMeasurement measure_target(const Image& left, const Image& right, double focus_distance_m,
                                 double target_distance_m, const FlowOptions& options, float most_mismatch) {
  const Flow flow = match_target(left, right, options);
  TargetMeasurement m{focus_distance_m, target_distance_m, node_image(), node_image()};
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      const double x = static_cast<double>(i) / (kColumns - 1), y = static_cast<double>(j) / (kRows - 1);
      m.disparity_dp_px.at(i, j) = sample(flow.disparity_dp_px, x, y);
      // a node speaks for the picture half way to its neighbours
      float sum = 0, count = 0;
      for (double v : {-0.5, -0.25, 0.0, 0.25, 0.5}) {
        for (double u : {-0.5, -0.25, 0.0, 0.25, 0.5}) {
          const double at_x = x + u / (kColumns - 1), at_y = y + v / (kRows - 1);
          if (at_x < 0.01 || at_x > 0.99 || at_y < 0 || at_y > 1) continue;  // matches end before the border
          sum += sample(flow.mismatch, at_x, at_y);
          ++count;
        }
      }
      m.usable.at(i, j) = sum <= most_mismatch * count ? 1.0f : 0.0f;
    }
  }
  return m;
}

Calibration fit_calibration(const Camera& camera, const std::vector<TargetMeasurement>& measurements) {
  if (measurements.empty()) throw InputError("calibration: no measurements");
  Calibration calibration;
  calibration.camera = camera;
  calibration.nearest_target_m = std::numeric_limits<double>::infinity();
  std::vector<const TargetMeasurement*> sorted;
  for (const TargetMeasurement& m : measurements) {
    sorted.push_back(&m);
    calibration.nearest_target_m = std::min(calibration.nearest_target_m, m.target_distance_m);
    calibration.farthest_target_m = std::max(calibration.farthest_target_m, m.target_distance_m);
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto* a, const auto* b) { return a->focus_distance_m > b->focus_distance_m; });
  std::vector<double> tilts_x, tilts_y;
  for (auto first = sorted.begin(); first != sorted.end();) {
    const auto last = std::find_if(first, sorted.end(),
                                   [&](const auto* m) { return m->focus_distance_m != (*first)->focus_distance_m; });
    const std::vector<const TargetMeasurement*> targets(first, last);
    require_span(targets);
    FocusCalibration fit = fit_lines(targets);
    if (middle(fit.slope_dp_px_m) == 0) {
      throw InputError(
          fmt::format("calibration: focus distance {}: the views match in the middle of only {:g} targets; "
                      "{} are needed: is the target textured and within range?",
                      metres(fit.focus_distance_m), middle(fit.count), kFewestTargets));
    }
    for (const TargetMeasurement* target : targets) {
      const TargetTilt tilt = estimate_tilt(camera, fit, *target);
      tilts_x.push_back(tilt.x_deg);
      tilts_y.push_back(tilt.y_deg);
    }
    calibration.focuses.push_back(std::move(fit));
    first = last;
  }
  const double x = median(tilts_x), y = median(tilts_y);
  if (std::hypot(x, y) > kTiltWarning_deg) {
    calibration.warnings.push_back(
        fmt::format("the target seems tilted: its right side is {:.1f} degrees farther, its lower side {:.1f} degrees "
                    "(or the lens is not symmetric); straighten it and repeat the sweep",
                    x, y));
  }
  return calibration;
}

TargetTilt estimate_tilt(const Camera& camera, const FocusCalibration& lines, const TargetMeasurement& measurement) {
  const double image_distance_mm =
      camera.focal_length_mm / (1 - 1e-3 * camera.focal_length_mm / lines.focus_distance_m);
  const double slope_per_px = 1e-3 * camera.pixel_pitch_um / image_distance_mm;
  double uu = 0, uv = 0, vv = 0, ue = 0, ve = 0;
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      const float here = lines.slope_dp_px_m.at(i, j), opposite = mirrored(lines.slope_dp_px_m, i, j);
      if (measurement.usable.at(i, j) == 0 || here == 0 || opposite == 0) continue;
      const double even = 0.5 * (here + opposite) / measurement.target_distance_m;
      const double u = (static_cast<double>(i) / (kColumns - 1) * camera.width_px - camera.principal_point_px[0]) *
                       slope_per_px * even;
      const double v = (static_cast<double>(j) / (kRows - 1) * camera.height_px - camera.principal_point_px[1]) *
                       slope_per_px * even;
      const double rest = even + lines.intercept_dp_px.at(i, j) - measurement.disparity_dp_px.at(i, j);
      uu += u * u, uv += u * v, vv += v * v, ue += u * rest, ve += v * rest;
    }
  }
  const double determinant = uu * vv - uv * uv;
  if (!(determinant > 1e-12 * uu * vv)) return {};
  const double degrees = 180 / M_PI;
  return {std::atan((vv * ue - uv * ve) / determinant) * degrees,
          std::atan((uu * ve - uv * ue) / determinant) * degrees};
}

CalibrationLine line_at(const FocusCalibration& focus, double x, double y) {
  return {bicubic(focus.slope_dp_px_m, x, y), bicubic(focus.intercept_dp_px, x, y)};
}

FocusCalibration focus_at(const Calibration& calibration, double focus_distance_m) {
  const std::vector<FocusCalibration>& focuses = calibration.focuses;  // 1/z ascends
  const double wanted = 1 / focus_distance_m;
  const auto next = std::find_if(focuses.begin(), focuses.end(),
                                 [&](const FocusCalibration& f) { return 1 / f.focus_distance_m >= wanted; });
  if (next == focuses.begin()) return focuses.front();
  if (next == focuses.end()) return focuses.back();
  const FocusCalibration &far = *(next - 1), &near = *next;
  const double span = 1 / near.focus_distance_m - 1 / far.focus_distance_m;
  const auto t = static_cast<float>((wanted - 1 / far.focus_distance_m) / span);
  FocusCalibration mixed = far;
  mixed.focus_distance_m = focus_distance_m;
  for (std::size_t i = 0; i < mixed.count.data.size(); ++i) {
    const bool both = far.slope_dp_px_m.data[i] != 0 && near.slope_dp_px_m.data[i] != 0;
    for (Image FocusCalibration::*map : {&FocusCalibration::slope_dp_px_m, &FocusCalibration::intercept_dp_px,
                                         &FocusCalibration::residual_dp_px, &FocusCalibration::r_squared}) {
      const float a = (far.*map).data[i], b = (near.*map).data[i];
      (mixed.*map).data[i] = both ? a + t * (b - a) : 0.0f;
    }
    mixed.count.data[i] = std::min(far.count.data[i], near.count.data[i]);
  }
  return mixed;
}

void require_same_camera(const Camera& own, const Camera& camera, const std::string& what) {
  const auto refuse = [&](const std::string& field, const auto& expected, const auto& found) {
    throw InputError(fmt::format("{}: /camera/{}: {}: another camera; must be {}", what, field, found, expected));
  };
  if (own.name != camera.name) refuse("name", printable(own.name), printable(camera.name));
  const auto same = [&](const char* field, double expected, double found) {
    if (!(std::abs(expected - found) <= 1e-6 * std::max(std::abs(expected), std::abs(found)))) {
      refuse(field, expected, found);
    }
  };
  same("width_px", own.width_px, camera.width_px);
  same("height_px", own.height_px, camera.height_px);
  same("pixel_pitch_um", own.pixel_pitch_um, camera.pixel_pitch_um);
  same("dp_downsample_x", own.dp_downsample_x, camera.dp_downsample_x);
  same("dp_downsample_y", own.dp_downsample_y, camera.dp_downsample_y);
  same("focal_length_mm", own.focal_length_mm, camera.focal_length_mm);
  same("f_number", own.f_number, camera.f_number);
  same("principal_point_px/0", own.principal_point_px[0], camera.principal_point_px[0]);
  same("principal_point_px/1", own.principal_point_px[1], camera.principal_point_px[1]);
}

Correction make_correction(const Calibration& calibration, const Camera& camera) {
  require_same_camera(calibration.camera, camera, "capture does not fit the calibration");
  Correction correction{node_image(1), node_image(), node_image(), 1, ""};
  const double far = calibration.focuses.front().focus_distance_m, near = calibration.focuses.back().focus_distance_m;
  const double wanted = 1 / camera.focus_distance_m;
  const double outside = std::max({1 / far - wanted, wanted - 1 / near, 0.0});
  if (outside > 1e-9) {
    correction.confidence = static_cast<float>(std::exp(-outside / kFocusReach_per_m));
    correction.warning =
        fmt::format("focus distance {} lies outside the calibrated {} to {}; the nearest calibration, {}, is used",
                    metres(camera.focus_distance_m), metres(near), metres(far), metres(wanted < 1 / far ? far : near));
  }
  const FocusCalibration focus = focus_at(calibration, camera.focus_distance_m);
  const CalibrationLine axis =
      line_at(focus, camera.principal_point_px[0] / camera.width_px, camera.principal_point_px[1] / camera.height_px);
  for (std::size_t i = 0; i < focus.slope_dp_px_m.data.size(); ++i) {
    const double share = focus.slope_dp_px_m.data[i] / axis.slope_dp_px_m;
    if (!(share >= kLeastSlope)) continue;  // also none, and a slope of the wrong sign
    correction.usable.data[i] = 1;
    correction.gain.data[i] = static_cast<float>(1 / share);
    correction.offset_dp_px.data[i] = static_cast<float>(axis.intercept_dp_px - focus.intercept_dp_px.data[i] / share);
  }
  return correction;
}

void correct_disparity(const Correction& correction, Image& disparity_dp_px, Image& confidence) {
  const int width = disparity_dp_px.width, height = disparity_dp_px.height;
  // first pixel of each interval of columns
  std::array<int, kColumns> begin{};
  for (int i = 1; i < kColumns; ++i) {
    begin[i] = std::clamp(static_cast<int>(std::ceil(1.0 * i * width / (kColumns - 1) - 0.5)), 0, width);
  }
  begin[kColumns - 1] = width;
  for_rows(height, [&](int y) {
    const Interval row = interval((y + 0.5) / height, kRows);
    const std::array<float, 4> weights = cubic(row.t);
    float gains[kColumns], offsets[kColumns];
    for (int i = 0; i < kColumns; ++i) {
      gains[i] = offsets[i] = 0;
      for (int k = 0; k < 4; ++k) {
        gains[i] += weights[k] * beyond(correction.gain.data.data() + i, kColumns, kRows, row.first - 1 + k);
        offsets[i] += weights[k] * beyond(correction.offset_dp_px.data.data() + i, kColumns, kRows, row.first - 1 + k);
      }
    }
    float* d = disparity_dp_px.row(y);
    float* sure = confidence.row(y);
    const float *above = correction.usable.row(row.first), *below = correction.usable.row(row.first + 1);
    for (int i = 0; i + 1 < kColumns; ++i) {
      // the interval's cubics in t, so that what is left for a pixel is two polynomials
      float gain[4], offset[4];
      const auto expand = [&](const float* nodes, float out[4]) {
        const float p0 = beyond(nodes, 1, kColumns, i - 1), p1 = nodes[i], p2 = nodes[i + 1],
                    p3 = beyond(nodes, 1, kColumns, i + 2);
        out[0] = p1;
        out[1] = 0.5f * (p2 - p0);
        out[2] = p0 - 2.5f * p1 + 2 * p2 - 0.5f * p3;
        out[3] = 0.5f * (p3 - p0) + 1.5f * (p1 - p2);
      };
      expand(gains, gain);
      expand(offsets, offset);
      const bool usable = above[i] * above[i + 1] * below[i] * below[i + 1] != 0;
      const float trust = usable ? correction.confidence : 0.0f;
      const float per_px = static_cast<float>(kColumns - 1) / static_cast<float>(width);
      for (int x = begin[i]; x < begin[i + 1]; ++x) {
        const float t = (static_cast<float>(x) + 0.5f) * per_px - static_cast<float>(i);
        d[x] = d[x] * (((gain[3] * t + gain[2]) * t + gain[1]) * t + gain[0]) +
               (((offset[3] * t + offset[2]) * t + offset[1]) * t + offset[0]);
        sure[x] *= trust;
      }
    }
  });
}

}  // namespace dualpixel::pipeline
