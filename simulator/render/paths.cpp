#include "simulator/render/paths.h"

#include <algorithm>
#include <cmath>

#include "simulator/render/glass_paths.h"
#include "simulator/render/light/surface_lattice.h"
#include "simulator/render/shading/bsdf.h"
#include "simulator/render/shading/radiometry.h"
#include "simulator/render/shading/surface.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::simulator {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNoPoints = kInfinity;  ///< `spread` of paths that sample all of their light themselves

void set_ray(RayPacket& rays, int i, glm::vec3 origin, glm::vec3 direction, float far) {
  rays.origin_x[i] = origin.x, rays.origin_y[i] = origin.y, rays.origin_z[i] = origin.z;
  rays.direction_x[i] = direction.x, rays.direction_y[i] = direction.y, rays.direction_z[i] = direction.z;
  rays.far[i] = far;
  rays.mesh[i] = kNoMesh;
}

struct Padded {
  alignas(64) float u[kPacket], v[kPacket];
};

/// Rays towards the lights, and what each adds to its path if nothing is in its way.
struct ShadowRays {
  alignas(64) int active[kPacket];
  RayPacket rays;
  Vec3Packet arriving;
};

/// kPacket where there is none.
int first_set(const int lanes[kPacket]) {
  int any = 0;
  for (int i = 0; i < kPacket; ++i) any |= lanes[i];
  if (!any) return kPacket;
  int first = 0;
  while (!lanes[first]) ++first;
  return first;
}

/// How much of light found along a sampled ray counts when the light sampler could have found it too (balance
/// heuristic, Veach 1995).
float mis_weight(float own_pdf, float other_pdf) {
  if (own_pdf == kCountedInFull) return 1;
  return own_pdf > 0 ? own_pdf / (own_pdf + other_pdf) : 0;
}

/// The light sampler's density against which a path is weighed: that of what it has met, density(), or, where glass
/// bent it, of what light samples find instead. So the weights of both add up to 1 in each direction of reflection.
template <typename Density>
float other_pdf(const Paths& paths, int i, Density density) {
  if (paths.pdf[i] == kCountedInFull) return 0;
  return paths.straight_pdf[i] < 0 ? density() : paths.straight_pdf[i];
}

void add_light(Paths& paths, int i, glm::vec3 light) {
  paths.radiance.set(i, paths.radiance.at(i) + paths.throughput.at(i) * light);
}

void see_environment(const RenderScene& world, const RayPacket& rays, Paths& paths, int i) {
  const Environment& environment = world.scene.environment;
  if (environment.radiance_nits.empty() || paths.pdf[i] == 0) return;
  const glm::vec3 d = glm::normalize(glm::vec3(rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]));
  if (!std::isfinite(d.x + d.y + d.z)) return;  // a ray that is none meets nothing (Intersector)
  const float other = other_pdf(
      paths, i, [&] { return world.lights.environment_pdf(paths.start.at(i), paths.normal.at(i), d, paths.kinds); });
  add_light(paths, i, environment_radiance(environment, d) * mis_weight(paths.pdf[i], other));
}

/// `t`: what of the light reaches the start of each path.
void see_unlit(const Scene& scene, const Mesh& mesh, const int lanes[kPacket], const RayPacket& rays,
               const Vec3Packet& t, Paths& paths) {
  Vec3Packet color;
  base_colors_at(scene, mesh, lanes, rays, color);
  Vec3Packet& r = paths.radiance;
  const float white_nits = scene.unlit_white_nits;
#pragma GCC ivdep
  for (int i = 0; i < kPacket; ++i) {  // `t` of lanes that met something else may be anything, NaN included
    r.x[i] += lanes[i] ? t.x[i] * color.x[i] * white_nits : 0.0f;
    r.y[i] += lanes[i] ? t.y[i] * color.y[i] * white_nits : 0.0f;
    r.z[i] += lanes[i] ? t.z[i] * color.z[i] * white_nits : 0.0f;
  }
}

/// The sixteen hits of one packet, seen from where their rays came from.
struct Hits {
  SurfacePacket surface;
  Vec3Packet to_eye, start;  ///< `start`: off the surface by more than the hit's rounding error
  alignas(64) float distance[kPacket];
  alignas(64) float spacing_m[kPacket];  ///< between points of light
};

void hits_at(const RenderScene& world, unsigned mesh_id, const int lanes[kPacket], const RayPacket& rays, Hits& hits) {
  const SurfacePacket& surface = hits.surface;
  surfaces_at(world.scene, world.scene.meshes[mesh_id], lanes, rays, hits.surface);
  for (int i = 0; i < kPacket; ++i) {
    const float dx = rays.direction_x[i], dy = rays.direction_y[i], dz = rays.direction_z[i];
    const float length = std::sqrt(dx * dx + dy * dy + dz * dz);
    hits.to_eye.x[i] = -dx / length, hits.to_eye.y[i] = -dy / length, hits.to_eye.z[i] = -dz / length;
    hits.distance[i] = rays.far[i] * length;
    const float px = surface.position.x[i], py = surface.position.y[i], pz = surface.position.z[i];
    const float off = 1e-5f * std::max(surface.magnitude[i], hits.distance[i]);
    hits.start.x[i] = px + off * surface.geometric_normal.x[i];
    hits.start.y[i] = py + off * surface.geometric_normal.y[i];
    hits.start.z[i] = pz + off * surface.geometric_normal.z[i];
  }
}

/// Light that the surface itself emits.
void add_emission(const RenderScene& world, unsigned mesh_id, const int lanes[kPacket], const RayPacket& rays,
                  const Hits& hits, Paths& paths) {
  for (int i = 0; i < kPacket; ++i) {
    if (!lanes[i] || paths.pdf[i] == 0) continue;
    const float cosine = glm::dot(hits.surface.geometric_normal.at(i), hits.to_eye.at(i));
    const float other = other_pdf(paths, i, [&] {
      return world.lights.triangle_pdf(paths.start.at(i), paths.normal.at(i), mesh_id, rays.triangle[i],
                                       hits.distance[i], cosine, paths.kinds);
    });
    add_light(paths, i, hits.surface.emission_nits.at(i) * mis_weight(paths.pdf[i], other));
  }
}

