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

/// What the leaky half of a hot photosite adds, electrons a second at 25 C.
struct Leak {
  double left = 0, right = 0;
};

Leak leak_of(const SensorOptions& sensor, std::uint64_t photosite) {
  if (sensor.hot_pixel_share == 0) return {};
  Draws draws(hash(sensor.fixed_pattern_seed, kHotPixelStream, photosite));
  if (draws.uniform() >= sensor.hot_pixel_share) return {};
  const double leak = -sensor.hot_pixel_e_per_s * std::log(draws.uniform());
  return draws.uniform() < 0.5 ? Leak{leak, 0} : Leak{0, leak};
}

/// What a row has in common in each of its read-outs, DN.
struct RowNoise {
  double whole = 0, left = 0, right = 0;
};

RowNoise row_noise_of(const SensorOptions& sensor, std::uint64_t seed, int y) {
  if (sensor.row_noise_dn == 0) return {};
  Draws draws(hash(seed, kRowNoiseStream, y));
  const auto offset = [&] { return sensor.row_noise_dn * draws.normal(); };
  return {offset(), offset(), offset()};
}

/// Dark current over that at 25 C.
double temperature_factor(const SensorOptions& sensor) {
  return std::exp2((sensor.temperature_c - 25) / sensor.dark_current_doubling_c);
}

/// Electrons for each lx s of the scene's white, under the R, G, B filter.
std::array<double, 3> white_electrons(const SensorOptions& sensor) {
  std::array<double, 3> electrons{};
  for (int c = 0; c < 3; ++c) {
    for (int k = 0; k < 3; ++k) electrons[c] += sensor.color_matrix[3 * c + k] * sensor.illuminant[k];
    electrons[c] *= sensor.electrons_per_lux_s[c];
  }
  return electrons;
}

/// From the scene's colors, its white at 1, 1, 1, to balanced camera colors.
Matrix3 balanced_from_scene(const SensorOptions& sensor) {
  Matrix3 balanced;
  const std::array<double, 3> white = white_electrons(sensor);
  for (int c = 0; c < 3; ++c) {
    for (int k = 0; k < 3; ++k) {
      balanced[3 * c + k] =
          sensor.electrons_per_lux_s[c] * sensor.color_matrix[3 * c + k] * sensor.illuminant[k] / white[c];
    }
  }
  return balanced;
}

FixedPattern fixed_pattern(const SensorOptions& sensor, std::uint64_t photosite) {
  if (sensor.prnu == 0 && sensor.dark_offset_dn == 0) return {};
  Draws draws(hash(sensor.fixed_pattern_seed, kFixedPatternStream, photosite));
  const double deviation = std::sqrt(2.0) * sensor.prnu;  // of one half
  const auto gain = [&] { return std::max(0.0, 1 + deviation * draws.normal()); };
  const auto offset = [&] { return sensor.dark_offset_dn * draws.normal(); };
  return {gain(), gain(), offset(), offset(), offset()};
}

/// How many read-outs' variance a signal has. In a view, half of what left - right has: where right is the sum less
/// left, that is 2 left - sum, five read-outs' instead of two, but no more dark current.
double noise_read_outs(const SensorOptions& sensor, bool whole) {
  return !whole && sensor.readout == Readout::sum_and_left ? 2.5 : 1;
}

/// Half-photosites that a DP pixel is the mean of.
int binned(const SensorOptions& sensor) {
  const int photosites = sensor.dp_downsample_x * sensor.dp_downsample_y;
  return photosites == 1 ? 1 : photosites / 2;
}

/// What a capture says of colors stays within what its readers take.
std::optional<OptionProblem> check_colors(const SensorOptions& s) {
  constexpr double kMostSeen = 100, kLeastElectrons = 1e-3, kMostChange = 1e6;
  for (const double value : s.illuminant) {
    if (const auto why = out_of_range(value, 1e-6, 1e6)) return OptionProblem{"illuminant", *why};
  }
  for (const double value : s.color_matrix) {
    if (const auto why = out_of_range(value, -kMostSeen, kMostSeen)) return OptionProblem{"color_matrix", *why};
  }
  for (const double electrons : white_electrons(s)) {
    if (electrons >= kLeastElectrons) continue;
    return OptionProblem{"color_matrix", fmt::format("{:g} electrons for each lx s of the illuminant under one filter: "
                                                     "each row must see {:g} or more",
                                                     electrons, kLeastElectrons)};
  }
  const double change = std::abs(determinant(balanced_from_scene(s)));
  if (change > 1 / kMostChange && change < kMostChange) return std::nullopt;
  return OptionProblem{"color_matrix",
                       fmt::format("determinant {:g} where the illuminant is white: must have an inverse, "
                                   "{:g} to {:g}",
                                   change, 1 / kMostChange, kMostChange)};
}

}  // namespace

