#include "evaluation/report/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "evaluation/report/page.h"

namespace dualpixel::evaluation {
namespace {

constexpr double kPlotWidth = 480, kPlotHeight = 300, kLeft = 62, kRight = 14, kTop = 12, kBottom = 46;

struct Axis {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  bool log = false;
  double of(double value) const { return log ? std::log10(value) : value; }
  bool shows(double value) const { return std::isfinite(value) && (!log || value > 0); }
  void include(double value) {
    low = std::min(low, of(value));
    high = std::max(high, of(value));
  }
  void widen() {
    if (!(low <= high)) low = 0, high = 1;
    if (!log && low == 0 && high == 0) high = 1;
    // what differs by rounding alone is drawn flat, and its ticks differ in the four digits that they have
    const double least = std::max(0.02 * std::max(std::abs(low), std::abs(high)), 1e-9);
    const double span = high - low;
    const double margin = span > least ? 0.04 * span : log ? 0.5 : least;
    low -= margin;
    high += margin;
  }
  /// Values with a tick, and what is written there.
  std::vector<double> ticks() const {
    if (!log) return round_ticks(low, high, 6);
    // decades where there are some, else round numbers
    for (const std::vector<double>& steps : {std::vector{1.0}, {1.0, 2.0, 5.0}}) {
      std::vector<double> result;
      for (int decade = static_cast<int>(std::floor(low)); decade <= high; ++decade) {
        for (double step : steps) {
          const double value = step * std::pow(10, decade);
          if (std::log10(value) >= low && std::log10(value) <= high) result.push_back(value);
        }
      }
      if (result.size() >= 2) return result;
    }
    return round_ticks(std::pow(10, low), std::pow(10, high), 4);
  }
};

/// What the browser shows under the pointer.
std::string dot_title(const Series& series, std::size_t k) {
  const auto [x, y] = series.points[k];
  const std::string label = k < series.labels.size() ? series.labels[k] + ": " : "";
  return fmt::format("<title>{}{:.4g}, {:.4g}</title>", escape_html(label), x, y);
}

/// To the right of a dot; to the left of one in the right half, so that it stays inside.
std::string dot_label(const std::string& label, double x, double y) {
  const bool right = x < kLeft + (kPlotWidth - kLeft - kRight) / 2;
  return fmt::format("<text class=\"label\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>",
                     right ? x + 6 : x - 6, y - 4, right ? "start" : "end", escape_html(label));
}

}  // namespace

std::vector<double> round_ticks(double low, double high, int count) {
  const double raw = (high - low) / std::max(count, 1);
  if (!(raw > 0) || !std::isfinite(raw)) return {low};
  const double power = std::pow(10, std::floor(std::log10(raw)));
  const double step = power * (raw / power < 1.5 ? 1 : raw / power < 3.5 ? 2 : raw / power < 7.5 ? 5 : 10);
  std::vector<double> ticks;
  for (double i = std::ceil(low / step); i * step <= high + 1e-9 * step; ++i) ticks.push_back(i == 0 ? 0.0 : i * step);
  return ticks;
}

std::string svg_plot(const Plot& plot) {
  Axis x, y;
  x.log = plot.log_x;
  y.log = plot.log_y;
  const auto shown = [&](const std::pair<double, double>& p) { return x.shows(p.first) && y.shows(p.second); };
  for (const Series& series : plot.series) {
    for (const auto& point : series.points) {
      if (!shown(point)) continue;
      x.include(point.first);
      y.include(point.second);
    }
  }
  x.widen();
  y.widen();
  const double wide = kPlotWidth - kLeft - kRight, high = kPlotHeight - kTop - kBottom;
  if (plot.equal_scale) {
    const double unit = std::max((x.high - x.low) / wide, (y.high - y.low) / high);
    const double more_x = unit * wide - (x.high - x.low), more_y = unit * high - (y.high - y.low);
    x.low -= more_x / 2, x.high += more_x / 2, y.low -= more_y / 2, y.high += more_y / 2;
  }
  const auto at_x = [&](double value) { return kLeft + wide * (x.of(value) - x.low) / (x.high - x.low); };
  const auto at_y = [&](double value) { return kTop + high * (y.high - y.of(value)) / (y.high - y.low); };

  std::string svg = fmt::format("<figure class=\"plot\"><svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">",
                                kPlotWidth, kPlotHeight, escape_html(plot.title));
  for (double tick : x.ticks()) {
    svg += fmt::format(
        "<line class=\"grid\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\"/>"
        "<text x=\"{0:.1f}\" y=\"{3}\" text-anchor=\"middle\">{4:.4g}</text>",
        at_x(tick), kTop, kTop + high, kTop + high + 16, tick);
  }
  for (double tick : y.ticks()) {
    svg += fmt::format(
        "<line class=\"grid\" x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\"/>"
        "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:.4g}</text>",
        kLeft, kLeft + wide, at_y(tick), kLeft - 6, at_y(tick) + 4, tick);
  }
  svg += fmt::format("<rect class=\"frame\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>", kLeft, kTop, wide, high);
  svg += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>", kLeft + wide / 2, kPlotHeight - 8,
                     escape_html(plot.x_label));
  svg += fmt::format("<text transform=\"translate(13 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
                     kTop + high / 2, escape_html(plot.y_label));
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const Series& series = plot.series[i];
    std::string points;
    const auto end_line = [&] {
      if (!points.empty()) {
        svg += fmt::format("<polyline class=\"c{}{}\" points=\"{}\"/>", i % kSeriesColors,
                           series.dashed ? " dashed" : "", points);
      }
      points.clear();
    };
    for (std::size_t k = 0; k < series.points.size(); ++k) {
      const auto& point = series.points[k];
      if (!shown(point)) {
        end_line();
      } else if (series.dots) {
        const double dot_x = at_x(point.first), dot_y = at_y(point.second);
        svg += fmt::format("<circle class=\"c{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\">{}</circle>", i % kSeriesColors,
                           dot_x, dot_y, dot_title(series, k));
        if (series.write_labels && k < series.labels.size()) svg += dot_label(series.labels[k], dot_x, dot_y);
      } else {
        points += fmt::format("{:.1f},{:.1f} ", at_x(point.first), at_y(point.second));
      }
    }
    end_line();
  }
  svg += "</svg><figcaption><b>" + escape_html(plot.title) + "</b>";
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    if (plot.series[i].name.empty()) continue;
    svg += fmt::format(
        " <span class=\"name\"><svg class=\"legend\" viewBox=\"0 0 22 9\"><line class=\"key c{}{}\" x1=\"0\" x2=\"22\" "
        "y1=\"5\" y2=\"5\" stroke-width=\"3\"/></svg> {}</span>",
        i % kSeriesColors, plot.series[i].dashed ? " dashed" : "", escape_html(plot.series[i].name));
  }
  return svg + "</figcaption></figure>\n";
}

std::string html_plots(const std::vector<Plot>& plots) {
  std::string html = plots.size() == 1 && plots[0].wide ? "<div class=\"plots wide-plot\">" : "<div class=\"plots\">";
  for (const Plot& plot : plots) html += svg_plot(plot);
  return html + "</div>\n";
}

}  // namespace dualpixel::evaluation
