#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "capture/folder/camera_json.h"
#include "capture/json_fields.h"
#include "pipeline/calibration/calibration.h"
#include "pipeline/calibration/nodes.h"

namespace dualpixel::pipeline {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kVersion = 2;
constexpr std::size_t kNodes = static_cast<std::size_t>(kCalibrationColumns) * kCalibrationRows;
constexpr double kFocusAtInfinity_m = std::numeric_limits<double>::infinity();
constexpr double kMost = 1e6;  ///< of any value at a node

/// JSON has no infinity.
Json distance_json(double distance_m) { return std::isinf(distance_m) ? Json("inf") : Json(distance_m); }

/// Rounded to 1e-4, which halves the bytes: a tenth of the best measurement's error, and of skews far less.
double rounded(double value) { return std::round(value * 1e4) / 1e4; }

Json nodes_json(const Image& image) {
  Json nodes = Json::array();
  for (const float value : image.data) nodes.push_back(rounded(value));
  return nodes;
}

void read_nodes(Fields& fields, const std::string& key, Image& image, double low, double high = kMost) {
  std::vector<double> values;
  fields.required(key).list(key, values, low, high, kNodes);
  if (values.size() != kNodes) {
    fields.fail(key, fmt::format("{} numbers: must be {} x {}, row by row", values.size(), kCalibrationColumns,
                                 kCalibrationRows));
  }
  image = Image(kCalibrationColumns, kCalibrationRows);
  for (std::size_t i = 0; i < kNodes; ++i) image.data[i] = static_cast<float>(values[i]);
}

/// Coefficients node after node.
Json coefficients_json(const SkewField& field, SkewCurve::Coefficients SkewCurve::*which) {
  Json numbers = Json::array();
  for (const SkewCurve& curve : field.nodes) {
    for (const float value : curve.*which) numbers.push_back(rounded(value));
  }
  return numbers;
}

Json skew_json(const SkewField& field) {
  return {{"columns", field.columns},
          {"rows", field.rows},
          {"farthest_dp_px", field.nodes.front().farthest_dp_px},
          {"xxx", coefficients_json(field, &SkewCurve::xxx)},
          {"xyy", coefficients_json(field, &SkewCurve::xyy)}};
}

SkewField read_skew(Fields fields) {
  constexpr int kMostNodes = 100;  // along an axis
  constexpr std::size_t kCoefficients = std::tuple_size_v<SkewCurve::Coefficients>;
  SkewField field;
  double farthest = 0;
  fields.required("columns").integer("columns", field.columns, 1, kMostNodes);
  fields.required("rows").integer("rows", field.rows, 1, kMostNodes);
  fields.required("farthest_dp_px").number("farthest_dp_px", farthest, 0, 100);
  field.nodes.assign(static_cast<std::size_t>(field.columns) * field.rows, {{}, {}, static_cast<float>(farthest)});
  const auto read = [&](const std::string& key, SkewCurve::Coefficients SkewCurve::*which) {
    std::vector<double> values;
    const std::size_t count = field.nodes.size() * kCoefficients;
    fields.required(key).list(key, values, -kMost, kMost, count);
    if (values.size() != count) {
      fields.fail(key, fmt::format("{} numbers: must be {} for each of {} x {} nodes, row by row", values.size(),
                                   kCoefficients, field.columns, field.rows));
    }
    for (std::size_t i = 0; i < count; ++i) {
      (field.nodes[i / kCoefficients].*which)[i % kCoefficients] = static_cast<float>(values[i]);
    }
  };
  read("xxx", &SkewCurve::xxx);
  read("xyy", &SkewCurve::xyy);
  fields.done();
  return field;
}

void read_header(Fields& fields, const std::string& expected) {
  std::string format;
  int version = 0;
  fields.required("format").choice("format", format, {expected});
  fields.required("version").integer("version", version, kVersion, kVersion);
}

constexpr const char* kCalibrationFormat = "dualpixel-calibration";
constexpr const char* kMeasurementFormat = "dualpixel-calibration-measurement";
constexpr double kNearest_m = 1e-4;

Json camera_json(const Camera& c) {
  return {{"name", c.name},
          {"width_px", c.width_px},
          {"height_px", c.height_px},
          {"pixel_pitch_um", c.pixel_pitch_um},
          {"dp_downsample_x", c.dp_downsample_x},
          {"dp_downsample_y", c.dp_downsample_y},
          {"focal_length_mm", c.focal_length_mm},
          {"f_number", c.f_number},
          {"principal_point_px", c.principal_point_px}};
}

Camera read_camera(Fields fields) {
  Camera c;
  read_intrinsics(fields, c);
  fields.done();
  return c;
}

}  // namespace

