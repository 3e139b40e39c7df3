#include "evaluation/experiments/failure_atlas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/run_program.h"

namespace dualpixel::evaluation {
namespace {

const FailureRow& row_of(const std::vector<FailureRow>& rows, const std::string& name) {
  return *std::find_if(rows.begin(), rows.end(), [&](const FailureRow& row) { return row.name == name; });
}

TEST(FailureAtlas, TruthIsTheCentroidOfHalfDiscs) {
  const std::vector<FailureRow> rows = failure_rows();
  for (const auto& [name, blur] : {std::pair{"defocus", 8.0}, {"near_defocus", -24.0}}) {
    // 4 r / 3 pi on either side; the disc is made of squares, 24 across
    EXPECT_NEAR(row_of(rows, name).make(blur).truth_dp_px.at(5, 5), 4 * blur / (3 * M_PI), 0.01 * std::abs(blur));
  }
}

TEST(FailureAtlas, BarsAndBackgroundHaveTheirOwnDisparity) {
  const FailureCase bars = row_of(failure_rows(), "edges").make(8);  // blurs of -4 and 4, bars of 64 every 128 px
  const double apart = 4 * 4 / (3 * M_PI);
  for (const double x : {32, 160, 288}) EXPECT_NEAR(bars.truth_dp_px.at(x, 9), -apart, 0.05) << x;
  for (const double x : {96, 224, 352}) EXPECT_NEAR(bars.truth_dp_px.at(x, 9), apart, 0.05) << x;
  for (const double x : {64, 127, 128, 191}) EXPECT_TRUE(std::isnan(bars.truth_dp_px.at(x, 9))) << x;
}

TEST(FailureAtlas, CountsWhatIsWrongAndSure) {
  FailureCase failure = row_of(failure_rows(), "defocus").make(0);
  const FailureFigures right = measure_failure(failure, FailureMethod::likelihood);
  EXPECT_EQ(right.wrong, 0);
  EXPECT_GT(right.sure, 0.99);
  for (float& truth : failure.truth_dp_px.data) truth += 1;  // a truth that neither can find
  const FailureFigures wrong = measure_failure(failure, FailureMethod::likelihood);
  EXPECT_EQ(wrong.wrong, 1);
  EXPECT_EQ(wrong.deceived, wrong.sure);
  EXPECT_NEAR(wrong.rmse_dp_px, 1, 0.01);
  EXPECT_TRUE(std::isnan(measure_failure(failure, FailureMethod::paper).deceived));
}

// Confidence falls before error rises, in every row and at every step.
TEST(SlowFailureAtlas, AtMostOnePercentIsWrongAndSure) {
  for (const FailureRow& row : failure_rows()) {
    for (const double value : row.values) {
      const FailureCase failure = row.make(value);
      const FailureFigures ours = measure_failure(failure, FailureMethod::likelihood);
      EXPECT_LE(ours.deceived, 0.01) << row.name << " " << value;
      const FailureFigures paper = measure_failure(failure, FailureMethod::paper);
      EXPECT_TRUE(std::isfinite(paper.confidence) && std::isfinite(ours.rmse_dp_px)) << row.name << " " << value;
    }
  }
}

TEST(SlowFailureAtlas, TheExperimentWritesChartsAndFigures) {
  const TemporaryFolder folder;
  const Outcome outcome = run_program("experiment failures -o '" + (folder / "new") + "'");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto json = nlohmann::json::parse(read_bytes(folder / "new/failures.json"));
  EXPECT_EQ(json["rows"].size(), failure_rows().size());
  EXPECT_GT(json["rows"][0]["steps"][0]["likelihood"]["sure_share"], 0.9);
  const std::string page = read_bytes(folder / "new/failures.html");
  EXPECT_EQ(page.find("http:"), std::string::npos);
  for (const FailureRow& row : failure_rows()) EXPECT_NE(page.find(row.title), std::string::npos) << row.title;
}

TEST(Experiment, RefusesWhatItCannotWrite) {
  expect_one_line_refusal(run_program("experiment"));
  expect_one_line_refusal(run_program("experiment failures"));
  expect_one_line_refusal(run_program("experiment failures -o /proc/none"));
}

}  // namespace
}  // namespace dualpixel::evaluation
