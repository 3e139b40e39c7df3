#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evaluation/experiments/aberrations_experiment.h"
#include "evaluation/report/page.h"
#include "evaluation/report/report_images.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {
namespace {

/// `map` minus `middle` as color.
std::string field_figure(const Image& map, float middle, float limit, const std::string& title,
                         const std::string& caption, const std::string& unit) {
  Image shown = map;
  for (float& value : shown.data) value -= middle;
  Image bar(256, 8);
  for (int y = 0; y < bar.height; ++y) {
    for (int x = 0; x < bar.width; ++x) bar.at(x, y) = limit * (static_cast<float>(x) / 127.5f - 1);
  }
  return html_figure({title, caption, jpeg_data_uri(diverging_colors(shown, limit), 92),
                      jpeg_data_uri(diverging_colors(bar, limit), 92), fmt::format("{:+.2f}", -limit),
                      fmt::format("{:+.2f}{}", limit, unit)});
}

/// The largest distance from `middle`, not quite at the outliers.
float shown_limit(const Image& map, float middle) {
  Image distance = map;
  for (float& value : distance.data) value = std::abs(value - middle);
  return std::max(percentile(distance, 0.99), 0.01f);
}

std::string figures_of(const AberratedField& f) {
  const int x = f.light.width / 2, y = f.light.height / 2;
  const float disparity = f.before_dp_px.at(x, y), limit = shown_limit(f.before_dp_px, disparity);
  Image diopters = f.focus_m;
  for (float& value : diopters.data) value = 1 / value;
  const float diopter = diopters.at(x, y);
  const std::string minus = fmt::format("minus the center's {:.3f} DP px", disparity);
  return "<div class=\"maps\">" +
         field_figure(f.before_dp_px, disparity, limit, "Disparity before calibration", minus, " DP px") +
         field_figure(f.after_dp_px, disparity, limit, "After calibration", minus, " DP px") +
         field_figure(diopters, diopter, shown_limit(diopters, diopter), "Field curvature",
                      fmt::format("depth without disparity, minus the center's {:.3f} m, in 1/m", 1 / diopter),
                      " / m") +
         html_figure(
             {"Vignetting", "light of both views over the brightest", jpeg_data_uri(gray_levels(f.light, 1), 92)}) +
         field_figure(f.left_share, 0.5f, std::max(shown_limit(f.left_share, 0.5f), 0.01f), "Split offset",
                      "the left view's share of the light, minus 1/2", "") +
         "</div>\n";
}

constexpr const char* kCauses = R"html(
<h2>What is left after calibration, as errors are added</h2>
<p>The deviation of the plane's disparity, DP px. Each column holds the errors of those before it, up to noise.
<b>grid</b>: lines traced at the nodes, at this focus distance; <b>focus</b>: traced at the two focus distances around;
<b>targets</b>: measured on eight simulated targets at each, with their texture and the lens's kernels; <b>noise</b>: these
at ISO 400; <b>by hand</b>: three targets at each of five focus distances instead, tilted by a degree. <b>matching</b>:
corrected as in “targets”, but the disparity that the default matcher finds in views of a textured plane at ISO 100, whose
own errors count here.</p>
)html";

}  // namespace

std::string to_page(const std::vector<AberratedField>& fields) {
  Table table{{"Lens", "focus, m", "plane, m", "deviation before, DP px", "after, DP px", "least light"}, {}};
  Table left{{"Lens"}, {}};
  for (const CalibrationRemainder& r : fields.front().remainders) left.header.push_back(r.cause);
  std::string body;
  for (const AberratedField& f : fields) {
    std::vector<std::string>& row = left.rows.emplace_back(std::vector{f.lens});
    for (const CalibrationRemainder& r : f.remainders) row.push_back(cell_of(r.sigma_dp_px, 4));
    table.rows.push_back({f.lens, cell_of(f.focus_distance_m, 2), cell_of(f.plane_m, 2),
                          cell_of(f.before_sigma_dp_px, 3), cell_of(f.after_sigma_dp_px, 3),
                          cell_of(*std::min_element(f.light.data.begin(), f.light.data.end()), 2)});
    body += fmt::format("<h2>{}</h2>\n", escape_name(f.lens)) + figures_of(f);
  }
  const std::string title = "Aberrations over the field";
  return html_page(title,
                   fmt::format("<h1>{}</h1>\n<p>A plane parallel to the sensor should have one disparity. Deviations "
                               "are standard deviations over the inner 90 % of the field.</p>\n",
                               title) +
                       html_table(table) + kCauses + html_table(left) + body);
}

}  // namespace dualpixel::evaluation
