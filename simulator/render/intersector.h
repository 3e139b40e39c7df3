#pragma once
#include <memory>
#include <optional>

#include "simulator/render/ray_packet.h"
#include "simulator/scene/scene.h"

struct RTCDeviceTy;
struct RTCGeometryTy;
struct RTCSceneTy;

/// The only code that calls Embree; compiles with Embree 3.13 and 4. A mesh without placements is a geometry in
/// world space; one with placements is stored once, and each placement is an Embree instance of it. Hits on alpha-cut
/// texels are passed through. A ray that is not finite, or has a number of 1e18 or more, meets nothing and gets no
/// light: Debian's Embree ends the program over one.
namespace dualpixel::simulator {

/// What an alpha-cut geometry's filter needs to know.
struct Cutout {
  const Scene* scene;
  const Mesh* mesh;
};

/// What an Embree instance is one of.
struct Placed {
  unsigned mesh = 0, placement = 0;
};

class Intersector {
 public:
  /// Keeps a pointer to `scene` (alpha cut-outs are looked up in it). Throws std::runtime_error where Embree fails.
  explicit Intersector(const Scene& scene);

  /// Packets in which Embree 3.13 is fastest, with AVX2: 8 take a quarter less time than 16 on plain scenes, a seventh
  /// on the portrait (`dualpixel bench render`). A constant, so that all machines make the same pictures.
  static constexpr int kWidth = 8;

  /// Nearest hits of the lanes with active[i] = -1 (others 0: left as they are). `active` is aligned to 64 bytes, as
  /// Embree reads it in vectors. `coherent`: the rays of one pixel through one lens. `width`: 1, 8 or 16 rays at a
  /// time.
  void intersect(const int active[kPacket], RayPacket& rays, bool coherent, int width = kWidth) const;
  /// hidden[i] = -1 where lane i is active and something lies between the ray's ends, otherwise 0.
  void occluded(const int active[kPacket], const RayPacket& rays, bool coherent, int hidden[kPacket],
                int width = kWidth) const;
  /// Light passes glass: it hides nothing, but is met like everything else.
  bool has_glass() const { return glass_ != nullptr; }
  /// Nearest hits on glass of the lanes with active[i] = -1; leaves those of them that meet some. False: none.
  bool intersect_glass(int active[kPacket], RayPacket& rays) const;

  /// The nearest hit of one ray.
  std::optional<Hit> intersect(const Ray& ray) const;

  struct Bounds {
    glm::vec3 low{0}, high{0};
  };
  /// Of the boxes of all meshes; of a placed mesh its box is turned along, so that there may be air in these.
  Bounds bounds() const;

 private:
  struct Release {
    void operator()(RTCDeviceTy* device) const;
    void operator()(RTCSceneTy* scene) const;
  };
  void add_mesh(const Scene& scene, unsigned mesh_id);
  void attach_mesh(RTCGeometryTy* geometry, unsigned id, bool glass);

  std::vector<std::unique_ptr<Cutout>> cutouts_;
  unsigned first_instance_ = 0;  ///< Embree's ids below it are meshes
  std::vector<Placed> placed_;   ///< the meshes and placements of the ids from it on
  std::unique_ptr<RTCDeviceTy, Release> device_;
  std::unique_ptr<RTCSceneTy, Release> embree_scene_;
  std::unique_ptr<RTCSceneTy, Release> glass_;  ///< the same geometries of glass alone; null: there are none
};

}  // namespace dualpixel::simulator
