#pragma once
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

#include "simulator/sampling/hash.h"

/// Counter-based random numbers for data sets whose training and held-out parts must not share a draw.
///
/// - Uniform numbers (a length, a color): the unit interval is cut into 16 blocks; the last fifth of each belongs to
///   held-out sets and the rest to training sets, so the two never draw the same number.
/// - Bell-shaped numbers (angles) are sums of such, and cover the same range in both.
/// - Pools of whole kinds (rooms, gestures) are split by choose().
/// - Noise seeds differ in their last bit.
namespace dualpixel::scenes {

class RandomStream {
 public:
  RandomStream(std::uint64_t seed, bool held_out) : key_(simulator::hash(seed) << 1 | (held_out ? 1 : 0)) {}

  bool held_out() const { return (key_ & 1) != 0; }

  /// Domain randomization (Tobin et al. 2017; docs/people.md): whether most fabrics, walls, environments and gestures
  /// of this picture are generic random patterns and shapes. Training sets only.
  bool domain_randomized() const { return domain_randomized_; }
  void set_domain_randomized() { domain_randomized_ = !held_out(); }

  /// An independent stream for one part of a sample: its draws do not change when another part draws more.
  RandomStream substream(std::uint64_t part) const {
    RandomStream rng(simulator::hash(key_, part), held_out());
    rng.domain_randomized_ = domain_randomized_;
    return rng;
  }

  /// Uniform over this set's part of [0, 1).
  float uniform() {
    const std::uint64_t bits = next();
    return share(static_cast<float>(bits & (kBlocks - 1)), static_cast<float>(bits >> 40) * 0x1p-24f);
  }
  float uniform(float low, float high) { return low + (high - low) * uniform(); }
  /// Bell-shaped, mean 0, deviation 1, within +-3.5: the sum of four uniform numbers, less this set's mean.
  float normal() {
    const float mean = share(0.5f * (kBlocks - 1), 0.5f);
    const float sum = uniform() + uniform() + uniform() + uniform();
    return (sum - 4 * mean) * 1.7320508f;
  }
  glm::vec3 uniform3(float low, float high) {
    const float x = uniform(low, high), y = uniform(low, high);
    return {x, y, uniform(low, high)};
  }
  /// Both sets draw these from the same values.
  bool chance(float p) { return static_cast<float>(next() >> 40) * 0x1p-24f < p; }
  int below(int n) { return static_cast<int>((next() >> 33) % static_cast<std::uint64_t>(n)); }
  float sign() { return chance(0.5f) ? 1.0f : -1.0f; }
  std::uint32_t seed() { return static_cast<std::uint32_t>(next() >> 32) << 1 | (held_out() ? 1 : 0); }

  /// An index into a pool of n kinds, of which the last `reserved` are for held-out sets only and the others for
  /// training sets only.
  int choose(int n, int reserved) { return held_out() ? n - reserved + below(reserved) : below(n - reserved); }

 private:
  static constexpr int kBlocks = 16, kSlots = 5;
  float share(float block, float within) const {
    const float slot = held_out() ? kSlots - 1 + within : (kSlots - 1) * within;
    return (block + slot / kSlots) / kBlocks;
  }
  std::uint64_t next() { return simulator::hash(key_, count_++); }
  std::uint64_t key_;
  std::uint64_t count_ = 0;
  bool domain_randomized_ = false;
};

}  // namespace dualpixel::scenes
