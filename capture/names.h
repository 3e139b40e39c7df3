#pragma once
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

/// Lists of named values: one table each, used for reading, writing, help and refusals, so that they cannot disagree.
///
///     inline constexpr Named<Falloff> kFalloffs[] = {{"none", Falloff::none, "no falloff"},
///                                                    {"cos4", Falloff::cos4, "fourth power of the cosine"}};
///
/// A row may be a struct of its own, so long as it has `name`, `value` and `description`.
namespace dualpixel {

template <class Value>
struct Named {
  const char* name;
  Value value;
  const char* description;  ///< one line, for help and documentation
};

template <class Table>
std::vector<std::string> names_of(const Table& table) {
  std::vector<std::string> names;
  for (const auto& row : table) names.emplace_back(row.name);
  return names;
}

/// The row with this name, or nullptr.
template <class Table>
const auto* find_named(const Table& table, std::string_view name) {
  for (const auto& row : table) {
    if (name == row.name) return &row;
  }
  return static_cast<decltype(&*std::begin(table))>(nullptr);
}

/// The row of a value. Throws std::logic_error where the table lacks one: a value was added without its row.
template <class Table, class Value>
const auto& row_of(const Table& table, const Value& value) {
  for (const auto& row : table) {
    if (row.value == value) return row;
  }
  throw std::logic_error("a value has no row in its table of names");
}

template <class Table, class Value>
const char* name_of(const Table& table, const Value& value) {
  return row_of(table, value).name;
}

/// "must be one of 'hard', 'ramp'; did you mean 'ramp'?", for messages that refuse `name`.
std::string must_be_one_of(const std::vector<std::string>& names, const std::string& name);

/// Throws InputError "field: name: must be one of ...".
[[noreturn]] void refuse_name(const std::string& field, const std::string& name, const std::vector<std::string>& names);

/// The value with this name. Throws InputError as refuse_name().
template <class Table>
auto value_named(const Table& table, const std::string& name, const std::string& field) {
  const auto* row = find_named(table, name);
  if (!row) refuse_name(field, name, names_of(table));
  return row->value;
}

/// Reads a field of a JSON object (`Reader`: Fields) whose value is a name of the table; absent, `value` stays.
template <class Reader, class Table, class Value>
void read_named(Reader& fields, const std::string& key, Value& value, const Table& table) {
  if (!fields.has(key)) return;
  std::string name;
  fields.choice(key, name, names_of(table));
  value = find_named(table, name)->value;
}

}  // namespace dualpixel