/// The surface at a vertex, for all triangles around it, in lane 0: normals, and where rays start.
void surface_of_vertex(const Mesh& mesh, const LatticePoint& point, Hits& hits) {
  const glm::vec3 position = mesh.positions[point.vertex];
  const glm::vec3 normal = (point.behind ? -1.0f : 1.0f) * mesh.normals[point.vertex];
  const float magnitude = std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)});
  hits.surface.normal.set(0, normal);
  hits.surface.geometric_normal.set(0, normal);
  hits.start.set(0, position + 1e-5f * magnitude * normal);
}

/// The same at any point of a lattice.
void surface_of(const RenderScene& world, const TriangleLattice& lattice, const LatticePoint& point, Hits& hits) {
  if (point.vertex >= 0) return surface_of_vertex(world.scene.meshes[lattice.hit().mesh], point, hits);
  const glm::vec3 view = glm::normalize(lattice.view());
  alignas(64) RayPacket rays{};
  rays.direction_x[0] = view.x, rays.direction_y[0] = view.y, rays.direction_z[0] = view.z;
  rays.triangle[0] = lattice.hit().triangle, rays.placement[0] = lattice.hit().placement;
  rays.u[0] = point.u, rays.v[0] = point.v;
  constexpr int kFirst[kPacket] = {-1};
  hits_at(world, lattice.hit().mesh, kFirst, rays, hits);
}

struct Sent {
  glm::vec3 direction;
  int to = -1;  ///< as Paths::sent_to
};

/// A direction of diffuse reflection: a share of them towards bright surfaces, the others by reflected(u, v).
template <typename Reflected>
Sent send(const RenderScene& world, glm::vec3 start, float u, float v, Reflected reflected) {
  const float share = world.bright.share();
  if (u >= share) return {reflected((u - share) / (1 - share), v)};
  const BrightSurfaces::Target target = world.bright.towards(start, u / share, v);
  return {target.direction, target.triangle};
}

/// What BrightSurfaces calls the triangle that a ray has met, if any: -1 where it is none of them.
int bright_triangle(const RenderScene& world, unsigned mesh, unsigned triangle) {
  return world.bright.share() == 0 || mesh == kNoMesh ? -1 : world.bright.met(mesh, triangle);
}

/// Density of a direction of diffuse reflection in which a ray meets `mesh` (or kNoMesh): sent there or reflected.
float both_pdf(const RenderScene& world, float reflected_pdf, unsigned mesh, unsigned triangle, glm::vec3 direction,
               float distance_m) {
  const float share = world.bright.share();
  const int met = bright_triangle(world, mesh, triangle);
  const float sent_pdf = met < 0 ? 0 : world.bright.pdf(met, direction, distance_m);
  return (1 - share) * reflected_pdf + share * sent_pdf;
}

/// Weighs what paths carry by the density of their directions in both ways, which is known when they have met something
/// (balance heuristic). What hides a bright surface from a ray that was sent there is left to reflection.
void weigh_sent(const RenderScene& world, const RayPacket& rays, Paths& paths) {
  if (world.bright.share() == 0) return;
  for (int i = 0; i < kPacket; ++i) {
    if (!paths.active[i] || paths.reflected_pdf[i] == 0) continue;
    if (paths.sent_to[i] >= 0 && bright_triangle(world, rays.mesh[i], rays.triangle[i]) != paths.sent_to[i]) {
      paths.active[i] = 0;
      continue;
    }
    const glm::vec3 direction(rays.direction_x[i], rays.direction_y[i], rays.direction_z[i]);
    const float weight = paths.reflected_pdf[i] / both_pdf(world, paths.reflected_pdf[i], rays.mesh[i],
                                                           rays.triangle[i], direction, rays.far[i]);
    paths.throughput.set(i, paths.throughput.at(i) * weight);
    paths.unlit_throughput.set(i, paths.unlit_throughput.at(i) * weight);
    if (paths.pdf[i] != kCountedInFull) paths.pdf[i] /= weight;
  }
}

/// Sum over samples of light, and of its squared luminance.
struct SampleSum {
  glm::vec3 light{0};
  float squares = 0;

  void add(glm::vec3 sample) {
    light += sample;
    squares += luminance(sample) * luminance(sample);
  }
  /// `scale` times the mean of so many samples, and its standard error.
  SurfaceLight soft(int samples, float scale = 1) const {
    const auto count = static_cast<float>(samples);
    const float mean = luminance(light) / count;
    const float variance = std::max(squares / count - mean * mean, 0.0f) / count;
    return {.soft = scale / count * light, .soft_error = scale * std::sqrt(variance)};
  }
};

/// Sum over sampled lights of irradiance that nothing hides.
struct LightSum {
  alignas(64) ShadowRays shadow{};
  const RenderScene& world;
  glm::vec3 start, normal, geometric_normal;
  SampleSum irradiance;

  LightSum(const RenderScene& scene, const Hits& hits)
      : world(scene),
        start(hits.start.at(0)),
        normal(hits.surface.normal.at(0)),
        geometric_normal(hits.surface.geometric_normal.at(0)) {}

  void set(int i, glm::vec3 direction, float distance_m, glm::vec3 radiance) {
    const float cosine = glm::dot(normal, direction);
    shadow.active[i] = 0;
    if (radiance == glm::vec3(0) || !(cosine > 0) || !(glm::dot(geometric_normal, direction) > 0)) return;
    shadow.arriving.set(i, radiance * cosine);
    set_ray(shadow.rays, i, start, direction, distance_m * (1 - 1e-4f));
    shadow.active[i] = -1;
  }
  void add_unhidden() {
    alignas(64) int hidden[kPacket];
    if (first_set(shadow.active) == kPacket) return;
    world.intersector.occluded(shadow.active, shadow.rays, false, hidden);
    if (world.intersector.has_glass()) dim_by_glass(world, shadow.active, hidden, shadow.rays, shadow.arriving);
    for (int i = 0; i < kPacket; ++i) {
      if (shadow.active[i] && !hidden[i]) irradiance.add(shadow.arriving.at(i));
    }
  }
};

int packets_of(int samples) { return (samples + kPacket - 1) / kPacket; }

