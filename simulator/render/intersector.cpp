#include "simulator/render/intersector.h"

#if __has_include(<embree3/rtcore.h>)
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>

#include "simulator/render/shading/surface.h"

namespace dualpixel::simulator {
namespace {

/// Embree's filter callback: rejects hits whose alpha lies under the material's cut-off.
void reject_cut_out(const RTCFilterFunctionNArguments* args) {
  const auto& cutout = *static_cast<const Cutout*>(args->geometryUserPtr);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const unsigned primitive = RTCHitN_primID(args->hit, args->N, i);
    const float u = RTCHitN_u(args->hit, args->N, i);
    const float v = RTCHitN_v(args->hit, args->N, i);
    if (is_cut_out(*cutout.scene, *cutout.mesh, primitive, u, v)) args->valid[i] = 0;
  }
}

/// Of glass, for shadow rays.
void reject_all(const RTCFilterFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i) args->valid[i] = 0;
}

void check(RTCDevice device, const char* what) {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  if (error != RTC_ERROR_NONE) throw std::runtime_error(std::string("Embree: ") + what);
}

}  // namespace

#if RTC_VERSION_MAJOR >= 4
namespace {

RTCIntersectArguments to_intersect(bool coherent) {
  RTCIntersectArguments args;
  rtcInitIntersectArguments(&args);
  args.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
  return args;
}
RTCOccludedArguments to_occlude(bool coherent) {
  RTCOccludedArguments args;
  rtcInitOccludedArguments(&args);
  args.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
  return args;
}

void trace(const int* active, RTCScene scene, RTCIntersectArguments& args, RTCRayHit16& rays) {
  rtcIntersect16(active, scene, &rays, &args);
}
void trace(const int* active, RTCScene scene, RTCIntersectArguments& args, RTCRayHit8& rays) {
  rtcIntersect8(active, scene, &rays, &args);
}
void trace(const int*, RTCScene scene, RTCIntersectArguments& args, RTCRayHit& ray) {
  rtcIntersect1(scene, &ray, &args);
}
void occlude(const int* active, RTCScene scene, RTCOccludedArguments& args, RTCRay16& rays) {
  rtcOccluded16(active, scene, &rays, &args);
}
void occlude(const int* active, RTCScene scene, RTCOccludedArguments& args, RTCRay8& rays) {
  rtcOccluded8(active, scene, &rays, &args);
}
void occlude(const int*, RTCScene scene, RTCOccludedArguments& args, RTCRay& ray) { rtcOccluded1(scene, &ray, &args); }

}  // namespace
#else
namespace {

RTCIntersectContext to_intersect(bool coherent) {
  RTCIntersectContext result;
  rtcInitIntersectContext(&result);
  result.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  return result;
}
RTCIntersectContext to_occlude(bool coherent) { return to_intersect(coherent); }

void trace(const int* active, RTCScene scene, RTCIntersectContext& context, RTCRayHit16& rays) {
  rtcIntersect16(active, scene, &context, &rays);
}
void trace(const int* active, RTCScene scene, RTCIntersectContext& context, RTCRayHit8& rays) {
  rtcIntersect8(active, scene, &context, &rays);
}
void trace(const int*, RTCScene scene, RTCIntersectContext& context, RTCRayHit& ray) {
  rtcIntersect1(scene, &context, &ray);
}
void occlude(const int* active, RTCScene scene, RTCIntersectContext& context, RTCRay16& rays) {
  rtcOccluded16(active, scene, &context, &rays);
}
void occlude(const int* active, RTCScene scene, RTCIntersectContext& context, RTCRay8& rays) {
  rtcOccluded8(active, scene, &context, &rays);
}
void occlude(const int*, RTCScene scene, RTCIntersectContext& context, RTCRay& ray) {
  rtcOccluded1(scene, &context, &ray);
}

}  // namespace
#endif

