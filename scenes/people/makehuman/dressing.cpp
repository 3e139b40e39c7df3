#include "scenes/people/makehuman/dressing.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scenes/people/shape/primitives.h"
#include "scenes/procedural/noise.h"

namespace dualpixel::scenes {
namespace {

/// Cloth that follows the body at a small distance, where `covers(rest position, weights)` is true.
template <typename Covers>
void add_shell(Dressing& dressing, const Covers& covers, float room_m, float folds_m, const Material& material,
               RandomStream& rng) {
  const BaseMesh& base = *dressing.morphed.base;
  const auto& rest = dressing.morphed.rest;
  const float chest_m = 0.72f * dressing.figure.body.stature_m;
  std::vector<bool> bare(dressing.posed.size());
  std::vector<vec3> at_rest(dressing.posed.size());
  for (std::size_t v = 0; v < bare.size(); ++v) {
    bare[v] = v >= base.weights.of_vertex.size() || !covers(rest[v], base.weights.of_vertex[v]);
    at_rest[v] = rest[v] - vec3(0, chest_m, 0);
  }
  SceneObject object = mesh_object(base.body, dressing.posed, at_rest, false, bare, dressing.figure.lowest_m - 0.05f);
  const auto seed = rng.seed();
  for (std::size_t i = 0; i < object.positions.size(); ++i) {
    const vec3 bent = object.rest[i] + 0.06f * noise(seed + 1, object.rest[i] * 9.0f);
    const float fold =
        fractal(seed, bent * vec3(15, 9, 13), 2) + std::abs(noise(seed + 2, bent * vec3(11, 17, 11)) - 0.5f);
    object.positions[i] += object.normals[i] * (room_m + folds_m * fold);
  }
  smooth_normals(object);
  add_object(dressing.scene, dressing.figure, std::move(object), material);
}

float weight_of(const Weights& weights, std::initializer_list<int> parts) {
  float sum = 0;
  for (const auto& [part, weight] : weights) {
    if (std::find(parts.begin(), parts.end(), part) != parts.end()) sum += weight;
  }
  return sum;
}

}  // namespace

SceneObject mesh_object(const TexturedMesh& mesh, const std::vector<vec3>& posed, const std::vector<vec3>& rest,
                        bool textured, const std::vector<bool>& hidden, float lowest_m) {
  SceneObject whole;
  whole.positions = posed;
  for (const glm::uvec3& t : mesh.triangles)
    whole.triangles.emplace_back(mesh.vertex[t.x], mesh.vertex[t.y], mesh.vertex[t.z]);
  smooth_normals(whole);
  SceneObject object;
  for (std::size_t i = 0; i < mesh.vertex.size(); ++i) {
    const auto v = static_cast<std::size_t>(mesh.vertex[i]);
    object.positions.push_back(posed[v]);
    object.normals.push_back(whole.normals[v]);
    object.rest.push_back(textured ? vec3(mesh.uv[i], 0) : rest[v]);
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::uvec3& t = whole.triangles[i];
    if (!hidden.empty() && (hidden[t.x] || hidden[t.y] || hidden[t.z])) continue;
    if (std::max({posed[t.x].y, posed[t.y].y, posed[t.z].y}) < lowest_m) continue;
    object.triangles.push_back(mesh.triangles[i]);
  }
  return object;
}

Material tinted(const FittedAsset& asset, vec3 color, bool cut_out) {
  Material material;
  material.a = color;
  if (!asset.texture) return material;
  material.kind = Material::Kind::textured;
  material.texture = asset.texture;
  material.a = color / glm::max(asset.mean_color, vec3(0.02f));
  material.cut_out = cut_out;
  return material;
}

void add_fitted(Dressing& dressing, const FittedAsset& asset, const Material& material, float grow_m) {
  const auto& rest = dressing.morphed.rest;
  vec3 scale(1);
  for (int axis = 0; axis < 3; ++axis) {
    const auto& s = asset.scale[axis];
    if (s.length > 0) scale[axis] = std::abs(rest[s.a][axis] - rest[s.b][axis]) / (s.length * kMetersPerUnit);
  }
  const PartWeights& weights = dressing.morphed.base->weights;
  std::vector<vec3> posed, at_rest;
  for (int i = 0; i < asset.mesh.vertices; ++i) {
    const FittedAsset::Hold& hold = asset.holds[static_cast<std::size_t>(i)];
    vec3 p(0), q(0);
    for (int j = 0; j < 3; ++j) p += hold.weight[j] * rest[static_cast<std::size_t>(hold.vertex[j])];
    p += hold.offset * scale;
    for (int j = 0; j < 3; ++j) {
      if (hold.weight[j] != 0)
        q += hold.weight[j] * moved(dressing.motion, weights.of_vertex[static_cast<std::size_t>(hold.vertex[j])], p);
    }
    at_rest.push_back(p - vec3(0, 0.72f * dressing.figure.body.stature_m, 0));
    posed.push_back(q);
  }
  SceneObject object = mesh_object(asset.mesh, posed, at_rest, material.kind == Material::Kind::textured, {},
                                   dressing.figure.lowest_m - 0.05f);
  if (grow_m > 0) {
    for (std::size_t i = 0; i < object.positions.size(); ++i) object.positions[i] += grow_m * object.normals[i];
  }
  add_object(dressing.scene, dressing.figure, std::move(object), material);
}

void add_shell_clothes(Dressing& dressing, RandomStream& rng) {
  const MorphedBody& m = dressing.morphed;
  const float h = dressing.figure.body.stature_m;
  const std::array<vec3, 2> shoulder{m.joint(0, "shoulder"), m.joint(1, "shoulder")},
      wrist{m.joint(0, "hand"), m.joint(1, "hand")};
  const vec3 neck = m.joint("neck");
  const float hip = m.joint(0, "upper-leg").y;
  const float sleeve = rng.chance(0.4f) ? rng.uniform(0.25f, 0.5f) : rng.chance(0.8f) ? 0.97f : 0.05f;
  const float hem = hip - rng.uniform(-0.02f, 0.1f) * h, neckline = rng.uniform(-0.01f, 0.05f) * h,
              vee = rng.chance(0.35f) ? rng.uniform(0.5f, 2) : 0;
  const float leg = rng.chance(0.25f) ? rng.uniform(0.25f, 0.5f) : 0.97f, knee_to_hip = hip * leg;
  const Material lower = cloth_material(rng);
  add_shell(
      dressing,
      [&](vec3 p, const Weights& w) {
        const float legs =
            weight_of(w, {part_of(0, kThigh), part_of(1, kThigh), part_of(0, kShin), part_of(1, kShin), kPelvis});
        return legs > 0.5f && p.y > hip - knee_to_hip && p.y < std::min(hip + 0.09f * h, hem + 0.03f * h);
      },
      rng.uniform(0.006f, 0.014f), rng.uniform(0.004f, 0.015f), lower, rng);
  Material upper = cloth_material(rng);
  if (rng.chance(0.4f)) upper.v[kPlacket] = rng.uniform(0.2f, 1);
  const auto covers_top = [&](vec3 p, const Weights& w) {
    for (int side = 0; side < 2; ++side) {
      const float arm = weight_of(w, {part_of(side, kUpperArm), part_of(side, kForeArm), part_of(side, kTwist)});
      if (arm < 0.5f) continue;
      const vec3 along = wrist[side] - shoulder[side];
      return glm::dot(p - shoulder[side], along) / glm::dot(along, along) < sleeve;
    }
    const float arms = weight_of(w, {part_of(0, kUpperArm), part_of(1, kUpperArm)});
    if (weight_of(w, {kPelvis, kChest, kNeck, part_of(0, kThigh), part_of(1, kThigh)}) + arms < 0.6f) return false;
    const float opening =
        neck.y - neckline -
        (p.z > neck.z ? 0.3f * (p.z - neck.z) + 0.2f * h * std::max(vee * 0.06f - std::abs(p.x) / h, 0.0f) * 4 : 0.0f);
    return p.y > hem && (p.y < opening || std::abs(p.x) > 0.055f * h) && weight_of(w, {kNeck}) < 0.6f;
  };
  add_shell(dressing, covers_top, rng.uniform(0.009f, 0.022f), rng.uniform(0.006f, 0.024f), upper, rng);
  if (rng.chance(0.25f)) {  // a second layer, open in front
    const float open = rng.uniform(0.03f, 0.08f) * h;
    add_shell(
        dressing, [&](vec3 p, const Weights& w) { return covers_top(p, w) && !(p.z > neck.z && std::abs(p.x) < open); },
        0.03f, rng.uniform(0.006f, 0.02f), cloth_material(rng), rng);
  }
}

}  // namespace dualpixel::scenes