std::optional<OptionProblem> check(const SensorOptions& s) {
  if (auto problem = check_ranges(s, kSensorRanges)) return problem;
  if (s.width_px % 2 != 0) {
    return OptionProblem{"width_px", fmt::format("{}: must be even: the mosaic repeats every 2", s.width_px)};
  }
  constexpr std::int64_t kMostPhotosites =
      55'000'000;  // truth's geometry.exr has nine values of each, and is read again
  if (static_cast<std::int64_t>(s.width_px) * s.height_px > kMostPhotosites) {
    return OptionProblem{"height_px",
                         fmt::format("{}: makes {:.0f} million photosites: must be at most {}", s.height_px,
                                     1e-6 * s.width_px * s.height_px, kMostPhotosites / 1'000'000)};
  }
  if (s.height_px % 4 != 0) {
    return OptionProblem{
        "height_px", fmt::format("{}: must be a multiple of 4: a DP pixel is up to 4 photosites high", s.height_px)};
  }
  for (double value : s.electrons_per_lux_s) {
    if (!(value >= 1e-3 && value <= 1e9)) {
      return OptionProblem{"electrons_per_lux_s", fmt::format("{}: must lie in [0.001, 1e9]", value)};
    }
  }
  if (auto problem = check_colors(s)) return problem;
  const int dp_x = s.dp_downsample_x, dp_y = s.dp_downsample_y;
  if (!(dp_x == 2 && (dp_y == 2 || dp_y == 4)) && !(dp_x == 1 && dp_y == 1)) {
    return OptionProblem{"dp_downsample_y",
                         fmt::format("{} x {}: a DP pixel must be 2 x 4, 2 x 2 or 1 x 1", dp_x, dp_y)};
  }
  if (const auto why = out_of_range(s.black_level_dn, 0, std::exp2(s.bits) / 2)) {
    return OptionProblem{"black_level_dn", *why};
  }
  if (s.readout == Readout::sum_and_left && s.black_level_dn != std::round(s.black_level_dn)) {
    return OptionProblem{"black_level_dn",
                         fmt::format("{:g}: must be a whole number where the read-out is sum_and_left: right is the "
                                     "difference of two numbers that were digitized",
                                     s.black_level_dn)};
  }
  return std::nullopt;
}

