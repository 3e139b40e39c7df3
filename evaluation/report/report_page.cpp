#include "evaluation/report/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {
namespace {

std::string disparity_table(const std::vector<RegionScore>& regions) {
  Table table{{"region", "coverage", "bias", "RMSE", "> 0.1", "> 0.25", "> 0.5", "fit scale", "fit offset",
               "fitted RMSE", "fitted > 0.1", "> 0.25", "> 0.5", "AIWE(1)", "1 − |ρ|", "AUSE"},
              {}};
  for (const RegionScore& r : regions) {
    const std::optional<double> scale = r.fit ? std::optional(r.fit->scale) : std::nullopt;
    const std::optional<double> offset = r.fit ? std::optional(r.fit->offset) : std::nullopt;
    std::vector<std::string>& row = table.rows.emplace_back(1, r.region);
    for (const auto& figure :
         {r.coverage, r.bias_px, r.rmse_px, r.bad[0], r.bad[1], r.bad[2], scale, offset, r.rmse_affine_px,
          r.bad_affine[0], r.bad_affine[1], r.bad_affine[2], r.aiwe1, r.one_minus_rho, r.sparsification.ause}) {
      row.push_back(cell_of(figure, 3));
    }
  }
  return html_table(table);
}

std::string picture_table(const Score& score) {
  Table table{{"", "PSNR sRGB, dB", "PSNR linear, dB", "SSIM sRGB", "SSIM linear"}, {}};
  for (const auto& [name, f] : {std::pair{"portrait", score.portrait}, {"input, not blurred", score.input}}) {
    if (!f) continue;
    table.rows.push_back({name, cell_of(f->psnr_srgb_db, 2), cell_of(f->psnr_linear_db, 2), cell_of(f->ssim_srgb, 4),
                          cell_of(f->ssim_linear, 4)});
  }
  return html_table(table);
}

Plot sparsification_plot(const Sparsification& curves) {
  Plot plot;
  plot.title = "Sparsification";
  plot.x_label = "share of pixels removed";
  plot.y_label = "mean error after the affine fit, DP px";
  plot.series = {{"least confident first", {}, false, false}, {"largest error first", {}, true, false}};
  for (std::size_t i = 0; i < curves.removed.size(); ++i) {
    plot.series[0].points.emplace_back(curves.removed[i], curves.error[i]);
    plot.series[1].points.emplace_back(curves.removed[i], curves.oracle[i]);
  }
  return plot;
}

double total_ms(const std::vector<pipeline::StageTime>& stages) {
  double sum = 0;
  for (const pipeline::StageTime& stage : stages) sum += stage.ms;
  return sum;
}

std::string stage_table(const std::vector<pipeline::StageTime>& stages) {
  Table table{{"stage", "ms", "peak memory, MB"}, {}};
  for (const pipeline::StageTime& stage : stages) {
    table.rows.push_back({stage.name, cell_of(stage.ms, 1), cell_of(stage.peak_rss_mb, 0)});
  }
  table.rows.push_back({"total", cell_of(total_ms(stages), 1), ""});
  return html_table(table);
}

std::string provenance(const char* title, const std::string& text) {
  return fmt::format("<details><summary>{}</summary><pre>{}</pre></details>\n", title, escape_html(text));
}

std::string score_html(const Score& score) {
  std::string html;
  if (!score.disparity.empty()) {
    const Sparsification& curves = score.disparity.front().sparsification;
    html += "<h4>Disparity against the truth, DP px</h4>\n" + disparity_table(score.disparity);
    if (!curves.error.empty() && *std::max_element(curves.error.begin(), curves.error.end()) > 0) {
      html += html_plots({sparsification_plot(curves)});
    }
  }
  html += "<h4>Against the true photograph</h4>\n" + picture_table(score);
  for (const std::string& note : score.notes) html += "<p class=\"soft\">" + escape_name(note) + "</p>\n";
  return html;
}

std::string result_html(const ResultSection& result) {
  std::string how = result.mode;
  if (!result.disparity_from.empty()) how += ", disparity: " + result.disparity_from;
  std::string html =
      fmt::format("<h3>{} <span class=\"mode\">{}</span></h3>\n", escape_name(result.name), escape_name(how));
  if (result.score) html += score_html(*result.score);
  html += "<h4>Time and memory</h4>\n" + stage_table(result.stages);
  return html + provenance("How this result was made", result.provenance);
}

/// The scores of one region, or an empty one.
RegionScore region_of(const std::optional<Score>& score, const std::string& name) {
  if (!score) return {};
  const auto found = std::find_if(score->disparity.begin(), score->disparity.end(),
                                  [&](const RegionScore& region) { return region.region == name; });
  return found != score->disparity.end() ? *found : RegionScore{};
}

std::string overview(const std::vector<CaptureSection>& captures) {
  Table table{{"result", "mode", "disparity", "confident fitted RMSE", "AIWE(1)", "1 − |ρ|", "PSNR, dB",
               "over the input, dB", "SSIM", "total, ms"},
              {}};
  for (const CaptureSection& capture : captures) {
    for (const ResultSection& result : capture.results) {
      const RegionScore everything = region_of(result.score, "everything");
      const Score score = result.score.value_or(Score());
      const PictureScore portrait = score.portrait.value_or(PictureScore()),
                         input = score.input.value_or(PictureScore());
      const bool both = portrait.psnr_srgb_db && input.psnr_srgb_db;
      table.rows.push_back({result.name, result.mode, result.disparity_from,
                            cell_of(region_of(result.score, "confident").rmse_affine_px, 3),
                            cell_of(everything.aiwe1, 3), cell_of(everything.one_minus_rho, 3),
                            cell_of(portrait.psnr_srgb_db, 2),
                            both ? fmt::format("{:+.2f}", *portrait.psnr_srgb_db - *input.psnr_srgb_db) : "–",
                            cell_of(portrait.ssim_srgb, 4), cell_of(total_ms(result.stages), 0)});
    }
  }
  return html_table(table);
}

constexpr const char* kDefinitions =
    "<details><summary>What the figures mean</summary>"
    "<p>Disparity is in dual-pixel pixels: negative in front of the focus plane, positive behind it. Regions: "
    "everything "
    "(valid truth, finite estimate); confident (confidence at least 0.5); depth edges (at most 8 full-resolution "
    "pixels "
    "from a jump of the true disparity by more than 0.1 DP px); person (true mask). Coverage is a region's share of "
    "the "
    "valid pixels.</p>"
    "<p>&gt; 0.1 and so on: share of the pixels that err by more. The affine fit, scale × estimate + offset, is least "
    "squares over the region itself; its RMSE is AIWE(2), and AIWE(1) is the mean absolute error after a robust fit "
    "(Garg et al. 2019). ρ is Spearman's rank correlation; ties get average ranks.</p>"
    "<p>AUSE: area between the sparsification curve and that of an oracle, over the mean error; 0 is a perfect "
    "confidence.</p>"
    "<p>PSNR and SSIM (Wang et al. 2004, luminance, 11 × 11 Gaussian window) against the true photograph through the "
    "wider "
    "aperture, signal clipped to 0…1; sRGB: encoded for display.</p></details>\n";

}  // namespace

std::string report_page(const std::vector<CaptureSection>& captures) {
  std::string body = "<h1>Dual-pixel portraits</h1>\n" + overview(captures) + kDefinitions;
  for (const CaptureSection& capture : captures) {
    body +=
        fmt::format("<h2>{}</h2>\n<p class=\"soft\">{}</p>\n", escape_name(capture.name), escape_html(capture.facts));
    body += html_viewer(capture.viewer) + provenance("How this capture was made", capture.provenance);
    for (const ResultSection& result : capture.results) body += result_html(result);
  }
  return html_page("Dual-pixel portraits", body);
}

}  // namespace dualpixel::evaluation