namespace {

/// Field `i` of Embree's packets, which are arrays, and of its single rays, which are not.
template <typename T>
T& lane(T& field, int) {
  return field;
}
template <typename T, int N>
T& lane(T (&field)[N], int i) {
  return field[i];
}

/// False for what is no number, too.
bool can_be_traced(const RayPacket& rays, int i) {
  constexpr float kMost = 1e18f;  // Embree's own limit is 1.8e18
  return std::abs(rays.origin_x[i]) < kMost && std::abs(rays.origin_y[i]) < kMost &&
         std::abs(rays.origin_z[i]) < kMost && std::abs(rays.direction_x[i]) < kMost &&
         std::abs(rays.direction_y[i]) < kMost && std::abs(rays.direction_z[i]) < kMost && !std::isnan(rays.far[i]);
}

/// Where a ray cannot be traced, `active` gets 0 as well: Debian's Embree ends the program over one, in an inactive
/// lane too, so that these hold a ray that it takes.
template <int Width, typename Rays>
void fill(Rays& to, int active[Width], const RayPacket& rays, int first) {
  for (int i = 0; i < Width; ++i) {
    const int k = first + i;
    active[i] = active[i] != 0 && can_be_traced(rays, k) ? -1 : 0;
    lane(to.org_x, i) = active[i] ? rays.origin_x[k] : 0.0f;
    lane(to.org_y, i) = active[i] ? rays.origin_y[k] : 0.0f;
    lane(to.org_z, i) = active[i] ? rays.origin_z[k] : 0.0f;
    lane(to.dir_x, i) = active[i] ? rays.direction_x[k] : 0.0f;
    lane(to.dir_y, i) = active[i] ? rays.direction_y[k] : 0.0f;
    lane(to.dir_z, i) = active[i] ? rays.direction_z[k] : 1.0f;
    lane(to.tfar, i) = active[i] ? rays.far[k] : 0.0f;
    lane(to.tnear, i) = lane(to.time, i) = 0;
    lane(to.mask, i) = ~0u;
    lane(to.flags, i) = 0;
  }
}

template <int Width>
bool any(const int* active) {
  int found = 0;
  for (int i = 0; i < Width; ++i) found |= active[i];
  return found != 0;
}

/// Which mesh a ray met, where a shared one may be it; the packet's `mesh` holds Embree's geometry id.
void find_placement(const std::vector<Placed>& placed, unsigned first_instance, unsigned instance, unsigned& mesh,
                    unsigned& placement) {
  if (instance == RTC_INVALID_GEOMETRY_ID) return;
  const Placed& p = placed[instance - first_instance];
  mesh = p.mesh;
  placement = p.placement;
}

template <int Width, typename Hits>
void intersect_in(RTCScene scene, const std::vector<Placed>& placed, unsigned first_instance, const int active[kPacket],
                  RayPacket& rays, bool coherent) {
  alignas(64) Hits embree;
  auto how = to_intersect(coherent);
  for (int first = 0; first < kPacket; first += Width) {
    if (!any<Width>(active + first)) continue;
    alignas(64) int traced[Width];
    std::copy_n(active + first, Width, traced);
    fill<Width>(embree.ray, traced, rays, first);
    for (int i = 0; i < Width; ++i) lane(embree.hit.geomID, i) = RTC_INVALID_GEOMETRY_ID;
    for (int i = 0; i < Width; ++i) lane(embree.hit.instID[0], i) = RTC_INVALID_GEOMETRY_ID;
    if (any<Width>(traced)) trace(traced, scene, how, embree);
    for (int i = 0; i < Width; ++i) {
      const bool wanted = active[first + i] != 0;
      rays.far[first + i] = wanted ? lane(embree.ray.tfar, i) : rays.far[first + i];
      rays.mesh[first + i] = wanted ? lane(embree.hit.geomID, i) : rays.mesh[first + i];
      rays.triangle[first + i] = wanted ? lane(embree.hit.primID, i) : rays.triangle[first + i];
      rays.u[first + i] = wanted ? lane(embree.hit.u, i) : rays.u[first + i];
      rays.v[first + i] = wanted ? lane(embree.hit.v, i) : rays.v[first + i];
    }
    if (placed.empty()) continue;
    for (int i = 0; i < Width; ++i) {
      if (!active[first + i]) continue;
      find_placement(placed, first_instance, lane(embree.hit.instID[0], i), rays.mesh[first + i],
                     rays.placement[first + i]);
    }
  }
}

template <int Width, typename Rays>
void occluded_in(RTCScene scene, const int active[kPacket], const RayPacket& rays, bool coherent, int hidden[kPacket]) {
  alignas(64) Rays embree;
  auto how = to_occlude(coherent);
  for (int first = 0; first < kPacket; first += Width) {
    for (int i = 0; i < Width; ++i) hidden[first + i] = 0;
    if (!any<Width>(active + first)) continue;
    alignas(64) int traced[Width];
    std::copy_n(active + first, Width, traced);
    fill<Width>(embree, traced, rays, first);
    if (any<Width>(traced)) occlude(traced, scene, how, embree);
    for (int i = 0; i < Width; ++i) {
      hidden[first + i] = lane(embree.tfar, i) < 0 || !traced[i] ? active[first + i] : 0;
    }
  }
}

}  // namespace

