#pragma once
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

}  // namespace dualpixel::pipeline
