#pragma once
#include <cstdint>

/// Counter-based randomness: a value depends on its key alone, never on what was drawn before it or by which thread.
namespace dualpixel::simulator {

/// SplitMix64's finalizer (Steele et al. 2014): a bijection of 64 bits with full avalanche.
constexpr std::uint64_t hash(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

constexpr std::uint64_t hash(std::uint64_t a, std::uint64_t b) { return hash(hash(a) ^ b); }
constexpr std::uint64_t hash(std::uint64_t a, std::uint64_t b, std::uint64_t c) { return hash(hash(a, b) ^ c); }

/// Uniform in [0, 1) from the upper 24 bits.
constexpr float unit_float(std::uint32_t bits) {
  return static_cast<float>(static_cast<std::int32_t>(bits >> 8)) * 0x1p-24f;
}

}  // namespace dualpixel::simulator
