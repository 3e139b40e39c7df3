#include "simulator/scene/gltf/gltf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "capture/error.h"
#include "capture/files.h"
#include "simulator/scene/gltf/accessor.h"
#include "simulator/scene/gltf/animation.h"
#include "simulator/scene/gltf/check.h"
#include "simulator/scene/gltf/files.h"
#include "simulator/scene/gltf/light_kinds.h"
#include "simulator/scene/gltf/material.h"
#include "simulator/scene/gltf/mesh.h"

namespace dualpixel::simulator {
namespace {

constexpr std::size_t kLargestFileBytes = std::numeric_limits<std::int32_t>::max();
constexpr std::size_t kMostVertices = 1 << 26;    // as stored, and as many corners of triangles
constexpr std::size_t kMostPlacements = 1 << 20;  // of primitives: half a gigabyte
constexpr double kFarthestNode_m = 1e6;           // for lights and cameras

/// Whether a primitive that so many nodes use takes less memory stored once; bytes as measured with Embree 3.13, with
/// what Scene holds. Rays take up to half as long again as among copies, a twentieth in scenes of ten million
/// triangles.
bool pays(std::size_t corners, std::size_t users) {
  constexpr std::size_t kTriangle = 100, kPlacement = 460, kShared = 6000;
  return users > 1 && corners / 3 * (users - 1) * kTriangle > kShared + users * kPlacement;
}

/// A node's position in the tree.
struct NodeState {
  glm::dmat4 world{1};  ///< world from node
  bool shown = false;   ///< belongs to the default scene
  bool person = false;  ///< it or an ancestor is marked as a person
  bool moved = false;   ///< an animation moves it or an ancestor
};

glm::dmat4 local_matrix(const tinygltf::Node& node) {
  glm::dmat4 matrix(1);
  if (!node.matrix.empty()) {
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = node.matrix[i];
    return matrix;
  }
  if (!node.rotation.empty()) {
    const auto& q = node.rotation;  // x, y, z, w
    matrix = glm::mat4_cast(glm::normalize(glm::dquat(q[3], q[0], q[1], q[2])));
  }
  for (int i = 0; i < 3 && !node.scale.empty(); ++i) matrix[i] *= node.scale[i];
  for (int i = 0; i < 3 && !node.translation.empty(); ++i) matrix[3][i] = node.translation[i];
  return matrix;
}

bool marked_as_person(const tinygltf::Node& node) {
  return node.extras.Has("category") && node.extras.Get("category").IsString() &&
         node.extras.Get("category").Get<std::string>() == "person";
}

std::vector<NodeState> walk_tree(const GltfFile& file, const std::vector<bool>& moved) {
  const tinygltf::Model& model = file.model;
  std::vector<NodeState> states(model.nodes.size());
  std::vector<bool> has_parent(model.nodes.size(), false);
  for (const tinygltf::Node& node : model.nodes) {
    for (const int child : node.children) has_parent[child] = true;
  }
  std::vector<int> order;  // parents before children, without recursion: a hostile tree may be deep
  for (std::size_t i = 0; i < model.nodes.size(); ++i) {
    if (!has_parent[i]) order.push_back(static_cast<int>(i));
  }
  for (const int root : model.scenes[std::max(model.defaultScene, 0)].nodes) states[root].shown = true;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const tinygltf::Node& node = model.nodes[order[i]];
    NodeState& state = states[order[i]];
    state.world = state.world * local_matrix(node);  // it held the parent's
    state.person = state.person || marked_as_person(node);
    state.moved = state.moved || moved[order[i]];
    for (int c = 0; c < 4; ++c) {
      if (!std::isfinite(glm::dot(state.world[c], state.world[c]))) {
        fail_gltf(file.name, fmt::format("/nodes/{}", order[i]), "its world transform must be finite");
      }
    }
    for (const int child : node.children) {
      states[child] = state;
      order.push_back(child);
    }
  }
  return states;
}

/// World matrices from the space in which a skin's mesh was bound (glTF 2.0, section 3.7.3.3).
std::vector<glm::dmat4> joint_matrices(const GltfFile& file, int skin_index, const std::vector<NodeState>& states) {
  const tinygltf::Skin& skin = file.model.skins[skin_index];
  std::vector<float> inverse_bind;
  if (skin.inverseBindMatrices >= 0) inverse_bind = read_floats(file, skin.inverseBindMatrices);
  std::vector<glm::dmat4> matrices;
  for (std::size_t j = 0; j < skin.joints.size(); ++j) {
    glm::dmat4 bind(1);
    for (int i = 0; i < 16 && !inverse_bind.empty(); ++i) bind[i / 4][i % 4] = inverse_bind[16 * j + i];
    matrices.push_back(states[skin.joints[j]].world * bind);
  }
  return matrices;
}

/// A node's position and its right-handed orthonormal axes: the direction of its z axis is kept, then that of y as
/// far as it can be.
glm::dmat4 rigid(const GltfFile& file, int node, const glm::dmat4& world) {
  const glm::dvec3 z = glm::normalize(glm::dvec3(world[2]));
  const glm::dvec3 x = glm::normalize(glm::cross(glm::dvec3(world[1]), z));
  const glm::dvec3 position = world[3];
  if (!(glm::length(position) <= kFarthestNode_m) || !std::isfinite(glm::dot(x, x)) || !std::isfinite(glm::dot(z, z))) {
    fail_gltf(file.name, fmt::format("/nodes/{}", node),
              fmt::format("a light or camera at ({:g}, {:g}, {:g}) m: must be within {:g} m of the origin, with axes "
                          "that span the space",
                          position.x, position.y, position.z, kFarthestNode_m));
  }
  return {glm::dvec4(x, 0), glm::dvec4(glm::cross(z, x), 0), glm::dvec4(z, 0), glm::dvec4(position, 1)};
}

PunctualLight read_light(const tinygltf::Light& source, const glm::dmat4& pose) {
  PunctualLight light;
  light.kind = value_named(kLightKinds, source.type, "light type");
  for (int c = 0; c < 3; ++c) {
    light.intensity[c] = static_cast<float>(source.intensity * (source.color.empty() ? 1 : source.color[c]));
  }
  light.position = glm::dvec3(pose[3]);
  light.direction = glm::dvec3(-pose[2]);
  light.range_m = static_cast<float>(source.range);
  if (light.kind == PunctualLight::Kind::spot) {
    light.cos_inner_cone = static_cast<float>(std::cos(source.spot.innerConeAngle));
    light.cos_outer_cone = static_cast<float>(std::cos(source.spot.outerConeAngle));
  }
  return light;
}

/// The matrix as float, where float is good enough for an instance; otherwise nothing. Embree carries rays to the mesh
/// by the float inverse: a point x on its surface comes back within c u k (|x| + |origin|), u = 2^-24, where k is the
/// largest row sum of |A| |A^-1| and c about 8 for the inverse, its product and the way back. Rays leave surfaces by
/// 1e-5 = 168 u of the larger of the two (pixel.cpp), which 2 c k must not exceed. Scaled axes that are turned have
/// k <= 3, however unlike each other; axes that are sheared have more, singular ones no end of it.
std::optional<glm::mat4x3> placement_matrix(const glm::dmat4& world_from_own) {
  constexpr double kMostShear = 10, kLeastAxis_m = 1e-6;
  const glm::dmat3 axes(world_from_own), inverse = glm::inverse(axes);
  for (int row = 0; row < 3; ++row) {
    double reach_m = std::abs(world_from_own[3][row]), shear = 0, inverse_reach = 0;
    for (int k = 0; k < 3; ++k) {
      reach_m += std::abs(axes[k][row]);
      inverse_reach += std::abs(inverse[k][row]);
      for (int column = 0; column < 3; ++column) shear += std::abs(axes[k][row]) * std::abs(inverse[column][k]);
    }
    // a copy says which vertex is too far away
    if (!(shear <= kMostShear && reach_m < kFarthestVertex_m / 2 && inverse_reach <= 1 / kLeastAxis_m)) return {};
  }
  return glm::mat4x3(glm::dmat4x3(world_from_own));
}

/// Puts the meshes of nodes into the scene.
class MeshReader {
 public:
  MeshReader(const GltfFile& file, const std::vector<NodeState>& states, Scene& scene)
      : file_(file), states_(states), scene_(scene), users_(file.model.meshes.size()) {
    for (std::size_t i = 0; i < states.size(); ++i) {
      if (may_share(static_cast<int>(i))) ++users_[file.model.nodes[i].mesh];
    }
  }

