#include "scenes/drawn/parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "capture/error.h"
#include "capture/names.h"
#include "scenes/procedural/random_stream.h"

namespace dualpixel::scenes {
namespace {

/// FNV-1a: a stream of its own for each name.
std::uint64_t hash_of_name(const std::string& name) {
  std::uint64_t h = 0xcbf29ce484222325u;
  for (const char c : name) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return h;
}

bool whole(const Parameter& p) { return step_of(p) > 0; }

double draw_number(const Parameter& p, RandomStream rng) {
  const double t = rng.uniform();
  if (p.drawn_low == p.drawn_high) return p.drawn_low;
  if (whole(p)) return std::min(p.drawn_low + std::floor(t * (p.drawn_high - p.drawn_low + 1)), p.drawn_high);
  if (p.type == Parameter::Type::logarithmic) return p.drawn_low * std::pow(p.drawn_high / p.drawn_low, t);
  return p.drawn_low + t * (p.drawn_high - p.drawn_low);
}

double read_number(const std::string& kind, const Parameter& p, const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool read = error == std::errc() && end == text.data() + text.size();
  const bool fits = read && value >= p.low && value <= p.high && (!whole(p) || value == std::floor(value)) &&
                    (p.type != Parameter::Type::multiple_of_16 || std::fmod(value, 16) == 0);
  if (fits) return value;
  throw InputError(fmt::format("{}: {}: {}: must be {} in [{:g}, {:g}]{}", kind, p.name, printable(text),
                               p.type == Parameter::Type::multiple_of_16 ? "a multiple of 16"
                               : whole(p)                                ? "an integer"
                                                                         : "a number",
                               p.low, p.high, *p.unit != '\0' ? std::string(" ") + p.unit : ""));
}

std::vector<std::string> as_strings(const std::vector<const char*>& names) { return {names.begin(), names.end()}; }

}  // namespace

Parameters draw_parameters(const std::string& kind, std::span<const Parameter> table,
                           const std::vector<std::string>& assignments, std::uint64_t seed) {
  Parameters values;
  for (const Parameter& p : table) {
    RandomStream rng = RandomStream(seed, false).substream(hash_of_name(p.name));
    if (p.type == Parameter::Type::folder) {
      values.choices_[p.name] = "";
    } else if (p.choices.empty()) {
      values.numbers_[p.name] = draw_number(p, rng);
    } else {
      values.choices_[p.name] = p.usual != nullptr ? p.usual : p.choices[rng.below(static_cast<int>(p.choices.size()))];
    }
  }
  for (const std::string& assignment : assignments) {
    const std::size_t equals = assignment.find('=');
    const std::string name = assignment.substr(0, equals);
    if (equals == std::string::npos) {
      throw InputError(fmt::format("{}: --set {}: must read NAME=VALUE", kind, printable(assignment)));
    }
    const std::string text = assignment.substr(equals + 1);
    const auto row = std::find_if(table.begin(), table.end(), [&](const Parameter& p) { return name == p.name; });
    if (row == table.end()) {
      std::vector<std::string> names;
      for (const Parameter& p : table) names.emplace_back(p.name);
      throw InputError(fmt::format("{}: {}: unknown parameter{}; there are {}", kind, printable(name),
                                   did_you_mean(name, names), fmt::join(names, ", ")));
    }
    if (row->type == Parameter::Type::folder) {
      if (std::error_code ignored; !text.empty() && !std::filesystem::is_directory(text, ignored)) {
        throw InputError(fmt::format("{}: {}: {}: must be a folder", kind, name, printable(text)));
      }
      values.choices_[name] = text;
    } else if (row->choices.empty()) {
      values.numbers_[name] = read_number(kind, *row, text);
    } else if (std::find(row->choices.begin(), row->choices.end(), text) != row->choices.end()) {
      values.choices_[name] = text;
    } else {
      refuse_name(fmt::format("{}: {}", kind, name), text, as_strings(row->choices));
    }
  }
  return values;
}

int step_of(const Parameter& p) {
  if (p.type == Parameter::Type::multiple_of_16) return 16;
  return p.type == Parameter::Type::integer ? 1 : 0;
}

std::string allowed_text(const Parameter& p) {
  if (p.type == Parameter::Type::folder) return "a folder";
  if (!p.choices.empty()) return fmt::format("{}", fmt::join(p.choices, ", "));
  const char* const steps = step_of(p) == 16 ? ", by 16" : step_of(p) == 1 ? ", whole" : "";
  return fmt::format("{:g} .. {:g}{}", p.low, p.high, steps);
}

std::string drawn_text(const Parameter& p) {
  if (p.type == Parameter::Type::folder) return "none";
  if (!p.choices.empty()) return p.usual != nullptr ? p.usual : "drawn";
  if (p.drawn_low == p.drawn_high) return fmt::format("{:g}", p.drawn_low);
  return fmt::format("{:g} .. {:g}", p.drawn_low, p.drawn_high);
}

}  // namespace dualpixel::scenes
