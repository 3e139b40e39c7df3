#include "scenes/make_scenes/portrait_hair.h"

#include <algorithm>
#include <cmath>

#include "scenes/make_scenes/portrait_face.h"
#include "scenes/make_scenes/sdf_mesh.h"
#include "scenes/procedural/signed_distance.h"
#include "scenes/test_targets/noise.h"

namespace dualpixel::scenes {
namespace {

constexpr float kPi = 3.14159265358979f;

float cranium(vec3 p) { return sdf_ellipsoid(p, kSkullCenter, kSkullRadii); }

/// Where hair grows: not on the face, not under the ears' height.
bool on_scalp(vec3 p) {
  const float hairline = 0.082f + 0.005f * std::sin(p.x * 60) - 6.0f * p.x * p.x;
  if (p.z > 0.03f) return p.y > hairline - 0.9f * (0.078f - p.z) * (std::abs(p.x) > 0.045f ? 1 : 0);
  return p.y > -0.03f - 0.3f * p.z && !(p.z > -0.03f && p.y < 0.03f);
}

/// A tapered ribbon through the points that are added, its flat side towards each `normal`.
class Ribbon {
 public:
  Ribbon(Mesh& mesh, float width_m, float shade, int segments)
      : mesh_(mesh), width_m_(width_m), shade_(shade), segments_(segments) {}

  void add(vec3 p, vec3 direction, vec3 normal) {
    const float t = static_cast<float>(added_) / static_cast<float>(segments_);
    const vec3 side = glm::normalize(glm::cross(direction, normal)) * width_m_ * (1 - 0.85f * t * t);
    for (const vec3& q : {p - side, p + side}) {
      mesh_.positions.push_back(q);
      mesh_.normals.push_back(normal);
      mesh_.uvs.push_back({shade_, t});
    }
    const auto end = static_cast<unsigned>(mesh_.positions.size());
    if (added_++ == 0) return;
    mesh_.triangles.push_back({end - 4, end - 3, end - 1});
    mesh_.triangles.push_back({end - 4, end - 1, end - 2});
  }

