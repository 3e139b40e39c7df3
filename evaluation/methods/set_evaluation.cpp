#include "evaluation/methods/set_evaluation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/names.h"
#include "evaluation/metrics/disparity_metrics.h"
#include "evaluation/report/page.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {
namespace {

using Json = nlohmann::ordered_json;

constexpr float kJumpDpPx = 0.1f, kFocusDpPx = 0.25f;
constexpr int kEdgeReachDpPx = 2, kThinDpPx = 8, kTextureRadius = 4;
constexpr double kTextureless = 2, kClipped = 0.98;

/// Of one pixel of a sample.
struct JudgedPixel {
  float truth;
  bool edge, thin, textureless, clipped;
};

struct Region {
  const char* name;
  bool (*holds)(const JudgedPixel& pixel);
};

template <int kLowHundredths, int kHighHundredths>
bool in_bin(const JudgedPixel& p) {
  const float amount = 100 * std::abs(p.truth);
  return amount >= kLowHundredths && amount < kHighHundredths;
}

constexpr Region kRegions[] = {
    {"everything", [](const JudgedPixel&) { return true; }},
    {"edges", [](const JudgedPixel& p) { return p.edge; }},
    {"thin", [](const JudgedPixel& p) { return p.thin; }},
    {"textureless", [](const JudgedPixel& p) { return p.textureless; }},
    {"clipped", [](const JudgedPixel& p) { return p.clipped; }},
    {"front", [](const JudgedPixel& p) { return p.truth < -kFocusDpPx; }},
    {"behind", [](const JudgedPixel& p) { return p.truth > kFocusDpPx; }},
    {"0 to 0.25", in_bin<0, 25>},
    {"0.25 to 1", in_bin<25, 100>},
    {"1 to 2", in_bin<100, 200>},
    {"2 to 4", in_bin<200, 400>},
    {"4 and more", in_bin<400, 100000000>},
};

/// Whether each pixel's surroundings vary no more than noise explains.
Mask textureless(const ViewSample& sample) {
  const Image& view = sample.left;
  Mask flat(view.width, view.height);
  if (!sample.sensor.noise) return flat;
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      double sum = 0, squares = 0, count = 0;
      for (int v = std::max(0, y - kTextureRadius); v <= std::min(view.height - 1, y + kTextureRadius); ++v) {
        for (int u = std::max(0, x - kTextureRadius); u <= std::min(view.width - 1, x + kTextureRadius); ++u) {
          const double value = view.at(u, v);
          sum += value, squares += value * value, count += 1;
        }
      }
      const double mean = sum / count, variance = (squares - sum * mean) / (count - 1);
      flat.at(x, y) = variance < kTextureless * (sample.sensor.noise->shot * mean + sample.sensor.noise->read);
    }
  }
  return flat;
}

/// Whether a line's pixel lies on something thin: it has what lies further back on both sides. `step` leads to the next
/// pixel of the line, which has `before` pixels before this one and `after` behind it.
bool is_thin(const float* pixel, std::ptrdiff_t step, int before, int after) {
  const auto ends_at = [&](int most, std::ptrdiff_t way) {
    for (int i = 1; i <= std::min(most, kThinDpPx); ++i) {
      if (pixel[way * i] > *pixel + kJumpDpPx) return i;
    }
    return kThinDpPx + 1;
  };
  return ends_at(before, -step) + ends_at(after, step) - 1 <= kThinDpPx;
}

/// Whether what each pixel shows is thin along its row or its column.
Mask thin(const Image& truth_dp_px) {
  Mask mask(truth_dp_px.width, truth_dp_px.height);
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      const float* pixel = truth_dp_px.row(y) + x;
      mask.at(x, y) =
          is_thin(pixel, 1, x, mask.width - 1 - x) || is_thin(pixel, truth_dp_px.width, y, mask.height - 1 - y);
    }
  }
  return mask;
}

