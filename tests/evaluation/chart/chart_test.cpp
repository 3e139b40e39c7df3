#include "evaluation/chart/chart.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "capture/error.h"

namespace dualpixel::evaluation {
namespace {

Chart small_chart() {
  Chart chart{true, "0.1", "Embree 0", "a machine", {}, {"nothing"}, true};
  chart.sections = {
      {"Matchers",
       "on a pair",
       "DP px",
       "ms",
       {{"slow", {0.1, 0.01}, {100, 1.0}}, {"fast", {0.3, 0.01}, {10, 0.1}, true}, {"neither", {0.31, 0.01}, {101}}}}};
  chart.sections[0].points[0].memory_mb = 12;
  chart.sections[0].points.push_back({"ideal", {0.01}, {1}, false, {}, true});
  chart.sections[0].default_reason = "it is fast.";
  chart.sections[0].seeds = {1, 2};
  chart.bars = {{"Time", "of one run", "ms", {{"merge", 30}, {"blur", 10}, {"gain", -5}}}};
  chart.growths = {{"Growth", "of a wall", "triangles", "ns", {{"a ray", {{1e4, 100}, {1e6, 300}}}}}};
  return chart;
}

TEST(Chart, FrontHoldsWhatNothingBeatsInBoth) {
  // the bound, which is better than all of them, is no setting
  EXPECT_EQ(pareto_front(small_chart().sections[0].points), (std::vector{true, true, false, false}));
  // of two alike, neither beats the other; equal error at less time does
  EXPECT_EQ(pareto_front({{"a", {1}, {1}}, {"b", {1}, {1}}, {"c", {1}, {2}}}), (std::vector{true, true, false}));
}

TEST(Chart, MeanHasTheStandardErrorOfTheMean) {
  const Measured mean = mean_of({1, 2, 3, 4});
  EXPECT_EQ(mean.value, 2.5);
  EXPECT_NEAR(*mean.standard_error, std::sqrt(5.0 / 3 / 4), 1e-12);  // variance 5/3 of four values, of their mean
  EXPECT_FALSE(mean_of({7}).standard_error);
}

TEST(Chart, IsReadAsItWasWritten) {
  const nlohmann::json json = to_json(small_chart());
  EXPECT_EQ(nlohmann::json(to_json(read_chart(json, "x"))), json);
  EXPECT_EQ(json["sections"][0]["points"][3]["bound"], true);
  EXPECT_EQ(json["sections"][0]["default_reason"], "it is fast.");
  EXPECT_THROW(read_chart({{"format", "other"}}, "x"), InputError);
  EXPECT_THROW(read_chart(nlohmann::json::array(), "x"), InputError);
}

TEST(Chart, StepsLeadAlongTheFront) {
  const std::vector<FrontStep> steps = front_steps(small_chart().sections[0].points);
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].from, "fast");
  EXPECT_EQ(steps[0].to, "slow");
  EXPECT_EQ(steps[0].more_time, 90);
  EXPECT_NEAR(steps[0].less_error, 0.2, 1e-12);
}

TEST(Chart, KnowsWhichStagesItHas) {
  Chart chart;
  add(chart, {.sections = {}, .bars = small_chart().bars}, "pipeline");
  add(chart, {.sections = {}, .growths = small_chart().growths}, "growth");
  EXPECT_TRUE(has_stage(chart, "pipeline") && has_stage(chart, "growth"));
  EXPECT_FALSE(has_stage(chart, "solver"));
}

// Widths are shares of what is drawn, 40 of 40; what is below 0 is not drawn, and counts in the sum.
TEST(Chart, BarsShowTheirParts) {
  const std::string page = to_page(small_chart());
  EXPECT_NE(page.find("x=\"0.0\" y=\"2\" width=\"674.0\""), std::string::npos);
  EXPECT_NE(page.find("x=\"675.0\" y=\"2\" width=\"224.0\""), std::string::npos);
  EXPECT_NE(page.find("merge 30 ms (86 %)"), std::string::npos);
  EXPECT_NE(page.find("gain -5 ms (-14 %)"), std::string::npos);
  EXPECT_NE(page.find("<td>12</td>"), std::string::npos);
  EXPECT_NE(page.find("<h2>What more time buys: Matchers</h2>"), std::string::npos);
  EXPECT_NE(page.find("Default: it is fast."), std::string::npos);
}

