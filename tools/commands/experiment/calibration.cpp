#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "capture/files.h"
#include "capture/json_fields.h"
#include "evaluation/calibration_sweep/calibration_sweep.h"
#include "evaluation/report/report_assets.h"
#include "evaluation/report/report_page.h"
#include "evaluation/report/svg_plot.h"
#include "pipeline/calibration/correction.h"
#include "pipeline/calibration/tilt.h"
#include "simulator/lens/disparity_field.h"
#include "simulator/sampling/hash.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kFocus_m = 0.69;  ///< of the captures to correct; none of the sweeps focuses there
constexpr double kDepths_m[] = {0.45, 0.9, 2.2};

/// One way to calibrate, and what is left of a plane's disparity spread over the field when it corrects.
struct Effort {
  std::string axis, name;
  evaluation::SweepOptions sweep;
  double residual_dp_px = 0;
  pipeline::TargetTilt tilt;  ///< as the calibration finds it
  bool warned = false;
};

std::vector<Effort> efforts() {
  std::vector<Effort> all;
  const auto add = [&](const std::string& axis, const std::string& name, const auto& change) {
    Effort effort{axis, name, {}};
    change(effort.sweep);
    all.push_back(effort);
  };
  for (const int n : {5, 10, 20, 40}) {
    add("focus distances", std::to_string(n), [&](evaluation::SweepOptions& s) { s.focuses = n; });
  }
  for (const int n : {4, 8, 16}) {
    add("target distances", std::to_string(n), [&](evaluation::SweepOptions& s) { s.targets = n; });
  }
  // one frame of a phone's sensor
  for (const float gain : {1.0f, 4.0f, 16.0f}) {
    add("noise", fmt::format("ISO {:g}", 100 * gain), [&](evaluation::SweepOptions& s) {
      s.noise = {4e-5f * gain, 1e-7f * gain};
    });
  }
  for (const int finest : {16, 32, 64}) {
    add("texture", fmt::format("cells of {} px", finest), [&](evaluation::SweepOptions& s) { s.finest_px = finest; });
  }
  for (const double tilt : {0.0, 1.0, 2.0, 5.0}) {
    add("tilt", fmt::format("{:g} degrees", tilt), [&](evaluation::SweepOptions& s) { s.tilt_x_deg = tilt; });
  }
  return all;
}

/// Standard deviation over the inner 90 % of the field, RMS over the depths.
double residual(const simulator::DisparityField& field, const Camera& camera, const pipeline::Correction* correction) {
  double variance = 0;
  for (const double depth : kDepths_m) {
    Image d(camera.dp_width() / 4, camera.dp_height() / 2), confidence(d.width, d.height, 1, 1.0f);
    for (int y = 0; y < d.height; ++y) {
      for (int x = 0; x < d.width; ++x) {
        const simulator::DisparityCoefficients c =
            field.at((x + 0.5) * camera.width_px / d.width, (y + 0.5) * camera.height_px / d.height);
        d.at(x, y) = static_cast<float>(c.slope_dp_px_m / depth + c.intercept_dp_px);
      }
    }
    if (correction) correct_disparity(*correction, d, confidence);
    double sum = 0, squares = 0, count = 0;
    for (int y = d.height / 20; y < d.height - d.height / 20; ++y) {
      for (int x = d.width / 20; x < d.width - d.width / 20; ++x) {
        const double value = d.at(x, y);
        sum += value, squares += value * value, ++count;
      }
    }
    variance += std::max(squares / count - sum / count * (sum / count), 0.0) / std::size(kDepths_m);
  }
  return std::sqrt(variance);
}

/// Only the two focus distances around kFocus_m are measured: the others of the sweep would not be used.
void measure(const simulator::Simulation& simulation, const simulator::DisparityField& field, Effort& effort) {
  const std::vector<double> focuses = evaluation::sweep_focus_distances(effort.sweep);
  std::vector<pipeline::TargetMeasurement> measurements;
  for (std::size_t i = 0; i < focuses.size(); ++i) {
    const bool far = i + 1 < focuses.size() && focuses[i] >= kFocus_m && focuses[i + 1] < kFocus_m;
    const bool near = i > 0 && focuses[i] < kFocus_m && focuses[i - 1] >= kFocus_m;
    if (!far && !near) continue;
    const evaluation::FocusSweep sweep(simulation, focuses[i], effort.sweep);
    for (std::size_t j = 0; j < sweep.target_distances_m().size(); ++j) {
      measurements.push_back(sweep.measure(sweep.target_distances_m()[j], simulator::hash(1, i, j)));
    }
  }
  Camera camera = describe_camera(simulation);
  const pipeline::Calibration calibration = fit_calibration(camera, measurements);
  camera.focus_distance_m = kFocus_m;
  const pipeline::Correction correction = make_correction(calibration, camera);
  effort.residual_dp_px = residual(field, camera, &correction);
  effort.tilt = estimate_tilt(camera, measurements);
  effort.warned = !calibration.warnings.empty();
}

