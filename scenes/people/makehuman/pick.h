#pragma once
#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "scenes/procedural/random_stream.h"

namespace dualpixel::scenes {

/// A random asset of a kind, of the group `wanted` where this set has any (see assets.h); null where there
/// is none of the kind.
template <typename T, typename GroupOf>
const T* pick(RandomStream& rng, const std::vector<T>& kind, GroupOf group_of, int wanted) {
  std::map<int, int> sizes, before;
  for (const T& asset : kind) ++sizes[group_of(asset)];
  std::vector<const T*> any, own, fitting;
  for (const T& asset : kind) {
    const int group = group_of(asset), n = sizes[group];
    const bool held_out = n > 1 && before[group]++ >= n - std::max(n / 5, 1);
    any.push_back(&asset);
    if (held_out != rng.held_out()) continue;
    own.push_back(&asset);
    if (group == wanted) fitting.push_back(&asset);
  }
  const std::vector<const T*>& from = !fitting.empty() ? fitting : !own.empty() ? own : any;
  return from.empty() ? nullptr : from[static_cast<std::size_t>(rng.below(static_cast<int>(from.size())))];
}
template <typename T>
const T* pick(RandomStream& rng, const std::vector<T>& kind) {
  return pick(
      rng, kind, [](const T&) { return 0; }, 0);
}

inline bool is_for_women(const std::string& name) { return name.find("female") != std::string::npos; }

}  // namespace dualpixel::scenes
