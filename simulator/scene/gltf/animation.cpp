#include "simulator/scene/gltf/animation.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/gtc/quaternion.hpp>

#include "capture/error.h"
#include "simulator/scene/gltf/accessor.h"
#include "simulator/scene/gltf/check.h"

namespace dualpixel::simulator {
namespace {

glm::dquat quaternion(const float* q) { return glm::normalize(glm::dquat(q[3], q[0], q[1], q[2])); }

/// A sampler's value at `time_s` (glTF 2.0, section 3.11): 4 numbers of a rotation, x, y, z, w; otherwise 3.
std::vector<double> value_at(const GltfFile& file, const tinygltf::AnimationSampler& sampler, bool rotation,
                             double time_s) {
  const std::vector<float> times = read_floats(file, sampler.input), values = read_floats(file, sampler.output);
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (!(times[i] > times[i - 1])) {
      fail_gltf(file.name, fmt::format("/accessors/{}", sampler.input),
                fmt::format("entry {} is {}: times must increase", i, times[i]));
    }
  }
  const std::size_t size = rotation ? 4 : 3;
  for (std::size_t i = 0; rotation && i < values.size(); i += 4) {
    const float *q = &values[i], squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (!(squared > 1e-6f)) {
      fail_gltf(file.name, fmt::format("/accessors/{}", sampler.output),
                fmt::format("element {}: ({}, {}, {}, {}): must not be 0", i / 4, q[0], q[1], q[2], q[3]));
    }
  }
  const std::size_t next = std::upper_bound(times.begin(), times.end(), time_s) - times.begin();
  const std::size_t before = next == 0 ? 0 : next - 1, after = std::min(next, times.size() - 1);
  const bool between = before != after && sampler.interpolation != "STEP";
  const double share = between ? (time_s - times[before]) / (times[after] - times[before]) : 0;
  const float *from = &values[before * size], *to = &values[after * size];
  if (rotation) {
    const glm::dquat q = glm::slerp(quaternion(from), quaternion(to), share);
    return {q.x, q.y, q.z, q.w};
  }
  std::vector<double> value(size);
  for (std::size_t i = 0; i < size; ++i) value[i] = (1 - share) * from[i] + share * to[i];
  return value;
}

}  // namespace

std::vector<bool> pose_nodes(GltfFile& file, double time_s) {
  std::vector<bool> moved(file.model.nodes.size(), false);
  for (std::size_t i = 0; i < file.model.animations.size(); ++i) {
    const tinygltf::Animation& animation = file.model.animations[i];
    for (std::size_t j = 0; j < animation.channels.size(); ++j) {
      const tinygltf::AnimationChannel& channel = animation.channels[j];
      const tinygltf::AnimationSampler& sampler = animation.samplers[channel.sampler];
      if (channel.target_node < 0) continue;
      if (channel.target_path == "weights" || sampler.interpolation == "CUBICSPLINE") {
        file.warnings.push_back(fmt::format("{}: /animations/{}/channels/{}: {} is ignored", printable(file.name), i, j,
                                            channel.target_path == "weights" ? "animation of weights" : "CUBICSPLINE"));
        continue;
      }
      tinygltf::Node& node = file.model.nodes[channel.target_node];
      std::vector<double>& target = channel.target_path == "translation" ? node.translation
                                    : channel.target_path == "rotation"  ? node.rotation
                                                                         : node.scale;
      target = value_at(file, sampler, channel.target_path == "rotation", time_s);
      moved[channel.target_node] = true;
    }
  }
  return moved;
}

}  // namespace dualpixel::simulator
