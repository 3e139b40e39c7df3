#include "simulator/render/glass_paths.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulator/render/shading/glass.h"
#include "simulator/render/shading/radiometry.h"

namespace dualpixel::simulator {
namespace {

constexpr int kMostPassages = 32;

bool is_glass(const Scene& scene, unsigned mesh) { return is_glass(scene, scene.meshes[mesh]); }

glm::vec3 direction_of(const RayPacket& rays, int i) {
  return {rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]};
}

Hit hit_of(const RayPacket& rays, int i) {
  return {rays.far[i], rays.mesh[i], rays.triangle[i], rays.u[i], rays.v[i], rays.placement[i]};
}

/// Solid glass met from within.
bool leaves_solid(const Scene& scene, const RayPacket& rays, int i) {
  const Hit hit = hit_of(rays, i);
  const Mesh& mesh = scene.meshes[hit.mesh];
  if (!scene.materials[mesh.material].layers->solid) return false;
  return glm::dot(outward_normal(mesh, hit), direction_of(rays, i)) > 0;
}

/// visit(lane, surface) for all hits of `lanes`, mesh by mesh.
template <typename Visit>
void each_surface(const Scene& scene, const int lanes[kPacket], const RayPacket& rays, Visit visit) {
  alignas(64) int waiting[kPacket];
  std::copy_n(lanes, kPacket, waiting);
  for (int first = 0; first < kPacket; ++first) {
    if (!waiting[first]) continue;
    alignas(64) int here[kPacket];
    for (int i = 0; i < kPacket; ++i) {
      here[i] = rays.mesh[i] == rays.mesh[first] ? waiting[i] : 0;
      waiting[i] &= ~here[i];
    }
    SurfacePacket surfaces;
    surfaces_at(scene, scene.meshes[rays.mesh[first]], here, rays, surfaces);
    for (int i = 0; i < kPacket; ++i) {
      if (here[i]) visit(i, surfaces.at(i), surfaces.magnitude[i]);
    }
  }
}

/// From the hit of lane `i` on, off its surface by more than the hit's rounding error.
void go_on(RayPacket& rays, int i, const Surface& s, float magnitude, float distance_m, glm::vec3 direction) {
  const float off = 1e-5f * std::max(magnitude, distance_m);
  const float side = glm::dot(direction, s.geometric_normal) < 0 ? -off : off;
  const glm::vec3 origin = s.position + side * s.geometric_normal;
  rays.origin_x[i] = origin.x, rays.origin_y[i] = origin.y, rays.origin_z[i] = origin.z;
  rays.direction_x[i] = direction.x, rays.direction_y[i] = direction.y, rays.direction_z[i] = direction.z;
  rays.mesh[i] = kNoMesh;
}

/// Density with which light samples at the last reflection of path `i` find what lies straight ahead, beyond all glass.
float straight_pdf(const RenderScene& world, const RayPacket& rays, const Paths& paths, int i) {
  if (!world.lights.has_soft()) return 0;
  const glm::vec3 origin(rays.origin_x[i], rays.origin_y[i], rays.origin_z[i]);
  const glm::vec3 direction = glm::normalize(direction_of(rays, i));
  float before = 0;
  std::optional<Hit> hit = world.intersector.intersect({origin, direction});
  for (int passage = 0; hit && passage < kMostPassages && is_glass(world.scene, hit->mesh); ++passage) {
    before += hit->t;
    const glm::vec3 point = glm::abs(origin + before * direction);
    before += 1e-5f * std::max({point.x, point.y, point.z, before});
    hit = world.intersector.intersect({origin + before * direction, direction});
  }
  const glm::vec3 start = paths.start.at(i), normal = paths.normal.at(i);
  if (!hit) return world.lights.environment_pdf(start, normal, direction, paths.kinds);
  const glm::vec3 facing = geometric_normal(world.scene.meshes[hit->mesh], *hit, direction);
  return world.lights.triangle_pdf(start, normal, hit->mesh, hit->triangle, paths.before_m[i] + before + hit->t,
                                   std::abs(glm::dot(facing, direction)), paths.kinds);
}

void scale_throughput(Paths& paths, int i, glm::vec3 by) {
  paths.throughput.set(i, paths.throughput.at(i) * by);
  paths.unlit_throughput.set(i, paths.unlit_throughput.at(i) * by);
}

/// The paths of one packet on their way through glass.
class GlassWalk {
 public:
  GlassWalk(const RenderScene& world, RayPacket& rays, Paths& paths) : world_(world), rays_(rays), paths_(paths) {}

