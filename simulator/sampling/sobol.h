#pragma once
#include <array>
#include <cstdint>

#include "simulator/sampling/hash.h"
#include "simulator/sampling/packet.h"

/// Owen-scrambled Sobol points, sixteen at a time. The first four dimensions are one joint net for pixel position and
/// pupil position: for a smooth picture under blur its error falls far faster than that of two padded planar nets.
/// Directions: Joe & Kuo 2008. Scrambling: Laine & Karras 2011 with Vegdahl's constants (2021), on reversed bits.
namespace dualpixel::simulator {

/// Reverses the order of 32 bits.
constexpr std::uint32_t reverse_bits(std::uint32_t x) {
  x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x >> 8) & 0x00ff00ffu) | ((x & 0x00ff00ffu) << 8);
  return (x >> 16) | (x << 16);
}

/// A nested uniform (Owen) scramble of a number given with its bits reversed; returns it in natural order.
constexpr std::uint32_t owen_scramble_reversed(std::uint32_t x, std::uint32_t seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return reverse_bits(x);
}

namespace detail {

inline constexpr int kSobolBits = 16;  ///< at most 65536 samples a pixel

/// Bit-reversed direction numbers of the first four Sobol dimensions, for index bits 0..15.
constexpr std::array<std::array<std::uint32_t, kSobolBits>, 4> sobol_directions() {
  // degree, coefficients and initial values of dimensions 2..4; dimension 1 is van der Corput's sequence
  constexpr int degree[3] = {1, 2, 3};
  constexpr int coefficients[3] = {0, 1, 1};
  constexpr std::uint32_t initial[3][3] = {{1, 0, 0}, {1, 3, 0}, {1, 3, 1}};
  std::array<std::array<std::uint32_t, kSobolBits>, 4> v{};
  for (int i = 0; i < kSobolBits; ++i) v[0][i] = 1u << (31 - i);
  for (int d = 0; d < 3; ++d) {
    const int s = degree[d];
    auto& w = v[d + 1];
    for (int i = 0; i < kSobolBits; ++i) {
      if (i < s) {
        w[i] = initial[d][i] << (31 - i);
      } else {
        w[i] = w[i - s] ^ (w[i - s] >> s);
        for (int j = 1; j < s; ++j) {
          if ((coefficients[d] >> (s - 1 - j)) & 1) w[i] ^= w[i - j];
        }
      }
    }
  }
  for (auto& dimension : v) {
    for (auto& direction : dimension) direction = reverse_bits(direction);
  }
  return v;
}

inline constexpr auto kDirections = sobol_directions();

/// Bit-reversed Sobol coordinates of n << 4k, for the four bits of n and k = 0..3: XOR of four entries is any point.
constexpr std::array<std::array<std::array<std::uint32_t, 16>, 4>, 4> nibble_points() {
  std::array<std::array<std::array<std::uint32_t, 16>, 4>, 4> points{};
  for (int d = 0; d < 4; ++d) {
    for (int k = 0; k < 4; ++k) {
      for (int n = 0; n < 16; ++n) {
        for (int bit = 0; bit < 4; ++bit) {
          if ((n >> bit) & 1) points[d][k][n] ^= kDirections[d][4 * k + bit];
        }
      }
    }
  }
  return points;
}

alignas(64) inline constexpr auto kNibblePoints = nibble_points();

constexpr std::uint32_t sobol_reversed(int dimension, std::uint32_t index) {
  const auto& points = kNibblePoints[dimension];
  return points[0][index & 15] ^ points[1][(index >> 4) & 15] ^ points[2][(index >> 8) & 15] ^ points[3][index >> 12];
}

}  // namespace detail

/// The four joint coordinates of samples first .. first + 15 of a pixel; `first` is a multiple of 16.
inline void joint_samples(std::uint32_t first, std::uint64_t pixel_key, float out[4][kPacket]) {
  for (int d = 0; d < 4; ++d) {
    const std::uint32_t base = detail::sobol_reversed(d, first);
    const auto seed = static_cast<std::uint32_t>(hash(pixel_key, d) >> 32);
    const auto& points = detail::kNibblePoints[d][0];
    for (int i = 0; i < kPacket; ++i) out[d][i] = unit_float(owen_scramble_reversed(base ^ points[i], seed));
  }
}

/// Eight points, `first` a multiple of 8, as mirrored pairs: lanes i and i + 8 are at one position on the pixel and at
/// opposite ones of the pupil, lanes 0 to 7 in its left half (third coordinate under 1/2).
inline void mirrored_samples(std::uint32_t first, std::uint64_t pixel_key, float out[4][kPacket]) {
  constexpr int kPairs = kPacket / 2;
  constexpr float kLast = 0x1.fffffep-1f;
  for (int d = 0; d < 4; ++d) {
    const std::uint32_t base = detail::sobol_reversed(d, first);
    const auto seed = static_cast<std::uint32_t>(hash(pixel_key, d) >> 32);
    const auto& points = detail::kNibblePoints[d][0];
    for (int i = 0; i < kPairs; ++i) {
      const float s = unit_float(owen_scramble_reversed(base ^ points[i], seed));
      out[d][i] = s;
      out[d][i + kPairs] = d < 2 ? s : kLast - s;
    }
  }
  for (int i = 0; i < kPairs; ++i) {
    const bool swap = out[2][i] >= 0.5f;
    for (int d = 2; d < 4; ++d) {
      const float s = out[d][i], mirrored = out[d][i + kPairs];
      out[d][i] = swap ? mirrored : s;
      out[d][i + kPairs] = swap ? s : mirrored;
    }
  }
}

/// Planar nets in shuffled order, for whatever follows the lens (`stream` numbers these decisions): one for lanes 0 to
/// 7, the left half of the pupil, one for the others, points first, first + 1, ... of each. Their pairing with the
/// joint coordinates is random, their own stratification is kept, within each half of the pupil: from one net for both,
/// each view would get a random half. `index_mask` + 1 is the power of two that holds all points of either.
inline void padded_samples(std::uint32_t first, std::uint32_t index_mask, std::uint64_t pixel_key, std::uint32_t stream,
                           float u[kPacket], float v[kPacket]) {
  constexpr int kHalf = kPacket / 2;
  std::uint32_t index[kPacket], x[kPacket], y[kPacket], seed_u[kPacket], seed_v[kPacket];
  for (int half = 0; half < 2; ++half) {
    const std::uint64_t key = hash(pixel_key, 4 + 2 * stream + half), seeds = hash(key);
    const auto shuffle = static_cast<std::uint32_t>(key);
    for (int i = half * kHalf; i < (half + 1) * kHalf; ++i) {
      index[i] = owen_scramble_reversed(reverse_bits(first + i % kHalf), shuffle) & index_mask;
      seed_u[i] = static_cast<std::uint32_t>(seeds);
      seed_v[i] = static_cast<std::uint32_t>(seeds >> 32);
    }
  }
  for (int i = 0; i < kPacket; ++i) {
    x[i] = detail::sobol_reversed(0, index[i]);
    y[i] = detail::sobol_reversed(1, index[i]);
  }
  for (int i = 0; i < kPacket; ++i) {
    u[i] = unit_float(owen_scramble_reversed(x[i], seed_u[i]));
    v[i] = unit_float(owen_scramble_reversed(y[i], seed_v[i]));
  }
}

}  // namespace dualpixel::simulator
