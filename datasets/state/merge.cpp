#include "datasets/state/merge.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "datasets/pictures/google.h"
#include "datasets/plan/plan.h"
#include "datasets/render/sample_folder.h"

namespace dualpixel::datasets {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json index_entry(const SampleLine& line, const std::string& dataset) {
  const std::string path = sample_folder(dataset, line) + "/" + kSampleFile;
  const json sample = read_json_file(path);
  try {
    const json& camera = sample.at("camera");
    json entry = {{"name", line.name},
                  {"split", name_of(kSplits, line.split)},
                  {"folder", std::string(kSamplesFolder) + "/" + line.name},
                  {"scene", line.scene},
                  {"statistics", sample.at("statistics")},
                  {"noise_fraction", sample.at("provenance").value("noise_fraction_reached", json())}};
    for (const char* field : {"f_number", "focal_length_mm", "focus_distance_m", "alpha"}) {
      entry[field] = camera.at(field);
    }
    for (const char* field : {"time_s", "iso"}) entry[field] = sample.at("exposure").at(field);
    if (sample.contains("missed_exposure")) entry["missed_exposure"] = sample["missed_exposure"];
    for (const json& file : sample.at("files")) entry["files"].push_back(file.at("path"));
    return entry;
  } catch (const json::exception& error) {
    throw InputError(printable(path) + ": is no sample: " + printable(error.what()));
  }
}

/// A second name for a file; what had that name is replaced.
void link_file(const std::string& from, const std::string& to) {
  make_parents(to);
  std::error_code error;
  fs::remove(to, error);
  fs::create_hard_link(from, to, error);
  if (error) fs::copy_file(from, to, error);  // some file systems have no links
  if (error) throw InputError(printable(to) + ": cannot be written: " + error.message());
}

void link_dpdd(const SampleLine& line, const std::string& dataset) {
  const std::string from = sample_folder(dataset, line);
  const std::string split = line.split == Split::validation ? "val" : name_of(kSplits, line.split);
  for (const char* view : {"c", "l", "r"}) {
    link_file(fmt::format("{}/source_{}.png", from, view),
              fmt::format("{}/dpdd/{}_{}/source/{}.png", dataset, split, view, line.name));
  }
  link_file(from + "/target.png", fmt::format("{}/dpdd/{}_c/target/{}.png", dataset, split, line.name));
}

void link_google(const SampleLine& line, const std::string& dataset) {
  for (const GoogleFile& file : kGoogleFiles) {
    link_file(
        sample_folder(dataset, line) + "/" + file.file,
        fmt::format("{}/google/{}/{}/{}/{}", dataset, name_of(kSplits, line.split), file.folder, line.name, file.file));
  }
}

}  // namespace

std::vector<json> merge_samples(const std::string& folder) {
  std::vector<json> index;
  std::string text;
  for (const SampleLine& line : read_plan(folder)) {
    if (!is_there(folder, line)) continue;
    index.push_back(index_entry(line, folder));
    text += index.back().dump() + "\n";
    if (line.layout == Layout::dpdd) link_dpdd(line, folder);
    if (line.layout == Layout::google) link_google(line, folder);
  }
  if (index.empty()) throw InputError(printable(folder) + ": nothing is rendered yet");
  replace_file(folder + "/" + kIndexFile, text);
  return index;
}

}  // namespace dualpixel::datasets