void Intersector::intersect(const int active[kPacket], RayPacket& rays, bool coherent, int width) const {
  RTCScene scene = embree_scene_.get();
  if (width == 1) return intersect_in<1, RTCRayHit>(scene, placed_, first_instance_, active, rays, coherent);
  if (width == 16) return intersect_in<16, RTCRayHit16>(scene, placed_, first_instance_, active, rays, coherent);
  intersect_in<8, RTCRayHit8>(scene, placed_, first_instance_, active, rays, coherent);
}

void Intersector::occluded(const int active[kPacket], const RayPacket& rays, bool coherent, int hidden[kPacket],
                           int width) const {
  if (width == 1) return occluded_in<1, RTCRay>(embree_scene_.get(), active, rays, coherent, hidden);
  if (width == 16) return occluded_in<16, RTCRay16>(embree_scene_.get(), active, rays, coherent, hidden);
  occluded_in<8, RTCRay8>(embree_scene_.get(), active, rays, coherent, hidden);
}

bool Intersector::intersect_glass(int active[kPacket], RayPacket& rays) const {
  intersect_in<8, RTCRayHit8>(glass_.get(), placed_, first_instance_, active, rays, false);
  int any = 0;
  for (int i = 0; i < kPacket; ++i) any |= active[i] &= rays.mesh[i] != kNoMesh ? -1 : 0;
  return any;
}

std::optional<Hit> Intersector::intersect(const Ray& ray) const {
  RayPacket rays{};
  rays.origin_x[0] = ray.origin.x, rays.origin_y[0] = ray.origin.y, rays.origin_z[0] = ray.origin.z;
  rays.direction_x[0] = ray.direction.x, rays.direction_y[0] = ray.direction.y, rays.direction_z[0] = ray.direction.z;
  rays.far[0] = std::numeric_limits<float>::infinity();
  alignas(64) constexpr int kFirst[kPacket] = {-1};
  intersect(kFirst, rays, false, 1);
  if (rays.mesh[0] == kNoMesh) return {};
  return Hit{rays.far[0], rays.mesh[0], rays.triangle[0], rays.u[0], rays.v[0], rays.placement[0]};
}

void Intersector::Release::operator()(RTCDeviceTy* device) const { rtcReleaseDevice(device); }
void Intersector::Release::operator()(RTCSceneTy* scene) const { rtcReleaseScene(scene); }

namespace {

/// How all scenes are built, those of shared meshes too.
void commit(RTCDevice device, RTCScene scene) {
  // Without this flag one ray in a quarter of a million slips between the triangles of a closed box
  // (SlowRobustness.ClosedBoxesLetNothingIn); it costs 5 to 10 % of a render.
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  // spatial splits: hair and leaves are long, thin and aslant, and rendering is far longer than building
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  rtcCommitScene(scene);
  const RTCError error = rtcGetDeviceError(device);
  // A thread that cannot start for lack of memory has no error code of its own; what goes in has been checked.
  if (error == RTC_ERROR_OUT_OF_MEMORY || error == RTC_ERROR_UNKNOWN) throw std::bad_alloc();
  if (error != RTC_ERROR_NONE) throw std::runtime_error("Embree: building the acceleration structure failed");
}

void attach(RTCScene scene, RTCGeometry geometry, unsigned id) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

RTCGeometry new_triangles(RTCDevice device, const Mesh& mesh) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3),
                                            mesh.positions.size());
  void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3),
                                            mesh.triangles.size());
  check(device, "out of memory for geometry");
  std::memcpy(positions, mesh.positions.data(), mesh.positions.size() * sizeof(glm::vec3));
  std::memcpy(triangles, mesh.triangles.data(), mesh.triangles.size() * sizeof(glm::uvec3));
  return geometry;
}