  /// Lanes at glass that have not settled; false: none.
  bool find_lanes(int lanes[kPacket]) const {
    int any = 0;
    for (int i = 0; i < kPacket; ++i) {
      const bool here = paths_.active[i] && !settled_[i] && rays_.mesh[i] != kNoMesh;
      any |= lanes[i] = here && is_glass(world_.scene, rays_.mesh[i]) ? -1 : 0;
    }
    return any;
  }

  void step(int i, const Surface& s, float magnitude, bool may_stay, float u, float v, float choice) {
    const glm::vec3 direction = direction_of(rays_, i);
    const float length = glm::length(direction), distance = rays_.far[i] * length;
    const glm::vec3 to_eye = -direction / length;
    const bool leaves = leaves_solid(world_.scene, rays_, i);
    if (leaves && !within_[i]) scale_throughput(paths_, i, absorbed(*s.layers, distance));  // it began in there
    float goes_on = 1;
    if (may_stay && !leaves) {
      const float stay = stays(s, to_eye);
      goes_on = 1 - stay;
      if (choice < stay) {
        settled_[i] = true;
        return scale_throughput(paths_, i, glm::vec3(1 / stay));
      }
      choice = (choice - stay) / goes_on;
    }
    const Passage passage = sample_passage(s, to_eye, leaves, choice, u, v);
    if (passage.share == glm::vec3(0)) {
      paths_.active[i] = 0;
      return;
    }
    scale_throughput(paths_, i, passage.share / goes_on);
    const bool bends = s.layers->solid || s.roughness >= kClearRoughness;
    const bool weighed = paths_.pdf[i] > 0 && paths_.pdf[i] < kCountedInFull;
    if (bends && weighed && paths_.straight_pdf[i] < 0) paths_.straight_pdf[i] = straight_pdf(world_, rays_, paths_, i);
    paths_.before_m[i] += distance;
    go_on(rays_, i, s, magnitude, distance, passage.direction);
    rays_.far[i] = std::numeric_limits<float>::infinity();
    const bool inside = s.layers->solid && glm::dot(passage.direction, s.geometric_normal) * (leaves ? -1 : 1) < 0;
    within_[i] = inside ? s.layers : nullptr;
  }

  /// After the rays of `lanes` have met what is next.
  void absorb(const int lanes[kPacket]) {
    for (int i = 0; i < kPacket; ++i) {
      if (lanes[i] && paths_.active[i] && within_[i] && rays_.mesh[i] != kNoMesh) {
        scale_throughput(paths_, i, absorbed(*within_[i], rays_.far[i]));
      }
    }
  }

 private:
  const RenderScene& world_;
  RayPacket& rays_;
  Paths& paths_;
  std::array<bool, kPacket> settled_{};
  std::array<const Layers*, kPacket> within_{};  ///< the solid glass that the ray is in
};

}  // namespace

bool find_divided(const RenderScene& world, const RayPacket& rays, const Paths& paths, int lanes[kPacket]) {
  int any = 0;
  for (int i = 0; i < kPacket; ++i) {
    const bool at_glass = paths.active[i] && rays.mesh[i] != kNoMesh && is_glass(world.scene, rays.mesh[i]);
    any |= lanes[i] = at_glass && !leaves_solid(world.scene, rays, i) ? -1 : 0;
  }
  return any;
}

void pass_glass(const RenderScene& world, const PathOptions& options, const SampleIndices& indices, int bounce,
                RayPacket& rays, Paths& paths) {
  const bool from_camera = bounce == 0;
  if (from_camera) paths.unlit_throughput = paths.throughput;  // camera rays have none yet
  GlassWalk walk(world, rays, paths);
  alignas(64) int lanes[kPacket];
  constexpr std::uint32_t kGlassStreams = 0x10000;  // beyond all others
  for (int passage = 0; walk.find_lanes(lanes); ++passage) {
    if (passage == kMostPassages) {
      for (int i = 0; i < kPacket; ++i) paths.active[i] &= ~lanes[i];
      return;
    }
    alignas(64) float u[kPacket], v[kPacket], choice[kPacket], unused[kPacket];
    const std::uint32_t stream = kGlassStreams + 2 * (kMostPassages * indices.reflections_before(bounce) + passage);
    path_samples(options.sampling, indices, stream, choice, unused);
    path_samples(options.sampling, indices, stream + 1, u, v);
    const bool may_stay = bounce <= options.max_bounces && !(from_camera && passage == 0);
    each_surface(world.scene, lanes, rays, [&](int i, const Surface& s, float magnitude) {
      walk.step(i, s, magnitude, may_stay, u[i], v[i], choice[i]);
    });
    for (int i = 0; i < kPacket; ++i) lanes[i] &= paths.active[i] && rays.mesh[i] == kNoMesh ? -1 : 0;
    if (options.log) write_down(*options.log, lanes, rays, false, false);
    world.intersector.intersect(lanes, rays, false);
    walk.absorb(lanes);
  }
}

