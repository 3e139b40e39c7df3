#pragma once
#include <memory>

#if __has_include(<embree3/rtcore.h>)
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#include "simulator/scene/scene.h"

/// The only place that talks to Embree; compiles with Embree 3.13 and 4. Geometry id = index into Scene::meshes.
/// Hits on alpha-cut texels are passed through. Rays must be finite (Debian's Embree aborts on others).
namespace dualpixel::simulator {

/// What an alpha-cut geometry's filter needs to know.
struct Cutout {
  const Scene* scene;
  const Mesh* mesh;
};

class Intersector {
 public:
  /// Keeps a pointer to `scene` (alpha cut-outs are looked up in it). Throws std::runtime_error where Embree fails.
  explicit Intersector(const Scene& scene);

  /// Nearest hits of the lanes with valid[i] = -1 (others 0). `coherent`: the rays of one pixel through one lens.
  void intersect(const int* valid, RTCRayHit16& rays, bool coherent) const;
  /// tfar becomes -infinity where something lies between tnear and tfar.
  void occluded(const int* valid, RTCRay16& rays, bool coherent) const;
  /// One ray.
  void intersect(RTCRayHit& ray) const;

  struct Bounds {
    glm::vec3 low{0}, high{0};
  };
  Bounds bounds() const;

 private:
  struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  };
  std::vector<std::unique_ptr<Cutout>> cutouts_;
  std::unique_ptr<RTCDeviceTy, Release> device_;
  std::unique_ptr<RTCSceneTy, Release> embree_scene_;
};

}  // namespace dualpixel::simulator
