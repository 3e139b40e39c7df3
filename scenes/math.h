#pragma once
#include <cmath>
#include <numbers>

namespace dualpixel::scenes {

inline constexpr float kPi = std::numbers::pi_v<float>;

/// What is left of `x` above the next lower integer: in [0, 1).
inline float fraction(float x) { return x - std::floor(x); }

}  // namespace dualpixel::scenes
