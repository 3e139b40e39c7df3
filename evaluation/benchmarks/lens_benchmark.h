#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

/// Each model of a lens, from the thin lens to the exact trace: its time, and its error in disparity.
namespace dualpixel::evaluation {

struct LensModelCost {
  std::string model;
  double ready_s = 0;  ///< until the first ray can be sampled
  double samples_per_core_s = 0;
  double time_over_thin = 0;         ///< of a sample
  double disparity_error_dp_px = 0;  ///< RMS over the field and over depths, against the exact trace
};

struct LensBenchmark {
  std::string lens;  ///< its name
  std::string file;
  std::vector<LensModelCost> models;
};

/// On one thread; what is rendered is the scene, at 1344 x 1008 photosites, from its own camera's pose.
std::vector<LensBenchmark> measure_lenses(const std::vector<std::string>& lens_files, const std::string& scene_file);

nlohmann::ordered_json to_json(const std::vector<LensBenchmark>& lenses, const std::string& scene_file);
std::string to_page(const std::vector<LensBenchmark>& lenses, const std::string& scene_file);

}  // namespace dualpixel::evaluation
