#include "scenes/people/photo/ray_tracer.h"

#include "scenes/people/photo/camera.h"

namespace dualpixel::scenes {

RayTracer::RayTracer(const SceneModel& scene) : scene_(scene) {
  simulator::Material opaque;
  geometry_.materials.push_back(opaque);
  for (const SceneObject& object : scene.objects) {
    simulator::Mesh& mesh = geometry_.meshes.emplace_back();
    mesh.positions = object.positions;
    mesh.triangles = object.triangles;
    const Material& material = scene.materials[static_cast<std::size_t>(object.material)];
    if (!material.cut_out) continue;
    mesh.material = static_cast<int>(geometry_.materials.size());
    simulator::Material& leaf = geometry_.materials.emplace_back();
    leaf.alpha_cutoff = 0.5f;
    leaf.base_color_texture.texture = static_cast<int>(geometry_.textures.size());
    simulator::Texture& texture = geometry_.textures.emplace_back();
    texture.width = material.texture->width, texture.height = material.texture->height;
    texture.rgba = material.texture->rgba;
    mesh.uv0.assign(object.rest.begin(), object.rest.end());
  }
  intersector_.emplace(geometry_);
}

Visibility visibility_of(const RayTracer& tracer, const simulator::CameraView& camera) {
  constexpr int kStep_px = 4, kMostLayers = 32;
  const auto& sensor = camera.lens.sensor();
  Visibility found;
  int towards_people = 0, occluded = 0;
  for (int y = kStep_px / 2; y < sensor.height_px; y += kStep_px) {
    for (int x = kStep_px / 2; x < sensor.width_px; x += kStep_px) {
      vec3 from(camera.world_from_camera[3]);
      const vec3 d = direction_of(camera, vec2(x, y));
      for (int layer = 0; layer < kMostLayers; ++layer) {
        const auto hit = tracer.intersector().intersect({from, d});
        if (!hit) break;
        const int person = tracer.scene().objects[hit->mesh].person;
        if (layer == 0 && person == kBystander) found.bystanders = true;
        if (person >= 0) {
          ++towards_people;
          occluded += layer > 0 ? 1 : 0;
          break;
        }
        from += (static_cast<float>(hit->t) + 1e-3f) * d;
      }
    }
  }
  if (towards_people > 0) found.occluded = static_cast<float>(occluded) / static_cast<float>(towards_people);
  return found;
}

}  // namespace dualpixel::scenes
