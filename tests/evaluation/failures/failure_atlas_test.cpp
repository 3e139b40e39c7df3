#include "evaluation/failures/failure_atlas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "tests/run_program.h"

namespace dualpixel::evaluation {
namespace {

const FailureRow& row_of(const std::vector<FailureRow>& rows, const std::string& name) {
  return *std::find_if(rows.begin(), rows.end(), [&](const FailureRow& row) { return row.name == name; });
}

DisparityMethod paper() { return method_named("paper"); }
DisparityMethod likelihood() { return method_named("likelihood"); }

TEST(FailureAtlas, TruthIsTheCentroidOfHalfDiscs) {
  const std::vector<FailureRow> rows = ideal_failure_rows();
  for (const auto& [name, blur] : {std::pair{"defocus", 8.0}, {"near_defocus", -24.0}}) {
    // 4 r / 3 pi on either side; the disc is made of squares, 24 across
    EXPECT_NEAR(row_of(rows, name).make(blur, 0).truth_dp_px.at(5, 5), 4 * blur / (3 * M_PI), 0.01 * std::abs(blur));
  }
}

TEST(FailureAtlas, TruthOfASoftSplitIsAlphaTimesTheBlur) {
  // the second moment of squares, 24 across, is the disc's within a percent
  const std::vector<FailureRow> rows = ideal_failure_rows();
  EXPECT_NEAR(row_of(rows, "soft_defocus").make(20, 0).truth_dp_px.at(5, 5), 4.2, 0.042);
  EXPECT_NEAR(row_of(rows, "near_soft_defocus").make(-45, 0).truth_dp_px.at(5, 5), -9.45, 0.095);
}

TEST(FailureAtlas, BarsAndBackgroundHaveTheirOwnDisparity) {
  const ViewSample bars =
      row_of(ideal_failure_rows(), "edges").make(8, 0);  // blurs of -4 and 4, bars of 64 every 128 px
  const double apart = 4 * 4 / (3 * M_PI);
  for (const double x : {32, 160, 288}) EXPECT_NEAR(bars.truth_dp_px.at(x, 9), -apart, 0.05) << x;
  for (const double x : {96, 224, 352}) EXPECT_NEAR(bars.truth_dp_px.at(x, 9), apart, 0.05) << x;
  for (const double x : {64, 127, 128, 191}) EXPECT_TRUE(std::isnan(bars.truth_dp_px.at(x, 9))) << x;
}

TEST(FailureAtlas, CountsOverconfidentErrors) {
  ViewSample failure = row_of(ideal_failure_rows(), "defocus").make(0, 0);
  const FailureFigures right = measure_failure(failure, likelihood());
  EXPECT_EQ(right.wrong, 0);
  EXPECT_GT(*right.trusted, 0.99);
  for (float& truth : failure.truth_dp_px.data) truth += 1;  // a truth that no matcher can find
  const FailureFigures wrong = measure_failure(failure, likelihood());
  EXPECT_EQ(wrong.wrong, 1);
  EXPECT_EQ(*wrong.overconfident, *wrong.trusted);
  EXPECT_NEAR(*wrong.rmse_dp_px, 1, 0.01);
  EXPECT_FALSE(measure_failure(failure, paper()).sigma_dp_px);
}

// A method of the user's own may write NaN where it found nothing: figures are those of what it found.
TEST(FailureAtlas, LeavesOutWhatHasNoSigma) {
  const ViewSample views = row_of(ideal_failure_rows(), "defocus").make(0, 0);
  const auto with_holes = [&](bool holes) {
    const DisparityMethod method = {"m", [&](const Image& left, const Image&, const pipeline::ViewSensor&) {
                                      Image sigma(left.width, left.height, 1, 0.15f),
                                          confidence(left.width, left.height, 1, 1);
                                      for (std::size_t i = 0; holes && i < sigma.data.size(); i += 3) {
                                        sigma.data[i] = confidence.data[i] = NAN;
                                      }
                                      return MethodRun{{views.truth_dp_px, confidence, sigma}, 0, 0, {}};
                                    }};
    return measure_failure(views, method);
  };
  const FailureFigures whole = with_holes(false), holed = with_holes(true);
  EXPECT_EQ(holed.sigma_dp_px, whole.sigma_dp_px);
  EXPECT_EQ(holed.within_one_sigma, 1);
  EXPECT_NEAR(*holed.confidence, 2.0 / 3, 0.01);
  EXPECT_NEAR(*holed.trusted, 2.0 / 3, 0.01);
}

TEST(FailureAtlas, HasNoErrorWhereNothingIsFound) {
  const FailureRow row = row_of(ideal_failure_rows(), "defocus");
  const DisparityMethod blind = {"blind", [](const Image& left, const Image&, const pipeline::ViewSensor&) {
                                   return MethodRun{{Image(left.width, left.height, 1, NAN), {}, {}}, 0, 0, {}};
                                 }};
  const FailureFigures figures = measure_failure(row.make(0, 0), blind);
  EXPECT_FALSE(figures.rmse_dp_px);
  EXPECT_EQ(figures.wrong, 1);
  EXPECT_FALSE(figures.overconfident);
  const std::vector<FailureSweep> sweeps = {measure_row(row, {blind}, 1)};
  EXPECT_EQ(sweeps[0].breaks[0].step, 0);
  const nlohmann::ordered_json json = to_json(sweeps[0], false);
  EXPECT_FALSE(json["steps"][0]["methods"][0].contains("rmse_dp_px"));
  EXPECT_NE(to_page(sweeps, "closed forms").find("<td>–</td>"), std::string::npos);
}

/// Of one step of a row.
FailureFigures figures_of(const std::string& name, double value, const DisparityMethod& matcher) {
  return measure_failure(row_of(ideal_failure_rows(), name).make(value, 0), matcher);
}

struct PaperRow {
  const char* name;
  double holds_at, rmse_dp_px;  ///< a value at which hardly a pixel is wrong, and a bound on the error there
  double breaks_at;             ///< a value at which most are wrong; NaN: none
};

// The paper's matcher: squared differences of locally normalized views, |d| up to 3 DP px, a parabola for the subpixel
// part. It holds until texture along the baseline, contrast or light is gone or the disparity leaves the range, and
// does not mind shading, clipping and highlights. Where it breaks, its confidence says so.
TEST(FailureAtlas, ThePapersMatcherHoldsAndBreaksWhereItShould) {
  constexpr PaperRow kRows[] = {
      {"parallel", 20, 0.12, 2},   {"texture", 5, 0.08, 0.2},      {"repetition", 6, 0.06, 3},
      {"range", 2, 0.06, 4},       {"noise", 30, 0.13, 1},         {"saturation", 0.3, 0.09, NAN},
      {"shading", 0.9, 0.09, NAN}, {"highlights", 1, 0.17, NAN},   {"edges", 2, 0.18, NAN},
      {"defocus", 4, 0.12, 12},    {"near_defocus", -4, 0.15, -16}};
  for (const PaperRow& row : kRows) {
    const FailureFigures holds = figures_of(row.name, row.holds_at, paper());
    EXPECT_LT(holds.wrong, 0.01) << row.name;
    EXPECT_LT(*holds.rmse_dp_px, row.rmse_dp_px) << row.name;
    EXPECT_GT(*holds.confidence, 0.1) << row.name;
    if (std::isnan(row.breaks_at)) continue;
    const FailureFigures broken = figures_of(row.name, row.breaks_at, paper());
    EXPECT_GT(broken.wrong, 0.5) << row.name;
    EXPECT_LT(*broken.confidence, 0.02) << row.name;
  }
  // A disparity just outside of the range is given as the range's end.
  EXPECT_NEAR(figures_of("range", 3.25, paper()).rmse_dp_px.value(), 0.25, 0.02);
}

/// Where a matcher is wrong with confidence, and why.
bool known_to_be_overconfident(std::string_view matcher, std::string_view row) {
  // It expects a soft split's blur at such disparities, and there is none.
  return matcher == "split" && row == "range";
}

// Confidence falls before error rises, in every row, but for the exceptions above, which must be real.
TEST(SlowFailureAtlas, AtMostOnePercentAreOverconfidentErrors) {
  const std::vector<DisparityMethod> methods = {paper(), likelihood(), method_named("split")};
  for (const FailureRow& row : ideal_failure_rows()) {
    const FailureSweep sweep = measure_row(row, methods, 1);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      for (const FailureStep& step : sweep.steps) {
        const FailureFigures& figures = step.methods[m];
        EXPECT_TRUE(figures.rmse_dp_px && std::isfinite(*figures.rmse_dp_px)) << row.name << " " << step.value;
        EXPECT_EQ(figures.sigma_dp_px.has_value(), methods[m].name != "paper");
      }
      const double worst = sweep.overconfident(m).value();
      EXPECT_EQ(worst > 0.01, known_to_be_overconfident(methods[m].name, row.name))
          << methods[m].name << " in " << row.name << ": " << worst;
    }
  }
}

// Of two rows: all of them are measured above.
TEST(SlowFailureAtlas, TheExperimentWritesChartsAndFigures) {
  const TemporaryFolder folder;
  const Outcome outcome =
      run_program("experiment failures --camera ideal --row parallel --row edges -o '" + (folder / "new") + "'");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto json = nlohmann::json::parse(read_bytes(folder / "new/failures.json"));
  const std::string page = read_bytes(folder / "new/failures.html");
  EXPECT_EQ(page.find("http:"), std::string::npos);
  ASSERT_EQ(json["rows"].size(), 2);
  for (const nlohmann::json& row : json["rows"]) {
    EXPECT_GT(row["steps"][0]["methods"][1]["trusted_share"], 0.9);
    EXPECT_NE(page.find(row_of(ideal_failure_rows(), row["name"]).title), std::string::npos) << row["name"];
  }
}

TEST(SlowExperiment, RefusesWhatItCannotWrite) {
  expect_one_line_refusal(run_program("experiment"));
  expect_one_line_refusal(run_program("experiment failures"));
  expect_one_line_refusal(run_program("experiment failures -o /proc/none"));
}

}  // namespace
}  // namespace dualpixel::evaluation
