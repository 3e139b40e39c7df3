#pragma once
#include <cstdint>
#include <vector>

#include "evaluation/baselines/match_intervals.h"
#include "pipeline/edge_aware/bilateral_grid.h"

/// Stereo in bilateral space (Barron et al. 2015, sections 2, 3 and 5): one label for each vertex of a bilateral grid,
/// by minimizing
///     E(v) = 1/2 v' (Dm - Dn B Dn) v + lambda sum_j g_j(v_j),    g_j(v) = sum_i max(0, first_i - v, v - last_i)
/// over the pixels i of vertex j. B blurs the grid along each axis by [1 2 1]; n makes Dn B Dn bistochastic. E is
/// convex.
namespace dualpixel::evaluation {

struct BilateralSpaceOptions {
  /// Data over smoothness, above 0, with labels as the unit. Of .05, .25, 1 and 4 the one of least error over drawn
  /// scenes: chosen with truth in view, in the method's favor.
  double lambda = 0.05;
  int iterations = 25;  ///< of L-BFGS, at most
  int levels = 5;       ///< of the pyramid, the grid's own among them, 1 to 16
  int bistochastic_iterations = 16;
};

/// E for one grid and its intervals.
class BilateralSpaceEnergy {
 public:
  /// Intervals have the grid's size. Throws InputError where they do not, or an option is out of its range.
  BilateralSpaceEnergy(const pipeline::BilateralGrid& grid, const MatchIntervals& intervals, int labels,
                       const BilateralSpaceOptions& options);

  /// E(v); `gradient` becomes its gradient (a subgradient where E has a kink, at whole labels).
  double operator()(const std::vector<double>& v, std::vector<double>& gradient) const;

 private:
  double data(int vertex, double label, double& slope) const;

  const pipeline::BilateralGrid& grid_;
  int vertices_, labels_;
  double lambda_;
  std::vector<double> n_;         ///< Dn, and 0 for a missing neighbor
  std::vector<double> diagonal_;  ///< Dm
  std::vector<double> pixels_;    ///< of each vertex: the slope of g_j beyond the labels
  std::vector<double> table_;     ///< g_j at each label, vertex by vertex; linear in between
};

/// The vertices' labels of least E, found over a pyramid of ever coarser grids (section 5: every vertex is the sum of
/// its ancestors' values, so that one step moves whole regions), by L-BFGS from the middle label.
std::vector<double> solve_bilateral_space(const pipeline::BilateralGrid& grid, const MatchIntervals& intervals,
                                          int labels, const BilateralSpaceOptions& options = {});

/// For each level above the grid's own, which vertex of it each vertex of the level below belongs to: pairs of cells
/// along all five axes become one.
std::vector<std::vector<std::int32_t>> grid_pyramid(const pipeline::BilateralGrid& grid, int levels);

}  // namespace dualpixel::evaluation
