#include "evaluation/experiments/edge_failures.h"
#include "evaluation/report/report_images.h"
#include "evaluation/stage_failures/stage_row.h"

namespace dualpixel::evaluation {
namespace {

StageOutcome solved_edge(const EdgeFailure& failure) {
  const Image result = solve(failure);
  return {failure.figure(result), gray_levels(result, 1)};
}

}  // namespace

std::vector<StageRow> edge_rows() {
  const std::string stage = "edges", width = "10 to 90 % width of the step, px";
  const std::string one_cell = "One cell of the bilateral grid: a step that is wider is blurred.";
  const double cell_px = 8;
  return {
      {stage,
       "weak_edges",
       "Weak edges",
       "step of the picture at the disparity's edge, levels of 255",
       "levels",
       {64, 32, 16, 8, 4, 2, 1},
       width,
       cell_px,
       false,
       one_cell,
       [](double levels, unsigned draw) { return solved_edge(edge_of_levels(levels, draw)); },
       true,
       "Disparity steps from 0 to 1, with noise of .05, and is unknown within 16 px of the step."},
      {stage,
       "same_colors",
       "The same colors before and behind",
       "length of the edge without contrast, px",
       "gap_px",
       {0, 1, 2, 4, 8, 16, 64, 256},
       "pixels that are given the other side's value",
       1.5 * cell_px * cell_px,
       false,
       "Half as much again as a cell of the bilateral grid.",
       [](double gap, unsigned draw) { return solved_edge(edge_with_gap(gap, draw)); },
       false,
       "As in weak_edges, with a step of 64 levels, but for a gap in the middle, within which the first 32 px behind "
       "the "
       "edge look like what is before it. Of few rows all take the other side's disparity, of many those in the "
       "middle."},
      {stage,
       "outliers",
       "Confident outliers",
       "share of outliers",
       "share",
       {0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.4},
       "mean error, of a range of 1",
       0.05,
       false,
       "Half a DP px of a range of ten: what counts as wrong in matching.",
       [](double share, unsigned draw) { return solved_edge(confident_outliers(share, 0, draw)); },
       false,
       "Targets of .2, a share of which are .7 too high with full confidence: the mean follows them."},
      {stage,
       "outliers_robust",
       "Confident outliers, solved robustly",
       "share of outliers",
       "share",
       {0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.6},
       "mean error, of a range of 1",
       0.05,
       false,
       "Half a DP px of a range of ten: what counts as wrong in matching.",
       [](double share, unsigned draw) { return solved_edge(confident_outliers(share, 5, draw)); },
       false,
       "Targets of .2, a share of which are .7 too high with full confidence, in five robust rounds, as for matchers "
       "with "
       "wide windows: the majority wins."},
      {stage,
       "noisy_guide",
       "A noisy picture",
       "white noise of the picture, levels of 255 from darkest to brightest",
       "levels",
       {0, 8, 16, 24, 32, 64, 128, 255},
       "RMS error, of a target's noise of .1",
       0.05,
       false,
       "Half of the noise is left.",
       [](double spread, unsigned draw) { return solved_edge(noisy_guide(spread, draw)); },
       false,
       "Every pixel looks like another surface, so none is averaged with its neighbors."},
  };
}

}  // namespace dualpixel::evaluation
