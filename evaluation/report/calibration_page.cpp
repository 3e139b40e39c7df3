#include "evaluation/report/calibration_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/viewer.h"
#include "pipeline/calibration/nodes.h"

namespace dualpixel::evaluation {
namespace {

namespace fs = std::filesystem;
using pipeline::Calibration;
using pipeline::FocusCalibration;
using pipeline::TargetMeasurement;

constexpr double kMapStep = 1.0 / 8192;  ///< of what maps keep
constexpr float kGap = std::numeric_limits<float>::quiet_NaN();

struct FieldNode {
  const char* name;
  int column, row;
};
constexpr int kLastColumn = pipeline::kCalibrationColumns - 1, kLastRow = pipeline::kCalibrationRows - 1;
constexpr FieldNode kFieldNodes[] = {{"center", kLastColumn / 2, kLastRow / 2},
                                     {"left", kLastColumn / 10, kLastRow / 2},
                                     {"right", kLastColumn - kLastColumn / 10, kLastRow / 2},
                                     {"top", kLastColumn / 2, kLastRow / 10},
                                     {"corner", kLastColumn - kLastColumn / 10, kLastRow / 10}};

/// Lines run as far as their measurements, or, where those are not at hand, over the whole sweep's targets.
Plot lines_plot(const Calibration& calibration, const FocusCalibration& focus,
                const std::vector<TargetMeasurement>& measurements) {
  Plot plot;
  plot.title = fmt::format("Disparity over inverse depth, focused at {:.3g} m (R² {:.5f})", focus.focus_distance_m,
                           focus.r_squared);
  plot.x_label = "1 / depth of the target, 1/m";
  plot.y_label = "DP px";
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double near = 0, far = kInfinity;
  for (const TargetMeasurement& m : measurements) {
    if (m.focus_distance_m != focus.focus_distance_m) continue;
    near = std::max(near, 1 / m.target_distance_m);
    far = std::min(far, 1 / m.target_distance_m);
  }
  if (std::isinf(far)) {
    near = 1 / calibration.nearest_target_m;
    far = 1 / calibration.farthest_target_m;
  }
  for (const FieldNode& point : kFieldNodes) {
    const double slope = focus.slope_dp_px_m.at(point.column, point.row);
    const double intercept = focus.intercept_dp_px.at(point.column, point.row);
    if (slope == 0) continue;
    plot.series.push_back({point.name, {{far, slope * far + intercept}, {near, slope * near + intercept}}});
  }
  Series measured{"measured", {}, false, true};
  for (const TargetMeasurement& m : measurements) {
    if (m.focus_distance_m != focus.focus_distance_m) continue;
    for (const FieldNode& point : kFieldNodes) {
      if (m.usable.at(point.column, point.row) == 0) continue;
      measured.points.emplace_back(1 / m.target_distance_m, m.disparity_dp_px.at(point.column, point.row));
    }
  }
  plot.series.push_back(measured);
  return plot;
}

/// The maps of several focus distances, each minus its value at the principal point; gray where there is no line.
Viewer maps_viewer(const Calibration& calibration, const std::vector<std::size_t>& shown) {
  const std::size_t principal = pipeline::principal_node(calibration.camera);
  const auto relative = [&](const Image& nodes, const Image& slope) {
    Image difference = nodes;
    for (std::size_t i = 0; i < nodes.data.size(); ++i) {
      difference.data[i] = slope.data[i] != 0 ? nodes.data[i] - nodes.data[principal] : kGap;
    }
    return difference;
  };
  Viewer viewer;
  viewer.width = calibration.camera.width_px;
  viewer.height = calibration.camera.height_px;
  viewer.layers = {{"Slope", "Minus the principal point's.", "DP px m", LayerColors::diverging, 0, 0.3, kMapStep},
                   {"Intercept", "Minus the principal point's.", "DP px", LayerColors::diverging, 0, 1, kMapStep}};
  for (const std::size_t i : shown) {
    const FocusCalibration& focus = calibration.focuses[i];
    viewer.results.push_back(fmt::format("focused at {:.3g} m", focus.focus_distance_m));
    viewer.layers[0].images.push_back(relative(focus.slope_dp_px_m, focus.slope_dp_px_m));
    viewer.layers[1].images.push_back(relative(focus.intercept_dp_px, focus.slope_dp_px_m));
  }
  return viewer;
}

template <typename Value>
Plot over_focus(const std::string& title, const std::string& unit, const Calibration& calibration, const Value& value) {
  Plot plot;
  plot.title = title;
  plot.x_label = "1 / focus distance, 1/m";
  plot.y_label = unit;
  for (const FieldNode& point : kFieldNodes) {
    Series series{point.name, {}};
    for (const FocusCalibration& focus : calibration.focuses) {
      const bool line = focus.slope_dp_px_m.at(point.column, point.row) != 0;
      series.points.emplace_back(1 / focus.focus_distance_m, line ? value(focus).at(point.column, point.row) : kGap);
    }
    plot.series.push_back(series);
  }
  return plot;
}

}  // namespace

Calibration read_calibration_folder(const std::string& folder) {
  const std::string file = folder + "/calibration.json";
  std::error_code unreadable;
  if (!fs::exists(file, unreadable)) {
    throw InputError(printable(folder) +
                     ": holds no calibration.json: must be a folder that `dualpixel calibrate` wrote and finished");
  }
  return pipeline::read_calibration(read_json_file(file), file);
}

std::vector<TargetMeasurement> read_measurements(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder + "/measurements", error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().extension() == ".json") files.push_back(entry->path().string());
  }
  std::sort(files.begin(), files.end());
  std::vector<TargetMeasurement> measurements;
  for (const std::string& file : files) {
    measurements.push_back(pipeline::read_measurement(read_json_file(file), file));
  }
  return measurements;
}

