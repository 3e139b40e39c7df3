#include "capture/option_ranges.h"

#include <fmt/format.h>

#include "capture/error.h"

namespace dualpixel {

std::optional<std::string> out_of_range(double value, double low, double high) {
  if (value >= low && value <= high) return std::nullopt;
  return fmt::format("{}: must be a number in [{:g}, {:g}]", value, low, high);
}

std::optional<std::string> out_of_range(int value, double low, double high) {
  if (value >= low && value <= high) return std::nullopt;
  return fmt::format("{}: must be an integer in [{}, {}]", value, static_cast<std::int64_t>(low),
                     static_cast<std::int64_t>(high));
}

std::optional<OptionProblem> within(const char* parent, std::optional<OptionProblem> problem) {
  if (problem) problem->field = fmt::format("{}/{}", parent, problem->field);
  return problem;
}

void require_valid(const std::optional<OptionProblem>& problem, const std::string& where) {
  if (problem) throw InputError(fmt::format("{}: /{}: {}", printable(where), problem->field, problem->message));
}

}  // namespace dualpixel