  void add_node(int node_index) {
    const tinygltf::Node& node = file_.model.nodes[node_index];
    const std::size_t primitives = file_.model.meshes[node.mesh].primitives.size();
    MeshPose pose{states_[node_index].world, {}};
    if (node.skin >= 0) pose.world_from_bind = joint_matrices(file_, node.skin, states_);
    std::size_t zero_area = 0;
    for (int i = 0; i < static_cast<int>(primitives); ++i) {
      if (!share(node_index, i, zero_area)) copy(node_index, i, pose, zero_area);
    }
    if (zero_area > 0) {
      scene_.warnings.push_back(fmt::format("{}: /nodes/{}/mesh: {} triangles without area are left out",
                                            printable(file_.name), node_index, zero_area));
    }
  }

 private:
  struct Shared {
    Mesh mesh;  ///< moved into the scene with its first placement
    glm::dmat4 file_from_own{1};
    std::optional<std::size_t> id;  ///< where it then is
  };

  const tinygltf::Primitive& primitive(int node, int i) const {
    return file_.model.meshes[file_.model.nodes[node].mesh].primitives[i];
  }
  std::size_t vertices(const tinygltf::Primitive& p) const {
    return file_.model.accessors[p.attributes.at("POSITION")].count;
  }
  std::size_t corners(const tinygltf::Primitive& p) const {
    return p.indices < 0 ? vertices(p) : file_.model.accessors[p.indices].count;
  }

