#pragma once
#include <string>
#include <utility>
#include <vector>

/// Line plots as inline SVG for our HTML pages: they take the page's colors, light or dark, and need no script.
namespace dualpixel::evaluation {

struct Series {
  std::string name;
  std::vector<std::pair<double, double>> points;  ///< in the order they are joined; not finite: a gap
  bool dashed = false;
  bool dots = false;                     ///< points alone, no line
  std::vector<std::string> labels = {};  ///< of dots, shown with their values under the pointer; empty: none
  bool write_labels = false;             ///< beside the dots, too
};

struct Plot {
  std::string title;
  std::string x_label, y_label;  ///< with units
  std::vector<Series> series;
  bool log_x = false, log_y = false;  ///< what is not above 0 is left out
  bool equal_scale = false;           ///< one unit is as long on both axes
  bool wide = false;                  ///< drawn large where it is the only one of its group
};

/// A `<figure>` with the plot and a legend. Text is escaped.
std::string svg_plot(const Plot& plot);

/// A group of plots, as many side by side as the page is wide.
std::string html_plots(const std::vector<Plot>& plots);

/// About `count` round numbers that cover low ... high.
std::vector<double> round_ticks(double low, double high, int count);

}  // namespace dualpixel::evaluation
