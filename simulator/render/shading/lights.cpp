#include "simulator/render/shading/lights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "simulator/render/shading/radiometry.h"
#include "simulator/render/shading/surface.h"

namespace dualpixel::simulator {
Lights::Lights(const Scene& scene, const Intersector& intersector)
    : scene_(scene),
      environment_(scene.environment),
      sky_(environment_, intersector),
      near_(scene, intersector.bounds()) {
  for (const PunctualLight& light : scene.lights) {
    const bool far = light.kind == PunctualLight::Kind::directional;
    if (far && luminance(light.intensity) > 0) directional_.push_back({light, luminance(light.intensity)});
  }
}

Lights::Choice Lights::sky_at(glm::vec3 point, glm::vec3 normal) const {
  Choice choice;
  choice.environment.table = environment_.table_of(normal.x, normal.y, normal.z);
  const VisibleSky::View& view = sky_.from(point, normal);
  choice.environment.other = view.seen.get(), choice.environment.other_share = view.share;
  choice.environment_lux = view.visible * environment_.lux(choice.environment.table);
  choice.all_lux = choice.environment_lux;
  return choice;
}

float Lights::directional_lux(glm::vec3 normal) const {
  float lux = 0;
  for (const Directional& d : directional_) lux += d.lux * std::max(-glm::dot(d.light.direction, normal), 0.0f);
  return lux;
}

Lights::Choice Lights::choice_at(glm::vec3 point, glm::vec3 normal, LightKinds kinds) const {
  Choice choice = environment_.dark() ? Choice{} : sky_at(point, normal);
  if (kinds != LightKinds::soft) choice.all_lux += directional_lux(normal);
  choice.near = near_.weights(point, normal, kinds);
  choice.near_lux = near_lux_beside(choice.all_lux, choice.near.lux, kinds);
  choice.all_lux += choice.near_lux;
  return choice;
}

float Lights::near_lux_beside(float others, float estimate, LightKinds kinds) const {
  constexpr float kMost = 3;
  return std::min(estimate, std::max(near_.average_lux(kinds), kMost * others));
}

float Lights::near_share() const {
  float all = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {-1.0f, 1.0f}) {
      glm::vec3 normal(0);
      normal[axis] = sign;
      const float sky_lux =
          environment_.dark() ? 0 : environment_.lux(environment_.table_of(normal.x, normal.y, normal.z));
      all += (sky_lux + directional_lux(normal) + near_lux()) / 6;
    }
  }
  return all > 0 ? near_lux() / all : 0;
}

