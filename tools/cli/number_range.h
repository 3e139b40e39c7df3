#pragma once
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <string>

namespace dualpixel::tools {

/// CLI::Range of numbers, which by itself takes NaN for one within.
inline CLI::Validator number_range(double low, double high) {
  const CLI::Range range(low, high);
  const auto check = [range, low, high](std::string& text) {
    double value = 0;
    const bool nan = CLI::detail::lexical_cast(text, value) && std::isnan(value);
    return nan ? fmt::format("Value {} not in range {:g} to {:g}", text, low, high) : range(text);
  };
  return {check, range.get_description()};
}

}  // namespace dualpixel::tools
