#include "evaluation/baselines/lbfgs.h"

#include <cmath>
#include <deque>
#include <numeric>
#include <utility>

namespace dualpixel::evaluation {
namespace {

using Vector = std::vector<double>;

constexpr std::size_t kPairs = 10;
constexpr int kHalvings = 30;
constexpr double kArmijo = 1e-4;

double dot(const Vector& a, const Vector& b) { return std::inner_product(a.begin(), a.end(), b.begin(), 0.0); }

void add(Vector& a, double share, const Vector& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += share * b[i];
}

/// A step and how the gradient changed over it.
struct Pair {
  Vector step, change;
  double inverse;  ///< 1 / (step . change)
};

/// The two loops: the estimated inverse Hessian times -gradient.
Vector direction_of(const Vector& gradient, const std::deque<Pair>& pairs) {
  Vector q = gradient;
  for (double& value : q) value = -value;
  std::vector<double> shares(pairs.size());
  for (std::size_t k = pairs.size(); k-- > 0;) {
    shares[k] = pairs[k].inverse * dot(pairs[k].step, q);
    add(q, -shares[k], pairs[k].change);
  }
  if (!pairs.empty()) {
    const Pair& last = pairs.back();
    const double scale = 1 / (last.inverse * dot(last.change, last.change));
    for (double& value : q) value *= scale;
  }
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    add(q, shares[k] - pairs[k].inverse * dot(pairs[k].change, q), pairs[k].step);
  }
  return q;
}

}  // namespace

std::vector<double> minimize_lbfgs(const Objective& f, std::vector<double> x, int iterations) {
  std::deque<Pair> pairs;
  Vector gradient(x.size()), next_gradient(x.size());
  double value = f(x, gradient);
  for (int i = 0; i < iterations; ++i) {
    const double steepest = std::sqrt(dot(gradient, gradient));
    if (!(steepest > 0)) break;
    const Vector direction = direction_of(gradient, pairs);
    const double slope = dot(gradient, direction);
    double length = pairs.empty() ? 1 / steepest : 1;
    Vector next;
    double next_value = value;
    int tries = 0;
    for (; tries < kHalvings; ++tries, length /= 2) {
      next = x;
      add(next, length, direction);
      next_value = f(next, next_gradient);
      if (next_value < value + kArmijo * length * slope) break;
    }
    if (tries == kHalvings) {
      if (pairs.empty()) break;
      pairs.clear();  // a kink: what was learned of the curvature is of its other side
      continue;
    }
    Pair pair{next, next_gradient, 0};
    add(pair.step, -1, x);
    add(pair.change, -1, gradient);
    const double curvature = dot(pair.step, pair.change);
    if (curvature > 1e-12 * dot(pair.change, pair.change)) {
      pair.inverse = 1 / curvature;
      pairs.push_back(std::move(pair));
      if (pairs.size() > kPairs) pairs.pop_front();
    }
    x = std::move(next);
    gradient = next_gradient;
    value = next_value;
  }
  return x;
}

}  // namespace dualpixel::evaluation
