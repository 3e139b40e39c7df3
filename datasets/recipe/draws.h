#pragma once
#include <cstdint>
#include <string_view>

#include "simulator/sampling/hash.h"

namespace dualpixel::datasets {

/// Random numbers of one sample, or of one scene: they depend on the data set's seed, on `index` and on the name of
/// what is drawn alone, so that one field's draw does not change another's.
class Draws {
 public:
  Draws(std::uint64_t seed, std::uint64_t index, std::string_view name) : key_(simulator::hash(seed, index)) {
    for (const char c : name) key_ = simulator::hash(key_, static_cast<unsigned char>(c));
  }

  std::uint64_t bits() { return simulator::hash(key_, count_++); }
  /// Uniform in [0, 1), 53 bits.
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }

 private:
  std::uint64_t key_;
  std::uint64_t count_ = 0;
};

}  // namespace dualpixel::datasets
