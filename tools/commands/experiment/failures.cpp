#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/files.h"
#include "evaluation/experiments/failure_atlas.h"
#include "evaluation/report/report_assets.h"
#include "evaluation/report/report_page.h"
#include "evaluation/report/svg_plot.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct Step {
  double value;
  evaluation::FailureFigures paper, ours;
};

/// Where more than a tenth of the pixels err by more than 0.5 DP px first; none where that never happens.
std::string breaks_at(const std::vector<Step>& steps, evaluation::FailureFigures Step::*of) {
  for (const Step& step : steps) {
    if ((step.*of).wrong > 0.1) return fmt::format("{:g}", step.value);
  }
  return "never";
}

nlohmann::ordered_json to_json(const evaluation::FailureFigures& figures) {
  nlohmann::ordered_json json = {
      {"rmse_dp_px", figures.rmse_dp_px}, {"wrong_share", figures.wrong}, {"mean_confidence", figures.confidence}};
  if (!std::isfinite(figures.sure)) return json;
  json["sure_share"] = figures.sure;
  json["wrong_and_sure_share"] = figures.deceived;
  json["median_sigma_dp_px"] = figures.median_sigma_dp_px;
  json["within_one_sigma_share"] = figures.within_one_sigma;
  json["within_two_sigma_share"] = figures.within_two_sigma;
  return json;
}

nlohmann::ordered_json to_json(const evaluation::FailureRow& row, const std::vector<Step>& steps) {
  nlohmann::ordered_json json = {
      {"name", row.name},
      {"title", row.title},
      {"breaks_at", {{"paper", breaks_at(steps, &Step::paper)}, {"likelihood", breaks_at(steps, &Step::ours)}}},
      {"steps", nlohmann::ordered_json::array()}};
  for (const Step& step : steps) {
    json["steps"].push_back(
        {{row.key, step.value}, {"paper", to_json(step.paper)}, {"likelihood", to_json(step.ours)}});
  }
  return json;
}

std::string plots(const evaluation::FailureRow& row, const std::vector<Step>& steps) {
  const auto line = [&](const char* name, evaluation::FailureFigures Step::*of,
                        double evaluation::FailureFigures::*figure, bool dashed) {
    evaluation::Series series{name, {}, dashed, false};
    for (const Step& step : steps) series.points.emplace_back(step.value, (step.*of).*figure);
    return series;
  };
  evaluation::Plot error, belief;
  error.title = row.title + ": wrong";
  belief.title = row.title + ": believed";
  error.x_label = belief.x_label = row.sweep;
  error.log_x = belief.log_x = row.log;
  error.y_label = "share of pixels";
  belief.y_label = "share, or 0..1";
  error.series = {line("paper, wrong by > 0.5 px", &Step::paper, &evaluation::FailureFigures::wrong, false),
                  line("likelihood", &Step::ours, &evaluation::FailureFigures::wrong, false),
                  line("likelihood, wrong and sure", &Step::ours, &evaluation::FailureFigures::deceived, true)};
  belief.series = {line("paper, mean confidence", &Step::paper, &evaluation::FailureFigures::confidence, false),
                   line("likelihood", &Step::ours, &evaluation::FailureFigures::confidence, false),
                   line("likelihood, sigma < 0.2 px", &Step::ours, &evaluation::FailureFigures::sure, true)};
  return "<div class=\"plots\">" + evaluation::svg_plot(error) + evaluation::svg_plot(belief) + "</div>";
}

std::string table(const evaluation::FailureRow& row, const std::vector<Step>& steps) {
  std::string html = "<details><summary>Figures</summary><div class=\"scroll\"><table><tr><th>" +
                     evaluation::escape_html(row.sweep) +
                     "</th><th>paper RMSE, px</th><th>wrong</th><th>confidence</th><th>likelihood RMSE, px</th>"
                     "<th>wrong</th><th>confidence</th><th>median sigma, px</th><th>wrong and sure</th>"
                     "<th>within 1, 2 sigma</th></tr>";
  for (const Step& step : steps) {
    html += fmt::format(
        "<tr><td>{:g}</td><td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td><td>{:.3f}</td>"
        "<td>{:.3f}</td><td>{:.4f}</td><td>{:.2f}, {:.2f}</td></tr>",
        step.value, step.paper.rmse_dp_px, step.paper.wrong, step.paper.confidence, step.ours.rmse_dp_px,
        step.ours.wrong, step.ours.confidence, step.ours.median_sigma_dp_px, step.ours.deceived,
        step.ours.within_one_sigma, step.ours.within_two_sigma);
  }
  return html + "</table></div></details>";
}

