#pragma once
#include <functional>
#include <vector>

#include "scenes/gltf/mesh.h"

/// Meshes of simple solids, appended to a mesh. UVs are meters on the surface, so that a texture has one scale
/// everywhere.
namespace dualpixel::scenes {

/// A box with half sizes `half` along the columns of `axes`; edges are rounded by `edge_m`, less than half the
/// smallest side (0: sharp).
void add_solid_box(Mesh& mesh, glm::vec3 center, glm::vec3 half, float edge_m = 0,
                   const glm::mat3& axes = glm::mat3(1));

/// A surface of revolution about y: `profile` holds (radius, height), from bottom to top along the outside. Edges of
/// more than 35 degrees stay sharp.
void add_lathe(Mesh& mesh, const glm::mat4& pose, const std::vector<glm::vec2>& profile, int sides = 48);

/// An ellipsoid; `bumps`, where given, scales the radius in each unit direction.
void add_ball(Mesh& mesh, glm::vec3 center, glm::vec3 radii, int rows = 24,
              const std::function<float(glm::vec3)>& bumps = {});

/// A tube along `path` with a radius at each point; ends are closed by a point where `closed_ends`.
void add_pipe(Mesh& mesh, const std::vector<glm::vec3>& path, const std::vector<float>& radii, int sides = 10,
              bool closed_ends = true);
/// The same of one radius.
void add_pipe(Mesh& mesh, const std::vector<glm::vec3>& path, float radius, int sides = 10);

/// A surface of `columns` x `rows` quads: at(u, v) is a point of it, u and v from 0 to 1. UVs are u * size_m.x,
/// v * size_m.y.
void add_sheet(Mesh& mesh, int columns, int rows, glm::vec2 size_m, const std::function<glm::vec3(float, float)>& at);

/// A closed curve: `count` points of at(t), t from 0 to 1.
std::vector<glm::vec3> curve(int count, const std::function<glm::vec3(float)>& at);

/// A rotation by `angle` about y, then a move: how things stand on tables and floors.
glm::mat4 standing(glm::vec3 at, float angle);

}  // namespace dualpixel::scenes
