#include "scenes/people/makehuman/morphed_body.h"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "capture/error.h"
#include "scenes/people/makehuman/body_parts.h"

namespace dualpixel::scenes {
namespace {

constexpr float kLeastEyes_m = 0.03f, kMostEyes_m = 0.09f;

std::vector<std::string> joint_names() {
  std::vector<std::string> names = {"neck", "jaw"};
  for (const char* side : {"l-", "r-"}) {
    for (const char* joint : {"eye", "shoulder", "elbow", "hand", "upper-leg", "knee", "ankle"})
      names.push_back(std::string(side) + joint);
    for (int finger = 0; finger < kFingers; ++finger) {
      for (int bone = 0; bone < kPhalanges; ++bone)
        names.push_back(fmt::format("{}finger-{}-{}", side, finger + 2, bone + 1));
    }
  }
  return names;
}

}  // namespace

void require_human_sizes(const MorphedBody& body, const std::string& whose) {
  const float eyes_m = glm::distance(body.joint("l-eye"), body.joint("r-eye"));
  if (!(eyes_m >= kLeastEyes_m && eyes_m <= kMostEyes_m)) {
    throw InputError(fmt::format("{}: the eyes are {:.3f} m apart; {} to {} m is allowed", whose, eyes_m, kLeastEyes_m,
                                 kMostEyes_m));
  }
  for (const int v : body.base->body.vertex) {
    const vec3 p = body.rest[static_cast<std::size_t>(v)];
    const float aside_m = std::max(std::abs(p.x), std::abs(p.z));
    if (!(aside_m <= 1.5f)) {
      throw InputError(fmt::format("{}: the body reaches {:.2f} m aside; up to 1.5 m is allowed", whose, aside_m));
    }
  }
}

void require_limbs(const MorphedBody& body, const std::string& whose) {
  vec3 low(1e9f), high(-1e9f);
  for (const int v : body.base->body.vertex) {
    low = glm::min(low, body.rest[static_cast<std::size_t>(v)]);
    high = glm::max(high, body.rest[static_cast<std::size_t>(v)]);
  }
  constexpr float kAbout_m = 0.1f;
  for (const std::string& name : joint_names()) {
    const vec3 at = body.joint(name);
    if (at == glm::clamp(at, low - kAbout_m, high + kAbout_m)) continue;
    throw InputError(
        fmt::format("{}: joint-{} is at {:.2f}, {:.2f}, {:.2f} m; at most {} m outside the body is allowed", whose,
                    name, at.x, at.y, at.z, kAbout_m));
  }

  constexpr float kShortest_m = 0.01f, kMostUnlike = 2;
  const auto require = [&](float length_m, const std::string& what) {
    if (length_m >= kShortest_m) return;
    throw InputError(fmt::format("{}: {} is {:.4f} m; {} m or more is allowed", whose, what, length_m, kShortest_m));
  };
  constexpr const char* kLimbs[][3] = {{"shoulder", "elbow", "hand"}, {"upper-leg", "knee", "ankle"}};
  for (const std::string side : {"l-", "r-"}) {
    const auto length_m = [&](const char* from, const char* to) {
      return glm::distance(body.joint(side + from), body.joint(side + to));
    };
    for (const auto& [from, middle, to] : kLimbs) {
      const float first_m = length_m(from, middle), second_m = length_m(middle, to);
      require(first_m, fmt::format("from {0}{1} to {0}{2}", side, from, middle));
      require(second_m, fmt::format("from {0}{1} to {0}{2}", side, middle, to));
      if (std::max(first_m, second_m) <= kMostUnlike * std::min(first_m, second_m)) continue;
      throw InputError(
          fmt::format("{0}: from {1}{2} to {1}{3} is {4:.3f} m, to {1}{5} {6:.3f} m; one may be {7} times "
                      "the other at most",
                      whose, side, from, middle, first_m, to, second_m, kMostUnlike));
    }
    require(length_m("hand", "finger-3-1"), fmt::format("from {0}hand to {0}finger-3-1", side));
    const vec3 along = glm::normalize(body.joint(side + "finger-3-1") - body.joint(side + "hand"));
    const vec3 across = body.joint(side + "finger-2-1") - body.joint(side + "finger-5-1");
    require(glm::length(across - along * glm::dot(across, along)), fmt::format("across {}hand it", side));
  }
}

void require_a_body(const BaseMesh& base, const std::string& path) {
  for (const std::string& name : joint_names()) {
    if (base.joints.count("joint-" + name) == 0)
      throw InputError(fmt::format("{}: no group 'joint-{}'", printable(path), name));
  }
  float low = 1e9f, high = -1e9f;
  for (const int v : base.body.vertex) {
    low = std::min(low, base.positions[static_cast<std::size_t>(v)].y);
    high = std::max(high, base.positions[static_cast<std::size_t>(v)].y);
  }
  if (high - low < 1 || high - low > 2.5f) {
    throw InputError(fmt::format("{}: the body is {:.2f} m high; 1 to 2.5 m is allowed (a unit is 10 cm)",
                                 printable(path), high - low));
  }
  const MorphedBody body{base.positions, &base};
  require_human_sizes(body, printable(path));
  require_limbs(body, printable(path));
}

}  // namespace dualpixel::scenes
