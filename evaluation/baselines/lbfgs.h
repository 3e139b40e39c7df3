#pragma once
#include <functional>
#include <vector>

namespace dualpixel::evaluation {

/// Value at x; `gradient` is set.
using Objective = std::function<double(const std::vector<double>& x, std::vector<double>& gradient)>;

/// A minimum of a convex function from `x` on, by L-BFGS (Nocedal and Wright 2006, algorithms 7.4 and 7.5) with steps
/// that are halved until the value falls enough (Armijo's rule): the value never rises. At most `iterations` steps;
/// ends before where no step lowers the value.
std::vector<double> minimize_lbfgs(const Objective& f, std::vector<double> x, int iterations);

}  // namespace dualpixel::evaluation
