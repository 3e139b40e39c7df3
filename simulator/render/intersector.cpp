#include "simulator/render/intersector.h"

#include <cstring>
#include <stdexcept>
#include <string>

#include "simulator/render/surface.h"

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

void check(RTCDevice device, const char* what) {
  const RTCError error = rtcGetDeviceError(device);
  if (error != RTC_ERROR_NONE) throw std::runtime_error(std::string("Embree: ") + what);
}

}  // namespace

#if RTC_VERSION_MAJOR >= 4
void Intersector::intersect(const int* valid, RTCRayHit16& rays, bool coherent) const {
  RTCIntersectArguments args;
  rtcInitIntersectArguments(&args);
  args.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
  rtcIntersect16(valid, embree_scene_.get(), &rays, &args);
}

void Intersector::occluded(const int* valid, RTCRay16& rays, bool coherent) const {
  RTCOccludedArguments args;
  rtcInitOccludedArguments(&args);
  args.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
  rtcOccluded16(valid, embree_scene_.get(), &rays, &args);
}

void Intersector::intersect(RTCRayHit& ray) const { rtcIntersect1(embree_scene_.get(), &ray); }
#else
namespace {

RTCIntersectContext context(bool coherent) {
  RTCIntersectContext result;
  rtcInitIntersectContext(&result);
  result.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  return result;
}

}  // namespace

void Intersector::intersect(const int* valid, RTCRayHit16& rays, bool coherent) const {
  RTCIntersectContext flags = context(coherent);
  rtcIntersect16(valid, embree_scene_.get(), &flags, &rays);
}

void Intersector::occluded(const int* valid, RTCRay16& rays, bool coherent) const {
  RTCIntersectContext flags = context(coherent);
  rtcOccluded16(valid, embree_scene_.get(), &flags, &rays);
}

void Intersector::intersect(RTCRayHit& ray) const {
  RTCIntersectContext flags = context(false);
  rtcIntersect1(embree_scene_.get(), &flags, &ray);
}
#endif

Intersector::Intersector(const Scene& scene) {
  device_.reset(rtcNewDevice(nullptr));
  if (!device_) throw std::runtime_error("Embree: no device");
  embree_scene_.reset(rtcNewScene(device_.get()));
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const Mesh& mesh = scene.meshes[i];
    RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    void* positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3),
                                              mesh.positions.size());
    void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3),
                                              mesh.triangles.size());
    check(device_.get(), "out of memory for geometry");
    std::memcpy(positions, mesh.positions.data(), mesh.positions.size() * sizeof(glm::vec3));
    std::memcpy(triangles, mesh.triangles.data(), mesh.triangles.size() * sizeof(glm::uvec3));
    if (scene.materials[mesh.material].alpha_cutoff > 0) {
      cutouts_.push_back(std::make_unique<Cutout>(Cutout{&scene, &mesh}));
      rtcSetGeometryUserData(geometry, cutouts_.back().get());
      rtcSetGeometryIntersectFilterFunction(geometry, reject_cut_out);
      rtcSetGeometryOccludedFilterFunction(geometry, reject_cut_out);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(embree_scene_.get(), geometry, static_cast<unsigned>(i));
    rtcReleaseGeometry(geometry);
  }
  // spatial splits: hair and leaves are long, thin and aslant, and rendering is far longer than building
  rtcSetSceneBuildQuality(embree_scene_.get(), RTC_BUILD_QUALITY_HIGH);
  rtcCommitScene(embree_scene_.get());
  check(device_.get(), "building the acceleration structure failed");
}

Intersector::Bounds Intersector::bounds() const {
  RTCBounds b;
  rtcGetSceneBounds(embree_scene_.get(), &b);
  return {{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}};
}

}  // namespace dualpixel::simulator
