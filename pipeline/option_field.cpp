#include "pipeline/option_field.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "capture/error.h"

namespace dualpixel::pipeline {
namespace {

bool is_integer(const OptionField& field) { return std::holds_alternative<int*>(field.value); }

double number(const OptionField& field) {
  return std::visit([](const auto* value) { return static_cast<double>(*value); }, field.value);
}

bool allowed(const OptionField& field, double value) {
  if (std::holds_alternative<float*>(field.value)) {  // the limits rounded as the value is
    const auto rounded = static_cast<float>(value);
    return rounded >= static_cast<float>(field.low) && rounded <= static_cast<float>(field.high);
  }
  return value >= field.low && value <= field.high;
}

/// A number without anything after it.
std::optional<double> parsed(const OptionField& field, const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return {};
  if (is_integer(field) && value != std::floor(value)) return {};
  return value;
}

}  // namespace

void check_fields(std::string_view group, const OptionFields& fields) {
  for (const OptionField& field : fields) {
    if (allowed(field, number(field))) continue;
    throw InputError(fmt::format("{}{}{}: {}: {}", group, group.empty() ? "" : ".", field.name, value_text(field),
                                 allowed_text(field)));
  }
}

OptionFields grouped(const std::string& group, OptionFields fields) {
  for (OptionField& field : fields) field.name = group + "." + field.name;
  return fields;
}

std::string allowed_text(const OptionField& field) {
  return fmt::format("must be {} in [{:g}, {:g}]", is_integer(field) ? "an integer" : "a number", field.low,
                     field.high);
}

std::string value_text(const OptionField& field) {
  return std::visit([](const auto* value) { return fmt::format("{}", *value); }, field.value);
}

void set_field(const OptionFields& fields, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  const std::string name = assignment.substr(0, equals);
  if (equals == std::string::npos || name.empty()) {
    throw InputError(printable(assignment) + ": must read FIELD=VALUE");
  }
  const std::string text = assignment.substr(equals + 1);
  std::vector<std::string> names;
  for (const OptionField& field : fields) {
    names.push_back(field.name);
    if (field.name != name) continue;
    const std::optional<double> value = parsed(field, text);
    if (!value || !allowed(field, *value)) {
      throw InputError(fmt::format("{}: {}: {}", name, printable(text), allowed_text(field)));
    }
    std::visit([&](auto* target) { *target = static_cast<std::remove_pointer_t<decltype(target)>>(*value); },
               field.value);
    return;
  }
  throw InputError(fmt::format("{}: unknown option{}", printable(name), did_you_mean(name, names)));
}

}  // namespace dualpixel::pipeline
