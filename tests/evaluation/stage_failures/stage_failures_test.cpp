#include "evaluation/stage_failures/stage_failures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "capture/error.h"
#include "pipeline/segmentation/network.h"

namespace dualpixel::evaluation {
namespace {

StageRow made_up_row() {
  StageRow row;
  row.stage = "defocus", row.name = "made_up", row.title = "<em>", row.sweep = "s", row.key = "s";
  row.values = {1, 2, 3, 4};
  row.figure = "f", row.limit = 2.5, row.reason = "r";
  row.make = [](double value, unsigned draw) { return StageOutcome{value + draw, Image(8, 8, 3, 0.5f)}; };
  return row;
}

StageOutcome outcome_of(const std::string& row, double value, unsigned draw = 0) {
  return stage_rows_named({row}).at(0).make(value, draw);
}

TEST(StageFailures, BreakWhereTheMeanOfTheDrawsLiesBeyondTheLimit) {
  const StageSweep sweep = measure_stage_row(made_up_row(), 3);  // figures: value, value + 1, value + 2
  ASSERT_EQ(sweep.steps.size(), 4u);
  EXPECT_DOUBLE_EQ(sweep.steps[1].figure, 3);
  EXPECT_EQ(sweep.steps[1].low, 2);
  EXPECT_EQ(sweep.steps[1].high, 4);
  EXPECT_EQ(sweep.breaks.step, 1u);  // means 2, 3, ...
  EXPECT_EQ(sweep.breaks.low, 0u);   // of the third draw: 3
  EXPECT_EQ(sweep.breaks.high, 2u);  // of the first: 1, 2, 3
  EXPECT_EQ(sweep.value_at(2), "3");
  EXPECT_EQ(sweep.value_at(4), "never");
}

TEST(StageFailures, AFallingFigureBreaksBelowTheLimit) {
  StageRow row = made_up_row();
  row.falls = true;
  row.make = [](double value, unsigned) { return StageOutcome{4 - value, Image(8, 8, 3)}; };
  EXPECT_EQ(measure_stage_row(row, 1).breaks.step, 1u);  // 3, 2
  row.limit = -1;
  EXPECT_EQ(measure_stage_row(row, 1).breaks.step, 4u);
}

TEST(StageFailures, WhatIsNotANumberIsBroken) {
  StageRow row = made_up_row();
  row.make = [](double value, unsigned) { return StageOutcome{value < 3 ? 0 : std::nan(""), Image(8, 8, 3)}; };
  EXPECT_EQ(measure_stage_row(row, 1).breaks.step, 2u);
  row.falls = true, row.limit = -1;
  EXPECT_EQ(measure_stage_row(row, 1).breaks.step, 2u);
}

TEST(StageFailures, RowsSayWhatTheyMeasure) {
  std::set<std::string> names;
  for (const StageRow& row : stage_rows()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    for (const std::string& text : {row.stage, row.title, row.sweep, row.key, row.figure, row.reason, row.note}) {
      EXPECT_FALSE(text.empty()) << row.name;
    }
    EXPECT_GE(row.values.size(), 3u) << row.name;
    EXPECT_TRUE(std::is_sorted(row.values.begin(), row.values.end()) ||
                std::is_sorted(row.values.rbegin(), row.values.rend()))
        << row.name;
  }
}

TEST(StageFailures, AreChosenByRowOrStage) {
  for (const StageRow& row : stage_rows_named({"edges"})) EXPECT_EQ(row.stage, "edges");
  const std::vector<StageRow> rows = stage_rows_named({"halos", "weak_edges"});
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].name, "weak_edges");  // in the pipeline's order
  EXPECT_EQ(stage_rows_named({}).size(), stage_rows().size());
  EXPECT_THROW(stage_rows_named({"halo"}), InputError);
}