/// Of lights of one kind, by at least `samples` samples, as soft light.
/// `shared`: as many directions, spread as their cosines, look for the same light.
SurfaceLight sampled_irradiance(const RenderScene& world, const Hits& hits, std::uint64_t key, int samples,
                                LightKinds kinds, bool shared) {
  Vec3Packet point, normal;
  alignas(64) int all[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    point.set(i, hits.start.at(0));
    normal.set(i, hits.surface.normal.at(0));
    all[i] = -1;
  }
  LightSum sum(world, hits);
  const int packets = packets_of(samples);
  for (int packet = 0; packet < packets; ++packet) {
    alignas(64) float numbers[4][kPacket];
    joint_samples(packet * kPacket, key, numbers);
    LightPacket light;
    world.lights.sample(all, point, normal, numbers[0], numbers[1], light, kinds);
    for (int i = 0; i < kPacket; ++i) {
      const glm::vec3 direction = light.direction.at(i);
      const float cosine_pdf = std::max(glm::dot(sum.normal, direction), 0.0f) / kPi;
      const float weight = shared && light.pdf[i] > 0 ? mis_weight(light.pdf[i], cosine_pdf) : 1;
      sum.set(i, direction, light.distance_m[i], light.radiance.at(i) * weight);
    }
    sum.add_unhidden();
  }
  return sum.irradiance.soft(packets * kPacket);
}

/// Of every light without extent.
glm::vec3 hard_irradiance(const RenderScene& world, const Hits& hits, std::uint64_t key, int samples) {
  constexpr std::size_t kMostOneByOne = 64;
  const std::size_t count = world.lights.hard_count();
  if (count > kMostOneByOne) {
    return sampled_irradiance(world, hits, hash(key, 1), samples, LightKinds::hard, false).soft;
  }
  LightSum sum(world, hits);
  for (std::size_t first = 0; first < count; first += kPacket) {
    for (int i = 0; i < kPacket; ++i) {
      const LightSample light = first + i < count ? world.lights.hard(first + i, sum.start) : LightSample{};
      sum.set(i, light.direction, light.distance_m, light.radiance);
    }
    sum.add_unhidden();
  }
  return sum.irradiance.light;
}

void find_nearest(const RenderScene& world, const PathOptions& options, RayPacket& rays, Paths& paths, int bounce);
void shade(const RenderScene& world, const PathOptions& options, RayPacket& rays, Paths& paths,
           const SampleIndices& indices, int bounce);

/// Mean of what arrives at a point along directions spread as their cosines, over the density 1 / pi: light that a path
/// of reflection `bounce` and more finds. `pdf_counts`: light samples of the soft kinds could have found it, too.
SurfaceLight gathered_light(const RenderScene& world, const PathOptions& options, const Hits& hits, std::uint64_t key,
                            int samples, int bounce, bool pdf_counts) {
  Surface matte;
  matte.normal = hits.surface.normal.at(0);
  const glm::vec3 up = hits.surface.geometric_normal.at(0), start = hits.start.at(0);
  const int packets = packets_of(samples);
  SampleSum sum;
  float nearness = 0, reflected = 0;
  for (int packet = 0; packet < packets; ++packet) {
    alignas(64) float numbers[4][kPacket];
    joint_samples(packet * kPacket, key, numbers);
    alignas(64) RayPacket rays;
    alignas(64) Paths paths;
    paths.kinds = LightKinds::soft;
    for (int i = 0; i < kPacket; ++i) {
      const Sent sent = pdf_counts ? Sent{sample_bsdf(matte, matte.normal, numbers[0][i], numbers[1][i])}
                                   : send(world, start, numbers[0][i], numbers[1][i],
                                          [&](float u, float v) { return sample_bsdf(matte, matte.normal, u, v); });
      const glm::vec3 direction = sent.direction;
      const float pdf = bsdf_pdf(matte, matte.normal, direction);
      set_ray(rays, i, start, direction, kInfinity);
      paths.active[i] = glm::dot(up, direction) > 0 && pdf > 0 ? -1 : 0;
      paths.throughput.set(i, glm::vec3(1));
      paths.unlit_throughput.set(i, glm::vec3(1));
      paths.radiance.set(i, glm::vec3(0));
      paths.pdf[i] = pdf_counts ? pdf : 0;
      paths.reflected_pdf[i] = pdf_counts ? 0 : pdf, paths.sent_to[i] = sent.to;
      paths.start.set(i, start);
      paths.normal.set(i, matte.normal);
      paths.spacing_m[i] = 0, paths.spread[i] = kNoPoints;
      paths.before_m[i] = 0, paths.straight_pdf[i] = -1;
    }
    const std::uint32_t mask = packets * kPacket / 2 - 1;
    const SampleIndices indices{static_cast<std::uint32_t>(packet) * kPacket / 2, mask, hash(key, 1), bounce};
    find_nearest(world, options, rays, paths, bounce);
    for (int i = 0; i < kPacket; ++i) {
      if (paths.sent_to[i] >= 0) continue;
      nearness += paths.active[i] ? 1 / rays.far[i] : 0;
      ++reflected;
    }
    shade(world, options, rays, paths, indices, bounce);
    trace_paths(world, options, indices, bounce + 1, rays, paths);
    for (int i = 0; i < kPacket; ++i) sum.add(paths.radiance.at(i));
  }
  SurfaceLight light = sum.soft(packets * kPacket, kPi);
  light.from_m = reflected / nearness;
  return light;
}

/// Of environment and emissive surfaces. Near an emissive surface light samples alone would be far off: there half of
/// the samples are directions.
SurfaceLight soft_irradiance(const RenderScene& world, const PathOptions& options, const Hits& hits, std::uint64_t key,
                             int samples) {
  if (!world.lights.has_soft()) return {};
  if (!world.lights.has_emissive()) return sampled_irradiance(world, hits, key, samples, LightKinds::soft, false);
  SurfaceLight light = sampled_irradiance(world, hits, key, samples / 2, LightKinds::soft, true);
  const SurfaceLight met =
      gathered_light(world, options, hits, hash(key, 4), samples / 2, options.max_bounces + 1, true);
  light.soft += met.soft;
  light.soft_error = std::hypot(light.soft_error, met.soft_error);
  return light;
}

