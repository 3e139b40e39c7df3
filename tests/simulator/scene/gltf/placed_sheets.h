#pragma once
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "tests/simulator/scene/gltf/gltf_builder.h"

namespace dualpixel::simulator {

/// A wavy sheet of 2 m x 2 m about the z axis, 2 `side`^2 triangles with normals and UVs, at each of `nodes`, which
/// say no mesh yet: either all of one glTF mesh, or each of a mesh of its own that reads the same numbers.
inline GltfBuilder placed_sheets(nlohmann::json nodes, bool shared, int side = 12) {
  std::vector<float> positions, normals, uvs;
  std::vector<std::uint16_t> corners;
  for (int i = 0; i <= side; ++i) {
    for (int j = 0; j <= side; ++j) {
      const float u = static_cast<float>(j) / static_cast<float>(side);
      const float v = static_cast<float>(i) / static_cast<float>(side);
      const float x = 2 * u - 1, y = 2 * v - 1;
      const glm::vec3 n = glm::normalize(
          glm::vec3(-0.6f * std::cos(3 * x) * std::cos(2 * y), 0.4f * std::sin(3 * x) * std::sin(2 * y), 1));
      positions.insert(positions.end(), {x, y, 0.2f * std::sin(3 * x) * std::cos(2 * y)});
      normals.insert(normals.end(), {n.x, n.y, n.z});
      uvs.insert(uvs.end(), {u, v});
      if (i == side || j == side) continue;
      const auto at = [&](int row, int column) { return static_cast<std::uint16_t>(row * (side + 1) + column); };
      corners.insert(corners.end(), {at(i, j), at(i, j + 1), at(i + 1, j + 1)});
      corners.insert(corners.end(), {at(i, j), at(i + 1, j + 1), at(i + 1, j)});
    }
  }
  GltfBuilder gltf;
  const int position = gltf.add_accessor(positions, "VEC3"), normal = gltf.add_accessor(normals, "VEC3");
  const int uv = gltf.add_accessor(uvs, "VEC2"), indices = gltf.add_accessor(corners, "SCALAR");
  const nlohmann::json mesh = {{"primitives",
                                {{{"attributes", {{"POSITION", position}, {"NORMAL", normal}, {"TEXCOORD_0", uv}}},
                                  {"indices", indices},
                                  {"material", 0}}}}};
  gltf.root["materials"] = {
      {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"baseColorFactor", {0.5, 0.5, 0.5, 1}}}}}};
  std::vector<bool> has_parent(nodes.size(), false);
  for (const auto& node : nodes) {
    for (const int child : node.value("children", std::vector<int>{})) has_parent[child] = true;
  }
  nlohmann::json roots = nlohmann::json::array();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!has_parent[i]) roots.push_back(i);
    if (!shared || i == 0) gltf.root["meshes"].push_back(mesh);
    nodes[i]["mesh"] = shared ? 0 : i;
  }
  gltf.root["nodes"] = nodes;
  gltf.root["scenes"] = {{{"nodes", roots}}};
  return gltf;
}

/// Sheets in front of a camera at the origin that looks along +z: shifted; turned, stretched 6 : 1, a person; mirrored,
/// far; sheared, as the child of a stretched and mirrored node; a thin one behind the others.
inline nlohmann::json sheets_in_view() {
  return nlohmann::json::parse(R"([
    {"translation": [-1.2, 0.4, 3]},
    {"translation": [1.1, -0.5, 2.5], "rotation": [0.2, 0.3, 0.1, 0.9273618495495703], "scale": [0.3, 1.8, 0.6],
     "extras": {"category": "person"}},
    {"translation": [0.3, 1.5, 6], "rotation": [0, 0.5, 0, 0.8660254037844386], "scale": [-1.5, 1.5, 1.5]},
    {"translation": [-0.8, -1.2, 4], "scale": [1, -2, 1], "children": [4]},
    {"translation": [0.2, 0.2, 1], "rotation": [0, 0, 0.3826834323650898, 0.9238795325112867]},
    {"translation": [0, 0, 9], "scale": [5, 5, 0.01]}
  ])");
}

}  // namespace dualpixel::simulator