  /// Whether the node leaves the shape of its mesh as every other such node does, for as long as the scene lasts.
  bool may_share(int node_index) const {
    const tinygltf::Node& node = file_.model.nodes[node_index];
    const NodeState& state = states_[node_index];
    return state.shown && !state.moved && node.mesh >= 0 && node.skin < 0 && node.weights.empty();
  }

  bool may_share(const tinygltf::Primitive& p) const {
    const bool dark = p.material < 0 || scene_.materials[p.material].emission_nits == glm::vec3(0);
    return dark && p.mode >= TINYGLTF_MODE_TRIANGLES;
  }

  void count(int node_index, const tinygltf::Primitive& p) {
    if (vertices(p) > vertices_left_ || corners(p) > corners_left_) {
      fail_gltf(file_.name, fmt::format("/nodes/{}/mesh", node_index),
                fmt::format("{}: the scene must have at most {} vertices and corners of triangles, those of a shared "
                            "mesh counted once",
                            file_.model.nodes[node_index].mesh, kMostVertices));
    }
    vertices_left_ -= vertices(p);
    corners_left_ -= corners(p);
  }

  void count_placement(int node_index) {
    if (placements_left_ == 0) {
      fail_gltf(file_.name, fmt::format("/nodes/{}/mesh", node_index),
                fmt::format("{}: the scene must place primitives at most {} times", file_.model.nodes[node_index].mesh,
                            kMostPlacements));
    }
    --placements_left_;
  }

  int material(const tinygltf::Primitive& p) const {
    return p.material < 0 ? static_cast<int>(file_.model.materials.size()) : p.material;
  }

  /// A mesh of the node's own, in world space.
  void copy(int node_index, int i, const MeshPose& pose, std::size_t& zero_area) {
    const tinygltf::Node& node = file_.model.nodes[node_index];
    const tinygltf::Primitive& p = primitive(node_index, i);
    count(node_index, p);
    count_placement(node_index);
    const std::vector<double>& weights = node.weights.empty() ? file_.model.meshes[node.mesh].weights : node.weights;
    Mesh mesh = read_primitive(file_, node.mesh, i, weights, pose, zero_area);
    if (mesh.triangles.empty()) return;
    mesh.material = material(p);
    mesh.object_id = static_cast<std::uint32_t>(node_index + 1);
    mesh.person = states_[node_index].person;
    scene_.meshes.push_back(std::move(mesh));
  }

