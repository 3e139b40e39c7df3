#include "scenes/make_scenes/portrait_scene.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/make_scenes/sdf_mesh.h"
#include "scenes/procedural/signed_distance.h"
#include "scenes/test_targets/noise.h"

namespace dualpixel::scenes {
namespace {

// One file, and functions as long as they are: the compiler inlines by the size of a file, and where it inlines, the
// last bits of the shipped glTF file change.

constexpr float kPi = 3.14159265358979f;
/// The middle of the head, between the ears. Shapes of the person are given relative to it, z towards the camera.
const vec3 kHead(0.01f, 0.075f, -0.86f);

vec3 mirrored(vec3 p) { return {-p.x, p.y, p.z}; }

float portrait_skull(vec3 p) { return sdf_ellipsoid(p, kSkullCenter, kSkullRadii); }

/// Head and neck without hair.
float head(vec3 p) {
  const vec3 s(std::abs(p.x), p.y, p.z);  // the face is symmetric, near enough
  float d = portrait_skull(p);
  d = sdf_union(d, sdf_ellipsoid(p, {0, -0.045f, 0.02f}, {0.056f, 0.062f, 0.066f}), 0.05f);          // jaw
  d = sdf_union(d, sdf_ellipsoid(s, {0.04f, -0.018f, 0.056f}, {0.027f, 0.025f, 0.024f}), 0.03f);     // cheeks
  d = sdf_union(d, sdf_ellipsoid(s, {0.024f, 0.036f, 0.077f}, {0.027f, 0.008f, 0.013f}), 0.02f);     // brows
  d = sdf_subtract(d, sdf_ellipsoid(s, {0.031f, 0.016f, 0.098f}, {0.020f, 0.013f, 0.02f}), 0.016f);  // sockets
  const float eye = glm::length(s - vec3(0.031f, 0.0148f, 0.0715f)) - 0.0134f;
  const float upper_lid = std::max(eye, 0.0035f - (p.y - 0.0148f)), lower_lid = std::max(eye, p.y - 0.0148f + 0.0055f);
  d = sdf_union(d, std::min(upper_lid, lower_lid), 0.004f);                                               // lids
  d = sdf_union(d, sdf_capsule(p, {0, 0.022f, 0.078f}, {0, -0.018f, 0.098f}, 0.0075f, 0.0105f), 0.012f);  // nose
  d = sdf_union(d, sdf_ellipsoid(s, {0.0115f, -0.0235f, 0.088f}, {0.0085f, 0.007f, 0.0095f}), 0.006f);    // wings
  d = sdf_subtract(d, sdf_ellipsoid(s, {0.0065f, -0.0305f, 0.09f}, {0.0034f, 0.003f, 0.005f}), 0.003f);   // nostrils
  d = sdf_union(d, sdf_ellipsoid(p, {0, -0.0485f, 0.078f}, {0.023f, 0.0058f, 0.0105f}), 0.006f);          // upper lip
  d = sdf_union(d, sdf_ellipsoid(p, {0, -0.0605f, 0.077f}, {0.020f, 0.0066f, 0.0105f}), 0.006f);          // lower lip
  d = sdf_subtract(d, sdf_ellipsoid(p, {0, -0.0545f, 0.0905f}, {0.022f, 0.0011f, 0.006f}), 0.002f);       // mouth
  d = sdf_union(d, sdf_ellipsoid(p, {0, -0.088f, 0.063f}, {0.022f, 0.017f, 0.018f}), 0.02f);              // chin
  const float ear = sdf_subtract(sdf_ellipsoid(s, {0.081f, 0.002f, -0.012f}, {0.009f, 0.031f, 0.019f}),
                                 sdf_ellipsoid(s, {0.091f, 0.004f, -0.006f}, {0.007f, 0.021f, 0.011f}), 0.005f);
  d = sdf_union(d, ear, 0.008f);
  d = sdf_union(d, sdf_capsule(p, {0, -0.05f, -0.02f}, {0, -0.2f, -0.035f}, 0.048f, 0.056f), 0.03f);  // neck
  return d + 0.0006f * (value_noise(71, p * 160.0f) - 0.5f);
}

float clothes(vec3 p) {
  const vec3 s(std::abs(p.x), p.y, p.z);
  float d = sdf_capsule(s, {0.0f, -0.215f, -0.04f}, {0.155f, -0.245f, -0.04f}, 0.06f, 0.062f);
  d = sdf_union(d, sdf_ellipsoid(p, {0, -0.41f, -0.04f}, {0.19f, 0.25f, 0.115f}), 0.09f);
  d = sdf_union(d, sdf_capsule(s, {0.165f, -0.25f, -0.04f}, {0.235f, -0.47f, 0.0f}, 0.058f, 0.047f), 0.03f);
  d = sdf_union(d, sdf_capsule(p, {0.225f, -0.44f, 0.03f}, {0.128f, -0.318f, 0.125f}, 0.042f, 0.033f), 0.03f);
  d = sdf_union(d, sdf_capsule(p, {-0.225f, -0.44f, 0.03f}, {-0.06f, -0.405f, 0.125f}, 0.042f, 0.033f), 0.03f);
  const float collar = std::abs(sdf_capsule(p, {0, -0.13f, -0.03f}, {0, -0.19f, -0.036f}, 0.068f, 0.079f)) - 0.008f;
  d = sdf_union(d, std::max(collar, std::abs(p.y + 0.165f + 0.25f * p.z) - 0.024f), 0.012f);
  d = sdf_subtract(d, sdf_capsule(p, {0, -0.05f, -0.03f}, {0, -0.172f, -0.034f}, 0.058f, 0.064f), 0.008f);
  const float folds = value_noise(81, vec3(p.x * 16 + 3 * value_noise(83, p * 9.0f), p.y * 7, p.z * 10));
  return d + 0.009f * (folds - 0.5f) + 0.003f * (value_noise(82, p * 40.0f) - 0.5f);
}

/// A hand at the origin, palm facing +z, fingers up; `curl` bends them.
float hand(vec3 p, float curl) {
  float d = sdf_ellipsoid(p, {0, 0, 0}, {0.039f, 0.044f, 0.015f});
  for (int finger = 0; finger < 4; ++finger) {
    const float x = -0.03f + 0.02f * finger;
    const float length = finger == 0 ? 0.026f : finger == 3 ? 0.032f : 0.037f;
    const vec3 knuckle(x, 0.036f, 0);
    const vec3 middle = knuckle + vec3(0.1f * x, length, 0.3f * curl * length);
    const vec3 tip = middle + vec3(0.05f * x, length * (1 - 0.5f * curl), curl * length);
    d = sdf_union(d, sdf_capsule(p, knuckle, middle, 0.0098f, 0.0088f), 0.006f);
    d = sdf_union(d, sdf_capsule(p, middle, tip, 0.0088f, 0.0073f), 0.003f);
  }
  d = sdf_union(d, sdf_capsule(p, {0.03f, -0.018f, 0.004f}, {0.062f, 0.014f, 0.014f}, 0.0125f, 0.0105f), 0.01f);
  d = sdf_union(d, sdf_capsule(p, {0.062f, 0.014f, 0.014f}, {0.07f, 0.044f, 0.016f}, 0.0105f, 0.0085f), 0.004f);
  d = sdf_union(d, sdf_capsule(p, {0, -0.03f, -0.002f}, {0, -0.1f, -0.02f}, 0.026f, 0.028f), 0.02f);
  return d + 0.0008f * (value_noise(91, p * 190.0f) - 0.5f);
}

/// Where hair grows: not on the face, not under the ears' height.
bool on_scalp(vec3 p) {
  const float hairline = 0.078f + 0.006f * std::sin(p.x * 60);
  if (p.z > 0.03f) return p.y > hairline - 0.9f * (0.078f - p.z) * (std::abs(p.x) > 0.045f ? 1 : 0);
  return p.y > -0.03f - 0.3f * p.z && !(p.z > -0.03f && p.y < 0.03f);
}

float scalp(vec3 p) {
  const float lifted = portrait_skull(p) - 0.007f - 0.004f * value_noise(95, p * 30.0f);
  return on_scalp(p) ? lifted : std::max(lifted, 0.004f);
}

/// Thin ribbons that grow from the scalp, fall and stray.
Mesh hair_strands(int count) {
  Mesh mesh;
  for (int i = 0; i < count; ++i) {
    const float z = 2 * scene_hash01(101, i) - 1, phi = 2 * kPi * scene_hash01(102, i);
    const float r = std::sqrt(1 - z * z);
    const vec3 outward(r * std::cos(phi), z, r * std::sin(phi));
    vec3 p = vec3(0, 0.035f, -0.012f) + outward * vec3(0.081f, 0.104f, 0.1f);
    if (!on_scalp(p)) continue;
    const bool stray = scene_hash01(103, i) < 0.015f;
    // combed away from a parting on the left, close to the head
    const vec3 comb = vec3(p.x > -0.025f ? 0.8f : -0.8f, -0.1f, p.z > 0.02f ? 0.25f : -0.35f) +
                      0.5f * (vec3(scene_hash01(104, i), scene_hash01(105, i), scene_hash01(106, i)) - 0.5f);
    vec3 direction = glm::normalize(comb + (stray ? 0.6f : 0.25f) * outward);
    const float length = (stray ? 0.03f : 0.06f) * (0.6f + 0.8f * scene_hash01(107, i));
    const float lift = 0.009f + 0.008f * scene_hash01(113, i);
    constexpr int kSegments = 6;
    const float width = 0.00022f + 0.00025f * scene_hash01(108, i);
    const auto first = static_cast<unsigned>(mesh.positions.size());
    const float shade = scene_hash01(109, i);
    for (int s = 0; s <= kSegments; ++s) {
      const float t = static_cast<float>(s) / kSegments;
      const vec3 side = glm::normalize(glm::cross(direction, vec3(0.2f, 0.1f, 1))) * width * (1 - 0.8f * t * t);
      for (const vec3& q : {p - side, p + side}) {
        mesh.positions.push_back(kHead + q);
        mesh.normals.push_back(glm::normalize(q - vec3(0, 0.035f, -0.012f)));
        mesh.uvs.push_back({shade, t});
      }
      if (s > 0) {
        const unsigned a = first + 2 * (s - 1);
        mesh.triangles.push_back({a, a + 1, a + 3});
        mesh.triangles.push_back({a, a + 3, a + 2});
      }
      const vec3 wander(value_noise(110, p * 45.0f) - 0.5f, value_noise(111, p * 45.0f) - 0.5f,
                        value_noise(112, p * 45.0f) - 0.5f);
      direction = glm::normalize(direction + (stray ? vec3(0, 0.02f, 0) : vec3(0, -0.3f, 0)) + 0.5f * wander);
      p += direction * (length / kSegments);
      const float above = portrait_skull(p) - lift * (0.4f + 0.6f * t);
      if (above < 0 || !stray) p -= (above < 0 ? 1.0f : 0.6f) * above * glm::normalize(p - vec3(0, 0.035f, -0.012f));
    }
  }
  return mesh;
}

Mesh placed(Mesh mesh, const glm::mat4& pose) {
  for (vec3& p : mesh.positions) p = vec3(pose * glm::vec4(p, 1));
  for (vec3& n : mesh.normals) n = glm::normalize(glm::mat3(pose) * n);
  return mesh;
}

Mesh ball(vec3 center, float radius, vec3 pole) {
  Mesh mesh;
  const vec3 x = glm::normalize(glm::cross(vec3(0, 1, 0), pole)), y = glm::cross(pole, x);
  constexpr unsigned kRows = 24, kColumns = 48;
  for (unsigned i = 0; i <= kRows; ++i) {
    for (unsigned j = 0; j <= kColumns; ++j) {
      const float theta = kPi * i / kRows, phi = 2 * kPi * j / kColumns;
      const vec3 n = std::cos(theta) * pole + std::sin(theta) * (std::cos(phi) * x + std::sin(phi) * y);
      mesh.positions.push_back(center + radius * n);
      mesh.normals.push_back(n);
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

/// A leaf: a folded blade of six triangles from `base` along `along`, `length` meters.
void add_leaf(Mesh& mesh, std::uint32_t seed, int i, vec3 base, vec3 along, vec3 side, float length) {
  const vec3 up = glm::normalize(glm::cross(side, along));
  const float half = length * (0.2f + 0.1f * scene_hash01(seed + 1, i));
  const vec3 edge = glm::normalize(side + 0.35f * up) * half, other = glm::normalize(-side + 0.35f * up) * half;
  const vec3 droop = -0.18f * length * up;
  const vec3 points[7] = {base,
                          base + along * (0.35f * length) + edge,
                          base + along * (0.35f * length) + other,
                          base + along * (0.4f * length),
                          base + along * (0.72f * length) + 0.7f * edge + 0.4f * droop,
                          base + along * (0.72f * length) + 0.7f * other + 0.4f * droop,
                          base + along * length + droop};
  const unsigned faces[8][3] = {{0, 1, 3}, {0, 3, 2}, {1, 4, 3}, {3, 5, 2}, {3, 4, 6}, {3, 6, 5}, {0, 0, 0}, {0, 0, 0}};
  const auto first = static_cast<unsigned>(mesh.positions.size());
  const glm::vec2 corner(scene_hash01(seed + 2, i), scene_hash01(seed + 3, i));
  for (const vec3& p : points) {
    mesh.positions.push_back(p);
    mesh.normals.push_back(up);
    mesh.uvs.push_back(corner + 0.25f * glm::vec2(glm::dot(p - base, side), glm::dot(p - base, along)) / length);
  }
  for (int f = 0; f < 6; ++f) mesh.triangles.push_back({first + faces[f][0], first + faces[f][1], first + faces[f][2]});
}

/// `count` leaves near the surface of an ellipsoid.
void add_bush(Mesh& mesh, std::uint32_t seed, int count, vec3 center, vec3 radii, float leaf_m) {
  for (int i = 0; i < count; ++i) {
    const float z = 2 * scene_hash01(seed, i, 1) - 1, phi = 2 * kPi * scene_hash01(seed, i, 2),
                r = std::sqrt(1 - z * z);
    const vec3 outward(r * std::cos(phi), z, r * std::sin(phi));
    const float bumps = 0.75f + 0.5f * fractal_noise(seed + 9, outward * 3.0f + center, 1, 3, 0.6f);
    const vec3 base = center + outward * radii * bumps * std::pow(0.5f + 0.5f * scene_hash01(seed, i, 3), 0.4f);
    const vec3 random =
        vec3(scene_hash01(seed, i, 4), scene_hash01(seed, i, 5), scene_hash01(seed, i, 6)) * 2.0f - 1.0f;
    const vec3 along = glm::normalize(outward * 0.8f + random + vec3(0, -0.3f, 0));
    const vec3 side =
        glm::normalize(glm::cross(along, glm::normalize(outward + 0.7f * vec3(random.z, random.x, random.y))));
    add_leaf(mesh, seed + 20, i, base, along, side, leaf_m * (0.6f + 0.8f * scene_hash01(seed, i, 7)));
  }
}

/// A tapered, bent branch of eight sides.
void add_branch(Mesh& mesh, std::uint32_t seed, vec3 from, vec3 to, float radius_from, float radius_to) {
  constexpr unsigned kSides = 10, kRings = 24;
  const vec3 axis = glm::normalize(to - from);
  const vec3 x = glm::normalize(glm::cross(axis, std::abs(axis.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0)));
  const vec3 y = glm::cross(axis, x);
  const float length = glm::length(to - from);
  const auto first = static_cast<unsigned>(mesh.positions.size());
  for (unsigned ring = 0; ring <= kRings; ++ring) {
    const float t = static_cast<float>(ring) / kRings;
    const vec3 bend =
        0.06f * length *
        ((value_noise(seed, vec3(t * 4, 0, 0)) - 0.5f) * x + (value_noise(seed + 1, vec3(t * 4, 0, 0)) - 0.5f) * y);
    for (unsigned s = 0; s <= kSides; ++s) {
      const float phi = 2 * kPi * static_cast<float>(s % kSides) / kSides;
      const vec3 n = std::cos(phi) * x + std::sin(phi) * y;
      const float radius = (radius_from + (radius_to - radius_from) * t) *
                           (0.9f + 0.25f * value_noise(seed + 2, vec3(s % kSides, t * 30, 0)));
      mesh.positions.push_back(from + (to - from) * t + bend + radius * n);
      mesh.normals.push_back(n);
      mesh.uvs.push_back({static_cast<float>(s) / kSides, t * length / (6 * radius_from)});
    }
  }
  for (unsigned ring = 0; ring < kRings; ++ring) {
    for (unsigned s = 0; s < kSides; ++s) {
      const unsigned a = first + ring * (kSides + 1) + s, b = a + kSides + 1;
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  }
}

void add_person(Glb& glb) {
  const glm::mat4 to_head = glm::rotate(glm::translate(glm::mat4(1), kHead), -0.16f, vec3(0, 1, 0));
  const glm::mat4 to_body = glm::translate(glm::mat4(1), kHead);

  const Texture skin = noise_texture(201, 1024, 4, 512, 0.82f, [](float n, float u, float v) {
    vec3 color = glm::mix(vec3(0.36f, 0.18f, 0.115f), vec3(0.70f, 0.45f, 0.335f), n);
    const float freckle = value_noise(202, vec3(u * 160, v * 160, 0));
    if (freckle > 0.8f) color *= 1 - 1.6f * (freckle - 0.8f);
    return color;
  });
  const int skin_texture = glb.add_texture(skin);
  const int skin_material = glb.add_material(skin_texture, vec3(1), false, 0.6f);
  glb.add_node("head", placed(mesh_sdf(head, {-0.1f, -0.21f, -0.125f}, {0.1f, 0.15f, 0.125f}, 0.002f, 0.11f), to_head),
               skin_material, true);
  const Texture iris = noise_texture(203, 512, 8, 128, 0.8f, [](float n, float u, float v) {
    const float r = 2 * std::hypot(u - 0.5f, v - 0.5f);
    if (r < 0.085f) return vec3(0.01f);
    if (r < 0.2f) return glm::mix(vec3(0.05f, 0.07f, 0.06f), vec3(0.22f, 0.26f, 0.2f), n) * (r > 0.185f ? 0.4f : 1.0f);
    return glm::mix(vec3(0.62f, 0.53f, 0.5f), vec3(0.8f, 0.76f, 0.73f), n);
  });
  const int eye_material = glb.add_material(glb.add_texture(iris), vec3(1), false, 0.12f);
  for (float side : {-1.0f, 1.0f}) {
    const vec3 gaze = glm::normalize(vec3(0.15f - 0.02f * side, -0.04f, 1));
    glb.add_node("eye", placed(ball({0.031f * side, 0.0148f, 0.0715f}, 0.0121f, gaze), to_head), eye_material, true);
  }
  const Texture lips = two_tone(204, {0.3f, 0.08f, 0.07f}, {0.55f, 0.22f, 0.19f}, 8, 256, 0.8f);
  const int lip_material = glb.add_material(glb.add_texture(lips), vec3(1), false, 0.35f);
  const auto lip_skin = [](vec3 p) {
    const float lip = std::min(sdf_ellipsoid(p, {0, -0.0485f, 0.078f}, {0.0232f, 0.0058f, 0.0108f}),
                               sdf_ellipsoid(p, {0, -0.0605f, 0.077f}, {0.0202f, 0.0066f, 0.0108f}));
    return std::max(lip - 0.0012f, head(p) - 0.0006f);
  };
  glb.add_node("lips",
               placed(mesh_sdf(lip_skin, {-0.03f, -0.075f, 0.055f}, {0.03f, -0.035f, 0.1f}, 0.0007f, 0.03f), to_head),
               lip_material, true);

  const Texture brown = two_tone(205, {0.012f, 0.007f, 0.004f}, {0.15f, 0.085f, 0.045f}, 4, 512, 0.9f);
  const int hair_material = glb.add_material(glb.add_texture(brown), vec3(1), false, 0.7f);
  glb.add_node("scalp", placed(mesh_sdf(scalp, {-0.1f, -0.08f, -0.13f}, {0.1f, 0.16f, 0.12f}, 0.003f, 0.05f), to_head),
               hair_material, true);
  Mesh strands = hair_strands(9000);
  glb.add_node("hair", placed(strands, to_head * glm::translate(glm::mat4(1), -kHead)), hair_material, true);
  Mesh brows;
  for (int i = 0; i < 700; ++i) {
    const float side = i % 2 ? 1.0f : -1.0f;
    const float t = scene_hash01(211, i);
    const vec3 root(side * (0.013f + 0.033f * t),
                    0.0375f + 0.005f * std::sin(2.2f * t) + 0.004f * (scene_hash01(212, i) - 0.5f),
                    0.0895f - 0.018f * t * t);
    const vec3 tip = root + vec3(side * 0.005f, 0.003f * (1 - 1.5f * t), 0.0012f);
    const vec3 across(0, 0.00022f, 0);
    const auto first = static_cast<unsigned>(brows.positions.size());
    for (const vec3& p : {root - across, root + across, tip}) {
      brows.positions.push_back(p);
      brows.normals.push_back({0, 0, 1});
      brows.uvs.push_back({scene_hash01(213, i), p.x * 20});
    }
    brows.triangles.push_back({first, first + 1, first + 2});
  }
  glb.add_node("brows", placed(brows, to_head), hair_material, true);

  const Texture wool = noise_texture(221, 1024, 8, 256, 0.85f, [](float n, float u, float v) {
    const float warp = std::sin(2 * kPi * (u * 40 + 0.6f * n)), weft = std::sin(2 * kPi * (v * 60 + 0.6f * n));
    const float thread = 0.5f + 0.3f * warp * weft + 0.5f * (n - 0.5f);
    const bool stripe = std::fmod(v * 5, 1.0f) < 0.22f;
    return stripe ? glm::mix(vec3(0.4f, 0.36f, 0.28f), vec3(0.8f, 0.75f, 0.62f), std::clamp(thread, 0.0f, 1.0f))
                  : glm::mix(vec3(0.012f, 0.03f, 0.065f), vec3(0.08f, 0.16f, 0.27f), std::clamp(thread, 0.0f, 1.0f));
  });
  glb.add_node("jumper",
               placed(mesh_sdf(clothes, {-0.32f, -0.6f, -0.18f}, {0.32f, -0.1f, 0.2f}, 0.0045f, 0.1f), to_body),
               glb.add_material(glb.add_texture(wool), vec3(1), false), true);

  const auto add_hand = [&](const char* name, vec3 at, float lean, float turn, bool left, float curl) {
    Mesh mesh = mesh_sdf([&](vec3 p) { return hand(left ? mirrored(p) : p, curl); }, {-0.085f, -0.13f, -0.06f},
                         {0.085f, 0.12f, 0.075f}, 0.002f, 0.11f);
    const glm::mat4 turned =
        glm::rotate(glm::rotate(to_body * glm::translate(glm::mat4(1), at), lean, vec3(0, 0, 1)), turn, vec3(0, 1, 0));
    glb.add_node(name, placed(mesh, turned), skin_material, true);
  };
  add_hand("right hand", {0.085f, -0.235f, 0.16f}, 0.5f, 2.6f, false, 0.35f);
  add_hand("left hand", {-0.01f, -0.39f, 0.155f}, -1.25f, 0.25f, true, 0.7f);
}

void add_garden(Glb& glb) {
  const auto plain = [&](const Texture& texture) { return glb.add_material(glb.add_texture(texture), vec3(1), false); };

  const Texture brick = noise_texture(301, 1024, 8, 512, 0.85f, [](float n, float u, float v) {
    const float row = std::floor(v * 12);
    const float x = u * 5 + 0.5f * std::fmod(row, 2.0f), y = v * 12;
    const float column = std::floor(x);
    const float joint = std::min({x - column, 1 - (x - column), (y - row) * 0.42f, (1 - (y - row)) * 0.42f});
    const float tone = scene_hash01(302, static_cast<int>(column) % 5, static_cast<int>(row));
    if (joint < 0.035f + 0.02f * n) return glm::mix(vec3(0.22f, 0.2f, 0.17f), vec3(0.5f, 0.47f, 0.42f), n);
    return glm::mix(vec3(0.12f, 0.04f, 0.025f), vec3(0.55f, 0.25f, 0.16f), 0.25f + 0.75f * n) * (0.6f + 0.6f * tone);
  });
  Mesh wall;
  wall.add_quad({-5.5f, -1.2f, -4.6f}, {5.2f, 0, 0.5f}, {0, 2.3f, 0}, {4.3f, 2.4f});
  glb.add_node("wall", wall, plain(brick));

  const Texture paving = noise_texture(311, 1024, 8, 512, 0.88f, [](float n, float u, float v) {
    const float x = u * 3, y = v * 3;
    const float joint = std::min({x - std::floor(x), std::ceil(x) - x, y - std::floor(y), std::ceil(y) - y});
    const float tone = scene_hash01(312, static_cast<int>(x), static_cast<int>(y));
    return glm::mix(vec3(0.12f, 0.11f, 0.095f), vec3(0.6f, 0.56f, 0.5f), n) *
           (joint < 0.03f ? 0.4f : 0.75f + 0.4f * tone);
  });
  Mesh ground;
  ground.add_quad({-7, -1.15f, -0.2f}, {14, 0, 0}, {0, 0, -14}, {9, 9});
  glb.add_node("terrace", ground, plain(paving));

  const Texture wood = noise_texture(321, 1024, 8, 512, 0.85f, [](float n, float u, float v) {
    const float grain = 0.5f + 0.5f * std::sin(2 * kPi * (v * 22 + 1.5f * n + 0.6f * std::sin(6.28318f * u)));
    return glm::mix(vec3(0.13f, 0.06f, 0.025f), vec3(0.5f, 0.3f, 0.15f), 0.5f * grain + 0.5f * n);
  });
  const int wood_material = plain(wood);
  Mesh table;
  table.add_quad({-0.62f, -0.215f, -0.4f}, {0.47f, 0, 0.0f}, {0, 0.0f, -0.34f}, {1.2f, 0.9f});
  table.add_quad({-0.62f, -0.235f, -0.4f}, {0.47f, 0, 0.0f}, {0, 0.02f, 0}, {1.2f, 0.05f});
  glb.add_node("table", table, wood_material);

  const Texture bark = two_tone(331, {0.035f, 0.025f, 0.018f}, {0.3f, 0.23f, 0.17f}, 8, 512, 0.9f);
  Mesh trees;
  add_branch(trees, 341, {1.05f, -1.2f, -2.7f}, {0.92f, 2.4f, -2.6f}, 0.11f, 0.08f);
  add_branch(trees, 344, {0.98f, 0.35f, -2.65f}, {0.15f, 0.95f, -2.5f}, 0.035f, 0.012f);
  add_branch(trees, 347, {-1.9f, -1.2f, -6.5f}, {-1.7f, 3.5f, -6.4f}, 0.16f, 0.12f);
  add_branch(trees, 350, {2.9f, -1.2f, -9.5f}, {3.0f, 4.0f, -9.5f}, 0.22f, 0.17f);
  add_branch(trees, 353, {0.55f, -1.2f, -12.0f}, {0.6f, 4.0f, -12.0f}, 0.2f, 0.16f);
  for (int i = 0; i < 14; ++i) {  // bare twigs that cross the sky and the wall
    const float x = -0.62f + 0.11f * i + 0.05f * scene_hash01(360, i);
    add_branch(trees, 400 + 3 * i, {x, 0.75f, -1.6f - 0.5f * scene_hash01(361, i)},
               {x + 0.35f * (scene_hash01(362, i) - 0.5f), 0.12f + 0.35f * scene_hash01(363, i), -1.5f}, 0.006f,
               0.0015f);
  }
  glb.add_node("branches", trees, plain(bark));

  const int leaf_green = plain(two_tone(371, {0.02f, 0.05f, 0.008f}, {0.24f, 0.40f, 0.08f}, 4, 256, 0.85f));
  const int leaf_olive = plain(two_tone(372, {0.035f, 0.045f, 0.012f}, {0.36f, 0.36f, 0.10f}, 4, 256, 0.85f));
  const int leaf_red = plain(two_tone(373, {0.10f, 0.02f, 0.01f}, {0.55f, 0.22f, 0.07f}, 4, 256, 0.85f));
  Mesh hedge, shrubs, autumn;
  for (int i = 0; i < 7; ++i)
    add_bush(hedge, 500 + 40 * i, 1300, {-0.2f + 0.62f * i, -0.45f + 0.16f * scene_hash01(499, i), -3.6f - 0.15f * i},
             {0.5f, 0.62f, 0.4f}, 0.11f);
  add_bush(shrubs, 800, 1100, {-0.95f, -0.62f, -2.0f}, {0.42f, 0.55f, 0.35f}, 0.075f);
  add_bush(shrubs, 840, 700, {0.62f, -0.62f, -1.55f}, {0.3f, 0.4f, 0.25f}, 0.065f);
  add_bush(hedge, 880, 1200, {-1.8f, 2.6f, -6.4f}, {1.6f, 1.3f, 1.2f}, 0.2f);
  add_bush(hedge, 920, 1200, {3.0f, 2.9f, -9.5f}, {2.2f, 1.6f, 1.6f}, 0.28f);
  add_bush(shrubs, 960, 1200, {0.5f, 2.6f, -12.0f}, {2.6f, 1.6f, 1.5f}, 0.34f);
  add_bush(shrubs, 1000, 1600, {-1.5f, 0.2f, -13.5f}, {7.0f, 1.9f, 0.8f}, 0.42f);
  add_bush(autumn, 1040, 420, {0.35f, 0.6f, -2.45f}, {0.5f, 0.22f, 0.25f}, 0.055f);
  for (int i = 0; i < 90; ++i) {  // leaves on the twigs
    const vec3 base(-0.65f + 1.5f * scene_hash01(1081, i), 0.15f + 0.45f * scene_hash01(1082, i),
                    -1.5f - 0.4f * scene_hash01(1083, i));
    const vec3 along = glm::normalize(vec3(scene_hash01(1084, i) - 0.5f, -0.6f, scene_hash01(1085, i) - 0.5f));
    add_leaf(autumn, 1090, i, base, along,
             glm::normalize(glm::cross(along, vec3(scene_hash01(1086, i) - 0.5f, 0.2f, 1))), 0.035f);
  }
  // the plant on the table, nearer than the focus plane
  add_bush(shrubs, 1120, 70, {-0.29f, -0.1f, -0.52f}, {0.06f, 0.08f, 0.05f}, 0.045f);
  add_bush(hedge, 1136, 60, {-0.25f, -0.15f, -0.47f}, {0.05f, 0.05f, 0.04f}, 0.03f);
  glb.add_node("hedge", hedge, leaf_green);
  glb.add_node("shrubs", shrubs, leaf_olive);
  glb.add_node("autumn leaves", autumn, leaf_red);

  const Texture clay = two_tone(381, {0.2f, 0.07f, 0.035f}, {0.6f, 0.3f, 0.18f}, 8, 512, 0.85f);
  Mesh pot;
  add_branch(pot, 1200, {-0.28f, -0.214f, -0.51f}, {-0.28f, -0.15f, -0.51f}, 0.032f, 0.045f);
  glb.add_node("pot", pot, plain(clay));
}

}  // namespace

void make_portrait(const std::string& path) {
  Glb glb;
  add_person(glb);
  add_garden(glb);
  glb.add_camera("camera", vec3(0), {0, 0, -1});
  glb.add_sun(glm::normalize(vec3(0.55f, -0.75f, -0.55f)), {1, 0.93f, 0.82f}, 16000);
  glb.write(path);
}

}  // namespace dualpixel::scenes
