#include "datasets/recipe/distribution.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "capture/error.h"
#include "capture/names.h"

namespace dualpixel::datasets {
namespace {

using nlohmann::json;
using Kind = Distribution::Kind;

constexpr Named<Kind> kKinds[] = {{"constant", Kind::constant, "always this value"},
                                  {"choice", Kind::choice, "one of these values"},
                                  {"uniform", Kind::uniform, "between two numbers"},
                                  {"log_uniform", Kind::log_uniform, "between two numbers, equal chances per octave"},
                                  {"integer", Kind::integer, "a whole number between two, ends included"},
                                  {"normal", Kind::normal, "mean and deviation, between bounds"},
                                  {"grid", Kind::grid, "each of these values in turn"}};

constexpr std::size_t kMostWeights = 1'000'000;
constexpr double kLargest = 1e15;  // up to which doubles tell whole numbers apart

/// Two numbers, the first not above the second.
void read_pair(Fields& fields, const std::string& key, double& low, double& high, double least) {
  double pair[2] = {};
  fields.required(key).numbers(key, pair, 2);
  if (!(pair[0] >= least && pair[0] <= pair[1] && pair[1] <= kLargest)) {
    fields.fail(key,
                fmt::format("[{:g}, {:g}]: must be [low, high] in [{:g}, {:g}]", pair[0], pair[1], least, kLargest));
  }
  low = pair[0];
  high = pair[1];
}

void read_values(Fields& fields, const std::string& key, Distribution& d) {
  const json& list = fields.raw(key);
  if (!list.is_array() || list.empty()) {
    fields.fail(key, printable(list.dump()) + ": must be a list of one value or more");
  }
  d.values = list.get<std::vector<json>>();
}

void read_weights(Fields& fields, Distribution& d) {
  fields.list("weights", d.weights, 0, kLargest, kMostWeights);
  if (d.weights.empty()) d.weights.assign(d.values.size(), 1);
  const double sum = std::accumulate(d.weights.begin(), d.weights.end(), 0.0);
  if (d.weights.size() != d.values.size() || !(sum > 0)) {
    fields.fail("weights", fmt::format("{}: must be {} numbers, not all 0: one for each value",
                                       printable(fields.raw("weights").dump()), d.values.size()));
  }
}

void read_normal(Fields& fields, Distribution& d) {
  double pair[2] = {};
  fields.numbers("normal", pair, 2);
  d.mean = pair[0];
  d.deviation = pair[1];
  if (!(d.deviation > 0 && std::abs(d.mean) <= kLargest && d.deviation <= kLargest)) {
    fields.fail("normal",
                fmt::format("[{:g}, {:g}]: must be [mean, deviation], deviation above 0", d.mean, d.deviation));
  }
  read_pair(fields, "bounds", d.low, d.high, -kLargest);
  constexpr double kFarthest = 6;  // deviations; beyond it the tail is too thin to draw from
  if (d.low > d.mean + kFarthest * d.deviation || d.high < d.mean - kFarthest * d.deviation) {
    fields.fail("bounds",
                fmt::format("[{:g}, {:g}]: must reach within {} deviations of the mean", d.low, d.high, kFarthest));
  }
}

/// Share of a standard normal distribution below `x`.
double normal_share(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

/// Where the share below is `share`, by bisection.
double normal_quantile(double share, double low, double high) {
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (normal_share(middle) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double draw_normal(const Distribution& d, double u) {
  constexpr double kEnds = 8;
  const double low = std::clamp((d.low - d.mean) / d.deviation, -kEnds, kEnds);
  const double high = std::clamp((d.high - d.mean) / d.deviation, -kEnds, kEnds);
  const double share = normal_share(low) + u * (normal_share(high) - normal_share(low));
  return d.mean + d.deviation * normal_quantile(share, low, high);
}

/// Six digits, so that a plan is readable and does not depend on the last bits of a library's logarithm; more in a
/// range that is narrow beside its values, for steps of a 10 000th of `width` at most.
double few_digits(double value, double width, const Distribution& d) {
  constexpr int kFewest = 6, kMost = 17;
  const auto order = [](double x) { return static_cast<int>(std::floor(std::log10(std::abs(x)))); };
  const int digits = value != 0 && width > 0 ? std::clamp(order(value) - order(width) + 5, kFewest, kMost) : kFewest;
  return std::clamp(std::stod(fmt::format("{:.{}g}", value, digits)), d.low, d.high);
}

std::size_t weighted_index(const std::vector<double>& weights, double u) {
  double left = u * std::accumulate(weights.begin(), weights.end(), 0.0);
  for (std::size_t i = 0; i + 1 < weights.size(); ++i) {
    if (left < weights[i]) return i;
    left -= weights[i];
  }
  return weights.size() - 1;
}

Distribution read_object(Fields fields, Kind kind, const std::string& name) {
  Distribution d;
  d.kind = kind;
  switch (kind) {
    case Kind::constant:
      d.values = {fields.raw(name)};
      break;
    case Kind::choice:
      read_values(fields, name, d);
      read_weights(fields, d);
      break;
    case Kind::grid:
      read_values(fields, name, d);
      break;
    case Kind::log_uniform:
      read_pair(fields, name, d.low, d.high, 1e-12);
      break;
    case Kind::uniform:
      read_pair(fields, name, d.low, d.high, -kLargest);
      break;
    case Kind::integer:
      read_pair(fields, name, d.low, d.high, -kLargest);
      if (d.low != std::floor(d.low) || d.high != std::floor(d.high)) {
        fields.fail(name, fmt::format("[{:g}, {:g}]: must be whole numbers", d.low, d.high));
      }
      break;
    case Kind::normal:
      read_normal(fields, d);
      break;
  }
  fields.done();
  return d;
}

}  // namespace

Distribution read_distribution(Fields& fields, const std::string& key) {
  const json& value = fields.required(key).raw(key);
  if (!value.is_object()) return {.kind = Kind::constant, .values = {value}};
  const std::vector<std::string> names = names_of(kKinds);
  for (const auto& row : kKinds) {
    if (value.contains(row.name)) return read_object(fields.object(key), row.value, row.name);
  }
  const std::string first = value.empty() ? "" : value.begin().key();
  fields.fail(key, fmt::format("{}: {}; an object as a value: {{\"constant\": {{...}}}}", printable(value.dump()),
                               must_be_one_of(names, first)));
}

Distribution read_numbers(Fields& fields, const std::string& key, double low, double high) {
  Distribution d = read_distribution(fields, key);
  const auto fits = [&](const json& v) { return v.is_number() && v >= low && v <= high; };
  const bool listed = !d.values.empty();
  if (listed ? !std::all_of(d.values.begin(), d.values.end(), fits) : !(d.low >= low && d.high <= high)) {
    fields.fail(key, fmt::format("{}: must be numbers in [{:g}, {:g}]", printable(fields.raw(key).dump()), low, high));
  }
  return d;
}

json draw(const Distribution& d, Draws draws, std::size_t grid_position) {
  const double u = draws.uniform();
  switch (d.kind) {
    case Kind::constant:
      return d.values.front();
    case Kind::choice:
      return d.values[weighted_index(d.weights, u)];
    case Kind::grid:
      return d.values[grid_position];
    case Kind::uniform:
      return few_digits(d.low + u * (d.high - d.low), d.high - d.low, d);
    case Kind::log_uniform:
      return few_digits(d.low * std::pow(d.high / d.low, u), d.high - d.low, d);
    case Kind::integer:
      return static_cast<std::int64_t>(d.low + std::floor(u * (d.high - d.low + 1)));
    case Kind::normal:
      return few_digits(draw_normal(d, u), std::min(d.high - d.low, d.deviation), d);
  }
  return nullptr;
}

}  // namespace dualpixel::datasets
