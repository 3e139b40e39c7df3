#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>

#include "capture/json_fields.h"

/// Options and what they may be, in one place for scene files, the command line, library users and tests: each options
/// struct has a table of the ranges of its numbers, and a function check() for these and for whatever
/// depends on several fields.
namespace dualpixel {

/// Why options cannot be used.
struct OptionProblem {
  std::string field;    ///< as scene files name it, such as "sensor/width_px"
  std::string message;  ///< the value and what is allowed
};

/// A number's closed range.
template <class Options>
struct OptionRange {
  const char* name;  ///< in scene files
  std::variant<int Options::*, float Options::*, double Options::*> field;
  double low, high;
};

/// "value: must be a number in [low, high]", where it is not; the same words as Fields::number().
std::optional<std::string> out_of_range(double value, double low, double high);
/// "value: must be an integer in [low, high]", where it is not; the same words as Fields::integer().
std::optional<std::string> out_of_range(int value, double low, double high);

template <class Options, class Table>
std::optional<OptionProblem> check_ranges(const Options& options, const Table& table) {
  for (const auto& row : table) {
    const auto why = std::visit(
        [&](auto field) {
          if constexpr (std::is_same_v<decltype(field), int Options::*>) {
            return out_of_range(options.*field, row.low, row.high);
          } else {
            return out_of_range(static_cast<double>(options.*field), row.low, row.high);
          }
        },
        row.field);
    if (why) return OptionProblem{row.name, *why};
  }
  return std::nullopt;
}

/// Reads those fields of the table that the JSON object has.
template <class Options, class Table>
void read_ranges(Fields& fields, Options& options, const Table& table) {
  for (const auto& row : table) {
    std::visit(
        [&](auto field) {
          if constexpr (std::is_same_v<decltype(field), int Options::*>) {
            fields.integer(row.name, options.*field, static_cast<std::int64_t>(row.low),
                           static_cast<std::int64_t>(row.high));
          } else {
            fields.number(row.name, options.*field, row.low, row.high);
          }
        },
        row.field);
  }
}

/// The same problem of a struct that is the field `parent` of another one.
std::optional<OptionProblem> within(const char* parent, std::optional<OptionProblem> problem);

/// Throws InputError "where: /field: message" where there is a problem.
void require_valid(const std::optional<OptionProblem>& problem, const std::string& where);

}  // namespace dualpixel
