#pragma once
#include <vector>

namespace dualpixel::evaluation {

struct MeanInterval {
  double mean = 0, low = 0, high = 0;
};

/// The mean and its 95 % interval by the bootstrap (Efron and Tibshirani 1993, chapter 13: percentiles of the means of
/// 10 000 samples drawn with replacement), the same for every run. `values` must not be empty.
MeanInterval bootstrap_mean(const std::vector<double>& values);

}  // namespace dualpixel::evaluation
