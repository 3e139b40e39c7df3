#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "pipeline/portrait/run_portrait.h"

/// The pipeline's time on a capture of a scene, in units of a copy of its input.
namespace dualpixel::evaluation {

struct PipelineTime {
  double dp_ms = 0;          ///< mode dp, wall time, all cores, the best of three
  double burst_copy_ms = 0;  ///< of all frames' mosaics in memory, once
  std::vector<pipeline::StageTime> stages;
};

PipelineTime measure_pipeline_time(const std::string& scene_file);

nlohmann::json to_json(const PipelineTime& time);

}  // namespace dualpixel::evaluation
