#pragma once
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "datasets/plan/sample_line.h"

namespace dualpixel::datasets {

/// One of `count` parts of a data set.
struct Shard {
  int index = 0;  ///< 0 .. count - 1
  int count = 1;
};

/// "I/N", I from 0 to N - 1. Throws InputError.
Shard parse_shard(const std::string& text);

/// What a batch system says of this process: SLURM_ARRAY_TASK_ID and SLURM_ARRAY_TASK_COUNT (with _MIN, _MAX, _STEP),
/// Kubernetes' JOB_COMPLETION_INDEX with JOB_COMPLETION_COUNT, AWS Batch's AWS_BATCH_JOB_ARRAY_INDEX with
/// AWS_BATCH_JOB_ARRAY_SIZE; otherwise the whole. Throws InputError where an index comes without its count, or where
/// Slurm's array has gaps that leave open how many tasks come before this one.
Shard shard_of_environment();

/// The shard's lines, samples of one scene side by side: each is in one shard, and scenes are spread over as few shards
/// as equal sizes allow.
std::vector<SampleLine> lines_of(std::vector<SampleLine> lines, const Shard& shard);

/// Hands lines out to jobs that ask when they are done: each goes on with its scene, then with one that nobody has
/// begun, and where there is none, helps with the scene of which most is left, so that all end together. Not for two
/// threads at once.
class LineQueue {
 public:
  /// `lines` with samples of one scene side by side, as lines_of() has them; jobs are numbered from 0.
  LineQueue(std::vector<SampleLine> lines, int jobs);

  /// The job's next line; none: no line is left.
  std::optional<SampleLine> next(int job);

 private:
  /// The samples of one scene.
  struct Run {
    std::deque<SampleLine> left;
    bool begun = false;
  };

  std::vector<Run> runs_;
  std::vector<std::size_t> run_of_job_;
};

}  // namespace dualpixel::datasets
