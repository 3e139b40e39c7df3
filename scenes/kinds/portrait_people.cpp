#include "scenes/kinds/portrait_people.h"

#include <tbb/parallel_for.h>

#include <map>
#include <utility>

#include "scenes/kinds/hair_curves.h"
#include "scenes/people/procedural_figure.h"
#include "scenes/people/shape/reflectance.h"
#include "scenes/procedural/noise.h"

namespace dualpixel::scenes {
namespace {

using Kind = Material::Kind;

/// Each triangle becomes four, for colors that change within one.
void subdivide(SceneObject& object, bool rest_is_direction) {
  std::map<std::pair<unsigned, unsigned>, unsigned> middles;
  const auto middle = [&](unsigned a, unsigned b) {
    const auto [known, is_new] = middles.try_emplace(std::minmax(a, b), static_cast<unsigned>(object.positions.size()));
    if (is_new) {
      const vec3 rest = object.rest[a] + object.rest[b];
      object.positions.push_back(0.5f * (object.positions[a] + object.positions[b]));
      object.rest.push_back(rest_is_direction ? glm::normalize(rest) : 0.5f * rest);
      object.normals.push_back(glm::normalize(object.normals[a] + object.normals[b]));
    }
    return known->second;
  };
  std::vector<glm::uvec3> finer;
  for (const glm::uvec3& t : object.triangles) {
    const unsigned a = middle(t.x, t.y), b = middle(t.y, t.z), c = middle(t.z, t.x);
    for (const glm::uvec3& part :
         {glm::uvec3(t.x, a, c), glm::uvec3(a, t.y, b), glm::uvec3(c, b, t.z), glm::uvec3(a, b, c)})
      finer.push_back(part);
  }
  object.triangles = std::move(finer);
}

bool is_skin(const Material& material) { return material.kind == Kind::skin || material.kind == Kind::face; }

/// Pores and fine lines, without which skin shines like wax: normals that waver by a few degrees over 2 mm, and spots.
void roughen_skin(const Material& material, const std::vector<vec3>& rest, std::vector<vec3>& normals,
                  std::vector<vec3>& colors) {
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const vec3 p = rest[i] * 480.0f;
    const auto wave = [&](std::uint32_t k) { return noise(material.seed + k, p) - 0.5f; };
    normals[i] = glm::normalize(normals[i] + 0.14f * vec3(wave(31), wave(32), wave(33)));
    colors[i] *= 1 + 0.07f * wave(34) + 0.14f * (fractal(material.seed + 35, rest[i] * 110.0f, 2) - 0.5f);
  }
}

Surface surface_of(const Material& material) {
  Surface surface;
  const bool skin = is_skin(material);
  surface.subsurface = skin ? 0.8f : 0.0f;
  surface.roughness = material.kind == Kind::eye    ? 0.12f
                      : skin                        ? 0.5f
                      : material.kind == Kind::hair ? 0.7f
                      : material.gloss > 0.05f      ? 0.45f
                                                    : 1.0f;
  return surface;
}

void add_object_mesh(SceneBuilder& build, SceneObject object, const Material& material) {
  const int halvings = material.kind == Kind::eye ? 3 : 0;
  for (int i = 0; i < halvings; ++i) subdivide(object, true);
  Mesh mesh;
  mesh.positions = object.positions;
  mesh.normals = object.normals;
  for (vec3& n : mesh.normals) n = glm::dot(n, n) > 1e-12f ? glm::normalize(n) : vec3(0, 1, 0);
  std::vector<vec3> colors(object.positions.size());
  const float shade = object.hair_m > 0 ? 0.55f : 1.0f;  // what shows between strands
  tbb::parallel_for(std::size_t{0}, colors.size(),
                    [&](std::size_t i) { colors[i] = shade * reflectance(material, object.rest[i]); });
  if (is_skin(material)) roughen_skin(material, object.rest, mesh.normals, colors);
  for (vec3& color : colors) color = glm::clamp(color, vec3(0), vec3(1));
  mesh.triangles = std::move(object.triangles);
  drop_flat_triangles(mesh);
  if (!mesh.triangles.empty()) build.glb.add_colored_person("person", mesh, colors, build.add(surface_of(material)));
}

void add_strands(SceneBuilder& build, const HairCurves& hair) {
  if (hair.segments.empty()) return;
  build.glb.add_person_hair("hair", hair.points, hair.widths_m, hair.colors, hair.segments,
                            build.add({.roughness = 0.35f}));
}

}  // namespace

StandingFace add_person(SceneBuilder& build, RandomStream rng, const PersonSpot& spot) {
  SceneModel model;
  FigureOptions options;
  options.position = spot.foot;
  options.yaw = spot.yaw;
  options.meters_per_px = 0.0012f;
  options.lowest_m = spot.lowest_m;
  options.gesture = random_gesture(rng);
  const Figure figure = add_figure(model, rng.substream(1), options);
  StandingFace face;
  face.outline = figure.face_outline;
  face.middle = 0.5f * (figure.face_points[1] + figure.face_points[2]);
  const vec3 lift(0, spot.eyes_m.value_or(face.middle.y) - face.middle.y, 0);
  for (vec3& p : face.outline) p += lift;
  face.middle += lift;
  for (SceneObject& object : model.objects) {
    for (vec3& p : object.positions) p += lift;
  }
  for (SceneObject& object : model.objects) {
    const Material& material = model.materials[static_cast<std::size_t>(object.material)];
    if (material.kind == Kind::hair && object.hair_m == 0) continue;  // ribbons in place of strands
    if (object.hair_m > 0) add_strands(build, grow_hair(object, material, figure, rng.substream(2)));
    add_object_mesh(build, std::move(object), material);
  }
  return face;
}

}  // namespace dualpixel::scenes
