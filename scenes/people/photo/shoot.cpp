#include "scenes/people/photo/shoot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "simulator/render/camera_rays.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::scenes {
namespace {

using simulator::kPacket;

constexpr float kDomeReach_m = 0.7f;  ///< what is nearer darkens
constexpr float kKeyReach_m = 4;      ///< what is nearer throws a shadow; walls further off let windows' light in

vec3 dome_radiance(const DomeLight& dome, vec3 d) {
  const float height = std::sqrt(std::abs(d.y));
  const vec3 gradient = glm::mix(dome.horizon, d.y > 0 ? dome.up : dome.down, height);
  return gradient + dome.lobe * std::exp(dome.lobe_sharpness * (glm::dot(d, dome.lobe_direction) - 1));
}

/// Its mean over the half sphere about a normal, weighed by the cosine; near enough.
vec3 dome_irradiance(const DomeLight& dome, vec3 n) {
  const vec3 gradient = 0.5f * dome.horizon + (0.25f + 0.25f * n.y) * dome.up + (0.25f - 0.25f * n.y) * dome.down;
  const float facing = std::max((glm::dot(n, dome.lobe_direction) + 0.4f) / 1.4f, 0.0f);
  return gradient + dome.lobe * (1.6f / dome.lobe_sharpness * facing);
}

vec3 seen_sky(const DomeLight& dome, vec3 d) {
  vec3 color = dome_radiance(dome, d);
  if (!dome.sky || d.y < 0) return color;
  const float clouds = fractal(dome.seed, d * (2.2f / (0.25f + d.y)), 4);
  const float cover = std::clamp(3 * (clouds - 0.5f), 0.0f, 1.0f);
  return glm::mix(color, vec3(0.9f) * (0.3f + glm::dot(color, vec3(0.33f))), cover);
}

/// Any two directions across a unit one.
void across(vec3 n, vec3& x, vec3& y) {
  x = glm::normalize(std::abs(n.y) < 0.9f ? glm::cross(n, vec3(0, 1, 0)) : glm::cross(n, vec3(1, 0, 0)));
  y = glm::cross(n, x);
}

vec3 cosine_direction(vec3 n, float u, float v) {
  vec3 x, y;
  across(n, x, y);
  const float r = std::sqrt(u), phi = 2 * std::numbers::pi_v<float> * v;
  return glm::normalize(r * std::cos(phi) * x + r * std::sin(phi) * y + std::sqrt(std::max(1 - u, 0.0f)) * n);
}

/// What one sample found: where it goes for its light, and what that light would add.
struct Lit {
  vec3 origin, towards;
  float reach_m = 0;
  vec3 seen{0}, hidden{0};  ///< added when the way is free, when it is not
};

Lit light_at(const SceneModel& scene, const SceneObject& object, const glm::uvec3& t, float b1, float b2,
             vec3 eye_direction, bool key, float u, float v) {
  const float b0 = 1 - b1 - b2;
  const auto at = [&](const std::vector<vec3>& values) {
    return b0 * values[t.x] + b1 * values[t.y] + b2 * values[t.z];
  };
  const Material& material = scene.materials[static_cast<std::size_t>(object.material)];
  const vec3 color = reflectance(material, at(object.rest));
  vec3 geometric =
      glm::cross(object.positions[t.y] - object.positions[t.x], object.positions[t.z] - object.positions[t.x]);
  const float area = glm::length(geometric);
  geometric = area > 0 ? geometric / area : vec3(0, 1, 0);
  if (glm::dot(geometric, eye_direction) > 0) geometric = -geometric;
  vec3 n = at(object.normals);
  const float length = glm::length(n);
  n = length > 1e-6f ? n / length : geometric;
  if (glm::dot(n, geometric) < 0) n = -n;
  Lit lit;
  lit.origin = at(object.positions) + 0.0015f * geometric;
  lit.seen = lit.hidden = color * material.emission;
  constexpr float kShare = 2;  // each kind of light is asked for by half of the samples, which are a net of their own
  if (key) {
    const KeyLight& light = scene.key;
    vec3 x, y;
    across(light.direction, x, y);
    const float r = light.spread * std::sqrt(u), phi = 2 * std::numbers::pi_v<float> * v;
    lit.towards = glm::normalize(light.direction + r * std::cos(phi) * x + r * std::sin(phi) * y);
    lit.reach_m = kKeyReach_m;
    const float cosine = glm::dot(n, light.direction);
    // light wraps around under skin and through leaves, red furthest
    const vec3 wrap = material.softness * vec3(1, 0.55f, 0.45f);
    const vec3 diffuse = glm::max((vec3(cosine) + wrap) / (1.0f + wrap), vec3(0));
    vec3 arriving = color * diffuse;
    if (material.gloss > 0 && cosine > 0) {
      const vec3 half = glm::normalize(light.direction - eye_direction);
      arriving += material.gloss * 0.06f * (material.gloss_power + 2) * cosine *
                  std::pow(std::max(glm::dot(n, half), 0.0f), material.gloss_power) *
                  glm::mix(vec3(1), color * 2.0f, 0.4f);
    }
    lit.seen += kShare * arriving * light.irradiance;
    if (diffuse == vec3(0)) lit.reach_m = 0;
    return lit;
  }
  lit.towards = cosine_direction(n, u, v);
  lit.reach_m = glm::dot(lit.towards, geometric) > 0 ? kDomeReach_m : 0;
  // the whole dome's light times what share of it is free: less grain than the radiance of single directions
  const vec3 ambient = dome_irradiance(scene.dome, n);
  lit.seen += kShare * color * ambient;
  lit.hidden += kShare * 0.35f * color * ambient * glm::mix(vec3(1), color, 0.5f);  // what the neighbour gives back
  return lit;
}

}  // namespace

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

