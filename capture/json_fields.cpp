#include "capture/json_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "capture/error.h"
#include "capture/files.h"

namespace dualpixel {
namespace {

using nlohmann::json;

constexpr std::size_t kLargestJsonBytes = 64 << 20;
constexpr int kDeepestNesting = 256;  // far beyond any file of ours, far below what exhausts the stack on copying
constexpr std::size_t kLongestOverridePath = 32;

const json kEmptyObject = json::object();
const json kNull;

std::string dump(const json& value) { return printable(value.dump(-1, ' ', false, json::error_handler_t::replace)); }

/// A key as one step of a JSON pointer (RFC 6901).
std::string pointer_step(const std::string& key) {
  std::string step = "/";
  for (const char c : key) {
    if (c == '~') {
      step += "~0";
    } else if (c == '/') {
      step += "~1";
    } else {
      step += c;
    }
  }
  return step;
}

std::string range_text(double low, double high) { return fmt::format("must be a number in [{:g}, {:g}]", low, high); }

/// The number that a field holds, or NaN.
double as_number(const json& value) {
  if (value.is_number()) return value.get<double>();
  if (value == "inf") return std::numeric_limits<double>::infinity();
  return std::numeric_limits<double>::quiet_NaN();
}

/// A first pass over the text that refuses what a tree of values would not survive or not show: deep nesting and fields
/// given twice. (The library's own callback for this takes time quadratic in the length of arrays.) A syntax error just
/// ends it: the parse that follows reports it.
class StructureCheck : public nlohmann::json_sax<json> {
 public:
  explicit StructureCheck(const std::string& file) : file_(file) {}

  bool start_object(std::size_t) override {
    keys_by_level_.emplace_back();
    return enter();
  }
  bool end_object() override {
    keys_by_level_.pop_back();
    return leave();
  }
  bool start_array(std::size_t) override { return enter(); }
  bool end_array() override { return leave(); }
  bool key(std::string& name) override {
    if (!keys_by_level_.back().insert(name).second) {
      throw InputError(fmt::format("{}: field {} is given twice", printable(file_), dump(json(name))));
    }
    return true;
  }
  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(json::number_integer_t) override { return true; }
  bool number_unsigned(json::number_unsigned_t) override { return true; }
  bool number_float(json::number_float_t, const std::string&) override { return true; }
  bool string(std::string&) override { return true; }
  bool binary(json::binary_t&) override { return true; }
  bool parse_error(std::size_t byte, const std::string&, const nlohmann::detail::exception&) override {
    fault_byte_ = byte;
    return false;
  }
  /// Where the text ceases to be JSON, from 1 on; 0 where it does not.
  std::size_t fault_byte() const { return fault_byte_; }

 private:
  bool enter() {
    if (++depth_ > kDeepestNesting) {
      throw InputError(fmt::format("{}: nested deeper than {} levels", printable(file_), kDeepestNesting));
    }
    return true;
  }
  bool leave() {
    --depth_;
    return true;
  }

  const std::string& file_;
  int depth_ = 0;
  std::size_t fault_byte_ = 0;
  std::vector<std::set<std::string>> keys_by_level_;  // of the objects that are open
};

}  // namespace

json parse_json(const std::string& text, const std::string& file) {
  if (text.size() > kLargestJsonBytes) throw InputError(printable(file) + ": JSON of more than 64 MB is refused");
  StructureCheck check(file);
  try {
    json::sax_parse(text, &check);
    return json::parse(text);
  } catch (const json::out_of_range& error) {  // says the number alone
    const auto at = text.begin() + static_cast<std::ptrdiff_t>(std::min(check.fault_byte(), text.size()));
    const bool has_lines = text.find('\n') != std::string::npos;
    const std::string line = has_lines ? fmt::format("line {}: ", 1 + std::count(text.begin(), at, '\n')) : "";
    throw InputError(fmt::format("{}: {}a number is too large", printable(file), line));
  } catch (const json::exception& error) {
    // "[json.exception.parse_error.101] parse error at line 1, column 2: ..." starts with the library's own tag.
    const std::string message = error.what();
    const std::size_t tag_end = message.find("] ");
    throw InputError(printable(file) + ": " +
                     printable(tag_end == std::string::npos ? message : message.substr(tag_end + 2)));
  }
}

json read_json_file(const std::string& path) {
  const std::string text = read_file(path, kLargestJsonBytes);
  if (text.starts_with("glTF")) {
    throw InputError(printable(path) + ": is binary glTF; give a JSON file, such as a scene file that names it");
  }
  return parse_json(text, path);
}

void apply_override(json& root, const std::string& assignment) {
  const auto refuse = [&](const std::string& why) -> void {
    throw InputError(fmt::format("--set {}: {}", printable(assignment), why));
  };
  try {
    (void)json(assignment).dump();
  } catch (const json::exception&) {
    refuse("must be UTF-8");
  }
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos) refuse("must look like camera.focus_distance_m=0.9");
  const std::string text = assignment.substr(equals + 1);

