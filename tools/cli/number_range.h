#pragma once
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>

namespace dualpixel::tools {

/// CLI::Range of numbers, which by itself takes NaN for one within and shows six decimals.
inline CLI::Validator number_range(double low, double high) {
  const auto check = [low, high](std::string& text) {
    double value = 0;
    const bool within = CLI::detail::lexical_cast(text, value) && value >= low && value <= high;
    return within ? std::string() : fmt::format("Value {} not in range {:g} to {:g}", text, low, high);
  };
  return {check, fmt::format("FLOAT in [{:g} - {:g}]", low, high)};
}

}  // namespace dualpixel::tools