 private:
  Mesh& mesh_;
  float width_m_, shade_;
  int segments_, added_ = 0;
};

/// Which way hair is combed at a point: away from a parting on the left, forward over the forehead, down at the sides.
vec3 combed(vec3 p) {
  const float side = 0.8f * std::clamp((p.x + 0.025f) / 0.012f, -1.0f, 1.0f);
  const float down = std::clamp((0.1f - p.y) * 8, 0.0f, 1.0f);
  return glm::normalize(vec3(side * (1 - 0.6f * down), -0.1f - 0.9f * down, p.z > 0.02f ? 0.35f * (1 - down) : -0.3f));
}

void add_strand(Mesh& mesh, int i, vec3 root) {
  constexpr int kSegments = 7;
  const bool stray = scene_hash01(103, i) < 0.02f;
  const auto random = [&](int k) { return scene_hash01(k, i) - 0.5f; };
  const vec3 outward = glm::normalize(root - kSkullCenter);
  const float length = (stray ? 0.045f : 0.052f) * (0.55f + 0.9f * scene_hash01(107, i));
  const float lift = 0.003f + 0.018f * scene_hash01(113, i) * scene_hash01(114, i);
  vec3 p = root;
  vec3 direction =
      glm::normalize(combed(p) + 0.35f * vec3(random(104), random(105), random(106)) + (stray ? 0.7f : 0.3f) * outward);
  Ribbon ribbon(mesh, 0.00013f + 0.00014f * scene_hash01(108, i), scene_hash01(109, i), kSegments);
  for (int s = 0; s <= kSegments; ++s) {
    const float t = static_cast<float>(s) / kSegments;
    const vec3 normal = glm::normalize(p - kSkullCenter);
    ribbon.add(p, direction, normal);
    const vec3 wander(value_noise(110, p * 40.0f) - 0.5f, value_noise(111, p * 40.0f) - 0.5f,
                      value_noise(112, p * 40.0f) - 0.5f);
    direction = glm::normalize(direction + 0.25f * combed(p) + 0.45f * wander + (stray ? 0.15f * normal : vec3(0)));
    p += direction * (length / kSegments);
    const float above = cranium(p) - lift * (0.4f + 0.6f * t);
    if (above < 0 || !stray) p -= (above < 0 ? 1.0f : 0.7f) * above * glm::normalize(p - kSkullCenter);
  }
}

}  // namespace

float scalp(vec3 p) {
  const float lifted = cranium(p) - 0.002f - 0.002f * value_noise(95, p * 60.0f);
  return on_scalp(p) ? lifted : std::max(lifted, 0.004f);
}

Mesh hair_strands() {
  constexpr int kTried = 42000;
  Mesh mesh;
  for (int i = 0; i < kTried; ++i) {
    const float z = 2 * scene_hash01(101, i) - 1, phi = 2 * kPi * scene_hash01(102, i);
    const float r = std::sqrt(1 - z * z);
    const vec3 root = kSkullCenter + (kSkullRadii + 0.001f) * vec3(r * std::cos(phi), z, r * std::sin(phi));
    if (on_scalp(root)) add_strand(mesh, i, root);
  }
  return mesh;
}

Mesh brow_hairs() {
  constexpr int kHairs = 520, kSegments = 3;
  Mesh mesh;
  for (int i = 0; i < kHairs; ++i) {
    const float side = i % 2 ? 1.0f : -1.0f, t = scene_hash01(211, i), across = scene_hash01(212, i) - 0.5f;
    const float x = 0.0135f + 0.036f * t - 0.008f * (1 - t) * scene_hash01(217, i);  // no straight inner end
    const float arch = 0.0335f + 0.0062f * std::sin(2.1f * t) - 0.0045f * t * t;
    const float height = 0.0046f * (1 - 0.65f * t) * std::min(0.5f + 2 * t, 1.0f);  // half of it at the inner end
    const float y = arch + height * across;
    vec3 p = on_face(side * x, y);
    vec3 direction = glm::normalize(vec3(side * (0.55f + 0.5f * t), 0.75f - 1.15f * t - 0.5f * across, 0.15f) +
                                    0.25f * vec3(scene_hash01(214, i) - 0.5f, scene_hash01(215, i) - 0.5f, 0));
    Ribbon ribbon(mesh, 0.00012f, 0.2f + 0.7f * scene_hash01(213, i), kSegments);
    for (int s = 0; s <= kSegments; ++s) {
      ribbon.add(p, direction, glm::normalize(vec3(0.4f * side * t, 0.1f, 1)));
      p += direction * (0.0075f * (0.7f + 0.5f * scene_hash01(216, i)) / kSegments);
      p.z = std::max(p.z, on_face(p.x, p.y).z + 0.0004f);
    }
  }
  return mesh;
}

Mesh lashes() {
  constexpr int kLashes = 110, kSegments = 4;
  Mesh mesh;
  for (int i = 0; i < 2 * kLashes; ++i) {
    const int along = i / 2;
    const float side = i % 2 ? 1.0f : -1.0f;
    const float x = 0.88f * kEyeHalfWidth_m * (2 * (static_cast<float>(along) + scene_hash01(221, i)) / kLashes - 1);
    const float y = upper_lid_m(x);
    const float z = std::sqrt(std::max(kLidRadius_m * kLidRadius_m - x * x - y * y, 0.0f));
    vec3 p = vec3(side * (kEye.x + x), kEye.y + y, kEye.z + z);
    vec3 direction = glm::normalize(vec3(side * (45 * x + 0.5f * (scene_hash01(222, i) - 0.5f)), -0.25f, 1));
    Ribbon ribbon(mesh, 0.00007f, 0, kSegments);
    for (int s = 0; s <= kSegments; ++s) {
      ribbon.add(p, direction, {0, 1, 0.2f});
      direction = glm::normalize(direction + vec3(0, 0.38f, 0));
      p += direction * (0.006f * (0.7f + 0.5f * scene_hash01(223, i)) / kSegments);
    }
  }
  return mesh;
}

}  // namespace dualpixel::scenes
