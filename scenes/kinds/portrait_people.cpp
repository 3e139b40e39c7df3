#include "scenes/kinds/portrait_people.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "capture/image/image_io.h"
#include "scenes/kinds/hair_curves.h"
#include "scenes/people/makehuman/makehuman_figure.h"
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

/// Noise over 2 mm, -1/2 ... 1/2.
float skin_wave(const Material& material, std::uint32_t k, const vec3& at) {
  return noise(material.seed + k, at * 480.0f) - 0.5f;
}

/// Pores and fine lines, without which skin shines like wax: normals that waver by a few degrees.
void roughen_skin(const Material& material, const std::vector<vec3>& rest, std::vector<vec3>& normals) {
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const auto wave = [&](std::uint32_t k) { return skin_wave(material, k, rest[i]); };
    normals[i] = glm::normalize(normals[i] + 0.14f * vec3(wave(31), wave(32), wave(33)));
  }
}

void spot_skin(const Material& material, const std::vector<vec3>& rest, std::vector<vec3>& colors) {
  for (std::size_t i = 0; i < colors.size(); ++i) {
    colors[i] *= 1 + 0.07f * skin_wave(material, 34, rest[i]) +
                 0.14f * (fractal(material.seed + 35, rest[i] * 110.0f, 2) - 0.5f);
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
  if (is_skin(material)) {
    roughen_skin(material, object.rest, mesh.normals);
    spot_skin(material, object.rest, colors);
  }
  for (vec3& color : colors) color = glm::clamp(color, vec3(0), vec3(1));
  mesh.triangles = std::move(object.triangles);
  drop_flat_triangles(mesh);
  if (!mesh.triangles.empty()) build.glb.add_colored_person("person", mesh, colors, build.add(surface_of(material)));
}

/// The texture, tinted by the material's color.
int add_tinted_texture(SceneBuilder& build, const Material& material) {
  const simulator::Texture& texture = *material.texture;
  std::vector<unsigned char> rgba(texture.bytes().begin(), texture.bytes().end());
  tbb::parallel_for(std::size_t{0}, rgba.size() / 4, [&](std::size_t i) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float linear = simulator::kDecodeTables.srgb[rgba[4 * i + c]] * material.a[static_cast<int>(c)];
      rgba[4 * i + c] = static_cast<unsigned char>(std::lround(255 * srgb_from_linear(std::clamp(linear, 0.0f, 1.0f))));
    }
  });
  return build.glb.add_texture(texture.width, texture.height, rgba);
}

/// Skin of MakeHuman's is known by its texture.
void add_textured_mesh(SceneBuilder& build, SceneObject object, const Material& material, const Figure& figure) {
  const bool skin = material.texture == figure.skin.texture;
  Mesh mesh;
  mesh.positions = std::move(object.positions);
  mesh.normals = std::move(object.normals);
  for (vec3& n : mesh.normals) n = glm::dot(n, n) > 1e-12f ? glm::normalize(n) : vec3(0, 1, 0);
  for (const vec3& uv : object.rest) mesh.uvs.emplace_back(uv.x, uv.y);
  if (skin) roughen_skin(material, mesh.positions, mesh.normals);
  mesh.triangles = std::move(object.triangles);
  drop_flat_triangles(mesh);
  if (mesh.triangles.empty()) return;
  GlbMaterial textured{.texture = add_tinted_texture(build, material), .roughness = material.iris ? 0.12f : 0.8f};
  if (skin) textured.roughness = 0.5f, textured.subsurface = 0.8f;
  textured.cut_out = material.cut_out || material.iris;  // corneas are clear
  build.glb.add_node("person", mesh, build.add_material(textured), true);
}

void add_strands(SceneBuilder& build, const HairCurves& hair) {
  if (hair.segments.empty()) return;
  build.glb.add_person_hair("hair", hair.points, hair.widths_m, hair.colors, hair.segments,
                            build.add({.roughness = 0.35f}));
}

}  // namespace

StandingFace add_person(SceneBuilder& build, RandomStream rng, const PersonSpot& spot,
                        const MakeHumanAssets* makehuman) {
  SceneModel model;
  FigureOptions options;
  options.position = spot.foot;
  options.yaw = spot.yaw;
  options.meters_per_px = 0.0012f;
  options.lowest_m = spot.lowest_m;
  options.gesture = random_gesture(rng);
  const Figure figure = makehuman != nullptr ? add_makehuman_figure(model, *makehuman, rng.substream(1), options)
                                             : add_figure(model, rng.substream(1), options);
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
    if (material.kind == Kind::textured) {
      add_textured_mesh(build, std::move(object), material, figure);
    } else {
      add_object_mesh(build, std::move(object), material);
    }
  }
  return face;
}

}  // namespace dualpixel::scenes