/// Which light is looked up: direct (`bounces` 0), or what arrives after 1 to `bounces` reflections.
struct WantedLight {
  int bounces = 0;
  bool refined = false;  ///< at points closer than those that are looked up first
  bool surer = false;    ///< direct light from four times as many samples of its own; compared, never used as light

  /// Names it among the kinds of light at one point.
  std::uint64_t id() const {
    if (bounces == 0) return surer ? 1 : 0;
    return 2 * static_cast<std::uint64_t>(bounces) + (refined ? 1 : 0);
  }

  /// Of one reflection where there are several: more of them add to what the same paths find.
  WantedLight of_same_paths() const { return {std::min(bounces, 1), refined, surer}; }
};

/// Light at one point of a lattice.
SurfaceLight light_at(const RenderScene& world, const PathOptions& options, const TriangleLattice& lattice,
                      const LatticePoint& point, WantedLight wanted) {
  constexpr int kMoreReflected = 4, kMoreToBeSure = 4;
  LightCache& cache = *world.light_cache;
  const int bounces = wanted.bounces;
  const auto key_of = [&](std::uint64_t id) { return id == 0 ? point.key : hash(point.key, id) | 1; };
  const std::uint64_t key = key_of(wanted.id());
  if (const auto known = cache.table.find(point.group, key)) return *known;
  Hits hits;
  surface_of(world, lattice, point, hits);
  SurfaceLight light;
  // Reflected light varies more from path to path, and its points are few where they are neither vertices nor refined.
  const int more_reflected = bounces > 0 && point.vertex < 0 && !wanted.refined ? kMoreReflected : 1;
  const int more = wanted.surer ? kMoreToBeSure : more_reflected;
  constexpr int kMostSamples = 65536;  // points of a net
  const int samples =
      std::clamp(more * cache.options.light_samples >> (2 * lattice.fewer()), 1, kMostSamples);  // in whole packets
  const std::uint64_t random = hash(key_of(wanted.of_same_paths().id()), cache.scramble);
  if (bounces > 0) {
    light = gathered_light(world, options, hits, random, samples, options.max_bounces - bounces + 1, false);
  } else {
    light = soft_irradiance(world, options, hits, random, samples);
    if (!wanted.surer) light.hard = hard_irradiance(world, hits, random, samples);
  }
  return cache.table.add(point.group, key, light);
}

/// Light interpolated between the points around a hit, and whether they agree on it so far that it may be.
struct InterpolatedLight {
  SurfaceLight light;
  bool soft_agrees = true, hard_agrees = true;
};

/// Looks up light for the hits of one packet, many of which share a triangle or even a cell of its lattice.
class LightLookup {
 public:
  LightLookup(const RenderScene& world, const PathOptions& options, int bounces)
      : world_(world), options_(options), bounces_(bounces), recent_(world.light_cache->recent.local()) {}

  /// Whether the triangle is no longer than `size_m`.
  bool is_small(const Hit& hit, glm::vec3 direction, float size_m) {
    return lattice_of(small_, hit, direction, size_m).is_small();
  }

  InterpolatedLight at(const Hit& hit, glm::vec3 direction, float spacing_m) {
    for (int level = 0;; ++level) {
      const TriangleLattice& lattice = lattice_of(lattices_[level], hit, direction, spacing_m);
      const LatticeCell cell = lattice.cell(hit.u, hit.v);
      const CellLight& around = around_cell(lattice, cell, level);
      if (level + 1 == kLevels || !is_coarse(lattice, around, level)) return interpolated(cell, around);
      spacing_m = lattice.reach_m() / 2;
    }
  }

 private:
  static constexpr int kLevels = 5;

  /// `last`: the one that was made last.
  const TriangleLattice& lattice_of(TriangleLattice& last, const Hit& hit, glm::vec3 direction, float spacing_m) {
    if (!last.is_of(hit, direction, spacing_m)) last = TriangleLattice(world_.scene, hit, direction, spacing_m);
    return last;
  }

  /// Whether light may vary so much between these points that it takes points half as far apart, at most. Direct light
  /// varies where it was found to, and as the surface turns; reflected light, too, and as the distance that it comes
  /// from is short (Ward 1988). What is interpolated is off by about an eighth of the sum below. Beyond two steps, as
  /// close as points of direct light, it takes closer ones only beside contacts where they differ. Small triangles near
  /// others, as leaves are, would take too many points of reflected light.
  bool is_coarse(const TriangleLattice& lattice, const CellLight& around, int level) const {
    constexpr float kDirect = 0.3f, kDirectTurn = 0.1f, kReflected = 0.2f, kContact = 0.7f;
    const float turn = lattice.turn() * lattice.turn();
    if (bounces_ == 0) {
      return level == 0 && !lattice.is_small() && (around.soft_difference > kDirect || turn > kDirectTurn);
    }
    const float nearness = lattice.is_small() ? 0 : lattice.spacing_m() / around.from_m;
    if (level < 2) return nearness * nearness + turn > kReflected;
    return nearness > 1 && around.soft_difference > kContact;
  }

  // Where neighbors differ by more than this share of the larger, an edge of a shadow or of a surface in contact lies
  // between them, and light is sampled there.
  static constexpr float kSoft = 0.7f, kHard = 0.3f;

  /// The points with the least and the most luminance of one kind of light.
  struct Range {
    const SurfaceLight *low, *high;
    float low_nits, high_nits;
    float difference() const { return high_nits > 0 ? 1 - low_nits / high_nits : 0; }
  };

  static Range range_of(const CellLight& around, glm::vec3 SurfaceLight::*kind) {
    Range range{&around.light[0][0], &around.light[0][0], kInfinity, -1};
    for (const auto& row : around.light) {
      for (const SurfaceLight& light : row) {
        const float nits = luminance(light.*kind);
        if (nits < range.low_nits) range.low = &light, range.low_nits = nits;
        if (nits > range.high_nits) range.high = &light, range.high_nits = nits;
      }
    }
    return range;
  }

