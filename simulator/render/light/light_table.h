#pragma once
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace dualpixel::simulator {

/// Irradiance on one side of a surface, lux for each of linear R, G, B.
struct SurfaceLight {
  glm::vec3 soft{0};  ///< of the environment and of emissive surfaces, direct or reflected
  glm::vec3 hard{0};  ///< of lights without extent: what their shadows do to it has sharp edges
  /// Of reflected light: harmonic mean of the distances, in meters, over which it came. Infinite where it came from no
  /// surface, or is direct.
  float from_m = std::numeric_limits<float>::infinity();
  float soft_error = 0;  ///< standard error of the luminance of `soft`, as of independent samples
};

/// Remembers light that has been computed, in bounded memory and for any number of threads without locks. It holds
/// results of a pure function of the key, so that a full table costs time but changes nothing.
class LightTable {
 public:
  /// Holds `bytes` at most; pages that are never written take no memory.
  explicit LightTable(std::size_t bytes);

  /// Three times 18 bits with a common exponent: to 4e-6 of the largest of the three.
  static std::uint64_t pack(glm::vec3 rgb);
  static glm::vec3 unpack(std::uint64_t packed);

  /// `group`: keys of one group lie on one page, so that neighbors on a surface share caches. `key` is not 0.
  std::optional<SurfaceLight> find(std::uint64_t group, std::uint64_t key) const;
  /// Returns the light as find() will give it, whether or not there was room for it.
  SurfaceLight add(std::uint64_t group, std::uint64_t key, const SurfaceLight& light);

  /// Points that are held, and those that found no room. Counted for messages alone.
  std::uint64_t points() const { return points_.load(std::memory_order_relaxed); }
  std::uint64_t turned_away() const { return turned_away_.load(std::memory_order_relaxed); }
  /// Memory of the pages that hold points.
  std::uint64_t bytes() const { return used_pages_.load(std::memory_order_relaxed) * kPage * sizeof(Slot); }

 private:
  struct alignas(32) Slot {
    std::atomic<std::uint64_t> key, soft, hard;  ///< key 0: empty; soft 0: being written
    std::atomic<float> from_m, soft_error;
  };
  struct Free {
    void operator()(Slot* slots) const { std::free(slots); }
  };
  static constexpr std::uint64_t kPage = 4096 / sizeof(Slot);  ///< slots

  std::uint64_t page_of(std::uint64_t group) const;

  std::uint64_t pages_;  ///< a power of two
  std::unique_ptr<Slot[], Free> slots_;
  std::vector<std::atomic<bool>> is_used_;  ///< of each page
  std::atomic<std::uint64_t> points_ = 0, turned_away_ = 0, used_pages_ = 0;
};

}  // namespace dualpixel::simulator