TEST(Chart, SaysWhereItIsNotComplete) {
  Chart chart = small_chart();
  EXPECT_EQ(to_page(chart).find("Not all of it is measured yet"), std::string::npos);
  chart.complete = false;
  EXPECT_NE(to_page(chart).find("Not all of it is measured yet"), std::string::npos);
}

TEST(Chart, GrowthHasItsPlot) {
  const std::string page = to_page(small_chart());
  EXPECT_NE(page.find("<h2>Growth</h2>"), std::string::npos);
  for (const char* label : {">triangles</text>", ">ns</text>", "a ray"}) EXPECT_NE(page.find(label), std::string::npos);
}

TEST(Chart, PointsTellNamesAndValues) {
  const std::string page = to_page(small_chart());
  EXPECT_NE(page.find("<title>neither: 101, 0.31</title>"), std::string::npos);
  EXPECT_NE(page.find("<title>ideal: 1, 0.01</title>"), std::string::npos);
  EXPECT_EQ(page.find(">neither</text>"), std::string::npos);
  EXPECT_NE(page.find(">fast</text>"), std::string::npos);
}

TEST(Chart, OfAnotherReleaseIsTold) {
  nlohmann::json json = to_json(small_chart());
  EXPECT_FALSE(is_of_other_version(json));
  json["version"] = 1;
  EXPECT_TRUE(is_of_other_version(json));
  EXPECT_THROW(read_chart(json, "x"), InputError);
  for (const nlohmann::json& other : {nlohmann::json::array(), nlohmann::json{{"version", 1}}}) {
    EXPECT_FALSE(is_of_other_version(other));
  }
}

TEST(Chart, ComparisonPassesOverNoise) {
  const Chart before = small_chart();
  Chart now = before;
  EXPECT_EQ(to_text(compare(before, now)), "nothing changed by more than noise\n");
  std::vector<ChartPoint>& points = now.sections[0].points;
  points[0].error.value += 0.04;  // under three of the difference's sqrt(2) * 0.01
  points[1].time.value += 0.9;    // over three standard errors, but under 10 %
  EXPECT_TRUE(compare(before, now).changes.empty());
  points[0].error.value = 0.15;
  points[1].time.value = 12;
  points[2].time.value = 50;
  points.push_back({"new", {1}, {1}});
  const ChartComparison since = compare(before, now);
  EXPECT_EQ(to_text(since),
            "worse  Matchers, slow: error 0.15, was 0.1 (+50.0 %)\n"
            "worse  Matchers, fast: time 12, was 10 (+20.0 %)\n"
            "better Matchers, neither: time 50, was 101 (-50.5 %)\n"
            "new    Matchers, new\n");
  const std::string page = to_page(now, since);
  EXPECT_NE(page.find("<td>Matchers, fast</td><td>time, worse</td><td>10</td><td>12</td><td>20.0</td>"),
            std::string::npos);
  EXPECT_NE(page.find("New:</p>\n<ul><li>Matchers, new</li></ul>"), std::string::npos);
  now.sections[0].time_unit = "s";
  EXPECT_EQ(to_text(compare({}, before)),
            "nothing changed by more than noise\nnew    Matchers, slow\nnew    Matchers, fast\n"
            "new    Matchers, neither\nnew    Matchers, ideal\n");
  EXPECT_EQ(compare(before, now).only_before.size(), 4u);  // nothing of it can be compared
}

TEST(Chart, PageNamesEverySettingEscaped) {
  Chart chart = small_chart();
  chart.sections[0].points[0].name = "<script>x";
  const std::string page = to_page(chart);
  EXPECT_EQ(page.find("<script>x"), std::string::npos);
  EXPECT_NE(page.find("<td>&lt;script&gt;x</td><td>0.1 ± 0.01</td><td>100 ± 1</td><td>yes</td>"), std::string::npos);
  EXPECT_NE(page.find("<td>fast</td><td>0.3 ± 0.01</td><td>10 ± 0.1</td><td>yes</td><td>yes</td>"), std::string::npos);
}

}  // namespace
}  // namespace dualpixel::evaluation
