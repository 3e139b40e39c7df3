#include "simulator/sensor/sensor.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "simulator/sampling/hash.h"

namespace dualpixel::simulator {
namespace {

/// Draws of one photosite: a counter under a key, so that they depend on nothing else.
class Draws {
 public:
  explicit Draws(std::uint64_t key) : key_(key) {}

  /// Uniform in (0, 1).
  double uniform() { return (static_cast<double>(hash(key_ + counter_++) >> 12) + 0.5) * 0x1p-52; }

  /// Standard normal (Box & Muller 1958); the second of each pair is kept.
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double r = std::sqrt(-2 * std::log(uniform()));
    const double phi = 2 * M_PI * uniform();
    has_spare_ = true;
    spare_ = r * std::sin(phi);
    return r * std::cos(phi);
  }

  /// Poisson: inversion where few are expected; a rounded normal with the same mean and variance where its skewness
  /// no longer shows (rounding adds 1/12 to the variance).
  double poisson(double mean) {
    if (mean > 40) return std::max(0.0, std::round(mean + std::sqrt(mean - 1.0 / 12) * normal()));
    double probability = std::exp(-mean);
    double rest = uniform() - probability;
    int count = 0;
    while (rest > 0 && count < 200) {
      ++count;
      probability *= mean / count;
      rest -= probability;
    }
    return count;
  }

 private:
  std::uint64_t key_;
  std::uint64_t counter_ = 0;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace

double gain_dn_per_electron(const SensorOptions& sensor, double iso) {
  const double white = std::exp2(sensor.bits) - 1;
  return (white - sensor.black_level_dn) / sensor.full_well_e * iso / 100;
}

Exposure describe_exposure(const SensorOptions& sensor, const ExposureOptions& exposure) {
  const double gain = gain_dn_per_electron(sensor, exposure.iso);
  const double read = gain * gain * sensor.read_noise_e * sensor.read_noise_e + 1.0 / 12;
  constexpr double kBinned = 4;  // green half-photosites in a DP pixel
  Exposure e;
  e.time_s = exposure.time_s;
  e.iso = exposure.iso;
  e.bits = sensor.bits;
  e.black_level_dn = sensor.black_level_dn;
  e.white_level_dn = std::exp2(sensor.bits) - 1;
  e.mosaic_noise = {gain, read};
  e.dp_noise = {gain / kBinned, gain * gain * sensor.read_noise_e * sensor.read_noise_e / kBinned + 1.0 / 12};
  for (int c = 0; c < 3; ++c) e.white_balance[c] = sensor.electrons_per_lux_s[1] / sensor.electrons_per_lux_s[c];
  e.lux_s_per_unit = (e.white_level_dn - e.black_level_dn) / gain / sensor.electrons_per_lux_s[1];
  return e;
}

Image expected_electrons(const Image& left, const Image& right, const SensorOptions& sensor,
                         const ExposureOptions& exposure, double lux_per_nit) {
  Image electrons(left.width, left.height, 2);
  tbb::parallel_for(0, left.height, [&](int y) {
    for (int x = 0; x < left.width; ++x) {
      const int c = cfa_color(x, y);
      const double per_nit = lux_per_nit * exposure.time_s * sensor.electrons_per_lux_s[c];
      electrons.at(x, y, 0) = static_cast<float>(left.at(x, y, c) * per_nit);
      electrons.at(x, y, 1) = static_cast<float>(right.at(x, y, c) * per_nit);
    }
  });
  return electrons;
}

Frame expose(const Image& electrons, const SensorOptions& sensor, const ExposureOptions& exposure, std::uint64_t seed) {
  const int width = electrons.width;
  const int height = electrons.height;
  const double gain = gain_dn_per_electron(sensor, exposure.iso);
  const double white = std::exp2(sensor.bits) - 1;
  // Beyond the full well, charge is lost; the two halves share one well.
  const auto level = [&](double counted) { return sensor.black_level_dn + gain * counted; };
  const auto digitise = [&](double dn) { return static_cast<std::uint16_t>(std::clamp(std::round(dn), 0.0, white)); };

  Frame frame;
  frame.seed = seed;
  frame.mosaic = ImageU16(width, height);
  frame.left = ImageU16(width / 2, height / 4);
  frame.right = ImageU16(width / 2, height / 4);
  tbb::parallel_for(0, height / 4, [&](int block_y) {
    std::vector<double> sums(width, 0.0);  // left, right of each DP pixel, DN
    for (int y = 4 * block_y; y < 4 * block_y + 4; ++y) {
      for (int x = 0; x < width; ++x) {
        Draws draws(hash(seed, static_cast<std::uint64_t>(y) << 32 | static_cast<unsigned>(x)));
        double left = draws.poisson(electrons.at(x, y, 0));
        double right = draws.poisson(electrons.at(x, y, 1));
        const double fill = (left + right) / sensor.full_well_e;
        if (fill > 1) {
          left /= fill;
          right /= fill;
        }
        frame.mosaic.at(x, y) = digitise(level(left + right + sensor.read_noise_e * draws.normal()));
        if (cfa_color(x, y) == 1) {
          sums[x / 2 * 2] += level(left + sensor.read_noise_e * draws.normal());
          sums[x / 2 * 2 + 1] += level(right + sensor.read_noise_e * draws.normal());
        }
      }
    }
    for (int x = 0; x < width / 2; ++x) {
      frame.left.at(x, block_y) = digitise(sums[2 * x] / 4);
      frame.right.at(x, block_y) = digitise(sums[2 * x + 1] / 4);
    }
  });
  return frame;
}

}  // namespace dualpixel::simulator