Json to_json(const std::vector<Effort>& all, double uncorrected_dp_px, const std::string& lens) {
  Json rows = Json::array();
  for (const Effort& e : all) {
    rows.push_back({{"axis", e.axis},
                    {"value", e.name},
                    {"photographs", e.sweep.focuses * e.sweep.targets},
                    {"residual_sigma_dp_px", e.residual_dp_px},
                    {"tilt_found_deg", e.tilt.x_deg},
                    {"tilt_standard_error_deg", e.tilt.x_error_deg},
                    {"tilt_warning", e.warned}});
  }
  return {{"format", "dualpixel-experiment-calibration"},
          {"version", 2},
          {"lens", lens},
          {"focus_distance_m", kFocus_m},
          {"depths_m", kDepths_m},
          {"uncorrected_sigma_dp_px", uncorrected_dp_px},
          {"efforts", rows}};
}

std::string to_page(const std::vector<Effort>& all, double uncorrected_dp_px, const std::string& lens) {
  std::string body = fmt::format(
      "<h1>What a cheaper calibration costs</h1>\n<p>{}, focused at {:g} m, where no sweep was. Planes at {:g}, {:g} "
      "and "
      "{:g} m should have one disparity each; its standard deviation over the inner 90 % of the field is {:.3f} DP px "
      "before correction. Below, after it; all but the one thing named as in the full sweep of 20 focus and 8 target "
      "distances.</p>\n",
      evaluation::escape_html(lens), kFocus_m, kDepths_m[0], kDepths_m[1], kDepths_m[2], uncorrected_dp_px);
  evaluation::Plot plot;
  plot.title = "Effort against residual";
  plot.x_label = "photographs";
  plot.y_label = "standard deviation over the field, DP px";
  for (const Effort& e : all) {
    if (plot.series.empty() || plot.series.back().name != e.axis) {
      plot.series.push_back({e.axis, {}, false, e.axis != "focus distances" && e.axis != "target distances"});
    }
    plot.series.back().points.emplace_back(e.sweep.focuses * e.sweep.targets, e.residual_dp_px);
  }
  body += "<div class=\"plots wide-plot\">" + evaluation::svg_plot(plot) +
          "</div><div class=\"scroll\"><table><tr><th>Changed</th>" +
          "<th>to</th><th>photographs</th><th>residual, DP px</th><th>tilt found, degrees</th><th>warning</th></tr>\n";
  for (const Effort& e : all) {
    body +=
        fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{:.4f}</td><td>{:.2f} ± {:.2f}</td><td>{}</td></tr>\n",
                    e.axis, e.name, e.sweep.focuses * e.sweep.targets, e.residual_dp_px, e.tilt.x_deg,
                    e.tilt.x_error_deg, e.warned ? "tilted" : "");
  }
  body += "</table></div>";
  return evaluation::html_page(
      "What a cheaper calibration costs",
      std::string(evaluation::kReportStyle) + evaluation::kPlotStyle +
          ".wide-plot { grid-template-columns: minmax(0, 900px); } .wide-plot .plot > svg { max-width: "
          "900px; }",
      body);
}

}  // namespace

void add_experiment_calibration(CLI::App& experiment) {
  struct Options {
    std::string scene, folder;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = experiment.add_subcommand(
      "calibration", "What fewer photographs, noise, another texture or a tilted target cost a calibration");
  command->add_option("camera", options->scene, "Scene file whose camera is calibrated")
      ->required()
      ->type_name("CAMERA.json");
  command
      ->add_option("-o,--output", options->folder,
                   "Folder to write calibration_cost.json and calibration_cost.html into")
      ->required()
      ->type_name("DIR");
  auto overrides = std::make_shared<std::vector<std::string>>();
  add_overrides_option(*command, *overrides, "lens.f_number=2.8");
  add_threads_option(*command);
  command->footer(
      "Example:\n  dualpixel experiment calibration build/release/scenes/portrait.json --set "
      "lens.file=../lens_models/phone_aberrated_4.4mm_f1.8.json -o out/calibration_cost");
  command->callback([options, overrides] {
    nlohmann::json json = read_json_file(options->scene);
    for (const std::string& assignment : *overrides) apply_override(json, assignment);
    const simulator::Simulation simulation = simulator::read_simulation(json, options->scene);
    NewFolder out(options->folder, "calibration_cost.json");
    Progress bar("calibration");
    std::vector<Effort> all = efforts();
    const simulator::DisparityField field(evaluation::FocusSweep(simulation, kFocus_m, {}).lens());
    const double uncorrected = residual(field, describe_camera(simulation), nullptr);
    for (std::size_t i = 0; i < all.size(); ++i) {
      measure(simulation, field, all[i]);
      bar(static_cast<double>(i + 1) / static_cast<double>(all.size()));
    }
    write_file(out.path() + "/calibration_cost.html", to_page(all, uncorrected, simulation.lens.name));
    write_file(out.path() + "/calibration_cost.json", to_json(all, uncorrected, simulation.lens.name).dump(2) + "\n");
    out.commit();
  });
}

}  // namespace dualpixel::tools