void Lights::sample(const int lanes[kPacket], const Vec3Packet& point, const Vec3Packet& normal, const float u[kPacket],
                    const float v[kPacket], LightPacket& out, LightKinds kinds) const {
  // `below`: the light of the lights before those in question; u * all_lux lies in one of these stretches
  Choice choice[kPacket];
  alignas(64) int from_environment[kPacket], waiting[kPacket];
  alignas(64) float below[kPacket], all_lux[kPacket], within[kPacket];
  const bool environment = !environment_.dark() && kinds != LightKinds::hard;
  const std::size_t directional = kinds == LightKinds::soft ? 0 : directional_.size();
  for (int i = 0; i < kPacket; ++i) {
    if (environment && lanes[i]) choice[i] = sky_at(point.at(i), normal.at(i));
    all_lux[i] = below[i] = choice[i].environment_lux;
  }
  const auto own_lux = [&](const Directional& d, int i) {
    const glm::vec3 l = d.light.direction;
    const float lux = -d.lux * (l.x * normal.x[i] + l.y * normal.y[i] + l.z * normal.z[i]);
    return lux > 0 ? lux : 0.0f;
  };
  for (std::size_t k = 0; k < directional; ++k) {
    for (int i = 0; i < kPacket; ++i) all_lux[i] += own_lux(directional_[k], i);
  }
  NearLights::Choice near;
  near_.choose(point, normal, kinds, near);
  alignas(64) float near_lux[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    near_lux[i] = near_lux_beside(all_lux[i], near.lux[i], kinds);
    all_lux[i] += near_lux[i];
  }
  int any_environment = 0, any_waiting = 0;
  for (int i = 0; i < kPacket; ++i) {
    const float at = u[i] * all_lux[i];
    from_environment[i] = at < below[i] ? lanes[i] : 0;
    waiting[i] = at < below[i] ? 0 : lanes[i];
    within[i] = at / below[i];
    any_environment |= from_environment[i];
    any_waiting |= waiting[i];
  }
  if (any_environment) sample_environment(from_environment, choice, within, v, all_lux, out);
  for (std::size_t k = 0; any_waiting && k < directional; ++k) {
    const Directional& d = directional_[k];
    for (int i = 0; i < kPacket; ++i) {
      if (!waiting[i]) continue;
      const float lux = own_lux(d, i);
      if (u[i] * all_lux[i] - below[i] < lux) {
        LightSample sample = sample_punctual(d.light, point.at(i));
        sample.radiance *= all_lux[i] / lux;
        out.set(i, sample);
        waiting[i] = 0;
      }
      below[i] += lux;
    }
  }
  if (!any_waiting) return;
  for (int i = 0; i < kPacket; ++i) within[i] = (u[i] * all_lux[i] - below[i]) / near_lux[i];
  sample_near(waiting, point, within, v, near, near_lux, all_lux, out);
}

void Lights::sample_environment(const int lanes[kPacket], const Choice choice[kPacket], const float u[kPacket],
                                const float v[kPacket], const float all_lux[kPacket], LightPacket& out) const {
  EnvironmentLight::Choice sky[kPacket];
  for (int i = 0; i < kPacket; ++i) sky[i] = choice[i].environment;
  EnvironmentLight::Samples samples;
  environment_.sample(lanes, sky, u, v, samples);
  for (int i = 0; i < kPacket; ++i) {
    if (!lanes[i]) continue;
    const float density = choice[i].environment_lux / all_lux[i] * samples.pdf[i];
    out.set(i,
            {samples.direction.at(i), std::numeric_limits<float>::infinity(), samples.nits.at(i) / density, density});
  }
}

LightSample Lights::sample_punctual(const PunctualLight& light, glm::vec3 point) const {
  LightSample s;
  if (light.kind == PunctualLight::Kind::directional) {
    s.direction = -light.direction;
    s.distance_m = std::numeric_limits<float>::infinity();
    s.radiance = light.intensity;
    return s;
  }
  const glm::vec3 to_light = light.position - point;
  const float squared = glm::dot(to_light, to_light);
  if (!(squared > 0)) return s;
  s.distance_m = std::sqrt(squared);
  s.direction = to_light / s.distance_m;
  s.radiance = light.intensity / squared;
  // KHR_lights_punctual: recommended range window and cone fall-off
  if (light.range_m > 0) {
    const float ratio = s.distance_m / light.range_m;
    s.radiance *= std::max(std::min(1 - ratio * ratio * ratio * ratio, 1.0f), 0.0f);
  }
  if (light.kind == PunctualLight::Kind::spot) {
    const float width = std::max(light.cos_inner_cone - light.cos_outer_cone, 1e-3f);
    const float a = std::clamp((-glm::dot(light.direction, s.direction) - light.cos_outer_cone) / width, 0.0f, 1.0f);
    s.radiance *= a * a;
  }
  return s;
}

