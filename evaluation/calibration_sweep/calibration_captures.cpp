#include "evaluation/calibration_sweep/calibration_captures.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/json_fields.h"
#include "capture/views.h"
#include "pipeline/burst/merge.h"
#include "pipeline/calibration/correction.h"
#include "pipeline/disparity/match_pixels.h"

namespace dualpixel::evaluation {
namespace {

pipeline::TargetMeasurement measure_capture(const Capture& capture, double target_distance_m, const std::string& path) {
  pipeline::MergedBurst burst = pipeline::align_and_merge(capture.frames, capture.exposure);
  const bool dense = pipeline::is_dense_mosaic(capture);
  if (dense) {
    for (Image* view : {&burst.left, &burst.right}) *view = pipeline::green_means(*view, capture.camera.cfa);
  }
  pipeline::TargetMeasurement measurement =
      pipeline::measure_target(burst.left, burst.right, capture.camera.focus_distance_m, target_distance_m);
  for (float& disparity : measurement.disparity_dp_px.data) disparity *= dense ? 2 : 1;  // found in pixels of two
  const Image& usable = measurement.usable;
  const auto seen = std::count(usable.data.begin(), usable.data.end(), 1.0f);
  if (2 * static_cast<std::size_t>(seen) < usable.data.size()) {
    throw InputError(
        fmt::format("{}: the views match on only {:.0f} % of the picture; a target must be textured and fill it",
                    printable(path), 100.0 * static_cast<double>(seen) / static_cast<double>(usable.data.size())));
  }
  return measurement;
}

}  // namespace

CaptureMeasurements measure_captures(const std::string& folder, const std::function<void(double)>& progress) {
  const std::string list = folder + "/distances.json";
  const nlohmann::json json = read_json_file(list);
  Fields root(json, list);
  std::vector<Fields> entries = root.required("captures").objects("captures");
  root.done();
  if (entries.empty()) root.fail("captures", "must name at least three captures");
  CaptureMeasurements all;
  for (Fields& entry : entries) {
    std::string name;
    double distance_m = 0;
    entry.required("capture").text("capture", name);
    entry.required("target_distance_m").number("target_distance_m", distance_m, 0.01, 1000);
    entry.done();
    const std::string path = (std::filesystem::path(folder) / name).string();
    const Capture capture = read_capture(path, false);
    require_views(capture, path);
    if (all.measurements.empty()) all.camera = capture.camera;
    pipeline::require_same_camera(all.camera, capture.camera, printable(path));
    all.measurements.push_back(measure_capture(capture, distance_m, path));
    progress(static_cast<double>(all.measurements.size()) / static_cast<double>(entries.size()));
  }
  return all;
}

}  // namespace dualpixel::evaluation
