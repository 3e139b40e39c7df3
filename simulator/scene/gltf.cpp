#include "simulator/scene/gltf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/gtc/quaternion.hpp>
#include <limits>

#include "capture/error.h"
#include "capture/files.h"
#include "simulator/scene/gltf_accessor.h"
#include "simulator/scene/gltf_animation.h"
#include "simulator/scene/gltf_check.h"
#include "simulator/scene/gltf_files.h"
#include "simulator/scene/gltf_material.h"
#include "simulator/scene/gltf_mesh.h"

namespace dualpixel::simulator {
namespace {

constexpr std::size_t kLargestFileBytes = std::numeric_limits<std::int32_t>::max();
constexpr std::size_t kMostVertices = 1 << 26;  // of all instances together, and as many triangles
constexpr double kFarthestNode_m = 1e6;         // for lights and cameras

/// A node's place in the tree.
struct NodeState {
  glm::dmat4 world{1};  ///< world from node
  bool shown = false;   ///< belongs to the default scene
  bool person = false;  ///< it or an ancestor is marked as a person
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

std::vector<NodeState> walk_tree(const GltfFile& file) {
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
  light.kind = source.type == "point"  ? PunctualLight::Kind::point
               : source.type == "spot" ? PunctualLight::Kind::spot
                                       : PunctualLight::Kind::directional;
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

void add_meshes(const GltfFile& file, int node_index, const std::vector<NodeState>& states, Scene& scene,
                std::size_t& vertices_left, std::size_t& triangles_left) {
  const tinygltf::Node& node = file.model.nodes[node_index];
  const tinygltf::Mesh& source = file.model.meshes[node.mesh];
  MeshPose pose{states[node_index].world, {}};
  if (node.skin >= 0) pose.world_from_bind = joint_matrices(file, node.skin, states);
  std::size_t zero_area = 0;
  for (std::size_t i = 0; i < source.primitives.size(); ++i) {
    const tinygltf::Primitive& primitive = source.primitives[i];
    const std::size_t vertices = file.model.accessors[primitive.attributes.at("POSITION")].count;
    const std::size_t corners = primitive.indices < 0 ? vertices : file.model.accessors[primitive.indices].count;
    if (vertices > vertices_left || corners > triangles_left) {
      fail_gltf(file.name, fmt::format("/nodes/{}/mesh", node_index),
                fmt::format("{}: the scene must have at most {} vertices and corners of triangles", node.mesh,
                            kMostVertices));
    }
    vertices_left -= vertices;
    triangles_left -= corners;
    Mesh mesh = read_primitive(file, node.mesh, static_cast<int>(i),
                               node.weights.empty() ? source.weights : node.weights, pose, zero_area);
    if (mesh.triangles.empty()) continue;
    mesh.material = primitive.material < 0 ? static_cast<int>(file.model.materials.size()) : primitive.material;
    mesh.object_id = static_cast<std::uint32_t>(node_index + 1);
    mesh.person = states[node_index].person;
    scene.meshes.push_back(std::move(mesh));
  }
  if (zero_area > 0) {
    scene.warnings.push_back(fmt::format("{}: /nodes/{}/mesh: {} triangles without area are left out",
                                         printable(file.name), node_index, zero_area));
  }
}

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

Scene read_gltf_bytes(const std::string& bytes, const std::string& name, const std::string& folder,
                      std::optional<double> time_s) {
  GltfFile file = load_gltf(bytes, name, folder, time_s.has_value());
  if (time_s) pose_nodes(file, *time_s);
  Scene scene;
  scene.warnings = file.warnings;
  scene.source_hash = file.source_hash;
  read_materials(file, scene);

  const std::vector<NodeState> states = walk_tree(file);
  std::size_t vertices_left = kMostVertices, triangles_left = kMostVertices;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const tinygltf::Node& node = file.model.nodes[i];
    const int index = static_cast<int>(i);
    scene.object_names.push_back(!node.name.empty() ? node.name : fmt::format("node {}", i));
    if (!states[i].shown) continue;
    if (node.mesh >= 0) add_meshes(file, index, states, scene, vertices_left, triangles_left);
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
