#include "evaluation/metrics/bootstrap.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>

namespace dualpixel::evaluation {

MeanInterval bootstrap_mean(const std::vector<double>& values) {
  constexpr int kSamples = 10000;
  const auto n = values.size();
  std::mt19937_64 random(1);
  std::vector<double> means(kSamples);
  for (double& mean : means) {
    for (std::size_t i = 0; i < n; ++i) mean += values[random() % n];
    mean /= static_cast<double>(n);
  }
  std::sort(means.begin(), means.end());
  return {std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(n), means[kSamples / 40],
          means[kSamples - 1 - kSamples / 40]};
}

}  // namespace dualpixel::evaluation
