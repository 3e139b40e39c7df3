#include "scenes/kinds/portrait_people.h"

#include <tbb/parallel_for.h>

#include <map>
#include <utility>

#include "scenes/people/procedural_figure.h"
#include "scenes/people/shape/reflectance.h"

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

Surface surface_of(const Material& material) {
  Surface surface;
  const bool skin = material.kind == Kind::skin || material.kind == Kind::face;
  surface.roughness = material.kind == Kind::eye            ? 0.12f
                      : skin || material.kind == Kind::hair ? 0.6f
                      : material.gloss > 0.05f              ? 0.45f
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
  tbb::parallel_for(std::size_t{0}, colors.size(), [&](std::size_t i) {
    colors[i] = glm::clamp(reflectance(material, object.rest[i]), vec3(0), vec3(1));
  });
  mesh.triangles = std::move(object.triangles);
  drop_flat_triangles(mesh);
  if (!mesh.triangles.empty()) build.glb.add_colored_person("person", mesh, colors, build.add(surface_of(material)));
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
  for (SceneObject& object : model.objects)
    add_object_mesh(build, std::move(object), model.materials[static_cast<std::size_t>(object.material)]);
  return face;
}

}  // namespace dualpixel::scenes