/// Ribbons that face each ray: a strand is much thinner than what a photosite sees. Embree wants a segment's vertices
/// one after the other, so each has its own.
RTCGeometry new_strands(RTCDevice device, const Mesh& mesh) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_FLAT_LINEAR_CURVE);
  auto* ends = static_cast<glm::vec4*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4,
                                                               sizeof(glm::vec4), 2 * mesh.triangles.size()));
  auto* segments = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT,
                                                                  sizeof(unsigned), mesh.triangles.size()));
  check(device, "out of memory for geometry");
  for (unsigned i = 0; i < mesh.triangles.size(); ++i) {
    for (unsigned k = 0; k < 2; ++k) {
      const unsigned vertex = mesh.triangles[i][k];
      ends[2 * i + k] = glm::vec4(mesh.positions[vertex], mesh.radii[vertex]);
    }
    segments[i] = 2 * i;
  }
  return geometry;
}

/// No scene has subdivision surfaces: Embree (3.13) hangs where it gets no memory for their cache, 128 MB, and releases
/// it. With AVX-512 Embree rounds otherwise; a build for AVX2 (DUALPIXEL_ARCH) keeps it to AVX2.
constexpr const char* kDeviceOptions =
    "tessellation_cache_size=0"
#if defined(__AVX2__) && !defined(__AVX512F__)
    ",isa=avx2"
#endif
    ;

/// An Embree may be compiled without what pictures rely on: Conan Center's drops back faces, for example.
void check_features(RTCDevice device) {
  const auto has = [&](RTCDeviceProperty property) { return rtcGetDeviceProperty(device, property) != 0; };
  const bool complete = !has(RTC_DEVICE_PROPERTY_BACKFACE_CULLING_ENABLED) &&
                        has(RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED) &&
                        has(RTC_DEVICE_PROPERTY_CURVE_GEOMETRY_SUPPORTED);
  if (!complete)
    throw std::runtime_error("Embree: is compiled to drop back faces, or without filter functions or curves");
#if defined(__AVX2__) && !defined(__AVX512F__)
  if (has(RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) throw std::runtime_error("Embree: does not keep to AVX2");
#endif
}

}  // namespace

Intersector::Intersector(const Scene& scene) : first_instance_(static_cast<unsigned>(scene.meshes.size())) {
  device_.reset(rtcNewDevice(kDeviceOptions));
  check(device_.get(), "no device");
  check_features(device_.get());
  embree_scene_.reset(rtcNewScene(device_.get()));
  for (const Mesh& mesh : scene.meshes) {
    if (!glass_ && is_glass(scene, mesh)) glass_.reset(rtcNewScene(device_.get()));
  }
  for (unsigned i = 0; i < scene.meshes.size(); ++i) add_mesh(scene, i);
  commit(device_.get(), embree_scene_.get());
  if (glass_) commit(device_.get(), glass_.get());
}

void Intersector::attach_mesh(RTCGeometry geometry, unsigned id, bool glass) {
  if (glass) {
    rtcRetainGeometry(geometry);
    attach(glass_.get(), geometry, id);
  }
  attach(embree_scene_.get(), geometry, id);
}

void Intersector::add_mesh(const Scene& scene, unsigned mesh_id) {
  RTCDevice device = device_.get();
  const Mesh& mesh = scene.meshes[mesh_id];
  RTCGeometry geometry = mesh.is_hair() ? new_strands(device, mesh) : new_triangles(device, mesh);
  if (scene.materials[mesh.material].alpha_cutoff > 0) {
    cutouts_.push_back(std::make_unique<Cutout>(Cutout{&scene, &mesh}));
    rtcSetGeometryUserData(geometry, cutouts_.back().get());
    rtcSetGeometryIntersectFilterFunction(geometry, reject_cut_out);
    rtcSetGeometryOccludedFilterFunction(geometry, reject_cut_out);
  }
  const bool glass = is_glass(scene, mesh);
  if (glass) rtcSetGeometryOccludedFilterFunction(geometry, reject_all);
  if (mesh.placements.empty()) return attach_mesh(geometry, mesh_id, glass);

  const std::unique_ptr<RTCSceneTy, Release> shared(rtcNewScene(device));  // its instances keep it alive
  attach(shared.get(), geometry, 0);
  commit(device, shared.get());
  for (unsigned k = 0; k < mesh.placements.size(); ++k) {
    RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, shared.get());
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, &mesh.placements[k].world_from_mesh);
    attach_mesh(instance, first_instance_ + static_cast<unsigned>(placed_.size()), glass);
    placed_.push_back({mesh_id, k});
  }
}

Intersector::Bounds Intersector::bounds() const {
  RTCBounds b;
  rtcGetSceneBounds(embree_scene_.get(), &b);
  return {{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}};
}

}  // namespace dualpixel::simulator
