#pragma once
#include <functional>
#include <string>
#include <vector>

#include "evaluation/chart/chart.h"
#include "evaluation/chart/chart_input.h"

/// What `dualpixel chart` measures, stage by stage, by the benchmarks and experiments that exist.
namespace dualpixel::evaluation {

struct ChartStage {
  std::string name;
  bool in_quick = true;
  std::function<ChartPart(const ChartInput&)> measure;
};

const std::vector<ChartStage>& chart_stages();

/// What no stage measures, and why; stages add what they could not (ChartPart).
std::vector<std::string> chart_left_out(bool quick);

}  // namespace dualpixel::evaluation