void dim_by_glass(const RenderScene& world, const int active[kPacket], const int hidden[kPacket],
                  const RayPacket& shadow_rays, Vec3Packet& light) {
  alignas(64) RayPacket rays = shadow_rays;
  alignas(64) int lanes[kPacket];
  for (int i = 0; i < kPacket; ++i) lanes[i] = active[i] && !hidden[i] ? -1 : 0;
  glm::vec3 within_per_m[kPacket] = {};  // absorption of the solid glass that the ray is in, where it entered it
  for (int passage = 0; passage < kMostPassages; ++passage) {
    alignas(64) float far[kPacket];
    alignas(64) int before[kPacket];
    std::copy_n(rays.far, kPacket, far);
    std::copy_n(lanes, kPacket, before);
    const bool any = world.intersector.intersect_glass(lanes, rays);
    for (int i = 0; i < kPacket; ++i) {  // a lamp in the glass
      if (!before[i] || lanes[i] || !std::isfinite(far[i])) continue;
      const float distance = far[i] * glm::length(direction_of(rays, i));
      light.set(i, light.at(i) * glm::exp(-within_per_m[i] * distance));
    }
    if (!any) return;
    each_surface(world.scene, lanes, rays, [&](int i, const Surface& s, float magnitude) {
      const glm::vec3 direction = direction_of(rays, i);
      const float distance = rays.far[i] * glm::length(direction);
      const bool leaves = leaves_solid(world.scene, rays, i);
      glm::vec3 share = passing(s, std::abs(glm::dot(s.normal, direction)) / glm::length(direction), leaves);
      if (leaves) share *= absorbed(*s.layers, distance);
      within_per_m[i] = s.layers->solid && !leaves ? s.layers->absorption_per_m : glm::vec3(0);
      light.set(i, light.at(i) * share);
      far[i] -= rays.far[i];
      go_on(rays, i, s, magnitude, distance, direction);
    });
    std::copy_n(far, kPacket, rays.far);
  }
  for (int i = 0; i < kPacket; ++i) {
    if (lanes[i]) light.set(i, glm::vec3(0));
  }
}

std::optional<Hit> seen_surface(const RenderScene& world, const Ray& ray) {
  std::optional<Hit> hit = world.intersector.intersect(ray);
  float before = 0;
  for (int passage = 0; hit && passage < kMostPassages && is_glass(world.scene, hit->mesh); ++passage) {
    alignas(64) RayPacket rays{};
    constexpr int kFirst[kPacket] = {-1};
    rays.direction_x[0] = ray.direction.x, rays.direction_y[0] = ray.direction.y, rays.direction_z[0] = ray.direction.z;
    rays.triangle[0] = hit->triangle, rays.u[0] = hit->u, rays.v[0] = hit->v, rays.placement[0] = hit->placement;
    SurfacePacket surfaces;
    surfaces_at(world.scene, world.scene.meshes[hit->mesh], kFirst, rays, surfaces);
    const Surface s = surfaces.at(0);
    const float length = glm::length(ray.direction), cosine = std::abs(glm::dot(s.normal, ray.direction)) / length;
    if (s.layers->solid || s.roughness >= kClearRoughness || luminance(passing(s, cosine, false)) < 0.5f) break;
    before += hit->t + 1e-5f * std::max(surfaces.magnitude[0] / length, hit->t + before);
    hit = world.intersector.intersect({ray.origin + before * ray.direction, ray.direction});
  }
  if (hit) hit->t += before;
  return hit;
}

}  // namespace dualpixel::simulator
