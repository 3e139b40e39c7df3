#include "simulator/sensor/hand_shake.h"

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "simulator/sampling/hash.h"

namespace dualpixel::simulator {
namespace {

constexpr int kBands = 24;
constexpr double kLowest_hz = 0.5, kHighest_hz = 12;
constexpr double kAngularSpeed_rad_s = 0.015;
constexpr double kPosition_m = 2e-4;

double uniform(std::uint64_t key) { return (static_cast<double>(hash(key) >> 12) + 0.5) * 0x1p-52; }

/// What a process whose speed is 1 RMS, of even power over the bands, has moved since time 0, s.
double path_s(std::uint64_t key, double time_s) {
  constexpr double kBand_hz = (kHighest_hz - kLowest_hz) / kBands;
  double sum = 0;
  for (int i = 0; i < kBands; ++i) {
    const double omega = 2 * M_PI * (kLowest_hz + kBand_hz * (i + uniform(hash(key, 2 * i))));
    const double phase = 2 * M_PI * uniform(hash(key, 2 * i + 1));
    sum += (std::sin(omega * time_s + phase) - std::sin(phase)) / omega;
  }
  return sum * std::sqrt(2.0 / kBands);
}

/// RMS of the path's displacement from its mean: the mean of 1 / omega^2 over the band is 1 / (omega_low omega_high).
double path_rms_s() { return 1 / (2 * M_PI * std::sqrt(kLowest_hz * kHighest_hz)); }

}  // namespace

glm::dmat4 hand_shake(std::uint64_t seed, double time_s, double scale) {
  glm::dvec3 turn_rad, shift_m;
  for (int axis = 0; axis < 3; ++axis) {
    turn_rad[axis] = scale * kAngularSpeed_rad_s * path_s(hash(seed, axis), time_s);
    shift_m[axis] = scale * kPosition_m / path_rms_s() * path_s(hash(seed, 3 + axis), time_s);
  }
  const glm::dmat4 shifted = glm::translate(glm::dmat4(1), shift_m);
  const double angle_rad = glm::length(turn_rad);
  return angle_rad > 0 ? glm::rotate(shifted, angle_rad, turn_rad / angle_rad) : shifted;
}

}  // namespace dualpixel::simulator
