#include "evaluation/report/dataset_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "capture/image/image_io.h"
#include "datasets/render/sample_folder.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/report_images.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {
namespace {

using nlohmann::json;

/// Values and how much each counts.
using Weighted = std::vector<std::pair<double, double>>;

/// Shares of the weight, in percent, in bins of equal width: the outline of their bars. Few values have few bins, by
/// Rice's rule; an odd number, so that equal values stand in the middle.
Series histogram(const Weighted& values, double low, double high) {
  constexpr int kMostBins = 49;
  const int count = std::min(static_cast<int>(2 * std::cbrt(values.size())) | 1, kMostBins);
  std::vector<double> bins(static_cast<std::size_t>(count));
  double sum = 0;
  for (const auto& [value, weight] : values) {
    const int bin = static_cast<int>(std::floor((value - low) / (high - low) * count));
    bins[static_cast<std::size_t>(std::clamp(bin, 0, count - 1))] += weight;
    sum += weight;
  }
  Series outline{"", {{low, 0}}};
  for (int i = 0; i < count; ++i) {
    const double percent = 100 * bins[static_cast<std::size_t>(i)] / sum;
    for (const int side : {0, 1}) outline.points.emplace_back(low + (high - low) * (i + side) / count, percent);
  }
  outline.points.emplace_back(high, 0);
  return outline;
}

/// The value below which `share` of the weight lies.
double weighted_quantile(Weighted values, double share) {
  std::sort(values.begin(), values.end());
  double sum = 0, below = 0;
  for (const auto& [value, weight] : values) sum += weight;
  for (const auto& [value, weight] : values) {
    below += weight;
    if (below >= share * sum) return value;
  }
  return values.empty() ? 0 : values.back().first;
}

/// Pixels of all samples, as each sample's quantiles tell of them.
Weighted pixels_of(const std::vector<json>& index, const char* statistic) {
  Weighted values;
  for (const json& sample : index) {
    for (const json& value : sample.at("statistics").at(statistic)) {
      if (value.is_number()) values.emplace_back(value.get<double>(), 1);
    }
  }
  return values;
}

Weighted samples_of(const std::vector<json>& index, const std::function<json(const json&)>& field) {
  Weighted values;
  for (const json& sample : index) {
    const json value = field(sample);
    if (value.is_number()) values.emplace_back(value.get<double>(), 1);
  }
  return values;
}

Plot plot_of(const char* title, const char* x_label, const char* y_label, const Weighted& values) {
  constexpr double kTail = 0.002;
  double low = weighted_quantile(values, kTail), high = weighted_quantile(values, 1 - kTail);
  if (!(high > low)) low -= 0.5, high += 0.5;
  return {title, x_label, y_label, {histogram(values, low, high)}};
}

/// In bins of equal ratio.
Plot log_plot_of(const char* title, const char* x_label, const char* y_label, Weighted values) {
  for (auto& [value, weight] : values) value = std::log2(value);
  Plot plot = plot_of(title, x_label, y_label, values);
  plot.log_x = true;
  for (auto& [x, percent] : plot.series[0].points) x = std::exp2(x);
  return plot;
}

std::string plots_of(const std::vector<json>& index) {
  constexpr const char* kPixels = "% of pixels";
  constexpr const char* kSamples = "% of samples";
  const auto statistic = [](const char* name) {
    return [name](const json& sample) { return sample.at("statistics").at(name); };
  };
  const auto field = [](const char* name) { return [name](const json& sample) { return sample.at(name); }; };
  return html_plots(
      {plot_of("Disparity", "disparity, DP px", kPixels, pixels_of(index, "disparity_dp_px")),
       log_plot_of("Depth", "depth, m", kPixels, pixels_of(index, "depth_m")),
       log_plot_of("Focus", "focus distance, m", kSamples, samples_of(index, field("focus_distance_m"))),
       plot_of("Light", "mean signal over white", kSamples, samples_of(index, statistic("mean_signal"))),
       plot_of("Clipped", "share of clipped pixels", kSamples, samples_of(index, statistic("clipped_share"))),
       plot_of("Rendering noise", "of the sensor's noise", kSamples, samples_of(index, field("noise_fraction")))});
}

Table splits_table(const std::vector<json>& index) {
  struct Split {
    int samples = 0, missed_exposures = 0;
    std::set<json> scenes;
  };
  std::map<std::string, Split> splits;
  for (const json& sample : index) {
    Split& split = splits[sample.at("split")];
    ++split.samples;
    split.missed_exposures += sample.contains("missed_exposure") ? 1 : 0;
    split.scenes.insert(sample.at("scene"));
  }
  Table table{{"split", "samples", "scenes", "mean exposure missed"}, {}};
  for (const auto& [name, split] : splits) {
    table.rows.push_back({name, std::to_string(split.samples), std::to_string(split.scenes.size()),
                          std::to_string(split.missed_exposures)});
  }
  return table;
}

/// Evenly over the data set, in order.
std::string contact_sheet_of(const std::vector<json>& index, const std::string& folder) {
  constexpr std::size_t kMost = 120;
  const std::size_t count = std::min(kMost, index.size());
  std::string html = "<div class=\"sheet\">";
  for (std::size_t i = 0; i < count; ++i) {
    const json& sample = index[i * index.size() / count];
    const std::string path = folder + "/" + sample.at("folder").get<std::string>() + "/" + datasets::kPreviewFile;
    html += html_figure(
        {.title = sample.at("name"), .caption = sample.at("split"), .data_uri = jpeg_data_uri(read_image(path))});
  }
  return html + "</div>";
}

}  // namespace

std::string dataset_page(const std::vector<json>& index, const std::string& folder) {
  const std::string title = fmt::format("{} samples", index.size());
  return html_page(title,
                   "<h1>" + title + "</h1>" + html_table(splits_table(index)) + plots_of(index) +
                       "<h2>Contact sheet</h2>" + contact_sheet_of(index, folder),
                   ".sheet{display:grid;grid-template-columns:repeat(auto-fill,minmax(160px,1fr));gap:8px}"
                   ".sheet figure{margin:0}");
}

}  // namespace dualpixel::evaluation
