#include "simulator/render/light/light_table.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <new>

namespace dualpixel::simulator {
namespace {

constexpr int kBits = 18, kBias = 128;
constexpr std::uint64_t kMantissa = (1u << kBits) - 1, kPresent = 1ull << 63;
constexpr int kProbes = 32;  // slots of its page in which a point may lie

}  // namespace

LightTable::LightTable(std::size_t bytes)
    : pages_(std::bit_floor(std::max<std::size_t>(bytes / 4096, 1))), is_used_(pages_) {
  // calloc: large blocks come as untouched pages of zeros, which the system fills when they are first written
  slots_.reset(static_cast<Slot*>(std::calloc(pages_ * kPage, sizeof(Slot))));
  if (!slots_) throw std::bad_alloc();
}

std::uint64_t LightTable::page_of(std::uint64_t group) const { return (group ^ group >> 29) & (pages_ - 1); }

std::uint64_t LightTable::pack(glm::vec3 rgb) {
  const float largest = std::max({rgb.x, rgb.y, rgb.z});
  if (!(largest > 0)) return kPresent;
  const int exponent = std::clamp(std::ilogb(largest) + 1, -kBias + 1, kBias - 1);
  const auto mantissa = [&](float value) {
    const float scaled = std::ldexp(std::max(value, 0.0f), kBits - exponent);
    return std::min(static_cast<std::uint64_t>(std::lround(scaled)), kMantissa);
  };
  return kPresent | static_cast<std::uint64_t>(exponent + kBias) << (3 * kBits) | mantissa(rgb.x) << (2 * kBits) |
         mantissa(rgb.y) << kBits | mantissa(rgb.z);
}

glm::vec3 LightTable::unpack(std::uint64_t packed) {
  const int exponent = static_cast<int>(packed >> (3 * kBits) & 0xff) - kBias - kBits;
  if (exponent == -kBias - kBits) return glm::vec3(0);
  const auto power = std::bit_cast<float>(static_cast<std::uint32_t>(std::max(exponent + 127, 1)) << 23);
  return power * glm::vec3(static_cast<float>(packed >> (2 * kBits) & kMantissa),
                           static_cast<float>(packed >> kBits & kMantissa), static_cast<float>(packed & kMantissa));
}

std::optional<SurfaceLight> LightTable::find(std::uint64_t group, std::uint64_t key) const {
  const Slot* page = &slots_[page_of(group) * kPage];
  for (int probe = 0; probe < kProbes; ++probe) {
    const Slot& slot = page[(key + probe) % kPage];
    const std::uint64_t held = slot.key.load(std::memory_order_relaxed);
    if (held == 0) return {};
    if (held != key) continue;
    const std::uint64_t soft = slot.soft.load(std::memory_order_acquire);
    if (soft == 0) return {};
    return SurfaceLight{unpack(soft), unpack(slot.hard.load(std::memory_order_relaxed)),
                        slot.from_m.load(std::memory_order_relaxed), slot.soft_error.load(std::memory_order_relaxed)};
  }
  return {};
}

SurfaceLight LightTable::add(std::uint64_t group, std::uint64_t key, const SurfaceLight& light) {
  const std::uint64_t soft = pack(light.soft), hard = pack(light.hard);
  const SurfaceLight held_light{unpack(soft), unpack(hard), light.from_m, light.soft_error};
  const std::uint64_t page_index = page_of(group);
  Slot* page = &slots_[page_index * kPage];
  if (!is_used_[page_index].exchange(true, std::memory_order_relaxed)) ++used_pages_;
  for (int probe = 0; probe < kProbes; ++probe) {
    Slot& slot = page[(key + probe) % kPage];
    std::uint64_t held = 0;
    if (slot.key.compare_exchange_strong(held, key, std::memory_order_relaxed)) {
      slot.hard.store(hard, std::memory_order_relaxed);
      slot.from_m.store(light.from_m, std::memory_order_relaxed);
      slot.soft_error.store(light.soft_error, std::memory_order_relaxed);
      slot.soft.store(soft, std::memory_order_release);
      points_.fetch_add(1, std::memory_order_relaxed);
      return held_light;
    }
    if (held == key) return held_light;  // another thread was first
  }
  turned_away_.fetch_add(1, std::memory_order_relaxed);
  return held_light;
}

}  // namespace dualpixel::simulator
