#pragma once
#include <algorithm>
#include <cstring>

/// A premultiplied RGBA pixel in one register, on compilers with vector extensions (GCC, Clang).
namespace dualpixel::pipeline {

using Rgba = float __attribute__((vector_size(16)));

inline Rgba load_rgba(const float* from) {
  Rgba pixel;
  std::memcpy(&pixel, from, sizeof(pixel));
  return pixel;
}

inline void store_rgba(const Rgba& pixel, float* to) { std::memcpy(to, &pixel, sizeof(pixel)); }

/// Premultiplied "disjoint over" (X Rendering Extension): what is behind fills what the front leaves open, as far as it
/// goes. In one picture nothing is known of what a nearer thing hides. Where both are blurred across their border, each
/// has seen its own share of the lens, and "over" would take the front's share off the other's a second time. Of
/// several layers the nearest two come first: parts of one thing that two layers share must add up before anything is
/// behind.
inline Rgba lay_over(const Rgba& front, const Rgba& behind) {
  const float open = 1 - std::min(front[3], 1.0f);
  return front + (behind[3] > open ? open / behind[3] : 1) * behind;
}

}  // namespace dualpixel::pipeline
