#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

/// How the renderer's cost grows, on a scene made by code: a wall of waves, of as many triangles as asked for, under a
/// sky, with one shadow ray a sample. Times are CPU time, so that other programs on the machine count little.
namespace dualpixel::evaluation {

/// {"samples", "photosites", "triangles"}: rows of one count and what a camera sample then costs, "cpu_ns", the
/// triangles' with "ray_ns" in Embree alone, "build_s" and "bytes_per_triangle" of the acceleration structure (its copy
/// of the geometry included); "placements": the same for places of a tile of 10^4 triangles, and, "copied_", for copies
/// of it; "threads": what a second thread gains. Triangles in powers of ten from 10^4 to `most_triangles`.
nlohmann::ordered_json measure_scaling(double most_triangles, const std::function<void(double fraction)>& progress);

/// HTML: the charts and a sentence for each.
std::string scaling_section(const nlohmann::ordered_json& scaling);

}  // namespace dualpixel::evaluation
