#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "evaluation/experiments/noise_experiment.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "pipeline/burst/merge.h"

namespace dualpixel::evaluation {
namespace {

template <typename Value>
Series over_light(const std::string& name, const LightSweep& sweep, const Value& value, bool dashed = false) {
  Series series{name, {}, dashed, false};
  for (const LightPoint& p : sweep.points) series.points.emplace_back(p.lux, value(p));
  return series;
}

constexpr const char* kLightLabel = "light on the target, lux";

/// Why the ratios are what they are, with figures of the sweep without a fixed pattern.
std::string explanation(const NoiseExperiment& experiment) {
  const double remaining = std::sqrt(pipeline::merged_view_variance(kNoiseFrames));
  std::string text = fmt::format(
      "<p>Merging reduces the noise of the views to {:.3f} of one frame's, so an error that is proportional to pixel "
      "noise has a ratio of {:.2f}. A floor is the same in every burst: the matcher's own error for each tile's "
      "texture, and the sensor's fixed pattern. In the dimmest and the brightest light:</p>\n<ul>\n",
      remaining, 1 / remaining);
  for (const LightSweep& sweep : experiment.light) {
    if (sweep.prnu > 0) continue;
    const LightPoint &dim = sweep.points.front(), &bright = sweep.points.back();
    text += fmt::format(
        "<li>{}: ratio {:.2f} and {:.2f}, without outliers {:.2f} and {:.2f}; of the six frames' error {:.3f} and "
        "{:.3f} DP px change from burst to burst, {:.3f} and {:.3f} stay.</li>\n",
        sweep.matcher, dim.one.sigma / dim.six.sigma, bright.one.sigma / bright.six.sigma,
        dim.one.robust / dim.six.robust, bright.one.robust / bright.six.robust, dim.six.temporal, bright.six.temporal,
        dim.six.floor, bright.six.floor);
  }
  return text + "</ul>\n";
}

std::vector<Plot> light_plots(const std::vector<LightSweep>& sweeps) {
  std::vector<Plot> plots;
  for (const bool robust : {false, true}) {
    Plot& ratio = plots.emplace_back();
    ratio.title = robust ? "One frame over six, without outliers" : "One frame over six, outliers included";
    ratio.x_label = kLightLabel;
    ratio.y_label = "ratio of standard deviations";
    ratio.log_x = true;
    for (const LightSweep& sweep : sweeps) {
      ratio.series.push_back(over_light(
          fmt::format("{}{}", sweep.matcher, sweep.prnu > 0 ? ", fixed pattern" : ""), sweep,
          [&](const LightPoint& p) { return robust ? p.one.robust / p.six.robust : p.one.sigma / p.six.sigma; },
          sweep.prnu > 0));
    }
  }
  for (const LightSweep& sweep : sweeps) {
    Plot& plot = plots.emplace_back();
    plot.title = fmt::format("Standard deviation, matcher {}{}", sweep.matcher,
                             sweep.prnu > 0 ? fmt::format(", fixed pattern of {:g} %", 100 * sweep.prnu) : "");
    plot.x_label = kLightLabel;
    plot.y_label = "DP px";
    plot.log_x = plot.log_y = true;
    plot.series = {
        over_light("one frame", sweep, [](const LightPoint& p) { return p.one.sigma; }),
        over_light("six frames", sweep, [](const LightPoint& p) { return p.six.sigma; }),
        over_light(
            "six, without outliers", sweep, [](const LightPoint& p) { return p.six.robust; }, true),
        over_light(
            "six, varying from burst to burst", sweep, [](const LightPoint& p) { return p.six.temporal; }, true),
        over_light(
            "six, the same in every burst: floor", sweep, [](const LightPoint& p) { return p.six.floor; }, true)};
  }
  return plots;
}

/// Names of the matchers, in the order of their sweeps.
std::vector<std::string> matchers_of(const std::vector<DepthSweep>& sweeps) {
  std::vector<std::string> names;
  for (const DepthSweep& sweep : sweeps) {
    if (std::find(names.begin(), names.end(), sweep.matcher) == names.end()) names.push_back(sweep.matcher);
  }
  return names;
}

/// How many of the targets that lie at one lens's focus distance are measured best by that lens.
int best_in_focus(const std::vector<DepthSweep>& sweeps, const std::string& matcher) {
  int count = 0;
  for (const DepthSweep& sweep : sweeps) {
    if (sweep.matcher != matcher) continue;
    for (std::size_t i = 0; i < sweep.points.size(); ++i) {
      if (sweep.points[i].depth_m != sweep.focus_m) continue;
      count += std::all_of(sweeps.begin(), sweeps.end(), [&](const DepthSweep& other) {
        return other.matcher != matcher || other.points[i].depth_sigma_m >= sweep.points[i].depth_sigma_m;
      });
    }
  }
  return count;
}

/// Disparity and depth of one matcher.
std::pair<Plot, Plot> depth_plots(const std::vector<DepthSweep>& sweeps, const std::string& matcher) {
  Plot disparity, depth;
  disparity.title = "Disparity, matcher " + matcher;
  disparity.y_label = "DP px";
  depth.title = "Depth, matcher " + matcher;
  depth.y_label = "mm";
  depth.log_y = true;
  disparity.x_label = depth.x_label = "depth of the target, m";
  for (const DepthSweep& sweep : sweeps) {
    if (sweep.matcher != matcher) continue;
    Series of_disparity{fmt::format("focus {:g} m", sweep.focus_m), {}}, of_depth = of_disparity;
    for (const DepthPoint& p : sweep.points) {
      of_disparity.points.emplace_back(p.depth_m, p.sigma_dp_px);
      of_depth.points.emplace_back(p.depth_m, 1e3 * p.depth_sigma_m);
    }
    disparity.series.push_back(of_disparity);
    depth.series.push_back(of_depth);
  }
  return {disparity, depth};
}

}  // namespace

std::string to_page(const NoiseExperiment& experiment, const NoiseExperimentOptions& options) {
  std::string best;
  std::vector<Plot> over_depth;
  for (const std::string& matcher : matchers_of(experiment.depth)) {
    best += fmt::format("{}{} by {}", best.empty() ? "" : ", ", best_in_focus(experiment.depth, matcher), matcher);
    const auto [disparity, depth] = depth_plots(experiment.depth, matcher);
    over_depth.push_back(disparity);
    over_depth.push_back(depth);
  }
  const std::string title = "Noise of disparity";
  return html_page(
      title,
      fmt::format(
          "<h1>{}</h1>\n<p>A textured target at {:g} m, the lens focused at {:g} m, the central quarter of the field; "
          "the standard deviation over tiles of 8 x 8 DP pixels of a disparity that is the same everywhere. The paper "
          "(Wadhwa et al. 2018, supplement) finds that six merged frames are 2 times less noisy than one at 5 lux, and "
          "1.5 times in brighter light.</p>\n<h2>Over light</h2>",
          title, options.target_m, options.focus_m) +
          explanation(experiment) + html_plots(light_plots(experiment.light)) +
          fmt::format(
              "<h2>Over depth</h2><p>Six frames at {:g} lux, outliers included. The target's texture keeps its size in "
              "the picture. Depth's error is disparity's times D^2 over the slope. Of the {} targets at the focus "
              "distance of one of the lenses, that lens measures best: {}.</p>",
              options.depth_lux, options.focus_distances_m.size(), best) +
          html_plots(over_depth));
}

}  // namespace dualpixel::evaluation