/// The pixels of a sample; those without truth have a NaN.
std::vector<JudgedPixel> judged_pixels(const ViewSample& sample) {
  // NaN exceeds nothing: no edge where the truth ends
  const Mask edges = depth_edges(sample.truth_dp_px, kJumpDpPx, kEdgeReachDpPx), narrow = thin(sample.truth_dp_px);
  const Mask flat = textureless(sample);
  const auto white = static_cast<float>(kClipped * sample.sensor.white);
  std::vector<JudgedPixel> pixels(sample.left.data.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const bool clipped = sample.left.data[i] >= white || sample.right.data[i] >= white;
    pixels[i] = {sample.truth_dp_px.data[i], edges.data[i] == 1, narrow.data[i] == 1, flat.data[i] == 1, clipped};
  }
  return pixels;
}

/// RegionSums over pixels, from which the figures follow.
struct RegionSums {
  double pixels = 0, found = 0, squares = 0, wrong = 0, with_sigma = 0, within_sigma = 0;
};

void add_errors(const std::vector<JudgedPixel>& pixels, const pipeline::PixelDisparity& found,
                std::vector<RegionSums>& sums) {
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (std::isnan(pixels[i].truth)) continue;
    const float error = std::abs(found.disparity_dp_px.data[i] - pixels[i].truth);
    for (std::size_t r = 0; r < std::size(kRegions); ++r) {
      if (!kRegions[r].holds(pixels[i])) continue;
      RegionSums& s = sums[r];
      s.pixels += 1;
      s.wrong += !(error <= kWrongDpPx);
      if (!std::isfinite(error)) continue;
      s.found += 1;
      s.squares += static_cast<double>(error) * error;
      if (found.sigma_dp_px.empty() || std::isnan(found.sigma_dp_px.data[i])) continue;
      s.with_sigma += 1;
      s.within_sigma += error <= found.sigma_dp_px.data[i];
    }
  }
}

SetFigures figures_of(const RegionSums& s) {
  SetFigures figures{static_cast<std::size_t>(s.pixels), s.pixels > 0 ? s.found / s.pixels : 0, {}, {}, {}};
  if (s.pixels > 0) figures.wrong = s.wrong / s.pixels;
  if (s.found > 0) figures.rmse_dp_px = std::sqrt(s.squares / s.found);
  if (s.with_sigma > 0) figures.within_one_sigma = s.within_sigma / s.with_sigma;
  return figures;
}

}  // namespace

std::vector<std::string> region_names() { return names_of(kRegions); }

std::vector<SetScore> evaluate_set(const std::vector<std::string>& sample_folders,
                                   const std::vector<DisparityMethod>& methods,
                                   const std::function<void(double)>& progress) {
  std::vector<SetScore> scores(methods.size());
  std::vector<std::vector<RegionSums>> sums(methods.size(), std::vector<RegionSums>(std::size(kRegions)));
  const auto count = static_cast<double>(sample_folders.size());
  for (std::size_t i = 0; i < sample_folders.size(); ++i) {
    const ViewSample sample = read_view_sample(sample_folders[i]);
    const std::vector<JudgedPixel> pixels = judged_pixels(sample);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const MethodRun run = methods[m].run(sample.left, sample.right, sample.sensor);
      add_errors(pixels, run.found, sums[m]);
      scores[m].wall_s += run.wall_s / count;
      scores[m].cpu_s += run.cpu_s / count;
      if (run.peak_rss_mb) scores[m].peak_rss_mb = std::max(*run.peak_rss_mb, scores[m].peak_rss_mb.value_or(0));
    }
    if (progress) progress(static_cast<double>(i + 1) / count);
  }
  for (std::size_t m = 0; m < methods.size(); ++m) {
    scores[m].method = methods[m].name;
    for (const RegionSums& s : sums[m]) scores[m].regions.push_back(figures_of(s));
  }
  return scores;
}