  /// What noise alone may do is no difference. Beside a point that no sample reached, so many errors are the square
  /// root of how many arrive at the other: of 4, all miss it with a probability of exp(-4).
  static bool is_more_than_noise(const Range& soft) {
    constexpr float kErrors = 3, kErrorsOfDark = 2;
    const float errors = soft.low->soft_error > 0 ? kErrors : kErrorsOfDark;
    return soft.high_nits - soft.low_nits > errors * std::hypot(soft.low->soft_error, soft.high->soft_error);
  }

  static bool noise_hides_a_shadow(const CellLight& around) {
    return around.soft_difference == 0 && range_of(around, &SurfaceLight::soft).difference() > kSoft;
  }

  static InterpolatedLight interpolated(const LatticeCell& cell, const CellLight& around) {
    InterpolatedLight out;
    out.soft_agrees = around.soft_difference <= kSoft, out.hard_agrees = around.hard_difference <= kHard;
    for (int k = 0; k < 2; ++k) {
      const LatticeCell::Row& row = cell.rows[k];
      const float right = row.share * row.beyond, left = row.share - right;
      out.light.soft += left * around.light[k][0].soft + right * around.light[k][1].soft;
      out.light.hard += left * around.light[k][0].hard + right * around.light[k][1].hard;
    }
    return out;
  }

  const CellLight& around_cell(const TriangleLattice& lattice, const LatticeCell& cell, int level) {
    const WantedLight wanted{bounces_, level > 0};
    const std::uint64_t key = lattice.key_of(cell) + 2 * wanted.id();
    if (recent_.slot(key).key == key) return recent_.slot(key);
    CellLight found = fetch(lattice, cell, wanted);
    // Where few samples arrive, their noise hides a full shadow. Whether there is one is asked of samples of its own:
    // light that is kept or not by what it was found to be is biased, and less so the less it decides.
    if (bounces_ == 0 && noise_hides_a_shadow(found)) {
      found.soft_difference = fetch(lattice, cell, {.surer = true}).soft_difference;
    }
    found.key = key;
    return recent_.slot(key) = found;
  }

  CellLight fetch(const TriangleLattice& lattice, const LatticeCell& cell, WantedLight wanted) const {
    CellLight found;
    for (int k = 0; k < 2; ++k) {
      const LatticeCell::Row& row = cell.rows[k];
      for (int side = 0; side < 2; ++side) {
        SurfaceLight& light = found.light[k][side];
        if (side == 1 && row.pieces == 0) {
          light = found.light[k][0];
          continue;
        }
        light = light_at(world_, options_, lattice, lattice.point(row.row, row.left + side, row.pieces), wanted);
        found.from_m = std::min(found.from_m, light.from_m);
      }
    }
    const Range soft = range_of(found, &SurfaceLight::soft), hard = range_of(found, &SurfaceLight::hard);
    if (is_more_than_noise(soft)) found.soft_difference = soft.difference();
    found.hard_difference = hard.difference();
    return found;
  }

  const RenderScene& world_;
  const PathOptions& options_;
  const int bounces_;
  RecentCells& recent_;
  TriangleLattice lattices_[kLevels];  ///< each of points half as far apart as the one before
  TriangleLattice small_;
};

/// What of each lane's light was taken from points on the surface.
struct KnownLight {
  int soft[kPacket], hard[kPacket];  ///< -1: all of this kind that is reflected diffusely
  Vec3Packet hard_irradiance;        ///< of lanes whose `hard` is set
  float nits[kPacket];               ///< luminance of the light reflected so
  int diffuse_by_lights[kPacket];    ///< -1: light samples alone find what is missing of it
};

/// Near surfaces that glow, light samples alone would be far off: there the next ray looks for diffuse light, too.
KnownLight nothing_known(const RenderScene& world, int bounces_left) {
  KnownLight known;
  for (int i = 0; i < kPacket; ++i) {
    known.soft[i] = known.hard[i] = 0, known.nits[i] = 0;
    known.diffuse_by_lights[i] = bounces_left == 0 && !world.lights.has_emissive() ? -1 : 0;
  }
  return known;
}

/// Whether points of light lie on the surface. Textures of normals make them vary between points.
bool has_points(const RenderScene& world, const Material& material, const Hits& hits) {
  return world.light_cache && !material.is_glass() && !hits.surface.hair && material.normal_texture.texture < 0;
}

void add_known_light(const RenderScene& world, const PathOptions& options, unsigned mesh_id, const int lanes[kPacket],
                     const RayPacket& rays, const Hits& hits, int bounces_left, Paths& paths, KnownLight& known) {
  constexpr float kIndirectSpacing = 4;  // over that of direct light, as it has no sharp shadows
  constexpr float kSmallPx = 4;          // photosites
  const Mesh& mesh = world.scene.meshes[mesh_id];
  alignas(64) int asking[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    asking[i] = lanes[i] && hits.spacing_m[i] > 0 && hits.spacing_m[i] < kInfinity ? -1 : 0;
  }
  if (first_set(asking) == kPacket || !has_points(world, world.scene.materials[mesh.material], hits)) return;
  const float small_px = kSmallPx / static_cast<float>(world.light_cache->options.light_spacing_px);
  LightLookup direct(world, options, 0), indirect(world, options, bounces_left);
  for (int i = 0; i < kPacket; ++i) {
    if (!asking[i]) continue;
    const glm::vec3 diffuse = diffuse_bsdf(hits.surface.at(i)), direction = -hits.to_eye.at(i);
    const float facing = std::abs(glm::dot(hits.surface.geometric_normal.at(i), direction));
    const float spacing_m = hits.spacing_m[i] / std::sqrt(std::max(facing, 0.1f));
    const Hit hit{0, mesh_id, rays.triangle[i], rays.u[i], rays.v[i], mesh.placements.empty() ? 0 : rays.placement[i]};
    // Points of reflected light take many paths each, more than ever ask for them where triangles are small: there all
    // light is sampled. Which are small does not depend on the spacing, so that closer points change nothing else.
    if (bounces_left > 0 && direct.is_small(hit, direction, small_px * spacing_m)) continue;
    const InterpolatedLight found = direct.at(hit, direction, spacing_m);
    if (!world.lights.has_emissive()) known.diffuse_by_lights[i] = -1;
    glm::vec3 irradiance(0);
    if (found.soft_agrees) known.soft[i] = -1, irradiance += found.light.soft;
    if (found.hard_agrees) known.hard[i] = -1, irradiance += found.light.hard;
    known.hard_irradiance.set(i, found.light.hard);
    if (bounces_left > 0 && (known.soft[i] || known.diffuse_by_lights[i])) {
      irradiance += indirect.at(hit, direction, kIndirectSpacing * spacing_m).light.soft;
    }
    known.nits[i] = luminance(diffuse * irradiance);
    add_light(paths, i, diffuse * irradiance);
  }
}

