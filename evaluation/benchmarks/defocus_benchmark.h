#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

/// Time of the defocus renderers by themselves.
namespace dualpixel::evaluation {

struct RendererTime {
  std::string name;  ///< key in the JSON, words joined by _
  double ms = 0, cpu_ms = 0;
};

/// Scattering the whole picture at half its size by one radius.
struct RadiusTime {
  double radius_px = 0;  ///< of the full-size picture
  double gradient_ms = 0, gradient_cpu_ms = 0;
  std::optional<double> direct_ms, direct_cpu_ms;  ///< brute force; none above 20 px
};

struct DefocusBenchmark {
  std::vector<RendererTime> renderers;
  std::vector<RadiusTime> radii;
};

/// On a burst of the scene at its full size; all cores.
DefocusBenchmark measure_defocus_time(const std::string& scene_file);

nlohmann::ordered_json to_json(const DefocusBenchmark& benchmark);
std::string to_page(const DefocusBenchmark& benchmark);

}  // namespace dualpixel::evaluation
