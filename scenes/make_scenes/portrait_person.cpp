#include "scenes/make_scenes/portrait_person.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/make_scenes/portrait_face.h"
#include "scenes/make_scenes/portrait_hair.h"
#include "scenes/make_scenes/sdf_mesh.h"
#include "scenes/math.h"
#include "scenes/procedural/signed_distance.h"
#include "scenes/test_targets/noise.h"

namespace dualpixel::scenes {
namespace {

/// The middle of the head, between the ears. Shapes of the person are given relative to it, z towards the camera.
const vec3 kHead(0.01f, 0.075f, -0.86f);

vec3 mirrored(vec3 p) { return {-p.x, p.y, p.z}; }

float clothes(vec3 p) {
  const vec3 s(std::abs(p.x), p.y, p.z);
  float d = sdf_capsule(s, {0.0f, -0.215f, -0.04f}, {0.155f, -0.245f, -0.04f}, 0.06f, 0.062f);
  d = sdf_union(d, sdf_ellipsoid(p, {0, -0.41f, -0.04f}, {0.168f, 0.255f, 0.115f}), 0.09f);
  d = sdf_union(d, sdf_capsule(s, {0.165f, -0.25f, -0.04f}, {0.222f, -0.47f, 0.0f}, 0.056f, 0.046f), 0.012f);
  d = sdf_union(d, sdf_capsule(p, {0.215f, -0.44f, 0.03f}, {0.128f, -0.318f, 0.125f}, 0.042f, 0.033f), 0.03f);
  d = sdf_union(d, sdf_capsule(p, {-0.215f, -0.44f, 0.03f}, {-0.06f, -0.405f, 0.125f}, 0.042f, 0.033f), 0.03f);
  const float collar = std::abs(sdf_capsule(p, {0, -0.13f, -0.03f}, {0, -0.19f, -0.036f}, 0.064f, 0.077f)) - 0.006f;
  d = sdf_union(d, std::max(collar, std::abs(p.y + 0.168f + 0.25f * p.z) - 0.02f), 0.012f);
  d = sdf_subtract(d, sdf_capsule(p, {0, -0.05f, -0.03f}, {0, -0.172f, -0.034f}, 0.056f, 0.063f), 0.008f);
  const float folds = value_noise(81, vec3(p.x * 16 + 3 * value_noise(83, p * 9.0f), p.y * 7, p.z * 10));
  return d + 0.009f * (folds - 0.5f) + 0.002f * (value_noise(82, p * 40.0f) - 0.5f);
}

struct Finger {
  vec3 knuckle, middle, last, tip;  ///< joints, and the end
  float thick;                      ///< over the others' thickness
};

/// From the little finger, 0, to the forefinger, 3; straight at a curl of 0.
Finger finger(int i, float curl) {
  const float x = -0.03f + 0.02f * static_cast<float>(i);
  const float length = i == 0 ? 0.026f : i == 3 ? 0.032f : 0.037f;
  const vec3 knuckle(x, 0.036f - 10 * x * x, 0);
  const vec3 middle = knuckle + vec3(0.1f * x, length, 0.3f * curl * length);
  const vec3 last = middle + vec3(0.05f * x, 0.55f * length * (1 - 0.4f * curl), 0.55f * curl * length);
  const vec3 tip = last + vec3(0.02f * x, 0.42f * length * (1 - 0.6f * curl), 0.5f * curl * length);
  return {knuckle, middle, last, tip, i == 0 ? 0.86f : 1.0f};
}

/// A hand at the origin, palm facing +z, fingers up; `curl` bends them.
float hand(vec3 p, float curl) {
  float d = sdf_ellipsoid(p, {0, 0, 0}, {0.039f, 0.044f, 0.0145f});
  d = sdf_union(d, sdf_ellipsoid(p, {0.022f, -0.012f, 0.008f}, {0.017f, 0.026f, 0.012f}), 0.01f);  // ball of the thumb
  for (int i = 0; i < 4; ++i) {
    const Finger f = finger(i, curl);
    d = sdf_union(d, sdf_capsule(p, f.knuckle, f.middle, 0.0099f * f.thick, 0.0087f * f.thick), 0.006f);
    d = sdf_union(d, sdf_capsule(p, f.middle, f.last, 0.0087f * f.thick, 0.0078f * f.thick), 0.001f);
    d = sdf_union(d, sdf_capsule(p, f.last, f.tip, 0.0078f * f.thick, 0.0068f * f.thick), 0.001f);
  }
  d = sdf_union(d, sdf_capsule(p, {0.03f, -0.018f, 0.004f}, {0.062f, 0.014f, 0.014f}, 0.0125f, 0.0102f), 0.01f);
  d = sdf_union(d, sdf_capsule(p, {0.062f, 0.014f, 0.014f}, {0.07f, 0.044f, 0.016f}, 0.0102f, 0.008f), 0.004f);
  d = sdf_union(d, sdf_capsule(p, {0, -0.03f, -0.002f}, {0, -0.1f, -0.02f}, 0.025f, 0.028f), 0.02f);
  return d + 0.0004f * (value_noise(91, p * 190.0f) - 0.5f);
}

/// What the skin's color is multiplied by: nails and joints of the four fingers.
vec3 hand_tint(vec3 p, float curl) {
  vec3 color(0.95f, 0.9f, 0.88f);
  for (int i = 0; i < 4; ++i) {
    const Finger f = finger(i, curl);
    const vec3 along = glm::normalize(f.tip - f.last), back = glm::normalize(glm::cross(along, vec3(1, 0, 0)));
    const vec3 q = p - (f.tip - 0.001f * along);
    const float across = q.x / (0.0050f * f.thick), down = glm::dot(q, along) / 0.0072f;
    const float inside = 1 - std::sqrt(std::pow(across, 4.0f) + std::pow(down, 4.0f));
    if (glm::dot(q, back) > 0.002f) {
      color *= glm::mix(vec3(1), vec3(1, 0.8f, 0.79f), std::clamp(6 * inside, 0.0f, 1.0f));
    }
    for (const vec3& joint : {f.knuckle, f.middle}) {
      color *= glm::mix(vec3(1), vec3(1, 0.9f, 0.88f), std::exp(-glm::dot(p - joint, p - joint) / (0.013f * 0.013f)));
    }
  }
  return color;
}

/// An eye that looks along `pole`: a ball with a cornea that bulges and curves more, so that it reflects the sun as a
/// small highlight.
Mesh eyeball(vec3 center, float radius, vec3 pole) {
  Mesh mesh;
  const vec3 x = glm::normalize(glm::cross(vec3(0, 1, 0), pole)), y = glm::cross(pole, x);
  constexpr unsigned kRows = 24, kColumns = 48;
  constexpr float kCornea_m = 0.0012f, kWidth2 = 0.42f * 0.42f;  // a Gaussian of the angle from the pole
  for (unsigned i = 0; i <= kRows; ++i) {
    for (unsigned j = 0; j <= kColumns; ++j) {
      const float theta = kPi * i / kRows, phi = 2 * kPi * j / kColumns;
      const vec3 across = std::cos(phi) * x + std::sin(phi) * y;
      const vec3 n = std::cos(theta) * pole + std::sin(theta) * across;
      const vec3 along = std::cos(theta) * across - std::sin(theta) * pole;  // how n changes with theta
      const float cornea = kCornea_m * std::exp(-theta * theta / kWidth2), r = radius + cornea;
      mesh.positions.push_back(center + r * n);
      mesh.normals.push_back(glm::normalize(r * n + 2 * theta / kWidth2 * cornea * along));
      mesh.uvs.push_back({0.5f + 0.5f * static_cast<float>(i) / kRows * std::cos(phi),
                          0.5f + 0.5f * static_cast<float>(i) / kRows * std::sin(phi)});
    }
  }
  for (unsigned i = 0; i < kRows; ++i) {
    for (unsigned j = 0; j < kColumns; ++j) {
      const unsigned a = i * (kColumns + 1) + j, b = a + kColumns + 1;
      if (i + 1 < kRows) mesh.triangles.push_back({a, b, b + 1});
      if (i > 0) mesh.triangles.push_back({a, b + 1, a + 1});
    }
  }
  return mesh;
}

void add_eyes(Glb& glb, const glm::mat4& to_head) {
  const Texture iris = noise_texture(203, 512, 8, 128, 0.8f, [](float n, float u, float v) {
    const float r = 2 * std::hypot(u - 0.5f, v - 0.5f),
                rays = value_noise(206, vec3(std::atan2(v - 0.5f, u - 0.5f) * 14, r * 9, 0));
    if (r < 0.058f) return vec3(0.006f);
    const vec3 color = glm::mix(vec3(0.045f, 0.026f, 0.013f), vec3(0.2f, 0.12f, 0.055f), 0.4f * n + 0.6f * rays);
    if (r < 0.143f) return color * std::clamp((0.145f - r) / 0.02f, 0.3f, 1.0f);
    const float rim = std::clamp((r - 0.113f) / 0.05f, 0.5f, 1.0f), corner = std::clamp(1.25f - 1.4f * r, 0.6f, 1.0f);
    return rim * corner * glm::mix(vec3(0.44f, 0.37f, 0.34f), vec3(0.53f, 0.47f, 0.44f), n);
  });
  const int material = glb.add_material(glb.add_texture(iris), vec3(1), false, 0.12f);
  for (const float side : {-1.0f, 1.0f}) {
    const vec3 gaze = glm::normalize(vec3(0.146f - 0.039f * side, -0.10f, 1));
    glb.add_node("eye", placed_mesh(eyeball({side * kEye.x, kEye.y, kEye.z}, kEyeRadius_m, gaze), to_head), material,
                 true);
  }
}

void add_head(Glb& glb, const glm::mat4& to_head, int skin_material) {
  const Mesh head = mesh_sdf(portrait_head, {-0.1f, -0.21f, -0.125f}, {0.1f, 0.15f, 0.125f}, 0.0012f, 0.11f);
  std::vector<vec3> colors;
  for (const vec3& p : head.positions) colors.push_back(skin_tint(p));
  glb.add_colored_person("head", placed_mesh(head, to_head), colors, skin_material);
  add_eyes(glb, to_head);
  const Texture brown = two_tone(205, {0.016f, 0.009f, 0.005f}, {0.16f, 0.09f, 0.048f}, 4, 512, 0.9f);
  const int hair_material = glb.add_material(glb.add_texture(brown), vec3(1), false, 0.55f);
  glb.add_node("scalp",
               placed_mesh(mesh_sdf(scalp, {-0.1f, -0.08f, -0.13f}, {0.1f, 0.16f, 0.12f}, 0.0025f, 0.05f), to_head),
               hair_material, true);
  glb.add_node("hair", placed_mesh(hair_strands(), to_head), hair_material, true);
  glb.add_node("brows", placed_mesh(brow_hairs(), to_head), hair_material, true);
  glb.add_node("lashes", placed_mesh(lashes(), to_head),
               glb.add_material(-1, vec3(0.006f, 0.004f, 0.003f), false, 0.6f), true);
}

void add_clothes(Glb& glb, const glm::mat4& to_body) {
  const Texture wool = noise_texture(221, 1024, 8, 256, 0.85f, [](float n, float u, float v) {
    const float warp = std::sin(2 * kPi * (u * 40 + 0.6f * n)), weft = std::sin(2 * kPi * (v * 60 + 0.6f * n));
    const float thread = std::clamp(0.5f + 0.3f * warp * weft + 0.5f * (n - 0.5f), 0.0f, 1.0f);
    const bool stripe = std::fmod(v * 5, 1.0f) < 0.22f;
    return stripe ? glm::mix(vec3(0.4f, 0.36f, 0.28f), vec3(0.8f, 0.75f, 0.62f), thread)
                  : glm::mix(vec3(0.012f, 0.03f, 0.065f), vec3(0.08f, 0.16f, 0.27f), thread);
  });
  glb.add_node("jumper",
               placed_mesh(mesh_sdf(clothes, {-0.32f, -0.6f, -0.18f}, {0.32f, -0.1f, 0.2f}, 0.0045f, 0.1f), to_body),
               glb.add_material(glb.add_texture(wool), vec3(1), false), true);
}

void add_hand(Glb& glb, const std::string& name, const glm::mat4& pose, bool left, float curl, int material) {
  const Mesh mesh = mesh_sdf([&](vec3 p) { return hand(left ? mirrored(p) : p, curl); }, {-0.085f, -0.13f, -0.06f},
                             {0.085f, 0.12f, 0.075f}, 0.0018f, 0.11f);
  std::vector<vec3> colors;
  for (const vec3& p : mesh.positions) colors.push_back(hand_tint(left ? mirrored(p) : p, curl));
  glb.add_colored_person(name, placed_mesh(mesh, pose), colors, material);
}

}  // namespace

void add_portrait_person(Glb& glb) {
  const glm::mat4 to_head = glm::rotate(glm::translate(glm::mat4(1), kHead), -0.16f, vec3(0, 1, 0));
  const glm::mat4 to_body = glm::translate(glm::mat4(1), kHead);
  const Texture skin = noise_texture(201, 1024, 16, 512, 0.93f, [](float n, float, float) {
    return glm::mix(vec3(0.595f, 0.345f, 0.23f), vec3(0.655f, 0.4f, 0.275f), n);
  });
  const int skin_material = glb.add_material(glb.add_texture(skin), vec3(1), false, 0.55f);
  add_head(glb, to_head, skin_material);
  add_clothes(glb, glm::translate(to_body, vec3(0, 0.02f, 0)));
  const auto hand_pose = [&](vec3 at, float lean, float turn) {
    return glm::rotate(glm::rotate(to_body * glm::translate(glm::mat4(1), at), lean, vec3(0, 0, 1)), turn,
                       vec3(0, 1, 0));
  };
  add_hand(glb, "right hand", hand_pose({0.085f, -0.235f, 0.16f}, 0.5f, 2.6f), false, 0.35f, skin_material);
  add_hand(glb, "left hand", hand_pose({-0.01f, -0.39f, 0.155f}, -1.25f, 0.25f), true, 0.7f, skin_material);
}

}  // namespace dualpixel::scenes
