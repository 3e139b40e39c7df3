#include "simulator/scene/gltf/mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simulator/scene/gltf/accessor.h"
#include "simulator/scene/gltf/check.h"

namespace dualpixel::simulator {
namespace {

/// The accessor of an attribute, or -1.
int accessor_of(const std::map<std::string, int>& attributes, const char* name) {
  const auto found = attributes.find(name);
  return found == attributes.end() ? -1 : found->second;
}

template <typename Vector>
std::vector<Vector> read_vectors(const GltfFile& file, int accessor) {
  if (accessor < 0) return {};
  const std::vector<float> values = read_floats(file, accessor);
  std::vector<Vector> vectors(values.size() / Vector::length());
  for (std::size_t i = 0; i < values.size(); ++i) vectors[i / Vector::length()][i % Vector::length()] = values[i];
  return vectors;
}

std::vector<glm::vec4> read_colors(const GltfFile& file, int accessor) {
  std::vector<glm::vec4> colors;
  if (accessor < 0) return colors;
  if (file.model.accessors[accessor].type == TINYGLTF_TYPE_VEC4) {
    colors = read_vectors<glm::vec4>(file, accessor);
  } else {
    for (const glm::vec3& rgb : read_vectors<glm::vec3>(file, accessor)) colors.emplace_back(rgb, 1.0f);
  }
  for (glm::vec4& color : colors) color = glm::clamp(color, 0.0f, 1.0f);  // more would make light
  return colors;
}

void add_morph_target(const GltfFile& file, int accessor, double weight, std::vector<glm::vec3>& values) {
  if (accessor < 0 || values.empty()) return;
  const std::vector<glm::vec3> offsets = read_vectors<glm::vec3>(file, accessor);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] += static_cast<float>(weight) * offsets[i];
}

/// The matrix that carries each vertex to the world.
class VertexMatrices {
 public:
  VertexMatrices(const GltfFile& file, const std::map<std::string, int>& attributes, const MeshPose& pose)
      : pose_(pose) {
    if (pose.world_from_bind.empty()) return;
    for (const char* set : {"0", "1"}) {
      const int joints = accessor_of(attributes, (std::string("JOINTS_") + set).c_str());
      const int weights = accessor_of(attributes, (std::string("WEIGHTS_") + set).c_str());
      if (joints < 0 || weights < 0) continue;
      sets_.push_back(
          {read_indices(file, joints, pose.world_from_bind.size(), "joints of the skin"), read_floats(file, weights)});
    }
  }

  glm::dmat4 operator()(std::size_t vertex) const {
    if (sets_.empty()) return pose_.world_from_mesh;
    glm::dmat4 blended(0);
    double sum = 0;
    for (const Influences& set : sets_) {
      for (std::size_t i = vertex * 4; i < vertex * 4 + 4; ++i) {
        if (!(set.weights[i] > 0)) continue;
        blended += static_cast<double>(set.weights[i]) * pose_.world_from_bind[set.joints[i]];
        sum += set.weights[i];
      }
    }
    // Quantized weights need not add up to 1; a vertex that no joint holds follows its first.
    return sum > 0 ? blended * (1 / sum) : pose_.world_from_bind[sets_[0].joints[vertex * 4]];
  }

 private:
  struct Influences {
    std::vector<std::uint32_t> joints;  ///< four for each vertex
    std::vector<float> weights;
  };
  const MeshPose& pose_;
  std::vector<Influences> sets_;
};

/// Normals transform with the inverse transpose; its sign, not its length, matters.
glm::dvec3 transformed_normal(const glm::dmat3& m, const glm::dvec3& normal, double determinant) {
  const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
  const glm::dvec3 n = cofactors * normal * (determinant < 0 ? -1.0 : 1.0);
  const double length = glm::length(n);
  return length > 0 && std::isfinite(length) ? n / length : glm::dvec3(0);
}

/// Lists, strips and fans as a list (glTF 2.0, section 3.7.2.1). An incomplete last triangle is left out.
std::vector<glm::uvec3> triangles_of(const std::vector<std::uint32_t>& v, int mode) {
  std::vector<glm::uvec3> triangles;
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    for (std::size_t i = 0; i + 2 < v.size(); i += 3) triangles.emplace_back(v[i], v[i + 1], v[i + 2]);
  } else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
    for (std::size_t i = 0; i + 2 < v.size(); ++i) triangles.emplace_back(v[i], v[i + 1 + i % 2], v[i + 2 - i % 2]);
  } else if (mode == TINYGLTF_MODE_TRIANGLE_FAN) {
    for (std::size_t i = 0; i + 2 < v.size(); ++i) triangles.emplace_back(v[i + 1], v[i + 2], v[0]);
  }
  return triangles;
}

