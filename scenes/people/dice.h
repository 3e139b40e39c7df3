#pragma once
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

#include "simulator/sampling/hash.h"

/// The draws of one recipe, in order, from a key alone, of a training or a held-out set. Of each sixteenth of the unit
/// interval the last fifth belongs to the held-out set and the rest to training, so a number that is drawn uniformly (a
/// length, a color, ...) is never the same in both. Numbers that are drawn about a middle (angles, ...) are sums of
/// such, and cover the same values in both. Pools of whole things (rooms, gestures, ...) are split by choose(). Seeds
/// of noise differ because the key's last bit says which set it is.
namespace dualpixel::scenes {

class RandomStream {
 public:
  RandomStream(std::uint64_t seed, bool held_out) : key_(simulator::hash(seed) << 1 | (held_out ? 1 : 0)) {}

  bool held_out() const { return (key_ & 1) != 0; }

  /// Whether most of what is drawn is to be of no particular kind (see docs/people.md): cloth, walls, places and
  /// gestures that nobody has seen come together, as they do in held-out sets. Never there.
  bool domain_randomized() const { return domain_randomized_; }
  void set_domain_randomized() { domain_randomized_ = !held_out(); }

  /// RandomStream for a part of what is made: its draws don't move when another part draws more.
  RandomStream substream(std::uint64_t part) const {
    RandomStream rng(simulator::hash(key_, part), held_out());
    rng.domain_randomized_ = domain_randomized_;
    return rng;
  }

  /// Uniform over this set's share of [0, 1).
  float uniform() {
    const std::uint64_t bits = next();
    return share(static_cast<float>(bits & (kBlocks - 1)), static_cast<float>(bits >> 40) * 0x1p-24f);
  }
  float uniform(float low, float high) { return low + (high - low) * uniform(); }
  /// Bell-shaped, mean 0, deviation 1, within +-3.5: the sum of four uniform numbers, less the mean of this set's.
  float normal() {
    const float mean = share(0.5f * (kBlocks - 1), 0.5f);
    const float sum = uniform() + uniform() + uniform() + uniform();
    return (sum - 4 * mean) * 1.7320508f;
  }
  glm::vec3 uniform3(float low, float high) {
    const float x = uniform(low, high), y = uniform(low, high);
    return {x, y, uniform(low, high)};
  }
  /// What both sets share: whether, and which of n.
  bool chance(float p) { return static_cast<float>(next() >> 40) * 0x1p-24f < p; }
  int below(int n) { return static_cast<int>((next() >> 33) % static_cast<std::uint64_t>(n)); }
  float sign() { return chance(0.5f) ? 1.0f : -1.0f; }
  std::uint32_t seed() { return static_cast<std::uint32_t>(next() >> 32) << 1 | (held_out() ? 1 : 0); }

  /// Which of a pool of n, the last `reserved` of which only held-out sets use, and the others only training.
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
