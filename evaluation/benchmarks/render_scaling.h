#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

/// How the renderer's cost grows, on a scene made by code: a wall of waves, of as many triangles as asked for, under a
/// sky, with one shadow ray a sample. Times are CPU time, so that other programs on the machine count little.
namespace dualpixel::evaluation {

/// Points of light on surfaces (simulator/render/light) that one picture asks for.
struct PointCost {
  double points = 0;
  double cpu_s = 0;  ///< what the picture takes longer when they are made than when they are known
};

/// CPU time of one camera sample where a photosite has `count` samples, or a picture `count` photosites.
struct SampleCost {
  double count = 0;
  double cpu_ns = 0;  ///< with points of light that are known
  PointCost light;
};

struct SceneCost {
  double triangles = 0;
  double cpu_ns = 0;              ///< of a camera sample, with points of light that are known
  double ray_ns = 0;              ///< of a ray in Embree alone
  double build_s = 0;             ///< of the acceleration structure
  double bytes_per_triangle = 0;  ///< of the acceleration structure, its copy of the geometry included
  PointCost light;                ///< of a picture of 128 x 96 photosites
};

/// One tile of 10^4 triangles placed many times, and the same with a copy at each position.
struct InstancingCost {
  int placements = 0;
  SceneCost placed, copied;
};

struct RenderScaling {
  std::vector<SampleCost> samples, photosites;
  double wall_time_ratio = 0, cpu_time_ratio = 0;  ///< one thread over two
  std::vector<SceneCost> triangles;                ///< powers of ten from 10^4
  std::vector<InstancingCost> instancing;
};

RenderScaling measure_scaling(double most_triangles, const std::function<void(double fraction)>& progress);

/// Half the range of the times over the middle of it: 0 where cost does not depend on the count.
double relative_spread(const std::vector<SampleCost>& costs);

nlohmann::ordered_json to_json(const RenderScaling& scaling);
/// HTML: the charts and a sentence for each.
std::string scaling_section(const RenderScaling& scaling);

}  // namespace dualpixel::evaluation