/// Lines with widths are strands of hair.
bool is_strands(const tinygltf::Primitive& primitive) {
  return primitive.mode >= TINYGLTF_MODE_LINE && primitive.mode <= TINYGLTF_MODE_LINE_STRIP &&
         primitive.attributes.count("_WIDTH") > 0;
}

/// Lines, loops and strips as a list of segments, as Mesh has them (glTF 2.0, section 3.7.2.1).
std::vector<glm::uvec3> segments_of(const std::vector<std::uint32_t>& v, int mode) {
  std::vector<glm::uvec3> segments;
  const std::size_t step = mode == TINYGLTF_MODE_LINE ? 2 : 1;
  for (std::size_t i = 0; i + 1 < v.size(); i += step) segments.emplace_back(v[i], v[i + 1], v[i]);
  if (mode == TINYGLTF_MODE_LINE_LOOP && v.size() > 2) segments.emplace_back(v.back(), v.front(), v.back());
  return segments;
}

std::vector<float> read_radii(const GltfFile& file, int accessor) {
  std::vector<float> radii = read_floats(file, accessor);
  for (std::size_t i = 0; i < radii.size(); ++i) {
    if (!(radii[i] > 0)) {
      fail_gltf(file.name, fmt::format("/accessors/{}", accessor),
                fmt::format("width {:g} of vertex {}: must be above 0", radii[i], i));
    }
    radii[i] *= 0.5f;
  }
  return radii;
}

/// Others would give Embree infinite bounds, or no width to divide by.
float scaled_radius(const GltfFile& file, int accessor, std::size_t vertex, float radius, double scale) {
  const double radius_m = radius * scale;
  if (!(radius_m >= kThinnestHair_m && radius_m <= kFarthestVertex_m)) {
    fail_gltf(file.name, fmt::format("/accessors/{}", accessor),
              fmt::format("width of vertex {}: its half, {:g} m in the world, must be {:g} to {:g} m", vertex, radius_m,
                          kThinnestHair_m, kFarthestVertex_m));
  }
  return static_cast<float>(radius_m);
}

/// Twice the area times the face normal; 0 where the triangle is a line or a point, up to float rounding.
glm::dvec3 area_vector(const Mesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 a = mesh.positions[t.x], b = mesh.positions[t.y], c = mesh.positions[t.z];
  const glm::dvec3 vector = glm::cross(b - a, c - a);
  const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
  return glm::length(vector) > std::max(1e-9 * longest * longest, 1e-20) ? vector : glm::dvec3(0);
}

/// Morphed, in the coordinates of the file, without triangles.
Mesh read_vertices(const GltfFile& file, const tinygltf::Primitive& primitive, const std::vector<double>& weights) {
  Mesh mesh;
  const auto& attributes = primitive.attributes;
  mesh.positions = read_vectors<glm::vec3>(file, accessor_of(attributes, "POSITION"));
  mesh.normals = read_vectors<glm::vec3>(file, accessor_of(attributes, "NORMAL"));
  mesh.uv0 = read_vectors<glm::vec2>(file, accessor_of(attributes, "TEXCOORD_0"));
  mesh.uv1 = read_vectors<glm::vec2>(file, accessor_of(attributes, "TEXCOORD_1"));
  mesh.colors = read_colors(file, accessor_of(attributes, "COLOR_0"));
  if (is_strands(primitive)) {
    mesh.radii = read_radii(file, accessor_of(attributes, "_WIDTH"));
    mesh.normals.clear();
  }
  for (std::size_t i = 0; i < std::min(weights.size(), primitive.targets.size()); ++i) {
    if (weights[i] == 0) continue;
    add_morph_target(file, accessor_of(primitive.targets[i], "POSITION"), weights[i], mesh.positions);
    add_morph_target(file, accessor_of(primitive.targets[i], "NORMAL"), weights[i], mesh.normals);
  }
  return mesh;
}