std::optional<OptionProblem> check_dark(const SensorOptions& sensor, const ExposureOptions& exposure) {
  const double dark_e = dark_electrons(sensor, exposure), most_e = 0.98 * sensor.full_well_e;
  if (dark_e <= most_e) return std::nullopt;
  return OptionProblem{
      "dark_current_e_per_s",
      fmt::format("{:g}: gathers {:.4g} electrons in {:g} s at {:g} C: must leave some of the well, {:.4g} "
                  "at most",
                  sensor.dark_current_e_per_s, dark_e, exposure.time_s, sensor.temperature_c, most_e)};
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

double dark_electrons(const SensorOptions& sensor, const ExposureOptions& exposure) {
  return sensor.dark_current_e_per_s * temperature_factor(sensor) * exposure.time_s;
}

double read_noise_dn2(const SensorOptions& sensor, const ExposureOptions& exposure, bool whole) {
  const double gain = gain_dn_per_electron(sensor, exposure.iso);
  const double dark_e = (whole ? 1 : 0.5) * dark_electrons(sensor, exposure);
  return noise_read_outs(sensor, whole) * (gain * gain * (sensor.read_noise_e * sensor.read_noise_e) +
                                           sensor.read_noise_after_gain_dn * sensor.read_noise_after_gain_dn +
                                           sensor.row_noise_dn * sensor.row_noise_dn) +
         gain * gain * dark_e;
}

Exposure describe_exposure(const SensorOptions& sensor, const ExposureOptions& exposure) {
  const double gain = gain_dn_per_electron(sensor, exposure.iso);
  const bool subtracted = sensor.readout == Readout::sum_and_left;
  Exposure e;
  e.time_s = exposure.time_s;
  e.iso = exposure.iso;
  e.bits = sensor.bits;
  e.black_level_dn = sensor.black_level_dn;
  e.white_level_dn = std::exp2(sensor.bits) - 1;
  // dark current fills wells, too, and its mean is taken off
  const double range_dn = e.white_level_dn - sensor.black_level_dn;
  const double free_well_e = sensor.full_well_e - dark_electrons(sensor, exposure);
  const double mosaic_dn = gain * free_well_e;
  if (mosaic_dn < range_dn - 1e-6) e.mosaic_white_level_dn = sensor.black_level_dn + mosaic_dn;
  // where right is what is left of the sum, it is none where the sum clips
  e.dp_white_level_dn = sensor.black_level_dn + std::min((subtracted ? 0.5 : 1) * range_dn, 0.5 * mosaic_dn);
  e.mosaic_noise = {gain, read_noise_dn2(sensor, exposure, true) + 1.0 / 12};
  e.dp_noise = {gain / binned(sensor),
                read_noise_dn2(sensor, exposure, false) / binned(sensor) + noise_read_outs(sensor, false) / 12};
  const std::array<double, 3> white = white_electrons(sensor);
  for (int c = 0; c < 3; ++c) e.white_balance[c] = white[1] / white[c];
  if (sensor.color_matrix != kIdentity3) e.color_matrix = inverse(balanced_from_scene(sensor));
  e.lux_s_per_unit = (e.white_level_dn - e.black_level_dn) / gain / white[1];
  return e;
}

Image expected_electrons(const Image& left, const Image& right, const SensorOptions& sensor,
                         const ExposureOptions& exposure, double lux_per_nit) {
  Image electrons(left.width, left.height, 2);
  tbb::parallel_for(0, left.height, [&](int y) {
    for (int x = 0; x < left.width; ++x) {
      const int c = cfa_color(x, y);
      const double per_nit = lux_per_nit * exposure.time_s * sensor.electrons_per_lux_s[c];
      double seen_left = 0, seen_right = 0;
      for (int k = 0; k < 3; ++k) {
        seen_left += sensor.color_matrix[3 * c + k] * left.at(x, y, k);
        seen_right += sensor.color_matrix[3 * c + k] * right.at(x, y, k);
      }
      electrons.at(x, y, 0) = static_cast<float>(std::max(seen_left, 0.0) * per_nit);
      electrons.at(x, y, 1) = static_cast<float>(std::max(seen_right, 0.0) * per_nit);
    }
  });
  return electrons;
}

Frame expose(const Image& electrons, const SensorOptions& sensor, const ExposureOptions& exposure, std::uint64_t seed) {
  const int width = electrons.width;
  const int height = electrons.height;
  const double gain = gain_dn_per_electron(sensor, exposure.iso);
  const double white = std::exp2(sensor.bits) - 1;
  const double dark_e = dark_electrons(sensor, exposure), leak_s = exposure.time_s * temperature_factor(sensor);
  const auto level = [&](double counted) { return sensor.black_level_dn + gain * counted; };
  const auto digitize = [&](double dn) { return static_cast<std::uint16_t>(std::clamp(std::round(dn), 0.0, white)); };

  const int block_width = sensor.dp_downsample_x, block_height = sensor.dp_downsample_y;
  const bool dense = block_width * block_height == 1, subtracted = sensor.readout == Readout::sum_and_left;
  Frame frame;
  frame.seed = seed;
  frame.mosaic = ImageU16(width, height);
  frame.left = ImageU16(width / block_width, height / block_height);
  frame.right = frame.left;
  tbb::parallel_for(0, frame.left.height, [&](int block_y) {
    // of each DP pixel, DN: left, and right or the sum
    std::vector<double> sums(2 * static_cast<std::size_t>(frame.left.width), 0.0);
    for (int y = block_height * block_y; y < block_height * (block_y + 1); ++y) {
      const RowNoise row = row_noise_of(sensor, seed, y);
      for (int x = 0; x < width; ++x) {
        const std::uint64_t photosite = static_cast<std::uint64_t>(y) << 32 | static_cast<unsigned>(x);
        const FixedPattern fixed = fixed_pattern(sensor, photosite);
        const Leak leak = leak_of(sensor, photosite);
        Draws draws(hash(seed, photosite));
        const auto read_out = [&](double counted, double offset_dn) {
          double dn = level(counted + sensor.read_noise_e * draws.normal()) + offset_dn;
          if (sensor.read_noise_after_gain_dn > 0) dn += sensor.read_noise_after_gain_dn * draws.normal();
          return dn;
        };
        const double left_light = fixed.left_gain * electrons.at(x, y, 0);
        const double right_light = fixed.right_gain * electrons.at(x, y, 1);
        double left = draws.poisson(left_light + (0.5 * dark_e + leak_s * leak.left));
        double right = draws.poisson(right_light + (0.5 * dark_e + leak_s * leak.right));
        fill_wells(sensor, left, right);
        const double whole_dn = read_out(left + right - dark_e, fixed.whole_offset_dn + row.whole);
        frame.mosaic.at(x, y) = digitize(whole_dn);
        if (dense || cfa_color(x, y) == 1) {
          double* const sum = &sums[2 * (x / block_width)];
          sum[0] += read_out(left - 0.5 * dark_e, fixed.left_offset_dn + row.left);
          sum[1] += subtracted ? whole_dn : read_out(right - 0.5 * dark_e, fixed.right_offset_dn + row.right);
        }
      }
    }
    for (int x = 0; x < frame.left.width; ++x) {
      const std::uint16_t left = digitize(sums[2 * x] / binned(sensor)),
                          other = digitize(sums[2 * x + 1] / binned(sensor));
      frame.left.at(x, block_y) = left;
      // where the sum clips, nothing is known of right
      const bool known = subtracted && other < white;
      frame.right.at(x, block_y) = known ? digitize(other - left + sensor.black_level_dn) : other;
    }
  });
  return frame;
}

}  // namespace dualpixel::simulator