  /// One more instance of a shared mesh; false where the node needs a copy.
  bool share(int node_index, int i, std::size_t& zero_area) {
    const int mesh_index = file_.model.nodes[node_index].mesh;
    const tinygltf::Primitive& p = primitive(node_index, i);
    if (!may_share(node_index) || !may_share(p) || !pays(corners(p), users_[mesh_index])) return false;
    const auto [found, anew] = shared_.try_emplace({mesh_index, i});
    Shared& shared = found->second;
    if (anew) {
      count(node_index, p);
      shared.mesh = read_shared_primitive(file_, mesh_index, i, file_.model.meshes[mesh_index].weights,
                                          shared.file_from_own, zero_area);
      shared.mesh.material = material(p);
    }
    if (!shared.id && shared.mesh.triangles.empty()) return true;
    const std::optional<glm::mat4x3> matrix = placement_matrix(states_[node_index].world * shared.file_from_own);
    if (!matrix) return false;
    count_placement(node_index);
    if (!shared.id) {
      shared.id = scene_.meshes.size();
      scene_.meshes.push_back(std::move(shared.mesh));
    }
    scene_.meshes[*shared.id].placements.push_back(
        {*matrix, static_cast<std::uint32_t>(node_index + 1), states_[node_index].person});
    return true;
  }

  const GltfFile& file_;
  const std::vector<NodeState>& states_;
  Scene& scene_;
  std::vector<std::size_t> users_;                ///< nodes of each mesh that may share it
  std::map<std::pair<int, int>, Shared> shared_;  ///< by mesh and primitive
  std::size_t vertices_left_ = kMostVertices, corners_left_ = kMostVertices, placements_left_ = kMostPlacements;
};

void add_camera(const GltfFile& file, int node_index, const glm::dmat4& world, Scene& scene) {
  const tinygltf::Node& node = file.model.nodes[node_index];
  const tinygltf::Camera& source = file.model.cameras[node.camera];
  CameraNode camera;
  camera.name = !node.name.empty() ? node.name : source.name;
  camera.world_from_node = glm::mat4(rigid(file, node_index, world));
  if (source.type == "perspective") camera.vertical_fov_rad = static_cast<float>(source.perspective.yfov);
  scene.cameras.push_back(camera);
}

}  // namespace

Scene read_gltf(const std::string& path, std::optional<double> time_s) {
  const std::string bytes = read_file(path, kLargestFileBytes);
  return read_gltf_bytes(bytes, path, std::filesystem::absolute(path).parent_path().string(), time_s);
}

std::string geometry_hash(const std::string& path) {
  return hash_of_geometry(read_file(path), path, std::filesystem::absolute(path).parent_path().string());
}

Scene read_gltf_bytes(const std::string& bytes, const std::string& name, const std::string& folder,
                      std::optional<double> time_s) {
  GltfFile file = load_gltf(bytes, name, folder, time_s.has_value());
  std::vector<bool> moved(file.model.nodes.size(), false);
  if (time_s) moved = pose_nodes(file, *time_s);
  Scene scene;
  scene.warnings = file.warnings;
  scene.source_hash = file.source_hash;
  read_materials(file, scene);

  const std::vector<NodeState> states = walk_tree(file, moved);
  MeshReader meshes(file, states, scene);
  for (std::size_t i = 0; i < states.size(); ++i) {
    const tinygltf::Node& node = file.model.nodes[i];
    const int index = static_cast<int>(i);
    scene.object_names.push_back(!node.name.empty() ? node.name : fmt::format("node {}", i));
    if (!states[i].shown) continue;
    if (node.mesh >= 0) meshes.add_node(index);
    if (node.camera >= 0) add_camera(file, index, states[i].world, scene);
    const auto light = node.extensions.find("KHR_lights_punctual");
    if (light != node.extensions.end()) {
      const int light_index = light->second.Get("light").GetNumberAsInt();
      scene.lights.push_back(read_light(file.model.lights[light_index], rigid(file, index, states[i].world)));
    }
  }
  if (scene.meshes.empty()) throw InputError(printable(name) + ": the scene must show at least one triangle with area");
  return scene;
}

}  // namespace dualpixel::simulator
