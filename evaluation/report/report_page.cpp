#include "evaluation/report/report_page.h"

#include <fmt/format.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <string_view>

#include "capture/error.h"
#include "evaluation/report/report_assets.h"

namespace dualpixel::evaluation {
namespace {

using Json = nlohmann::ordered_json;

struct Column {
  const char* key;
  const char* title;
  int decimals;
};

constexpr Column kDisparityColumns[] = {{"coverage", "coverage", 3},
                                        {"bias_px", "bias", 3},
                                        {"rmse_px", "RMSE", 3},
                                        {"bad_0p1", "> 0.1", 3},
                                        {"bad_0p25", "> 0.25", 3},
                                        {"bad_0p5", "> 0.5", 3},
                                        {"affine_scale", "fitted scale", 3},
                                        {"affine_offset_px", "and offset", 3},
                                        {"rmse_affine_px", "fitted RMSE", 3},
                                        {"bad_0p1_affine", "fitted > 0.1", 3},
                                        {"bad_0p25_affine", "> 0.25", 3},
                                        {"bad_0p5_affine", "> 0.5", 3},
                                        {"aiwe1", "AIWE(1)", 3},
                                        {"one_minus_rho_average_ranks", "1 − |ρ|", 3},
                                        {"ause", "AUSE", 3}};

/// What a name from outside (a path, a mode) may show as: one line of valid UTF-8, with no meaning in HTML.
std::string shown(const std::string& name) { return escape_html(printable(name)); }

std::string figure_text(const Json& value, int decimals) {
  return value.is_number() ? fmt::format("{:.{}f}", value.get<double>(), decimals) : "–";
}

/// A table whose cells are HTML already; the first row is its head.
std::string table(const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<div class=\"scroll\"><table>";
  for (const std::vector<std::string>& row : rows) {
    const char* cell = &row == &rows.front() ? "th" : "td";
    html += "<tr>";
    for (const std::string& text : row) html += fmt::format("<{0}>{1}</{0}>", cell, text);
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string image_tag(const Picture& picture) {
  return fmt::format("<img src=\"{}\" alt=\"{}\">", picture.data_uri, escape_html(picture.title));
}

std::string stack(const std::vector<Picture>& pictures) {
  std::string html = "<div class=\"stack\">";
  for (const Picture& picture : pictures) html += image_tag(picture);
  return html + "</div>\n";
}

std::string flicker(const std::vector<Picture>& views) {
  return "<figure class=\"flicker pair\">" + stack(views) +
         "<div class=\"controls\"><button type=\"button\">Flip</button>"
         "<label><input type=\"checkbox\"> automatically</label><output></output></div><figcaption>" +
         escape_html(views.front().caption) + "</figcaption></figure>\n";
}

std::string comparison(const std::vector<Picture>& pictures) {
  const auto choice = [&](const char* label, std::size_t chosen) {
    std::string html = fmt::format("<label>{} <select>", label);
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      html += fmt::format("<option{}>{}</option>", i == chosen ? " selected" : "", escape_html(pictures[i].title));
    }
    return html + "</select></label>";
  };
  return "<figure class=\"compare pair\">" + stack(pictures) + "<div class=\"controls\">" + choice("Left:", 0) +
         "<input type=\"range\" min=\"0\" max=\"100\" step=\"any\" value=\"50\" aria-label=\"Divider\">" +
         choice("Right:", pictures.size() - 1) + "</div><figcaption>" + escape_html(pictures.front().caption) +
         "</figcaption></figure>\n";
}

std::string map(const Picture& picture) {
  std::string html = "<figure>" + image_tag(picture);
  if (!picture.bar_uri.empty()) {
    html += fmt::format("<div class=\"bar soft\"><span>{}</span><img src=\"{}\" alt=\"\"><span>{}</span></div>",
                        escape_html(picture.bar_low), picture.bar_uri, escape_html(picture.bar_high));
  }
  return html + fmt::format("<figcaption><b>{}</b> {}</figcaption></figure>\n", escape_html(picture.title),
                            escape_html(picture.caption));
}

std::string disparity_scores(const Json& regions) {
  std::vector<std::vector<std::string>> rows(1, {"region"});
  for (const Column& column : kDisparityColumns) rows[0].push_back(column.title);
  for (const auto& [region, figures] : regions.items()) {
    std::vector<std::string>& row = rows.emplace_back();
    row.push_back(shown(region));
    for (const Column& column : kDisparityColumns) row.push_back(figure_text(figures[column.key], column.decimals));
  }
  return table(rows);
}

std::string image_scores(const Json& figures) {
  std::vector<std::vector<std::string>> rows = {{"", "PSNR sRGB, dB", "PSNR linear, dB", "SSIM sRGB", "SSIM linear"}};
  for (const auto& [label, suffix] : {std::pair{"portrait", ""}, std::pair{"input, not blurred", "_input"}}) {
    rows.push_back({label, figure_text(figures[fmt::format("psnr_srgb{}_db", suffix)], 2),
                    figure_text(figures[fmt::format("psnr_linear{}_db", suffix)], 2),
                    figure_text(figures[fmt::format("ssim_srgb{}", suffix)], 4),
                    figure_text(figures[fmt::format("ssim_linear{}", suffix)], 4)});
  }
  return table(rows);
}

/// The two curves of scoring.h's sparsification, as a drawing.
std::string sparsification_chart(const Json& curves) {
  const auto removed = curves["removed"].get<std::vector<double>>();
  const auto error = curves["error_px"].get<std::vector<double>>();
  const auto oracle = curves["oracle_px"].get<std::vector<double>>();
  const double highest = error.empty() ? 0 : *std::max_element(error.begin(), error.end());
  if (highest <= 0) return "";
  constexpr double kLeft = 50, kTop = 15, kWidth = 340, kHeight = 170;
  const auto line = [&](const char* kind, const std::vector<double>& values) {
    std::string points;
    for (std::size_t i = 0; i < values.size(); ++i) {
      points += fmt::format("{:.1f},{:.1f} ", kLeft + kWidth * removed[i], kTop + kHeight * (1 - values[i] / highest));
    }
    return fmt::format("<polyline class=\"{}\" points=\"{}\"/>", kind, points);
  };
  return fmt::format(
      "<figure><svg viewBox=\"0 0 400 225\" role=\"img\" aria-label=\"Sparsification curve\">"
      "<path class=\"axis\" d=\"M{0} {1}v{2}h{3}\"/>{4}{5}"
      "<text x=\"{6}\" y=\"{7}\" text-anchor=\"end\">{8:.3f}</text><text x=\"{6}\" y=\"{9}\" "
      "text-anchor=\"end\">0</text>"
      "<text x=\"{0}\" y=\"{10}\">0</text><text x=\"{11}\" y=\"{10}\" text-anchor=\"end\">all removed</text></svg>"
      "<figcaption>Mean error after the affine fit, DP px, of the pixels that remain when the least confident are "
      "removed; dashed: when the worst are.</figcaption></figure>\n",
      kLeft, kTop, kHeight, kWidth, line("oracle", oracle), line("error", error), kLeft - 6, kTop + 8, highest,
      kTop + kHeight, kTop + kHeight + 18, kLeft + kWidth);
}

double total_ms(const nlohmann::json& stages) {
  double sum = 0;
  for (const nlohmann::json& stage : stages) sum += stage["ms"].get<double>();
  return sum;
}

std::string stage_table(const nlohmann::json& stages) {
  std::vector<std::vector<std::string>> rows = {{"stage", "ms", "peak memory, MB"}};
  for (const nlohmann::json& stage : stages) {
    rows.push_back({shown(stage["name"].get<std::string>()), fmt::format("{:.1f}", stage["ms"].get<double>()),
                    fmt::format("{:.0f}", stage["peak_rss_mb"].get<double>())});
  }
  rows.push_back({"total", fmt::format("{:.1f}", total_ms(stages)), ""});
  return table(rows);
}

std::string provenance(const char* title, const nlohmann::json& json) {
  return fmt::format("<details><summary>{}</summary><pre>{}</pre></details>\n", title,
                     escape_html(json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace)));
}

std::string result_section(const ResultSection& result) {
  std::string html =
      fmt::format("<h3>{} <span class=\"mode\">{}</span></h3>\n", shown(result.name), shown(result.mode));
  html += comparison(result.photographs);
  if (!result.maps.empty()) {
    html += "<h4>Maps</h4>\n<div class=\"maps\">\n";
    for (const Picture& picture : result.maps) html += map(picture);
    html += "</div>\n";
  }
  if (result.score.is_object()) {
    if (result.score.contains("disparity")) {
      const Json& regions = result.score["disparity"];
      html += "<h4>Disparity against the truth, DP px</h4>\n" + disparity_scores(regions);
      html += sparsification_chart(regions["everything"]["sparsification"]);
    }
    html += "<h4>Against the true photograph</h4>\n" + image_scores(result.score["image"]);
    for (const Json& note : result.score["notes"]) {
      html += "<p class=\"soft\">" + shown(note.get<std::string>()) + "</p>\n";
    }
  }
  html += "<h4>Time and memory</h4>\n" + stage_table(result.stages);
  return html + provenance("How this result came about", result.provenance);
}

std::string overview(const std::vector<CaptureSection>& captures) {
  std::vector<std::vector<std::string>> rows = {{"result", "mode", "confident fitted RMSE", "AIWE(1)", "1 − |ρ|",
                                                 "PSNR, dB", "over the input, dB", "SSIM", "total, ms"}};
  for (const CaptureSection& capture : captures) {
    for (const ResultSection& result : capture.results) {
      const auto figure = [&](const char* pointer) {
        const Json::json_pointer at(pointer);
        return result.score.contains(at) ? result.score[at] : Json();
      };
      const Json psnr = figure("/image/psnr_db"), psnr_input = figure("/image/psnr_input_db");
      const bool both = psnr.is_number() && psnr_input.is_number();
      rows.push_back({shown(result.name), shown(result.mode),
                      figure_text(figure("/disparity/confident/rmse_affine_px"), 3),
                      figure_text(figure("/disparity/everything/aiwe1"), 3),
                      figure_text(figure("/disparity/everything/one_minus_rho_average_ranks"), 3), figure_text(psnr, 2),
                      both ? fmt::format("{:+.2f}", psnr.get<double>() - psnr_input.get<double>()) : "–",
                      figure_text(figure("/image/ssim"), 4), fmt::format("{:.0f}", total_ms(result.stages))});
    }
  }
  return table(rows);
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

std::string escape_html(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string report_page(const std::vector<CaptureSection>& captures) {
  std::string body = "<h1>Dual-pixel portraits</h1>\n" + overview(captures) + kDefinitions;
  for (const CaptureSection& capture : captures) {
    body += fmt::format("<h2>{}</h2>\n<p class=\"soft\">{}</p>\n", shown(capture.name), escape_html(capture.facts));
    body += flicker(capture.flicker) + provenance("How this capture came about", capture.provenance);
    for (const ResultSection& result : capture.results) body += result_section(result);
  }
  return html_page("Dual-pixel portraits", kReportStyle, body, kReportScript);
}

std::string html_page(const std::string& title, const std::string& style, const std::string& body,
                      const std::string& script) {
  // Only the style and the script that carry this nonce are run; whoever chooses a name in the page cannot know it.
  const std::string nonce = fmt::format("{:016x}", XXH64(body.data(), body.size(), 0));
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
      "style-src 'nonce-{0}'; script-src 'nonce-{0}'; base-uri 'none'; form-action 'none'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{4}</title>\n"
      "<style nonce=\"{0}\">{1}</style>\n</head>\n<body>\n{2}<script nonce=\"{0}\">{3}</script>\n</body>\n</html>\n",
      nonce, style, body, script, escape_html(title));
}

}  // namespace dualpixel::evaluation
