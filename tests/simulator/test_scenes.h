#pragma once
#include <glm/glm.hpp>

#include "simulator/render/camera_view.h"
#include "simulator/render/views.h"
#include "simulator/scene/scene.h"

/// Scenes of a few triangles, made in memory: what the physics is tested on.
namespace dualpixel::simulator::testing {

/// Two triangles: corner, corner + a, corner + a + b, corner + b.
inline Mesh make_quad(glm::vec3 corner, glm::vec3 a, glm::vec3 b, int material) {
  Mesh mesh;
  mesh.positions = {corner, corner + a, corner + a + b, corner + b};
  mesh.uv0 = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.material = material;
  mesh.object_id = 1;
  return mesh;
}

/// A material that shines with `nits` whatever falls on it.
inline Material glowing(float nits) {
  Material m;
  m.base_color = {0, 0, 0, 1};
  m.metallic = 0;
  m.emission_nits = glm::vec3(nits);
  return m;
}

inline Material diffuse(float albedo) {
  Material m;
  m.base_color = {albedo, albedo, albedo, 1};
  m.metallic = 0;
  return m;
}

/// Material 0 shows a picture that shines by itself, white at `white_nits`, to a camera at the origin; no mesh yet.
inline Scene shining_picture(Texture picture, float white_nits) {
  keep_decoded(picture);
  Material material;
  material.unlit = true;
  material.base_color_texture.texture = 0;
  Scene scene;
  scene.textures = {std::move(picture)};
  scene.materials = {material};
  scene.unlit_white_nits = white_nits;
  scene.cameras = {{"camera", glm::mat4(1), {}}};
  return scene;
}

inline SensorGrid phone_sensor(int width_px, int height_px, double pixel_pitch_m = 1.4e-6) {
  return {width_px, height_px, pixel_pitch_m, {0.5 * width_px, 0.5 * height_px}};
}

/// A phone's main camera at the origin, looking along the world's +z with the world's axes its own.
inline CameraView phone_camera(double focus_distance_m, int width_px, int height_px, const SplitPixel& split = {},
                               double pixel_pitch_m = 1.4e-6) {
  Lens lens;
  lens.thin = {4.442e-3, 1.8, focus_distance_m};
  lens.split = split;
  return {glm::mat4(1), LensSampler(lens, phone_sensor(width_px, height_px, pixel_pitch_m))};
}

inline const ThinLens& thin(const CameraView& camera) { return camera.lens.lens().thin; }

/// Zeroth, first and second central moments of a picture's first channel.
struct Moments {
  double mass = 0, x = 0, y = 0, variance_x = 0, variance_y = 0;
};

inline Moments moments(const Image& image) {
  Moments m;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double v = image.at(x, y);
      m.mass += v;
      m.x += v * (x + 0.5);
      m.y += v * (y + 0.5);
    }
  }
  m.x /= m.mass;
  m.y /= m.mass;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double v = image.at(x, y) / m.mass;
      m.variance_x += v * (x + 0.5 - m.x) * (x + 0.5 - m.x);
      m.variance_y += v * (y + 0.5 - m.y) * (y + 0.5 - m.y);
    }
  }
  return m;
}

}  // namespace dualpixel::simulator::testing