/// Numbers for one reflection of each path, drawn when first wanted.
class ScatterSamples {
 public:
  ScatterSamples(Sampling sampling, const SampleIndices& indices, int reflections_before)
      : sampling_(sampling), indices_(indices), reflections_before_(reflections_before) {}

  const Padded& light() { return drawn(0); }
  const Padded& reflection() { return drawn(1); }
  const Padded& roulette() { return drawn(2); }
  const Padded& strand() { return drawn(3); }
  const Padded& side() { return drawn(4); }
  const Padded& check() { return drawn(5); }

 private:
  const Padded& drawn(int which) {
    // What was added later has streams beyond all others, which stay as they were.
    constexpr std::uint32_t kStrandStreams = 0x20000, kCheckStreams = 0x40000;
    const std::uint32_t stream = which < 3   ? 3 * reflections_before_ + which
                                 : which < 5 ? kStrandStreams + 2 * reflections_before_ + which - 3
                                             : kCheckStreams + reflections_before_;
    if (!drawn_[which]) {
      path_samples(sampling_, indices_, stream, numbers_[which].u, numbers_[which].v);
    }
    drawn_[which] = true;
    return numbers_[which];
  }

  Sampling sampling_;
  const SampleIndices& indices_;
  int reflections_before_;
  bool drawn_[6] = {};
  Padded numbers_[6];
};

/// Whether to follow something of this size, for which 1 is always followed; what is followed counts 1 / keep.
bool keeps(float size, float random, float& keep) {
  keep = std::min(size, 1.0f);
  return random < keep;
}

/// The part of a surface's reflection that its next ray carries.
glm::vec3 carried(const Surface& s, glm::vec3 to_eye, glm::vec3 to_light, bool without_diffuse) {
  return bsdf(s, to_eye, to_light) - (without_diffuse ? diffuse_bsdf(s) : glm::vec3(0));
}

bool carries_nothing(const SurfacePacket& surface, bool without_diffuse) {
  return surface.lambertian && without_diffuse;
}

/// How far from its hit a ray begins: 0, or beyond the strand of hair that it would meet at once.
float way_out(const Hits& hits, int i, glm::vec3 direction) {
  if (!hits.surface.hair) return 0;
  const float along = glm::dot(direction, hits.surface.tangent.at(i));
  return 2.5f * hits.surface.radius_m[i] / std::sqrt(std::max(1 - along * along, 0.01f));
}

/// Whether reflection spreads rays so far that few of them would ask for the same points.
bool is_wide(const Surface& s, bool without_diffuse) {
  constexpr float kMostShared = 0.3f;  // roughness
  return s.roughness > kMostShared || !without_diffuse;
}

/// Whether a share of the reflected rays is sent towards bright surfaces.
bool sends_rays(const Surface& s, bool without_diffuse) { return !s.hair && is_wide(s, without_diffuse); }

/// Lets the light samples of strands look to one of both sides.
void turn_to_sides(const int lanes[kPacket], const Padded& numbers, SurfacePacket& surface) {
  for (int i = 0; i < kPacket; ++i) {
    if (!lanes[i] || numbers.u[i] < 0.5f) continue;
    surface.normal.set(i, -surface.normal.at(i));
    surface.geometric_normal.set(i, -surface.geometric_normal.at(i));
  }
}

/// One shadow ray from each hit to a sampled point of a light of these kinds.
void sample_lights(const RenderScene& world, const int lanes[kPacket], const Hits& hits, ScatterSamples& samples,
                   LightKinds kinds, const KnownLight& known, const Paths& paths, ShadowRays& shadow) {
  constexpr float kSmall = 0.15f;  // of the light that is known: what adds less is followed by fewer rays
  const Padded &light = samples.light(), &roulette = samples.roulette();
  LightPacket l;
  world.lights.sample(lanes, hits.start, hits.surface.normal, light.u, light.v, l, kinds);
  for (int i = 0; i < kPacket; ++i) {
    if (!lanes[i]) continue;
    const glm::vec3 direction = l.direction.at(i), radiance = l.radiance.at(i), to_eye = hits.to_eye.at(i);
    const float cosine = glm::dot(hits.surface.normal.at(i), direction);
    if (radiance == glm::vec3(0) || !(cosine > 0) || !(glm::dot(hits.surface.geometric_normal.at(i), direction) > 0)) {
      continue;
    }
    const Surface s = hits.surface.at(i);
    const bool hard = l.pdf[i] == 0, is_known = hard ? known.hard[i] : known.soft[i];
    const bool without_diffuse = known.soft[i] || known.diffuse_by_lights[i];
    const bool also_by_reflection = !hard && !carries_nothing(hits.surface, without_diffuse);
    glm::vec3 reflected = carried(s, to_eye, direction, without_diffuse);
    if (also_by_reflection) {
      const float pdf = bsdf_pdf(s, to_eye, direction);
      const bool sends = sends_rays(s, without_diffuse);
      reflected *= mis_weight(l.pdf[i],
                              sends ? both_pdf(world, pdf, l.mesh[i], l.triangle[i], direction, l.distance_m[i]) : pdf);
    }
    if (!is_known && without_diffuse) reflected += diffuse_bsdf(s);
    if (is_known && !without_diffuse) reflected -= diffuse_bsdf(s);
    const glm::vec3 arriving = reflected * radiance * cosine;
    float keep = 1;
    const float size = known.nits[i] > 0 ? luminance(glm::abs(arriving)) / (kSmall * known.nits[i]) : 1.0f;
    if (arriving == glm::vec3(0) || !keeps(size, roulette.u[i], keep)) continue;
    shadow.arriving.set(i, paths.throughput.at(i) * arriving / keep);
    // stop short of the light's own surface
    const float way = way_out(hits, i, direction);
    set_ray(shadow.rays, i, hits.start.at(i) + way * direction, direction, l.distance_m[i] * (1 - 1e-4f) - way);
    shadow.active[i] = -1;
  }
}