TEST(StageFailures, PageAndJsonHoldEveryStep) {
  const std::vector<StageSweep> sweeps = {measure_stage_row(made_up_row(), 2)};
  const nlohmann::ordered_json json = to_json(sweeps, 2);
  EXPECT_EQ(json["rows"][0]["breaks_at"], "3");  // means 1.5, 2.5, 3.5
  EXPECT_EQ(json["rows"][0]["steps"].size(), 4u);
  EXPECT_EQ(json["rows"][0]["steps"][2]["s"], 3);
  const std::string page = to_page(sweeps, 2);
  EXPECT_NE(page.find("id=\"made_up\""), std::string::npos);
  EXPECT_EQ(page.find("<em>"), std::string::npos);
}

/// The rows whose figures need no simulator: the first step holds, the last does not.
TEST(StageFailures, EdgesAndDefocusGoFromHarmlessToHopeless) {
  for (const StageRow& row : stage_rows_named({"edges", "defocus"})) {
    EXPECT_LE(row.make(row.values.front(), 0).figure, row.limit) << row.name;
    const double last = row.make(row.values.back(), 0).figure;
    if (row.name == "halos") {
      EXPECT_LT(last, row.limit);  // the row's note says that none breaks it
    } else {
      EXPECT_GT(last, row.limit) << row.name;
    }
  }
}

TEST(StageFailures, ASecondPersonInFocusLacksNothing) {
  EXPECT_EQ(outcome_of("two_depths", 1).figure, 0);
  EXPECT_GT(outcome_of("two_depths", 2).figure, outcome_of("two_depths", 1.4).figure);
}

/// A gap of one row, which lies beside the middle, is painted, and leaks.
TEST(StageFailures, AGapOfOneRowCounts) {
  EXPECT_EQ(outcome_of("same_colors", 0).figure, 0);
  EXPECT_GT(outcome_of("same_colors", 1).figure, 0);
  EXPECT_GT(outcome_of("same_colors", 64).figure, 8 * outcome_of("same_colors", 1).figure);
}

/// Of lamps at twice white half of the light is clipped away.
TEST(StageFailures, ClippingTakesTheLightThatItClips) {
  // the blur by layers sums to within 1 % (the same row at 1), and enlarging spreads the lamp by under 2 %
  EXPECT_NEAR(outcome_of("highlights", 2).figure, 0.5, 0.015);
  EXPECT_NEAR(outcome_of("highlights", 1).figure, 0, 0.01);
}

/// S_z and I_z by a line through wrong inverse depths have another scale, the same at every point of the field, and
/// d' = I(0) + S(0) (d - I(x)) / S(x) keeps no trace of it.
TEST(SlowStageFailures, DistancesOfTheWrongScaleCancel) {
  const double right = outcome_of("wrong_distance", 0).figure;
  EXPECT_NEAR(outcome_of("wrong_distance", 1).figure, right, 1e-4);
  // each photograph's own error is that of all points, too; only what weighs their slopes differs
  EXPECT_NEAR(outcome_of("uneven_distances", 0.1).figure, right, 0.02 * right);
  EXPECT_LT(right, 0.1);
}

TEST(SlowStageFailures, ATiltedTargetTiltsTheCorrection) {
  const double straight = outcome_of("tilt", 0).figure, tilted = outcome_of("tilt", 20).figure;
  EXPECT_LT(straight, 0.5);
  EXPECT_GT(tilted, 0.5);
}

/// The sharpest of the first three frames is the base: a fourth one is not looked at.
TEST(SlowStageFailures, ASharpFrameIsFoundAmongTheFirstThree) {
  EXPECT_LT(outcome_of("late_sharp_frame", 3).figure, 1);
  EXPECT_GT(outcome_of("late_sharp_frame", 4).figure, 1);
}

TEST(SlowStageFailures, WhatRollsTooFarIsNotMerged) {
  EXPECT_GT(outcome_of("misalignment", 16).figure, 1.5 * outcome_of("misalignment", 0).figure);
}

TEST(SlowStageFailures, APersonIsFoundFromTheFrontAndNotFromBehind) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without oneDNN";
  EXPECT_GT(outcome_of("turned", 0).figure, 0.75);
  EXPECT_EQ(outcome_of("turned", 180).figure, 0);
}

}  // namespace
}  // namespace dualpixel::evaluation