constexpr const char* kIntroduction = R"html(
<h1>How matching two dual-pixel views fails</h1>
<p>Each row sweeps one way of failing until a method breaks. The views are made in closed form: textures with as much
contrast in every octave (20 % of a mean of 811 electrons, 100 lux, unless swept), seen through mirrored halves of the
pupil; the truth is the disparity of the kernels' centroids, and is left out where a pixel sees no one surface.
A pixel is wrong where it errs by more than 0.5 DP px, and sure where less than 0.2 px was predicted: what must not
happen is both, in over 1 % of a picture. Disparities are those of the pixels, after upsampling from tiles.</p>
<p>A wrong focus distance in the metadata changes neither method's disparity: they don't read it. A depth derived from a
disparity d by 1/D = 1/z - d / (alpha L f) is then wrong by the difference of 1/z, the same everywhere.</p>
)html";

void run(const std::string& folder) {
  NewFolder out(folder, "failures.json");
  const std::vector<evaluation::FailureRow> rows = evaluation::failure_rows();
  nlohmann::ordered_json results = nlohmann::ordered_json::array();
  std::string summary =
      "<div class=\"scroll\"><table><tr><th>failure</th><th>swept</th><th>paper breaks at</th>"
      "<th>likelihood breaks at</th><th>most wrong and sure</th></tr>";
  std::string body;
  Progress bar("failures");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const evaluation::FailureRow& row = rows[i];
    std::vector<Step> steps;
    double deceived = 0;
    for (const double value : row.values) {
      const evaluation::FailureCase failure = row.make(value);
      steps.push_back({value, evaluation::measure_failure(failure, evaluation::FailureMethod::paper),
                       evaluation::measure_failure(failure, evaluation::FailureMethod::likelihood)});
      deceived = std::max(deceived, steps.back().ours.deceived);
    }
    bar(static_cast<double>(i + 1) / static_cast<double>(rows.size()));
    results.push_back(to_json(row, steps));
    summary += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{:.2f} %</td></tr>",
                           evaluation::escape_html(row.title), evaluation::escape_html(row.sweep),
                           breaks_at(steps, &Step::paper), breaks_at(steps, &Step::ours), 100 * deceived);
    body += "<h2>" + evaluation::escape_html(row.title) + "</h2>" + plots(row, steps) + table(row, steps);
  }
  const std::string page = kIntroduction + summary +
                           "</table></div><p class=\"soft\">Broken: more than a tenth of the pixels are wrong.</p>" +
                           body;
  const nlohmann::ordered_json json = {{"format", "dualpixel-experiment-failures"}, {"version", 1}, {"rows", results}};
  write_file(out.path() + "/failures.json", json.dump(2) + "\n");
  write_file(out.path() + "/failures.html",
             evaluation::html_page("How matching fails", std::string(evaluation::kReportStyle) + evaluation::kPlotStyle,
                                   page));
  out.commit();
}

}  // namespace

void add_experiment_failures(CLI::App& experiment) {
  auto folder = std::make_shared<std::string>();
  CLI::App* command = experiment.add_subcommand(
      "failures", "Sweep fourteen ways in which disparity fails: error and confidence of both matchers");
  command->add_option("-o,--output", *folder, "Folder for failures.json and failures.html")
      ->required()
      ->type_name("DIR");
  add_threads_option(*command);
  command->footer("Example:\n  dualpixel experiment failures -o out/failures");
  command->callback([folder] { run(*folder); });
}

}  // namespace dualpixel::tools