  std::vector<std::string> path;
  for (std::size_t begin = 0; begin <= equals;) {
    const std::size_t end = std::min(assignment.find('.', begin), equals);
    if (end == begin) refuse("the name of a field is empty");
    path.push_back(assignment.substr(begin, end - begin));
    begin = end + 1;
  }
  if (path.size() > kLongestOverridePath) refuse(fmt::format("more than {} names", kLongestOverridePath));

  json *target = &root, *parent = nullptr;
  for (const std::string& name : path) {
    parent = target;
    if (target->is_array()) {
      const bool digits = name.size() <= 9 && name.find_first_not_of("0123456789") == std::string::npos;
      if (!digits || std::stoul(name) >= target->size()) {
        refuse(fmt::format("'{}' must be an index below {}", printable(name), target->size()));
      }
      target = &(*target)[std::stoul(name)];
    } else {
      if (target->is_null()) *target = json::object();
      if (!target->is_object()) refuse(fmt::format("'{}' would be inside a value that is no object", printable(name)));
      target = &(*target)[name];
    }
  }
  *target = json::accept(text) ? parse_json(text, "--set " + assignment) : json(text);
  if (target->is_null() && parent->is_object()) parent->erase(path.back());
}

Fields::Fields(const json& object, std::string file, std::string pointer)
    : object_(object), file_(std::move(file)), pointer_(std::move(pointer)) {
  if (!object_.is_object()) {
    throw InputError(fmt::format("{}: {}{}must be an object", printable(file_), printable(pointer_),
                                 pointer_.empty() ? "" : ": " + dump(object_) + ": "));
  }
}

const json* Fields::find(const std::string& key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.push_back(key);
  const auto found = object_.find(key);
  return found == object_.end() ? nullptr : &*found;
}

bool Fields::has(const std::string& key) { return find(key) != nullptr; }

Fields& Fields::required(const std::string& key) {
  if (!find(key)) {
    // A misspelt name is both missing and unknown: say which one it probably is.
    for (const auto& [present, value] : object_.items()) {
      if (!did_you_mean(present, {key}).empty() && std::find(known_.begin(), known_.end(), present) == known_.end()) {
        fail(present, "unknown field" + did_you_mean(present, {key}));
      }
    }
    fail(key, "is required");
  }
  return *this;
}

Fields& Fields::number(const std::string& key, double& value, double low, double high) {
  if (const json* found = find(key)) {
    const double number = as_number(*found);
    if (!(number >= low && number <= high)) fail(key, dump(*found) + ": " + range_text(low, high));
    value = number;
  }
  return *this;
}

Fields& Fields::number(const std::string& key, float& value, double low, double high) {
  double wide = value;
  number(key, wide, low, high);
  if (has(key)) {
    value = static_cast<float>(wide);
    if (std::isinf(value) && std::isfinite(wide)) fail(key, fmt::format("{:g}: beyond single precision", wide));
  }
  return *this;
}

Fields& Fields::integer(const std::string& key, int& value, std::int64_t low, std::int64_t high) {
  if (const json* found = find(key)) {
    // A number past 2^63 is stored as unsigned; read as signed it would wrap around.
    const bool too_large = found->is_number_unsigned() &&
                           found->get<std::uint64_t>() > std::uint64_t{std::numeric_limits<std::int64_t>::max()};
    if (!found->is_number_integer() || too_large || found->get<std::int64_t>() < low ||
        found->get<std::int64_t>() > high) {
      fail(key, fmt::format("{}: must be an integer in [{}, {}]", dump(*found), low, high));
    }
    value = static_cast<int>(found->get<std::int64_t>());
  }
  return *this;
}