simulator::CameraView make_camera(const CameraSetup& plan) {
  const vec3 forward = glm::normalize(plan.target - plan.eye);
  const vec3 level = glm::normalize(glm::cross(forward, vec3(0, 1, 0)));
  const vec3 level_down = glm::cross(forward, level);
  const vec3 right = std::cos(plan.roll) * level + std::sin(plan.roll) * level_down;
  const vec3 down = glm::cross(forward, right);
  simulator::Lens lens;
  lens.thin.focal_length_m = 0.05;  // nominal: with `power` only the field of view and the pupil matter
  lens.thin.f_number = lens.thin.focal_length_m / plan.aperture_m;
  lens.thin.focus_distance_m = std::max(plan.focus_m, 0.1f);
  lens.thin.focusing = simulator::ThinLens::Focusing::power;
  simulator::SensorGrid sensor;
  sensor.width_px = plan.width_px;
  sensor.height_px = plan.height_px;
  sensor.pixel_pitch_m =
      lens.thin.focal_length_m * plan.height_m / glm::distance(plan.eye, plan.target) / plan.height_px;
  sensor.principal_point_px = {0.5 * plan.width_px, 0.5 * plan.height_px};
  const glm::mat4 pose(glm::vec4(right, 0), glm::vec4(down, 0), glm::vec4(forward, 0), glm::vec4(plan.eye, 1));
  return {pose, simulator::LensSampler(lens, sensor)};
}

vec3 project(const simulator::CameraView& camera, vec3 point) {
  const vec3 local = (point - vec3(camera.world_from_camera[3])) * mat3(camera.world_from_camera);
  const auto& sensor = camera.lens.sensor();
  const auto scale = static_cast<float>(camera.lens.lens().thin.image_distance_m() / sensor.pixel_pitch_m);
  const float z = std::max(local.z, 1e-3f);
  return {static_cast<float>(sensor.principal_point_px.x) + scale * local.x / z,
          static_cast<float>(sensor.principal_point_px.y) + scale * local.y / z, local.z};
}

