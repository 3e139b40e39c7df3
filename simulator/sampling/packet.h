#pragma once
#include <algorithm>
#include <cmath>

namespace dualpixel::simulator {

inline constexpr int kPacket = 16;  ///< lanes of a packet: samples of one pixel

/// Concentric map of the unit square onto the unit disc (Shirley & Chiu 1997): keeps the sign of x - 1/2, so the two
/// halves of the pupil are stratified each. Branch-free, polynomials for sine and cosine on [-pi/4, pi/4].
inline void concentric_disc(const float u[kPacket], const float v[kPacket], float x[kPacket], float y[kPacket]) {
  for (int i = 0; i < kPacket; ++i) {
    const float a = 2 * u[i] - 1;
    const float b = 2 * v[i] - 1;
    const bool wide = std::abs(a) > std::abs(b);
    const float r = wide ? a : b;
    const float ratio = (wide ? b : a) / std::copysign(std::max(std::abs(r), 1e-20f), r);
    const float t = 0.785398163f * ratio;
    const float t2 = t * t;
    const float sine =
        t * (1 + t2 * (-1.66666667e-1f + t2 * (8.33333333e-3f + t2 * (-1.98412698e-4f + t2 * 2.7557e-6f))));
    const float cosine = 1 + t2 * (-0.5f + t2 * (4.16666667e-2f + t2 * (-1.38888889e-3f + t2 * 2.48016e-5f)));
    x[i] = r * (wide ? cosine : sine);
    y[i] = r * (wide ? sine : cosine);
  }
}

}  // namespace dualpixel::simulator