void Lights::sample_near(const int lanes[kPacket], const Vec3Packet& point, const float u[kPacket],
                         const float v[kPacket], const NearLights::Choice& choice, const float near_lux[kPacket],
                         const float all_lux[kPacket], LightPacket& out) const {
  struct Lane {
    int triangle = -1;  // of near_.triangles()
    float b1 = 0, b2 = 0;
  };
  std::array<Lane, kPacket> chosen;
  Vec3Packet to_light, normal;
  alignas(64) float area[kPacket], probability[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    to_light.set(i, glm::vec3(0));
    normal.set(i, glm::vec3(0));
    area[i] = probability[i] = 1;
    if (!lanes[i]) continue;
    if (!(near_lux[i] > 0)) {
      out.set(i, {});
      continue;
    }
    float along = u[i];
    const NearLights::Picked picked = near_.pick(choice, i, along);
    probability[i] = picked.probability * near_lux[i] / all_lux[i];
    if (picked.light < scene_.lights.size()) {
      LightSample sample = sample_punctual(scene_.lights[picked.light], point.at(i));
      sample.radiance /= probability[i];
      out.set(i, sample);
      continue;
    }
    Lane& lane = chosen[i];
    lane.triangle = static_cast<int>(picked.light - scene_.lights.size());
    // uniform over the triangle (Heitz 2019, low distortion)
    const float half = 0.5f * std::min(along, v[i]);
    lane.b1 = along - half, lane.b2 = v[i] - half;
    const NearLights::Triangle& light = near_.triangles()[lane.triangle];
    to_light.set(i, light.corner + lane.b1 * light.first_edge + lane.b2 * light.second_edge - point.at(i));
    normal.set(i, light.normal);
    area[i] = light.area_m2;
  }
  alignas(64) float distance[kPacket], pdf[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const float x = to_light.x[i], y = to_light.y[i], z = to_light.z[i];
    const float squared = x * x + y * y + z * z, length = std::sqrt(squared), scale = 1 / length;
    const float cosine = std::abs(normal.x[i] * x + normal.y[i] * y + normal.z[i] * z) * scale;
    to_light.x[i] = x * scale, to_light.y[i] = y * scale, to_light.z[i] = z * scale;
    distance[i] = length;
    pdf[i] = cosine > 1e-6f ? squared / (cosine * area[i]) : 0.0f;  // 0 where a light is seen edge-on
  }
  for (int i = 0; i < kPacket; ++i) {
    if (chosen[i].triangle < 0) continue;
    LightSample sample;
    if (pdf[i] > 0) {
      const NearLights::Triangle& light = near_.triangles()[chosen[i].triangle];
      const Mesh& mesh = scene_.meshes[light.mesh];
      const bool is_there = scene_.materials[mesh.material].alpha_cutoff <= 0 ||
                            !is_cut_out(scene_, mesh, light.triangle, chosen[i].b1, chosen[i].b2);
      const glm::vec3 nits =
          is_there ? emission_at(scene_, mesh, light.triangle, chosen[i].b1, chosen[i].b2) : glm::vec3(0);
      sample = {to_light.at(i),          distance[i], nits / (pdf[i] * probability[i]),
                pdf[i] * probability[i], light.mesh,  light.triangle};
    }
    out.set(i, sample);
  }
}

float Lights::environment_pdf(glm::vec3 point, glm::vec3 normal, glm::vec3 direction, LightKinds kinds) const {
  if (environment_.dark()) return 0;
  const Choice choice = choice_at(point, normal, kinds);
  return choice.environment_lux / choice.all_lux * environment_.pdf(choice.environment, direction);
}

float Lights::triangle_pdf(glm::vec3 point, glm::vec3 normal, unsigned mesh, unsigned triangle, float distance_m,
                           float abs_cos_at_light, LightKinds kinds) const {
  const int index = near_.index_of(mesh, triangle);
  if (index < 0 || !(abs_cos_at_light > 1e-6f)) return 0;
  const Choice choice = choice_at(point, normal, kinds);
  const float probability = near_.probability(point, normal, choice.near, index);
  if (!(probability > 0)) return 0;
  return choice.near_lux / choice.all_lux * probability * distance_m * distance_m /
         (abs_cos_at_light * near_.triangles()[index].area_m2);
}

}  // namespace dualpixel::simulator