Fields& Fields::integer(const std::string& key, std::uint64_t& value, std::uint64_t low, std::uint64_t high) {
  if (const json* found = find(key)) {
    const bool natural = found->is_number_unsigned() || (found->is_number_integer() && found->get<std::int64_t>() >= 0);
    if (!natural || found->get<std::uint64_t>() < low || found->get<std::uint64_t>() > high) {
      fail(key, fmt::format("{}: must be an integer in [{}, {}]", dump(*found), low, high));
    }
    value = found->get<std::uint64_t>();
  }
  return *this;
}

Fields& Fields::boolean(const std::string& key, bool& value) {
  if (const json* found = find(key)) {
    if (!found->is_boolean()) fail(key, dump(*found) + ": must be true or false");
    value = found->get<bool>();
  }
  return *this;
}

Fields& Fields::text(const std::string& key, std::string& value) {
  if (const json* found = find(key)) {
    if (!found->is_string()) fail(key, dump(*found) + ": must be a string");
    value = found->get<std::string>();
  }
  return *this;
}

Fields& Fields::choice(const std::string& key, std::string& value, const std::vector<std::string>& allowed) {
  if (const json* found = find(key)) {
    if (!found->is_string() || std::find(allowed.begin(), allowed.end(), found->get<std::string>()) == allowed.end()) {
      fail(key, fmt::format("{}: must be one of '{}'{}", dump(*found), fmt::join(allowed, "', '"),
                            found->is_string() ? did_you_mean(found->get<std::string>(), allowed) : ""));
    }
    value = found->get<std::string>();
  }
  return *this;
}

Fields& Fields::numbers(const std::string& key, double* values, std::size_t count) {
  if (const json* found = find(key)) {
    if (!found->is_array() || found->size() != count || !std::all_of(found->begin(), found->end(), [](const json& v) {
          return v.is_number() && std::isfinite(v.get<double>());
        })) {
      fail(key, fmt::format("{}: must be {} finite numbers", dump(*found), count));
    }
    for (std::size_t i = 0; i < count; ++i) values[i] = (*found)[i].get<double>();
  }
  return *this;
}

Fields& Fields::list(const std::string& key, std::vector<double>& values, double low, double high, std::size_t most) {
  if (const json* found = find(key)) {
    if (!found->is_array() || found->size() > most || !std::all_of(found->begin(), found->end(), [&](const json& v) {
          return v.is_number() && v.get<double>() >= low && v.get<double>() <= high;
        })) {
      fail(key, fmt::format("{}: must be up to {} numbers in [{:g}, {:g}]", dump(*found), most, low, high));
    }
    values = found->get<std::vector<double>>();
  }
  return *this;
}

Fields& Fields::laid_over(const json& own, std::string file, std::string pointer) {
  if (!own.is_object()) return *this;
  own_ = &own;
  own_file_ = std::move(file);
  own_pointer_ = std::move(pointer);
  return *this;
}

std::vector<Fields> Fields::objects(const std::string& key) {
  std::vector<Fields> result;
  if (const json* found = find(key)) {
    if (!found->is_array()) fail(key, dump(*found) + ": must be an array of objects");
    for (std::size_t i = 0; i < found->size(); ++i) {
      result.emplace_back((*found)[i], file_, fmt::format("{}{}/{}", pointer_, pointer_step(key), i));
    }
  }
  return result;
}

Fields Fields::object(const std::string& key) {
  const json* found = find(key);
  const json* own = own_ && own_->contains(key) ? &(*own_)[key] : nullptr;
  if (own && found && *own == *found) return {*found, own_file_, own_pointer_ + pointer_step(key)};
  Fields fields(found ? *found : kEmptyObject, file_, pointer_ + pointer_step(key));
  if (own) fields.laid_over(*own, own_file_, own_pointer_ + pointer_step(key));
  return fields;
}

const json& Fields::raw(const std::string& key) {
  const json* found = find(key);
  return found ? *found : kNull;
}

void Fields::done() {
  for (const auto& [key, value] : object_.items()) {
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    std::string known = did_you_mean(key, known_);
    if (known.empty() && !known_.empty()) known = fmt::format("; there are {}", fmt::join(known_, ", "));
    fail(key, "unknown field" + known);
  }
}

void Fields::fail(const std::string& key, const std::string& message) const {
  const bool own = own_ && own_->contains(key);
  throw InputError(fmt::format("{}: {}: {}", printable(own ? own_file_ : file_),
                               printable((own ? own_pointer_ : pointer_) + pointer_step(key)), message));
}

}  // namespace dualpixel
