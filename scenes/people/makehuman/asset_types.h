#pragma once
#include <array>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "scenes/procedural/signed_distance.h"
#include "simulator/scene/scene.h"

/// What MakeHuman's files hold.
namespace dualpixel::scenes {

inline constexpr float kMetersPerUnit = 0.1f;
inline constexpr int kMostVertices = 1 << 20;

/// A mesh whose corners are split where texture coordinates differ.
struct TexturedMesh {
  std::vector<int> vertex;  ///< of each corner: its position's index
  std::vector<vec2> uv;     ///< of each corner, v = 0 at the top
  std::vector<glm::uvec3> triangles;
  int vertices = 0;  ///< positions in all
};

/// An asset fitted to the base mesh: each vertex is placed by three of its vertices.
struct FittedAsset {
  struct Hold {
    std::array<int, 3> vertex{};
    std::array<float, 3> weight{1, 0, 0};
    vec3 offset{0};
  };
  struct Scale {
    int a = 0, b = 0;
    float length = 0;  ///< 0: none is given
  };
  std::string name;
  TexturedMesh mesh;
  std::vector<Hold> holds;
  std::array<Scale, 3> scale;                         ///< x, y, z
  std::vector<bool> hides;                            ///< the base mesh's vertices that it covers
  std::shared_ptr<const simulator::Texture> texture;  ///< null: missing
  vec3 mean_color{0.5f};                              ///< linear, of its opaque texels
};

/// Displacements of some vertices, meters.
struct MorphTarget {
  std::vector<int> vertex;
  std::vector<vec3> offset;
};

/// Skinning weights: (part of the body, weight) of each vertex; parts as in body_parts.h.
struct PartWeights {
  std::vector<std::vector<std::pair<int, float>>> of_vertex;
};

/// The mesh that targets morph, assets are fitted to and bones move.
struct BaseMesh {
  std::vector<vec3> positions;                     ///< meters
  TexturedMesh body;                               ///< its visible part
  std::map<std::string, std::vector<int>> joints;  ///< vertices whose mean is the joint
  PartWeights weights;
};

}  // namespace dualpixel::scenes
