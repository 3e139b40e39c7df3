#include "simulator/sensor/sensor.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "simulator/sampling/hash.h"
#include "simulator/sampling/mosaic.h"
#include "simulator/sampling/random_streams.h"

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

/// What never changes about a photosite: the sensitivity of its halves, and the offsets of its read-outs, DN.
struct FixedPattern {
  double left_gain = 1, right_gain = 1;
  double whole_offset_dn = 0, left_offset_dn = 0, right_offset_dn = 0;
};

FixedPattern fixed_pattern(const SensorOptions& sensor, std::uint64_t photosite) {
  if (sensor.prnu == 0 && sensor.dark_offset_dn == 0) return {};
  Draws draws(hash(sensor.fixed_pattern_seed, kFixedPatternStream, photosite));
  const double deviation = std::sqrt(2.0) * sensor.prnu;  // of one half
  const auto gain = [&] { return std::max(0.0, 1 + deviation * draws.normal()); };
  const auto offset = [&] { return sensor.dark_offset_dn * draws.normal(); };
  return {gain(), gain(), offset(), offset(), offset()};
}

/// Half-photosites that a DP pixel is the mean of.
int binned(const SensorOptions& sensor) {
  const int photosites = sensor.dp_downsample_x * sensor.dp_downsample_y;
  return photosites == 1 ? 1 : photosites / 2;
}

}  // namespace

std::optional<OptionProblem> check(const SensorOptions& s) {
  if (auto problem = check_ranges(s, kSensorRanges)) return problem;
  if (s.width_px % 2 != 0) {
    return OptionProblem{"width_px", fmt::format("{}: must be even: the mosaic repeats every 2", s.width_px)};
  }
  if (s.height_px % 4 != 0) {
    return OptionProblem{
        "height_px", fmt::format("{}: must be a multiple of 4: a DP pixel is up to 4 photosites high", s.height_px)};
  }
  for (double value : s.electrons_per_lux_s) {
    if (!(value > 0 && value < 1e9)) {
      return OptionProblem{"electrons_per_lux_s", fmt::format("{}: must lie in (0, 1e9)", value)};
    }
  }
  const int dp_x = s.dp_downsample_x, dp_y = s.dp_downsample_y;
  if (!(dp_x == 2 && (dp_y == 2 || dp_y == 4)) && !(dp_x == 1 && dp_y == 1)) {
    return OptionProblem{"dp_downsample_y",
                         fmt::format("{} x {}: a DP pixel must be 2 x 4, 2 x 2 or 1 x 1", dp_x, dp_y)};
  }
  if (const auto why = out_of_range(s.black_level_dn, 0, std::exp2(s.bits) / 2)) {
    return OptionProblem{"black_level_dn", *why};
  }
  return std::nullopt;
}

SensorGrid sensor_grid(const SensorOptions& sensor) {
  return {sensor.width_px,
          sensor.height_px,
          sensor.pixel_pitch_um * 1e-6,
          {0.5 * sensor.width_px, 0.5 * sensor.height_px},
          sensor.dp_downsample_x};
}

void describe_sensor(const SensorOptions& sensor, Camera& camera) {
  camera.width_px = sensor.width_px;
  camera.height_px = sensor.height_px;
  camera.pixel_pitch_um = sensor.pixel_pitch_um;
  camera.cfa = name_of(kColorFilterArrays, kSimulatedCfa);
  camera.dp_downsample_x = sensor.dp_downsample_x;
  camera.dp_downsample_y = sensor.dp_downsample_y;
  const glm::dvec2 center = sensor_grid(sensor).principal_point_px;
  camera.principal_point_px = {center.x, center.y};
}

double gain_dn_per_electron(const SensorOptions& sensor, double iso) {
  const double white = std::exp2(sensor.bits) - 1;
  return (white - sensor.black_level_dn) / sensor.full_well_e * iso / 100;
}

double read_noise_dn2(const SensorOptions& sensor, double iso) {
  const double gain = gain_dn_per_electron(sensor, iso);
  return gain * gain * sensor.read_noise_e * sensor.read_noise_e +
         sensor.read_noise_after_gain_dn * sensor.read_noise_after_gain_dn;
}

Exposure describe_exposure(const SensorOptions& sensor, const ExposureOptions& exposure) {
  const double gain = gain_dn_per_electron(sensor, exposure.iso);
  const double read = read_noise_dn2(sensor, exposure.iso);
  Exposure e;
  e.time_s = exposure.time_s;
  e.iso = exposure.iso;
  e.bits = sensor.bits;
  e.black_level_dn = sensor.black_level_dn;
  e.white_level_dn = std::exp2(sensor.bits) - 1;
  e.dp_white_level_dn = std::min(e.white_level_dn, sensor.black_level_dn + gain * 0.5 * sensor.full_well_e);
  e.mosaic_noise = {gain, read + 1.0 / 12};
  e.dp_noise = {gain / binned(sensor), read / binned(sensor) + 1.0 / 12};
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
  const auto level = [&](double counted) { return sensor.black_level_dn + gain * counted; };
  const auto digitize = [&](double dn) { return static_cast<std::uint16_t>(std::clamp(std::round(dn), 0.0, white)); };

  const int block_width = sensor.dp_downsample_x, block_height = sensor.dp_downsample_y;
  const bool dense = block_width * block_height == 1;
  Frame frame;
  frame.seed = seed;
  frame.mosaic = ImageU16(width, height);
  frame.left = ImageU16(width / block_width, height / block_height);
  frame.right = frame.left;
  tbb::parallel_for(0, frame.left.height, [&](int block_y) {
    std::vector<double> sums(2 * static_cast<std::size_t>(frame.left.width), 0.0);  // left, right of each DP pixel, DN
    for (int y = block_height * block_y; y < block_height * (block_y + 1); ++y) {
      for (int x = 0; x < width; ++x) {
        const std::uint64_t photosite = static_cast<std::uint64_t>(y) << 32 | static_cast<unsigned>(x);
        const FixedPattern fixed = fixed_pattern(sensor, photosite);
        Draws draws(hash(seed, photosite));
        const auto read_out = [&](double counted, double offset_dn) {
          double dn = level(counted + sensor.read_noise_e * draws.normal()) + offset_dn;
          if (sensor.read_noise_after_gain_dn > 0) dn += sensor.read_noise_after_gain_dn * draws.normal();
          return dn;
        };
        double left = draws.poisson(fixed.left_gain * electrons.at(x, y, 0));
        double right = draws.poisson(fixed.right_gain * electrons.at(x, y, 1));
        fill_wells(sensor, left, right);
        frame.mosaic.at(x, y) = digitize(read_out(left + right, fixed.whole_offset_dn));
        if (dense || cfa_color(x, y) == 1) {
          sums[2 * (x / block_width)] += read_out(left, fixed.left_offset_dn);
          sums[2 * (x / block_width) + 1] += read_out(right, fixed.right_offset_dn);
        }
      }
    }
    for (int x = 0; x < frame.left.width; ++x) {
      frame.left.at(x, block_y) = digitize(sums[2 * x] / binned(sensor));
      frame.right.at(x, block_y) = digitize(sums[2 * x + 1] / binned(sensor));
    }
  });
  return frame;
}

}  // namespace dualpixel::simulator
