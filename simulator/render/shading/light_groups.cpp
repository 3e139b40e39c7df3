#include "simulator/render/shading/light_groups.h"

#include <algorithm>

namespace dualpixel::simulator {
namespace {

glm::vec3 middle_of(const LightSource& light) { return 0.5f * (light.low + light.high); }

struct Bounds {
  glm::vec3 low{0}, high{0};
};

Bounds bounds_of_middles(const std::vector<LightSource>& lights, const LightGroup& group) {
  Bounds bounds{middle_of(lights[group.first]), middle_of(lights[group.first])};
  for (std::size_t i = group.first; i < group.end; ++i) {
    bounds.low = glm::min(bounds.low, middle_of(lights[i])), bounds.high = glm::max(bounds.high, middle_of(lights[i]));
  }
  return bounds;
}

LightGroup group_of(const std::vector<LightSource>& lights, std::size_t first, std::size_t end) {
  LightGroup group{first, end};
  glm::vec3 low = lights[first].low, high = lights[first].high;
  for (std::size_t i = first; i < end; ++i) {
    low = glm::min(low, lights[i].low), high = glm::max(high, lights[i].high);
    group.candela += lights[i].candela, group.average_lux += lights[i].average_lux;
  }
  group.center = 0.5f * (low + high);
  for (std::size_t i = first; i < end; ++i) {
    const glm::vec3 farthest = glm::max(lights[i].high - group.center, group.center - lights[i].low);
    group.radius_m = std::max(group.radius_m, glm::length(farthest));
  }
  return group;
}

/// How badly one place stands for all of its lights.
float spread_of(const std::vector<LightSource>& lights, const LightGroup& group) {
  const Bounds bounds = bounds_of_middles(lights, group);
  const glm::vec3 size = bounds.high - bounds.low;
  return group.candela * glm::dot(size, size);
}

/// Sorts lights by the half of the group that they lie in, along its longest side; returns where the second begins.
std::size_t halve(std::vector<LightSource>& lights, const LightGroup& group) {
  const Bounds bounds = bounds_of_middles(lights, group);
  const glm::vec3 size = bounds.high - bounds.low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const float at = 0.5f * (bounds.low[axis] + bounds.high[axis]);
  const auto half = std::stable_partition(lights.begin() + static_cast<std::ptrdiff_t>(group.first),
                                          lights.begin() + static_cast<std::ptrdiff_t>(group.end),
                                          [&](const LightSource& light) { return middle_of(light)[axis] < at; });
  return static_cast<std::size_t>(half - lights.begin());
}

}  // namespace

std::vector<LightGroup> group_lights(std::vector<LightSource>& lights, std::size_t most) {
  if (lights.empty()) return {};
  std::vector<LightGroup> groups{group_of(lights, 0, lights.size())};
  std::vector<float> spreads{spread_of(lights, groups[0])};
  while (groups.size() < most) {
    const auto widest = static_cast<std::size_t>(std::max_element(spreads.begin(), spreads.end()) - spreads.begin());
    if (!(spreads[widest] > 0)) break;
    const LightGroup whole = groups[widest];
    const std::size_t middle = halve(lights, whole);
    spreads[widest] = 0;  // unless it is halved: its lights may lie closer than numbers tell apart
    if (middle == whole.first || middle == whole.end) continue;
    groups[widest] = group_of(lights, whole.first, middle);
    groups.push_back(group_of(lights, middle, whole.end));
    spreads[widest] = spread_of(lights, groups[widest]);
    spreads.push_back(spread_of(lights, groups.back()));
  }
  return groups;
}

}  // namespace dualpixel::simulator