Json to_json(const std::vector<SetScore>& scores, std::size_t samples) {
  Json json = {{"format", "dualpixel-evaluation"}, {"version", 1}, {"samples", samples}};
  for (const SetScore& score : scores) {
    Json& entry = json["methods"][score.method];
    entry = {{"wall_s", score.wall_s}, {"cpu_s", score.cpu_s}};
    if (score.peak_rss_mb) entry["peak_rss_mb"] = *score.peak_rss_mb;
    for (std::size_t r = 0; r < std::size(kRegions); ++r) {
      const SetFigures& f = score.regions[r];
      Json& region = entry["regions"][kRegions[r].name];
      region = {{"pixels", f.pixels}, {"found_share", f.found}};
      if (f.rmse_dp_px) region["rmse_dp_px"] = *f.rmse_dp_px;
      if (f.wrong) region["wrong_share"] = *f.wrong;
      if (f.within_one_sigma) region["within_one_sigma_share"] = *f.within_one_sigma;
    }
  }
  return json;
}

std::string to_page(const std::vector<SetScore>& scores, std::size_t samples) {
  std::string body = fmt::format(
      "<h1>Methods compared over {} pair{}</h1>\n<p>A click on a column's head sorts by it. Edges: up to {} DP px from "
      "a jump of the true disparity by more than {} DP px. Thin: no more than {} DP px along the row or the column, "
      "with what lies further back by such a jump on both sides. Textureless: views vary by less than {} times the "
      "variance of their noise. Clipped: a view reaches {} of its white. Front and behind: the true disparity is under "
      "-{} or over {} DP px; bins are of its amount. Wrong: by more than {} DP px, or not found.</p>\n",
      samples, samples == 1 ? "" : "s", kEdgeReachDpPx, kJumpDpPx, kThinDpPx, kTextureless, kClipped, kFocusDpPx,
      kFocusDpPx, kWrongDpPx);
  using Figure = std::optional<double> (*)(const SetFigures&);
  const std::pair<const char*, Figure> figures[] = {
      {"RMSE of what was found, DP px", [](const SetFigures& f) { return f.rmse_dp_px; }},
      {"Share that is wrong", [](const SetFigures& f) { return f.wrong; }},
      {"Share that was found",
       [](const SetFigures& f) { return f.pixels ? std::optional(f.found) : std::optional<double>(); }},
      {"Share of errors within one sigma", [](const SetFigures& f) { return f.within_one_sigma; }}};
  for (const auto& [title, figure] : figures) {
    Table table{{"method"}, {}};
    for (const Region& region : kRegions) table.header.emplace_back(region.name);
    for (const SetScore& score : scores) {
      std::vector<std::string>& row = table.rows.emplace_back(1, score.method);
      for (const SetFigures& f : score.regions) row.push_back(cell_of(figure(f), 3));
    }
    body += fmt::format("<h2>{}</h2>\n", title) + html_table(table);
  }
  Table cost{{"method", "s a pair", "CPU s a pair", "peak memory, MB"}, {}};
  for (const SetScore& s : scores) {
    cost.rows.push_back({s.method, cell_of(s.wall_s, 3), cell_of(s.cpu_s, 3), cell_of(s.peak_rss_mb, 0)});
  }
  body += "<h2>Time and memory</h2>\n" + html_table(cost);
  return html_page("Methods compared", body);
}

std::string to_text(const std::vector<SetScore>& scores) {
  std::size_t width = 20;
  for (const SetScore& s : scores) width = std::max(width, s.method.size() + 1);
  std::string text =
      fmt::format("{:<{}}{:>9}{:>9}{:>9}{:>10}{:>10}\n", "method", width, "RMSE px", "wrong", "found", "s", "MB");
  for (const SetScore& s : scores) {
    const SetFigures& all = s.regions.front();
    text += fmt::format("{:<{}}{:>9}{:>9}{:>9.3f}{:>10.3f}{:>10}\n", s.method, width, cell_of(all.rmse_dp_px, 3),
                        cell_of(all.wrong, 3), all.found, s.wall_s, cell_of(s.peak_rss_mb, 0));
  }
  return text;
}

}  // namespace dualpixel::evaluation
