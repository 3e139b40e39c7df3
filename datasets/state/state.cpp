#include "datasets/state/state.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <filesystem>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "datasets/plan/plan.h"
#include "datasets/render/render.h"
#include "datasets/render/sample_folder.h"

namespace dualpixel::datasets {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The last reason for each name. A line that a full disk cut short is left out.
std::map<std::string, std::string> failures_in(const std::string& folder) {
  std::map<std::string, std::string> reasons;
  const std::string path = folder + "/" + kFailuresFile;
  std::error_code error;
  if (!fs::exists(path, error)) return reasons;
  const std::string text = read_file(path);
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const json entry = json::parse(text.substr(begin, end - begin), nullptr, false);
    if (entry.is_object() && entry.contains("name") && entry["name"].is_string()) {
      reasons[entry["name"]] = entry.value("reason", json()).is_string() ? entry["reason"].get<std::string>() : "";
    }
    begin = end + 1;
  }
  return reasons;
}

/// The fault of each line's sample; empty where it is whole, or not there.
std::vector<std::string> faults_by_line(const std::string& folder, const std::vector<SampleLine>& lines) {
  std::vector<std::string> faults(lines.size());
  tbb::parallel_for(std::size_t{0}, lines.size(), [&](std::size_t i) {
    if (is_there(folder, lines[i])) faults[i] = fault_of_sample(folder, lines[i]);
  });
  return faults;
}

int remove_leftovers(const std::string& folder) {
  std::error_code error;
  std::vector<fs::path> leftovers;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().filename().string().starts_with(kTemporaryPrefix)) leftovers.push_back(entry.path());
  }
  for (const fs::path& path : leftovers) fs::remove_all(path, error);
  return static_cast<int>(leftovers.size());
}

int remove_scenes(const std::string& folder) {
  std::error_code error;
  int count = 0;
  for (const auto& entry : fs::directory_iterator(folder, error)) count += entry.is_directory(error) ? 1 : 0;
  fs::remove_all(folder, error);
  return count;
}

}  // namespace

DatasetState::Counts DatasetState::total() const {
  Counts sum;
  for (const Counts& split : splits) {
    sum.planned += split.planned;
    sum.there += split.there;
    sum.failed += split.failed;
  }
  return sum;
}

DatasetState state_of(const std::string& folder) {
  DatasetState state;
  const std::map<std::string, std::string> reasons = failures_in(folder);
  for (const SampleLine& line : read_plan(folder)) {
    DatasetState::Counts& split = state.splits[static_cast<std::size_t>(line.split)];
    ++split.planned;
    if (is_there(folder, line)) {
      ++split.there;
    } else if (const auto reason = reasons.find(line.name); reason != reasons.end()) {
      ++split.failed;
      state.reasons.insert(*reason);
    }
  }
  return state;
}

std::vector<std::string> faults_of(const std::string& folder) {
  std::vector<std::string> faults = faults_by_line(folder, read_plan(folder));
  std::erase(faults, "");
  return faults;
}

Cleared clear(const std::string& folder) {
  const std::vector<SampleLine> lines = read_plan(folder);
  for (const char* part : {"scenes", kSamplesFolder}) require_no_link(folder + "/" + part);
  Cleared cleared;
  for (const char* part : {"", "/scenes", "/samples"}) cleared.leftovers += remove_leftovers(folder + part);
  const std::vector<std::string> faults = faults_by_line(folder, lines);
  std::error_code error;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (faults[i].empty()) continue;
    fs::remove_all(sample_folder(folder, lines[i]), error);
    ++cleared.damaged;
  }
  const bool whole = std::all_of(lines.begin(), lines.end(), [&](const auto& line) { return is_there(folder, line); });
  if (whole) cleared.scenes = remove_scenes(folder + "/scenes");
  return cleared;
}

}  // namespace dualpixel::datasets