Json to_json(const Calibration& calibration) {
  Json focuses = Json::array();
  for (const FocusCalibration& f : calibration.focuses) {
    focuses.push_back({{"focus_distance_m", distance_json(f.focus_distance_m)},
                       {"r_squared", rounded(f.r_squared)},
                       {"slope_dp_px_m", nodes_json(f.slope_dp_px_m)},
                       {"intercept_dp_px", nodes_json(f.intercept_dp_px)},
                       {"residual_dp_px", nodes_json(f.residual_dp_px)}});
    if (!f.skew.nodes.empty()) focuses.back()["kernel_skew"] = skew_json(f.skew);
  }
  return {{"format", kCalibrationFormat},
          {"version", kVersion},
          {"camera", camera_json(calibration.camera)},
          {"nearest_target_m", calibration.nearest_target_m},
          {"farthest_target_m", calibration.farthest_target_m},
          {"warnings", calibration.warnings},
          {"focuses", focuses}};
}

Calibration read_calibration(const nlohmann::json& json, const std::string& file) {
  Fields root(json, file);
  read_header(root, kCalibrationFormat);
  Calibration calibration;
  calibration.camera = read_camera(root.required("camera").object("camera"));
  root.required("nearest_target_m").number("nearest_target_m", calibration.nearest_target_m, kNearest_m, 1e6);
  root.required("farthest_target_m")
      .number("farthest_target_m", calibration.farthest_target_m, calibration.nearest_target_m, 1e6);
  const nlohmann::json& warnings = root.required("warnings").raw("warnings");
  if (!warnings.is_array()) root.fail("warnings", "must be an array of texts");
  for (const nlohmann::json& warning : warnings) {
    if (!warning.is_string()) root.fail("warnings", "must be an array of texts");
    calibration.warnings.push_back(warning.get<std::string>());
  }
  double last = kFocusAtInfinity_m;
  for (Fields& entry : root.required("focuses").objects("focuses")) {
    FocusCalibration& f = calibration.focuses.emplace_back();
    entry.required("focus_distance_m").number("focus_distance_m", f.focus_distance_m, kNearest_m, kFocusAtInfinity_m);
    if (calibration.focuses.size() > 1 && !(f.focus_distance_m < last)) {
      entry.fail("focus_distance_m", fmt::format("{}: must be nearer than the one before it", f.focus_distance_m));
    }
    last = f.focus_distance_m;
    entry.required("r_squared").number("r_squared", f.r_squared, 0, 1);
    read_nodes(entry, "slope_dp_px_m", f.slope_dp_px_m, -kMost);
    read_nodes(entry, "intercept_dp_px", f.intercept_dp_px, -kMost);
    read_nodes(entry, "residual_dp_px", f.residual_dp_px, 0);
    if (entry.has("kernel_skew")) f.skew = read_skew(entry.object("kernel_skew"));
    const SkewField& first = calibration.focuses.front().skew;
    if (f.skew.columns != first.columns || f.skew.rows != first.rows) {
      entry.fail("kernel_skew", "must have as many nodes as that of the first focus distance");
    }
    if (f.slope_dp_px_m.data[principal_node(calibration.camera)] == 0) {
      entry.fail("slope_dp_px_m", "0 at the principal point: there is nothing to correct to");
    }
    entry.done();
  }
  if (calibration.focuses.empty()) root.fail("focuses", "must hold at least one focus distance");
  root.done();
  return calibration;
}

Json to_json(const TargetMeasurement& measurement) {
  return {{"format", kMeasurementFormat},
          {"version", kVersion},
          {"focus_distance_m", distance_json(measurement.focus_distance_m)},
          {"target_distance_m", measurement.target_distance_m},
          {"disparity_dp_px", nodes_json(measurement.disparity_dp_px)},
          {"usable", nodes_json(measurement.usable)}};
}

TargetMeasurement read_measurement(const nlohmann::json& json, const std::string& file) {
  Fields root(json, file);
  read_header(root, kMeasurementFormat);
  TargetMeasurement m;
  root.required("focus_distance_m").number("focus_distance_m", m.focus_distance_m, kNearest_m, kFocusAtInfinity_m);
  root.required("target_distance_m").number("target_distance_m", m.target_distance_m, kNearest_m, 1e6);
  read_nodes(root, "disparity_dp_px", m.disparity_dp_px, -kMost);
  read_nodes(root, "usable", m.usable, 0, 1);
  root.done();
  return m;
}

}  // namespace dualpixel::pipeline
