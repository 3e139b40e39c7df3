#include "evaluation/report/calibration_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/report_images.h"
#include "pipeline/calibration/nodes.h"

namespace dualpixel::evaluation {
namespace {

namespace fs = std::filesystem;
using pipeline::Calibration;
using pipeline::FocusCalibration;
using pipeline::TargetMeasurement;

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

/// A map's difference from its value at the principal point, as color; gray where `slope` says that there is no line.
std::string map_figure(const Image& nodes, const Image& slope, std::size_t principal, const std::string& name,
                       const std::string& unit, float limit) {
  const float middle = nodes.data[principal];
  constexpr int kScale = 24;
  Image large(kScale * nodes.width, kScale * nodes.height);
  for (int y = 0; y < large.height; ++y) {
    for (int x = 0; x < large.width; ++x) {
      const int i = x / kScale, j = y / kScale;
      large.at(x, y) = slope.at(i, j) != 0 ? nodes.at(i, j) - middle : kGap;
    }
  }
  Image bar(256, 8);
  for (int y = 0; y < bar.height; ++y) {
    for (int x = 0; x < bar.width; ++x) bar.at(x, y) = limit * (static_cast<float>(x) / 127.5f - 1);
  }
  return html_figure({name, fmt::format("minus the principal point's {:.3f}", middle),
                      jpeg_data_uri(diverging_colors(large, limit), 92),
                      jpeg_data_uri(diverging_colors(bar, limit), 92), fmt::format("{:+.2f}", -limit),
                      fmt::format("{:+.2f} {}", limit, unit)});
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
  const std::size_t principal = pipeline::principal_node(calibration.camera);
  const std::size_t last = focuses.size() - 1;
  std::vector<std::size_t> shown = {last / 4, last / 2, last};
  shown.erase(std::unique(shown.begin(), shown.end()), shown.end());
  std::vector<Plot> lines;
  for (const std::size_t i : shown) lines.push_back(lines_plot(calibration, focuses[i], measurements));
  body += "<h2>Lines</h2>" + html_plots(lines) + "<h2>Maps</h2>";
  for (const std::size_t i : shown) {
    body += fmt::format("<h4>Focused at {:.3g} m</h4><div class=\"maps\">", focuses[i].focus_distance_m);
    const Image& slope = focuses[i].slope_dp_px_m;
    body += map_figure(slope, slope, principal, "Slope", "DP px m", 0.3f);
    body += map_figure(focuses[i].intercept_dp_px, slope, principal, "Intercept", "DP px", 1);
    body += "</div>";
  }
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
