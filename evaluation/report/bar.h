#pragma once
#include <string>
#include <utility>
#include <vector>

/// A whole and its parts as one bar, inline SVG for our HTML pages.
namespace dualpixel::evaluation {

struct Bar {
  std::string title;
  std::string unit;
  std::vector<std::pair<std::string, double>> parts;  ///< from left to right
};

/// A `<figure>` with the bar, and each part's name, value and share of the sum. What is below 0 or not finite is in the
/// legend alone. Text is escaped.
std::string svg_bar(const Bar& bar);

}  // namespace dualpixel::evaluation
