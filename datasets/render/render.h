#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "datasets/plan/sample_line.h"
#include "datasets/render/sample_folder.h"
#include "datasets/render/shard.h"
#include "simulator/ready_scene.h"

namespace dualpixel::datasets {

/// What a line stands for. It depends on the line alone. `ready` is the scene of the last call, which is
/// loaded once for samples that share it; drawn scenes are written to DATASET/scenes. Throws InputError.
RenderedSample render_line(const SampleLine& line, const std::string& dataset,
                           std::unique_ptr<simulator::ReadyScene>& ready);

struct RenderCounts {
  int planned = 0;  ///< in this shard
  int there = 0;    ///< before
  int rendered = 0;
  int failed = 0;

  int left() const { return planned - there - rendered - failed; }
};

struct RenderTask {
  std::string dataset;
  Shard shard;
  int jobs = 1;                               ///< samples at a time (LineQueue), each with its share of the threads
  const std::atomic<int>* stopped = nullptr;  ///< set and not 0: no further sample is begun
  std::function<void(const RenderCounts&)> progress = {};  ///< after each sample, one at a time
};

inline constexpr const char* kFailuresFile = "failures.jsonl";

/// Renders what the shard lacks. A sample that cannot be rendered gets a line in failures.jsonl, with its name and the
/// reason, and the others go on; the next call tries it again. Throws InputError where the data set cannot be read, or
/// its folder cannot be written.
RenderCounts render_shard(const RenderTask& task);

}  // namespace dualpixel::datasets
