#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// The fields of an options struct as data: for the command line's --set and --options, for a result's provenance, and
/// for the check that every stage makes. Each stage lists its own:
///     OptionFields fields(MatchOptions& options);   // pointers into `options`
///     void check(const MatchOptions& options);      // throws InputError
namespace dualpixel::pipeline {

struct OptionField {
  std::string name;  ///< "range_px", or with its group before it: "match.range_px"
  std::variant<int*, float*, double*> value;
  double low = 0, high = 0;  ///< what is allowed, both included
  std::string unit;          ///< "DP px", ...; empty for numbers without one
  std::string source;        ///< section of the paper (S: its supplement), or "ours"
};
using OptionFields = std::vector<OptionField>;

/// Throws InputError "GROUP.FIELD: VALUE: must be ..." for the first field that is out of its range or no number.
void check_fields(std::string_view group, const OptionFields& fields);

/// check_fields for `options`, whose fields(Options&) lists them.
template <typename Options>
void check_options(std::string_view group, const Options& options) {
  check_fields(group, fields(const_cast<Options&>(options)));  // they are only read
}

/// The fields of one group, each with "GROUP." before its name.
OptionFields grouped(const std::string& group, OptionFields fields);

/// What is allowed, as messages say it: "must be an integer in [1, 64]".
std::string allowed_text(const OptionField& field);

/// The field's value as the command line reads it.
std::string value_text(const OptionField& field);

/// Sets the field that `assignment` ("match.range_px=5") names. Throws InputError where there is no such field (with
/// the nearest name) or its value is not allowed.
void set_field(const OptionFields& fields, const std::string& assignment);

}  // namespace dualpixel::pipeline