vec3 direction_of(const simulator::CameraView& camera, vec2 at) {
  const auto& sensor = camera.lens.sensor();
  const auto scale = static_cast<float>(sensor.pixel_pitch_m / camera.lens.lens().thin.image_distance_m());
  const vec2 middle(sensor.principal_point_px.x, sensor.principal_point_px.y);
  return glm::normalize(mat3(camera.world_from_camera) * vec3(scale * (at - middle), 1));
}

float lowest_visible_m(const simulator::CameraView& camera, float reach_m) {
  const auto& sensor = camera.lens.sensor();
  const vec3 eye(camera.world_from_camera[3]);
  float lowest = eye.y;
  for (const int x : {0, sensor.width_px}) {
    const vec3 d = direction_of(camera, vec2(x, sensor.height_px));
    for (const float z : {-reach_m, reach_m}) {
      if (d.z > -1e-3f) return std::numeric_limits<float>::lowest();  // straight down, or back
      lowest = std::min(lowest, eye.y + d.y * std::max((z - eye.z) / d.z, 0.0f));
    }
  }
  return lowest;
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

Rendering render(const RayTracer& tracer, const simulator::CameraView& camera, int people, std::uint64_t seed) {
  const SceneModel& scene = tracer.scene();
  const int width = camera.lens.sensor().width_px, height = camera.lens.sensor().height_px;
  Rendering out{Image(width, height, 3), Image(width, height, 3), Image(width, height, std::max(people, 1))};
  alignas(64) float samples[4][kPacket];
  alignas(64) float u[kPacket], v[kPacket];
  simulator::LensPacket packet;
  alignas(64) simulator::RayPacket rays;
  alignas(64) simulator::RayPacket shadow;
  alignas(64) int active[kPacket], hidden[kPacket];
  Lit lit[kPacket];
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::uint64_t key = simulator::hash(seed, static_cast<std::uint64_t>(y) * width + x);
      simulator::joint_samples(0, key, samples);
      simulator::padded_samples(0, kPacket / 2 - 1, key, 1, u, v);
      camera.lens.sample_ideal(x, y, samples, 1, packet);
      simulator::to_world(packet, camera.world_from_camera, rays);
      std::fill_n(active, kPacket, -1);
      tracer.intersector().intersect(active, rays, true);
      for (int i = 0; i < kPacket; ++i) {
        active[i] = 0;
        const vec3 direction = glm::normalize(vec3(rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]));
        if (rays.mesh[i] == simulator::kNoMesh) {
          lit[i].seen = seen_sky(scene.dome, direction);
          continue;
        }
        const SceneObject& object = scene.objects[rays.mesh[i]];
        lit[i] = light_at(scene, object, object.triangles[rays.triangle[i]], rays.u[i], rays.v[i], direction,
                          i % 2 == 0, u[i], v[i]);
        if (lit[i].reach_m <= 0) continue;
        active[i] = -1;
        shadow.origin_x[i] = lit[i].origin.x, shadow.origin_y[i] = lit[i].origin.y,
        shadow.origin_z[i] = lit[i].origin.z;
        shadow.direction_x[i] = lit[i].towards.x, shadow.direction_y[i] = lit[i].towards.y,
        shadow.direction_z[i] = lit[i].towards.z;
        shadow.far[i] = lit[i].reach_m;
      }
      tracer.intersector().occluded(active, shadow, false, hidden);
      vec3 all(0), of_people(0);
      for (int i = 0; i < kPacket; ++i) {
        const vec3 light = (active[i] && hidden[i] ? lit[i].hidden : lit[i].seen) / static_cast<float>(kPacket);
        all += light;
        const int person = rays.mesh[i] == simulator::kNoMesh ? -1 : scene.objects[rays.mesh[i]].person;
        if (person < 0) continue;
        of_people += light;
        out.coverage.at(x, y, person) += 1.0f / kPacket;
      }
      for (int c = 0; c < 3; ++c) {
        out.light.at(x, y, c) = all[c];
        out.people_light.at(x, y, c) = of_people[c];
      }
    }
  }
  return out;
}

}  // namespace dualpixel::scenes