std::string to_page(const Calibration& calibration, const std::vector<TargetMeasurement>& measurements) {
  const std::vector<FocusCalibration>& focuses = calibration.focuses;
  std::string body = fmt::format(
      "<h1>Calibration of {}</h1>\n<p>{} focus distances from {:.3g} to {:.3g} m, targets from {:.3g} to {:.3g} m. At "
      "each field point disparity is slope / depth + intercept.</p>\n",
      escape_name(calibration.camera.name), focuses.size(), focuses.front().focus_distance_m,
      focuses.back().focus_distance_m, calibration.nearest_target_m, calibration.farthest_target_m);
  for (const std::string& warning : calibration.warnings) {
    body += "<p>Warning: " + escape_name(warning) + "</p>\n";
  }
  const std::size_t last = focuses.size() - 1;
  std::vector<std::size_t> shown = {last / 4, last / 2, last};
  shown.erase(std::unique(shown.begin(), shown.end()), shown.end());
  std::vector<Plot> lines;
  for (const std::size_t i : shown) lines.push_back(lines_plot(calibration, focuses[i], measurements));
  body += "<h2>Lines</h2>" + html_plots(lines) + "<h2>Maps</h2>" + html_viewer(maps_viewer(calibration, shown));
  body += "<h2>Over the focus distance</h2><p>The thin lens's slope does not depend on the focus distance.</p>";
  body += html_plots({over_focus("Slope", "DP px m", calibration,
                                 [](const FocusCalibration& f) -> const Image& { return f.slope_dp_px_m; }),
                      over_focus("Intercept", "DP px", calibration,
                                 [](const FocusCalibration& f) -> const Image& { return f.intercept_dp_px; }),
                      over_focus("Residual of the line, RMS", "DP px", calibration,
                                 [](const FocusCalibration& f) -> const Image& { return f.residual_dp_px; })});
  return html_page("Calibration of " + printable(calibration.camera.name), body);
}

}  // namespace dualpixel::evaluation
