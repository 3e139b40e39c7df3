#include "datasets/render/shard.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdlib>

#include "capture/error.h"
#include "simulator/ready_scene.h"

namespace dualpixel::datasets {
namespace {

constexpr int kMostShards = 1'000'000;

bool read_whole(const std::string& text, int& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() && !text.empty();
}

/// The variable's number, -1 where it is not set.
int number_in(const char* variable) {
  const char* text = std::getenv(variable);
  if (text == nullptr) return -1;
  int value = 0;
  if (!read_whole(text, value) || value < 0) {
    throw InputError(fmt::format("{}: '{}': must be a whole number", variable, printable(text)));
  }
  return value;
}

/// What a batch system calls its index and count.
struct BatchVariables {
  const char *index, *count;
};
constexpr BatchVariables kSlurm = {"SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT"};
constexpr BatchVariables kOthers[] = {{"JOB_COMPLETION_INDEX", "JOB_COMPLETION_COUNT"},
                                      {"AWS_BATCH_JOB_ARRAY_INDEX", "AWS_BATCH_JOB_ARRAY_SIZE"}};

int count_in(const BatchVariables& batch) {
  const int count = number_in(batch.count);
  if (count >= 0) return count;
  throw InputError(fmt::format("{} is set without {}: give --shard I/N", batch.index, batch.count));
}

Shard shard_in(const BatchVariables& batch, int index) {
  const Shard shard{index, count_in(batch)};
  if (shard.count >= 1 && shard.count <= kMostShards && shard.index < shard.count) return shard;
  throw InputError(
      fmt::format("{}: {} of {} {}: must be below it: give --shard I/N", batch.index, index, batch.count, shard.count));
}

/// Of an array such as 0-19, or 3-30:3. One with gaps of unlike size does not say how many of its tasks come before
/// this one.
Shard shard_of_slurm() {
  const int id = number_in(kSlurm.index), count = count_in(kSlurm);
  const int first = std::max(number_in("SLURM_ARRAY_TASK_MIN"), 0);
  const int step = std::max(number_in("SLURM_ARRAY_TASK_STEP"), 1);
  const int given_last = number_in("SLURM_ARRAY_TASK_MAX");
  const std::int64_t last = first + std::int64_t{step} * (count - 1);
  if (id < first || id > last || (id - first) % step != 0 || (given_last >= 0 && given_last != last)) {
    throw InputError(fmt::format(
        "SLURM_ARRAY_TASK_ID: {}: is in an array of {} tasks from {}{} that are not evenly spaced, which "
        "leaves open what part it is: give --shard I/N, or an array such as 0-{}",
        id, count, first, given_last >= 0 ? fmt::format(" to {}", given_last) : "", std::max(count - 1, 0)));
  }
  return shard_in(kSlurm, (id - first) / step);
}

/// Equal for samples that share a scene.
std::string scene_key(const SampleLine& line) {
  std::string key = line.scene.dump();
  for (const auto& [field, value] : line.set.items()) {
    if (simulator::is_of_scene(field)) key += " " + field + "=" + value.dump();
  }
  return key;
}

}  // namespace

Shard parse_shard(const std::string& text) {
  Shard shard;
  const std::size_t slash = text.find('/');
  const bool read = slash != std::string::npos && read_whole(text.substr(0, slash), shard.index) &&
                    read_whole(text.substr(slash + 1), shard.count);
  if (!read || shard.count < 1 || shard.count > kMostShards || shard.index < 0 || shard.index >= shard.count) {
    throw InputError(fmt::format("--shard: '{}': must be I/N with I from 0 to N - 1", printable(text)));
  }
  return shard;
}

Shard shard_of_environment() {
  if (number_in(kSlurm.index) >= 0) return shard_of_slurm();
  for (const BatchVariables& batch : kOthers) {
    if (const int index = number_in(batch.index); index >= 0) return shard_in(batch, index);
  }
  return {};
}

std::vector<SampleLine> lines_of(std::vector<SampleLine> lines, const Shard& shard) {
  std::vector<std::pair<std::string, std::size_t>> order;
  for (std::size_t i = 0; i < lines.size(); ++i) order.emplace_back(scene_key(lines[i]), i);
  std::sort(order.begin(), order.end());
  std::vector<SampleLine> mine;
  const auto at = [&](int index) { return order.size() * static_cast<std::size_t>(index) / shard.count; };
  for (std::size_t i = at(shard.index); i < at(shard.index + 1); ++i) {
    mine.push_back(std::move(lines[order[i].second]));
  }
  return mine;
}

LineQueue::LineQueue(std::vector<SampleLine> lines, int jobs) {
  std::string last;
  for (SampleLine& line : lines) {
    const std::string key = scene_key(line);
    if (runs_.empty() || key != last) runs_.emplace_back();
    runs_.back().left.push_back(std::move(line));
    last = key;
  }
  run_of_job_.assign(static_cast<std::size_t>(jobs), runs_.size());
}

std::optional<SampleLine> LineQueue::next(int job) {
  std::size_t& mine = run_of_job_[static_cast<std::size_t>(job)];
  if (mine == runs_.size() || runs_[mine].left.empty()) {
    const auto rank = [](const Run& run) { return std::pair(!run.begun, run.left.size()); };
    const auto best =
        std::max_element(runs_.begin(), runs_.end(), [&](const Run& a, const Run& b) { return rank(a) < rank(b); });
    if (best == runs_.end() || best->left.empty()) return std::nullopt;
    mine = static_cast<std::size_t>(best - runs_.begin());
  }
  Run& run = runs_[mine];
  run.begun = true;
  std::optional<SampleLine> line = std::move(run.left.front());
  run.left.pop_front();
  return line;
}

}  // namespace dualpixel::datasets
