#include "scenes/drawn/scene_builder.h"

#include <cmath>
#include <numbers>

namespace dualpixel::scenes {

SceneBuilder::SceneBuilder() {
  glb.set_generator("dualpixel scene", 1);
  scene = {{"version", 1}, {"gltf", "scene.glb"}, {"camera", {{"node", "camera"}}}};
}

int SceneBuilder::add(const Surface& surface) {
  GlbMaterial material{.color = surface.color,
                       .unlit = surface.unlit,
                       .roughness = surface.roughness,
                       .metallic = surface.metallic,
                       .emission_nits = surface.emission_nits,
                       .transmission = surface.transmission,
                       .solid = surface.solid,
                       .subsurface = surface.subsurface};
  if (surface.texture.size > 0) material.texture = glb.add_texture(surface.texture);
  repeat_m_.push_back(surface.repeat_m);
  return glb.add_material(material);
}

int SceneBuilder::add_material(const GlbMaterial& material) {
  repeat_m_.push_back(1);
  return glb.add_material(material);
}

void SceneBuilder::add(const std::string& name, Mesh mesh, int surface) {
  drop_flat_triangles(mesh);
  if (mesh.triangles.empty()) return;
  for (glm::vec2& uv : mesh.uvs) uv /= repeat_m_[static_cast<std::size_t>(surface)];
  glb.add_node(name, mesh, surface);
}

int SceneBuilder::add_shared(std::vector<std::pair<Mesh, int>> parts) {
  std::vector<std::pair<const Mesh*, int>> filled;
  for (auto& [mesh, surface] : parts) {
    drop_flat_triangles(mesh);
    if (mesh.triangles.empty()) continue;
    for (glm::vec2& uv : mesh.uvs) uv /= repeat_m_[static_cast<std::size_t>(surface)];
    filled.emplace_back(&mesh, surface);
  }
  return glb.add_mesh(filled);
}

void SceneBuilder::camera(glm::vec3 at, glm::vec3 look_at) {
  glb.add_camera("camera", at, look_at);
  eye = at;
  forward = glm::normalize(look_at - at);
}

void SceneBuilder::focus_on(glm::vec3 point) {
  shooting.focus_m = glm::dot(point - eye, forward);
  shooting.subject = point;
}

void SceneBuilder::sky(float elevation_deg, float azimuth_deg, float sun_lux, float zenith_nits, float horizon_nits,
                       float ground_nits, glm::vec3 sun_color) {
  const float glow = sun_lux > 0 ? 4 * horizon_nits : 0.3f * horizon_nits;
  scene["environment"] = {{"model", "sky"},
                          {"sun_elevation_deg", elevation_deg},
                          {"sun_azimuth_deg", azimuth_deg},
                          {"zenith_nits", zenith_nits},
                          {"horizon_nits", horizon_nits},
                          {"ground_nits", ground_nits},
                          {"sun_glow_nits", glow},
                          {"sun_glow_width_deg", 14}};
  if (sun_lux <= 0) return;
  constexpr float kRadians = std::numbers::pi_v<float> / 180;
  const float up = elevation_deg * kRadians, around = azimuth_deg * kRadians;
  const glm::vec3 to_sun(std::cos(up) * std::sin(around), std::sin(up), -std::cos(up) * std::cos(around));
  glb.add_sun(-to_sun, sun_color, sun_lux);
}

void SceneBuilder::ambient(glm::vec3 nits) {
  scene["environment"] = {{"model", "constant"}, {"nits", {nits.x, nits.y, nits.z}}};
}

}  // namespace dualpixel::scenes
