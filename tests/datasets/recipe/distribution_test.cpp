#include "datasets/recipe/distribution.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "capture/error.h"
#include "tests/temporary_folder.h"

namespace dualpixel::datasets {
namespace {

using nlohmann::json;

constexpr int kDraws = 20000;

Distribution read(const json& value) {
  const json object = {{"x", value}};
  Fields fields(object, "r.json");
  return read_distribution(fields, "x");
}

std::vector<double> draws(const json& value) {
  const Distribution d = read(value);
  std::vector<double> all;
  for (int k = 0; k < kDraws; ++k) {
    all.push_back(draw(d, Draws(7, static_cast<std::uint64_t>(k), "x"), 0).get<double>());
  }
  return all;
}

/// The largest difference between the share of draws below a value and `share` (Kolmogorov). It exceeds 1.95 / sqrt(n)
/// once in a thousand (Kolmogorov 1933: 2 exp(-2 * 1.95^2) = .001); the seed is fixed.
template <typename Share>
double largest_difference(std::vector<double> values, const Share& share) {
  std::sort(values.begin(), values.end());
  double largest = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double expected = share(values[i]), n = static_cast<double>(values.size());
    largest = std::max({largest, std::abs(static_cast<double>(i) / n - expected),
                        std::abs(static_cast<double>(i + 1) / n - expected)});
  }
  return largest;
}
const double kLargestByChance = 1.95 / std::sqrt(kDraws);

double normal_below(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

TEST(Distribution, DrawsWhatItsNameSays) {
  EXPECT_LT(largest_difference(draws({{"uniform", {-1, 3}}}), [](double x) { return (x + 1) / 4; }), kLargestByChance);
  EXPECT_LT(largest_difference(draws({{"log_uniform", {0.1, 10}}}), [](double x) { return (std::log10(x) + 1) / 2; }),
            kLargestByChance);
  // mean 2, deviation .5, cut at 1.5 and 4: -1 and 4 deviations
  const double low = normal_below(-1), high = normal_below(4);
  EXPECT_LT(largest_difference(draws({{"normal", {2, 0.5}}, {"bounds", {1.5, 4}}}),
                               [&](double x) { return (normal_below((x - 2) / 0.5) - low) / (high - low); }),
            kLargestByChance);
}

TEST(Distribution, DrawsAllOfANarrowRange) {
  EXPECT_LT(largest_difference(draws({{"uniform", {1000000, 1000004}}}), [](double x) { return (x - 1000000) / 4; }),
            kLargestByChance + 1e-4);
  EXPECT_LT(largest_difference(draws({{"normal", {1e6, 1}}, {"bounds", {0, 2e6}}}),
                               [](double x) { return normal_below(x - 1e6); }),
            kLargestByChance + 1e-4);
  for (const double x : draws({{"uniform", {0.9, 1.1}}})) ASSERT_EQ(x, std::stod(fmt::format("{:.6g}", x)));
}

TEST(Distribution, ChoosesByWeight) {
  std::map<double, int> counts;
  for (const double value : draws({{"choice", {1, 2, 3}}, {"weights", {1, 0, 3}}})) ++counts[value];
  EXPECT_EQ(counts.count(2), 0U);
  // five standard deviations of a binomial count
  EXPECT_NEAR(counts[1], 0.25 * kDraws, 5 * std::sqrt(0.25 * 0.75 * kDraws));
  counts.clear();
  for (const double value : draws({{"integer", {-1, 2}}})) ++counts[value];
  ASSERT_EQ(counts.size(), 4U);
  for (const auto& [value, count] : counts) EXPECT_NEAR(count, 0.25 * kDraws, 5 * std::sqrt(0.25 * 0.75 * kDraws));
}

TEST(Distribution, ConstantsAreAnyValue) {
  for (const json& value : {json(1), json("sky"), json::array({1, 2}), json(true)}) {
    EXPECT_EQ(draw(read(value), Draws(1, 1, "x"), 0), value);
  }
  EXPECT_EQ(draw(read({{"constant", {{"file", "a.json"}}}}), Draws(1, 1, "x"), 0), (json{{"file", "a.json"}}));
}

TEST(Distribution, OneFieldsDrawDoesNotHangOnAnothers) {
  EXPECT_NE(Draws(1, 2, "a").bits(), Draws(1, 2, "b").bits());
  EXPECT_NE(Draws(1, 2, "a").bits(), Draws(1, 3, "a").bits());
  EXPECT_NE(Draws(1, 2, "a").bits(), Draws(2, 2, "a").bits());
  EXPECT_EQ(Draws(1, 2, "a").bits(), Draws(1, 2, "a").bits());
}

TEST(Distribution, RefusesWithFieldAndWhatIsAllowed) {
  const std::map<std::string, json> cases = {
      {"r.json: /x: {\"unform\":[1,2]}: must be one of 'constant', 'choice', 'uniform', 'log_uniform', 'integer', "
       "'normal', 'grid'; did you mean 'uniform'?; an object as a value: {\"constant\": {...}}",
       {{"unform", {1, 2}}}},
      {"r.json: /x/uniform: [2, 1]: must be [low, high] in [-1e+15, 1e+15]", {{"uniform", {2, 1}}}},
      {"r.json: /x/log_uniform: [0, 1]: must be [low, high] in [1e-12, 1e+15]", {{"log_uniform", {0, 1}}}},
      {"r.json: /x/choice: []: must be a list of one value or more", {{"choice", json::array()}}},
      {"r.json: /x/weights: [0,0]: must be 2 numbers, not all 0: one for each value",
       {{"choice", {1, 2}}, {"weights", {0, 0}}}},
      {"r.json: /x/integer: [0.5, 2]: must be whole numbers", {{"integer", {0.5, 2}}}},
      {"r.json: /x/bounds: is required", {{"normal", {0, 1}}}},
      {"r.json: /x/bounds: [7, 8]: must reach within 6 deviations of the mean",
       {{"normal", {0, 1}}, {"bounds", {7, 8}}}},
      {"r.json: /x/step: unknown field; there are uniform", {{"uniform", {1, 2}}, {"step", 1}}},
  };
  for (const auto& [message, value] : cases) {
    EXPECT_EQ(message_of<InputError>([&value = value] { read(value); }), message);
  }
}

}  // namespace
}  // namespace dualpixel::datasets