/// Light samples of the kinds that each lane still needs.
void sample_missing_lights(const RenderScene& world, const int lanes[kPacket], const Hits& hits,
                           ScatterSamples& samples, const KnownLight& known, const Paths& paths, ShadowRays& shadow) {
  const auto missing = [&](int i) -> std::optional<LightKinds> {
    if (!hits.surface.lambertian || (!known.soft[i] && !known.diffuse_by_lights[i])) return LightKinds::all;
    if (known.soft[i] && known.hard[i]) return {};
    if (known.soft[i]) return LightKinds::hard;
    return known.hard[i] ? LightKinds::soft : LightKinds::all;
  };
  for (const LightKinds kinds : {LightKinds::all, LightKinds::hard, LightKinds::soft}) {
    alignas(64) int wanted[kPacket];
    for (int i = 0; i < kPacket; ++i) wanted[i] = lanes[i] && missing(i) == kinds ? -1 : 0;
    if (first_set(wanted) == kPacket) continue;
    sample_lights(world, wanted, hits, samples, kinds, known, paths, shadow);
  }
}

/// A shadow may lie between points that agree on light without extent. So some of the paths that took it from points
/// look for it themselves, and the difference counts for all of them (a control variate): such a shadow is noisy, not
/// missing. With several lights each would need a ray, or noise of the choice would come in: then points are trusted.
void check_hard_light(const RenderScene& world, const int lanes[kPacket], const Hits& hits, ScatterSamples& samples,
                      const KnownLight& known, Paths& paths, ShadowRays& shadow) {
  constexpr float kShare = 0.25f;
  if (world.lights.hard_count() != 1) return;
  for (int i = 0; i < kPacket; ++i) {
    if (!lanes[i] || !known.hard[i] || samples.check().u[i] >= kShare) continue;
    const glm::vec3 diffuse = diffuse_bsdf(hits.surface.at(i)) / kShare;
    if (diffuse == glm::vec3(0)) continue;
    add_light(paths, i, -diffuse * known.hard_irradiance.at(i));
    const LightSample light = world.lights.hard(0, hits.start.at(i));
    const float cosine = glm::dot(hits.surface.normal.at(i), light.direction);
    if (light.radiance == glm::vec3(0) || !(cosine > 0) ||
        !(glm::dot(hits.surface.geometric_normal.at(i), light.direction) > 0)) {
      continue;
    }
    shadow.arriving.set(i, paths.throughput.at(i) * diffuse * light.radiance * cosine);
    set_ray(shadow.rays, i, hits.start.at(i), light.direction, light.distance_m * (1 - 1e-4f));
    shadow.active[i] = -1;
  }
}

/// The next ray of each path.
void sample_reflections(const RenderScene& world, const int lanes[kPacket], const Hits& hits, ScatterSamples& samples,
                        const KnownLight& known, RayPacket& rays, Paths& paths) {
  constexpr float kSmall = 0.25f;  // rays that carry less are followed less often
  for (int i = 0; i < kPacket; ++i) {
    const bool without_diffuse = known.soft[i] || known.diffuse_by_lights[i];
    if (!lanes[i] || carries_nothing(hits.surface, without_diffuse)) continue;
    Surface s = hits.surface.at(i);
    const glm::vec3 to_eye = hits.to_eye.at(i);
    const float u = samples.reflection().u[i], v = samples.reflection().v[i];
    const auto reflected = [&](float a, float b) {
      if (s.hair) return sample_strand(s, to_eye, {samples.strand().u[i], a, b, samples.strand().v[i]});
      return sample_bsdf(s, to_eye, a, b);
    };
    const bool sends = sends_rays(s, without_diffuse);
    const Sent sent = sends ? send(world, hits.start.at(i), u, v, reflected) : Sent{reflected(u, v)};
    const glm::vec3 direction = sent.direction;
    const float n_l = glm::dot(s.normal, direction);
    const float pdf = bsdf_pdf(s, to_eye, direction);
    if (!(n_l > 0) || !(glm::dot(s.geometric_normal, direction) > 0) || !(pdf > 0)) continue;
    const glm::vec3 carries = carried(s, to_eye, direction, without_diffuse) * (n_l / pdf);
    float keep = 1;
    const float size = paths.follow_all ? 1.0f : luminance(glm::abs(carries)) / kSmall;
    if (!keeps(size, samples.roulette().v[i], keep)) continue;
    const glm::vec3 for_unlit = carried(s, to_eye, direction, true) * (n_l / pdf);
    paths.unlit_throughput.set(i, paths.throughput.at(i) * for_unlit / keep);
    paths.throughput.set(i, paths.throughput.at(i) * carries / keep);
    paths.pdf[i] = pdf;
    paths.start.set(i, hits.start.at(i));
    paths.normal.set(i, s.normal);
    paths.spacing_m[i] = hits.spacing_m[i];
    paths.reflected_pdf[i] = sends ? pdf : 0, paths.sent_to[i] = sent.to;
    paths.spread[i] = is_wide(s, without_diffuse) ? kNoPoints : paths.spread[i] + 0.2f * s.roughness;
    paths.before_m[i] = 0, paths.straight_pdf[i] = -1;
    set_ray(rays, i, hits.start.at(i) + way_out(hits, i, direction) * direction, direction, kInfinity);
    paths.active[i] = -1;
  }
}

/// The paths of `lanes`, all at one mesh: emission at the hit, light known there, light samples, and the next ray.
void scatter(const RenderScene& world, const PathOptions& options, unsigned mesh_id, const int lanes[kPacket],
             int bounces_left, ScatterSamples& samples, RayPacket& rays, Paths& paths, ShadowRays& shadow,
             ShadowRays& checks) {
  Hits hits;
  hits_at(world, mesh_id, lanes, rays, hits);
  for (int i = 0; i < kPacket; ++i) hits.distance[i] += paths.before_m[i];
  for (int i = 0; i < kPacket; ++i) hits.spacing_m[i] = paths.spacing_m[i] + paths.spread[i] * hits.distance[i];
  if (hits.surface.hair) turn_to_sides(lanes, samples.side(), hits.surface);
  if (hits.surface.emits) add_emission(world, mesh_id, lanes, rays, hits, paths);
  KnownLight known = nothing_known(world, bounces_left);
  add_known_light(world, options, mesh_id, lanes, rays, hits, bounces_left, paths, known);
  sample_missing_lights(world, lanes, hits, samples, known, paths, shadow);
  check_hard_light(world, lanes, hits, samples, known, paths, checks);
  sample_reflections(world, lanes, hits, samples, known, rays, paths);
}

