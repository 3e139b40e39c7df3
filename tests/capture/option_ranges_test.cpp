#include "capture/option_ranges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "tests/temporary_folder.h"

namespace dualpixel {
namespace {

struct Options {
  int count = 3;
  float share = 0.5f;
  double length_m = 2;
};

constexpr OptionRange<Options> kRanges[] = {
    {"count", &Options::count, 1, 8},
    {"share", &Options::share, 0, 1},
    {"length_m", &Options::length_m, -1e3, 1e3},
};

std::string problem_of(const Options& options) {
  const auto problem = check_ranges(options, kRanges);
  return problem ? problem->field + ": " + problem->message : "fine";
}

TEST(OptionRanges, BothEndsAreAllowedAndNothingBeyond) {
  EXPECT_EQ(problem_of({}), "fine");
  EXPECT_EQ(problem_of({1, 0, -1e3}), "fine");
  EXPECT_EQ(problem_of({8, 1, 1e3}), "fine");
  EXPECT_EQ(problem_of({0}), "count: 0: must be an integer in [1, 8]");
  EXPECT_EQ(problem_of({9}), "count: 9: must be an integer in [1, 8]");
  EXPECT_EQ(problem_of({1, 1.25f}), "share: 1.25: must be a number in [0, 1]");
  EXPECT_EQ(problem_of({1, 0, 1000.5}), "length_m: 1000.5: must be a number in [-1000, 1000]");
}

TEST(OptionRanges, NoNumberIsInNoRange) {
  EXPECT_EQ(problem_of({1, std::nanf("")}), "share: nan: must be a number in [0, 1]");
  EXPECT_EQ(problem_of({1, 0, INFINITY}), "length_m: inf: must be a number in [-1000, 1000]");
}

TEST(OptionRanges, ReadsWhatIsThereAndLeavesTheRest) {
  const nlohmann::json json = {{"count", 7}, {"length_m", -2.5}};
  Fields fields(json, "a.json", "/options");
  Options options;
  read_ranges(fields, options, kRanges);
  fields.done();
  EXPECT_EQ(options.count, 7);
  EXPECT_EQ(options.share, 0.5f);
  EXPECT_EQ(options.length_m, -2.5);
}

TEST(OptionRanges, AWholeNumberMustBeOneInAFileToo) {
  const nlohmann::json json = {{"count", 2.5}};
  Options options;
  const std::string refusal = message_of<InputError>([&] {
    Fields fields(json, "a.json", "/options");
    read_ranges(fields, options, kRanges);
  });
  EXPECT_TRUE(refusal.starts_with("a.json: /options/count: 2.5: ")) << refusal;
  EXPECT_EQ(options.count, 3);
}

TEST(OptionRanges, AProblemNamesItsWay) {
  const auto problem = within("scene", within("options", check_ranges(Options{0}, kRanges)));
  EXPECT_EQ(message_of<InputError>([&] { require_valid(problem, "a.json"); }),
            "a.json: /scene/options/count: 0: must be an integer in [1, 8]");
  EXPECT_FALSE(within("options", std::nullopt));
  require_valid(std::nullopt, "a.json");
}

}  // namespace
}  // namespace dualpixel