/// Moves the vertices to where the pose puts them, and adds the triangles.
void pose_and_connect(const GltfFile& file, const tinygltf::Primitive& primitive, const MeshPose& pose,
                      std::size_t& zero_area, Mesh& mesh) {
  const auto& attributes = primitive.attributes;
  const VertexMatrices world_from_vertex(file, attributes, pose);
  std::vector<bool> mirrored(mesh.positions.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::dmat4 matrix = world_from_vertex(i);
    const double determinant = glm::determinant(glm::dmat3(matrix));
    mirrored[i] = determinant < 0;
    const glm::dvec3 world = matrix * glm::dvec4(mesh.positions[i], 1);
    if (!(glm::length(world) <= kFarthestVertex_m)) {
      fail_gltf(file.name, fmt::format("/accessors/{}", accessor_of(attributes, "POSITION")),
                fmt::format("vertex {} stands at ({:g}, {:g}, {:g}) m: must be within {:g} m of the origin", i, world.x,
                            world.y, world.z, kFarthestVertex_m));
    }
    mesh.positions[i] = world;
    if (mesh.is_hair()) {
      const int widths = accessor_of(attributes, "_WIDTH");
      mesh.radii[i] = scaled_radius(file, widths, i, mesh.radii[i], std::cbrt(std::abs(determinant)));
    }
    if (!mesh.normals.empty()) mesh.normals[i] = transformed_normal(matrix, mesh.normals[i], determinant);
  }

  std::vector<std::uint32_t> vertices;
  if (primitive.indices >= 0) {
    vertices = read_indices(file, primitive.indices, mesh.positions.size(), "vertices");
  } else {
    vertices.resize(mesh.positions.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) vertices[i] = static_cast<std::uint32_t>(i);
  }
  if (mesh.is_hair()) {
    for (const glm::uvec3& s : segments_of(vertices, primitive.mode)) {
      if (mesh.positions[s.x] != mesh.positions[s.y]) mesh.triangles.push_back(s);
    }
    return;
  }
  for (glm::uvec3 t : triangles_of(vertices, primitive.mode)) {
    if (mirrored[t.x]) std::swap(t.y, t.z);
    const glm::dvec3 face = area_vector(mesh, t);
    if (face == glm::dvec3(0)) {
      ++zero_area;
      continue;
    }
    mesh.triangles.push_back(t);
    // A vertex whose normal has no direction takes that of its first face.
    for (int i = 0; i < 3 && !mesh.normals.empty(); ++i) {
      if (mesh.normals[t[i]] == glm::vec3(0)) mesh.normals[t[i]] = glm::normalize(face);
    }
  }
}

/// Moves and scales the middle and the longest half-side of the vertices' box to 0 and (0.5, 1], by a power of two.
glm::dmat4 own_from_file(const std::vector<glm::vec3>& positions) {
  glm::dvec3 low = positions.front(), high = low;
  for (const glm::dvec3 p : positions) low = glm::min(low, p), high = glm::max(high, p);
  const glm::dvec3 half = 0.5 * (high - low);
  const double longest = std::max({half.x, half.y, half.z});
  const double scale = longest > 0 ? std::exp2(-std::ceil(std::log2(longest))) : 1;
  glm::dmat4 matrix(scale);
  matrix[3] = glm::dvec4(-scale * (low + half), 1);
  return matrix;
}

}  // namespace

Mesh read_primitive(const GltfFile& file, int mesh_index, int primitive_index, const std::vector<double>& weights,
                    const MeshPose& pose, std::size_t& zero_area) {
  const tinygltf::Primitive& primitive = file.model.meshes[mesh_index].primitives[primitive_index];
  if (primitive.mode < TINYGLTF_MODE_TRIANGLES && !is_strands(primitive)) return {};
  Mesh mesh = read_vertices(file, primitive, weights);
  pose_and_connect(file, primitive, pose, zero_area, mesh);
  return mesh;
}

Mesh read_shared_primitive(const GltfFile& file, int mesh_index, int primitive_index,
                           const std::vector<double>& weights, glm::dmat4& file_from_own, std::size_t& zero_area) {
  const tinygltf::Primitive& primitive = file.model.meshes[mesh_index].primitives[primitive_index];
  Mesh mesh = read_vertices(file, primitive, weights);
  const MeshPose own{own_from_file(mesh.positions), {}};
  file_from_own = glm::inverse(own.world_from_mesh);
  pose_and_connect(file, primitive, own, zero_area, mesh);
  return mesh;
}

}  // namespace dualpixel::simulator