/// What a ray that is followed for lights alone finds on a mesh.
void see_lights(const RenderScene& world, unsigned mesh_id, const int lanes[kPacket], const RayPacket& rays,
                Paths& paths) {
  if (world.scene.materials[world.scene.meshes[mesh_id].material].emission_nits == glm::vec3(0)) return;
  Hits hits;
  hits_at(world, mesh_id, lanes, rays, hits);
  for (int i = 0; i < kPacket; ++i) hits.distance[i] += paths.before_m[i];
  add_emission(world, mesh_id, lanes, rays, hits, paths);
}

void add_unhidden(const RenderScene& world, const PathOptions& options, ShadowRays& shadow, Paths& paths) {
  if (first_set(shadow.active) == kPacket) return;
  if (options.log) write_down(*options.log, shadow.active, shadow.rays, true, false);
  alignas(64) int hidden[kPacket];
  world.intersector.occluded(shadow.active, shadow.rays, false, hidden);
  if (world.intersector.has_glass()) dim_by_glass(world, shadow.active, hidden, shadow.rays, shadow.arriving);
  for (int i = 0; i < kPacket; ++i) {
    if (shadow.active[i] && !hidden[i]) paths.radiance.set(i, paths.radiance.at(i) + shadow.arriving.at(i));
  }
}

void find_nearest(const RenderScene& world, const PathOptions& options, RayPacket& rays, Paths& paths, int bounce) {
  const bool coherent = bounce == 0;
  if (options.log) write_down(*options.log, paths.active, rays, false, coherent);
  world.intersector.intersect(paths.active, rays, coherent);
}

/// What all active paths find where their rays have ended, glass passed: light, shadow rays.
void shade_met(const RenderScene& world, const PathOptions& options, RayPacket& rays, Paths& paths,
               const SampleIndices& indices, int bounce) {
  const Scene& scene = world.scene;
  alignas(64) int waiting[kPacket];  // paths that have hit a mesh and are still to be shaded
  bool any_missed = false;
  for (int i = 0; i < kPacket; ++i) {
    waiting[i] = rays.mesh[i] == kNoMesh ? 0 : paths.active[i];
    any_missed |= waiting[i] != paths.active[i];
  }
  for (int i = 0; any_missed && i < kPacket; ++i) {
    if (paths.active[i] && !waiting[i]) see_environment(world, rays, paths, i);
  }
  alignas(64) ShadowRays shadow, checks;
  for (int i = 0; i < kPacket; ++i) paths.active[i] = shadow.active[i] = checks.active[i] = 0;
  ScatterSamples samples(options.sampling, indices, indices.reflections_before(bounce));
  for (int first; (first = first_set(waiting)) < kPacket;) {  // mesh by mesh: most packets hit only one
    const unsigned mesh_id = rays.mesh[first];
    alignas(64) int lanes[kPacket];
    for (int i = 0; i < kPacket; ++i) {
      lanes[i] = rays.mesh[i] == mesh_id ? waiting[i] : 0;
      waiting[i] &= ~lanes[i];
    }
    const Mesh& mesh = scene.meshes[mesh_id];
    if (scene.materials[mesh.material].unlit) {
      if (bounce > options.max_bounces && paths.kinds == LightKinds::soft) continue;
      see_unlit(scene, mesh, lanes, rays, bounce > options.max_bounces ? paths.unlit_throughput : paths.throughput,
                paths);
      continue;
    }
    if (bounce > options.max_bounces) {
      see_lights(world, mesh_id, lanes, rays, paths);
      continue;
    }
    scatter(world, options, mesh_id, lanes, options.max_bounces - bounce, samples, rays, paths, shadow, checks);
  }
  add_unhidden(world, options, shadow, paths);
  add_unhidden(world, options, checks, paths);
  paths.kinds = LightKinds::all;
  paths.follow_all = false;
}

/// One step of all active paths, whose rays have met what is nearest. Beyond the last reflection, rays look for lights
/// alone.
void shade(const RenderScene& world, const PathOptions& options, RayPacket& rays, Paths& paths,
           const SampleIndices& indices, int bounce) {
  weigh_sent(world, rays, paths);
  if (world.intersector.has_glass()) {
    pass_glass(world, options, indices, bounce, rays, paths);
  }
  shade_met(world, options, rays, paths, indices, bounce);
}

/// What the first glass that camera rays meet reflects. They themselves go on through it.
void add_reflected(const RenderScene& world, const PathOptions& options, const SampleIndices& indices,
                   const RayPacket& rays, Paths& paths) {
  alignas(64) int divided[kPacket];
  if (!find_divided(world, rays, paths, divided)) return;
  alignas(64) RayPacket reflected_rays = rays;
  alignas(64) Paths reflected = paths;
  std::copy_n(divided, kPacket, reflected.active);
  reflected.follow_all = true;
  shade_met(world, options, reflected_rays, reflected, indices, 0);
  trace_paths(world, options, indices, 1, reflected_rays, reflected);
  for (int i = 0; i < kPacket; ++i) {
    if (divided[i]) paths.radiance.set(i, reflected.radiance.at(i));  // which began with all that `paths` had
  }
}

}  // namespace

void trace_paths(const RenderScene& world, const PathOptions& options, const SampleIndices& indices, int bounce,
                 RayPacket& rays, Paths& paths) {
  for (; bounce <= options.max_bounces + 1 && first_set(paths.active) < kPacket; ++bounce) {
    find_nearest(world, options, rays, paths, bounce);
    if (bounce == 0 && world.intersector.has_glass()) add_reflected(world, options, indices, rays, paths);
    shade(world, options, rays, paths, indices, bounce);
  }
}

}  // namespace dualpixel::simulator
