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
#include "datasets/state/state.h"

namespace dualpixel::datasets {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

json index_entry(const SampleLine& line, const std::string& dataset) {
  const std::string path = sample_folder(dataset, line) + "/" + kSampleFile;
  const json sample = read_json_file(path);
  const std::vector<SampleFile> files = files_of_sample(dataset, line, sample);
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
    for (const char* field : {"missed_exposure", "scene_warnings"}) {
      if (sample.contains(field)) entry[field] = sample[field];
    }
    for (const SampleFile& file : files) entry["files"].push_back(file.name);
    return entry;
  } catch (const json::exception& error) {
    throw InputError(printable(path) + ": is no sample: " + printable(error.what()));
  }
}

/// Throws where a folder of the data set on the way to `name` is a link.
void require_own_folders(const std::string& dataset, const std::string& name) {
  fs::path path = dataset;
  for (const fs::path& part : fs::path(name).parent_path()) require_no_link((path /= part).string());
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

/// The names that a layout's tree has for files of a sample.
struct Link {
  std::string file;  ///< of the sample
  std::string name;  ///< in the data set
};

std::vector<Link> dpdd_links(const SampleLine& line) {
  const std::string split = line.split == Split::validation ? "val" : name_of(kSplits, line.split);
  std::vector<Link> links;
  for (const char* view : {"c", "l", "r"}) {
    links.push_back(
        {fmt::format("source_{}.png", view), fmt::format("dpdd/{}_{}/source/{}.png", split, view, line.name)});
  }
  links.push_back({"target.png", fmt::format("dpdd/{}_c/target/{}.png", split, line.name)});
  return links;
}

std::vector<Link> google_links(const SampleLine& line) {
  std::vector<Link> links;
  for (const GoogleFile& file : kGoogleFiles) {
    links.push_back({file.file, fmt::format("google/{}/{}/{}/{}", name_of(kSplits, line.split), file.folder, line.name,
                                            file.file)});
  }
  return links;
}

std::vector<Link> links_of(const SampleLine& line) {
  if (line.layout == Layout::dpdd) return dpdd_links(line);
  return line.layout == Layout::google ? google_links(line) : std::vector<Link>{};
}

void link_sample(const std::string& dataset, const SampleLine& line) {
  for (const Link& link : links_of(line)) {
    link_file(sample_folder(dataset, line) + "/" + link.file, dataset + "/" + link.name);
  }
}

/// Of a sample that is not there any more.
void unlink_sample(const std::string& dataset, const SampleLine& line) {
  std::error_code error;
  for (const Link& link : links_of(line)) {
    const fs::path path = dataset + "/" + link.name;
    if (!fs::remove(path, error)) continue;
    if (line.layout == Layout::google) fs::remove(path.parent_path(), error);  // the sample's own
  }
}

}  // namespace

std::vector<json> merge_samples(const std::string& folder) {
  std::vector<SampleLine> lines = read_plan(folder);
  const auto gone =
      std::stable_partition(lines.begin(), lines.end(), [&](const SampleLine& line) { return is_there(folder, line); });
  if (gone == lines.begin()) throw InputError(printable(folder) + ": nothing is rendered yet");
  // what may be refused comes first: a refusal leaves everything as it was
  for (const SampleLine& line : lines) {
    for (const Link& link : links_of(line)) require_own_folders(folder, link.name);
  }
  std::vector<json> index;
  std::string text;
  for (auto line = lines.begin(); line != gone; ++line) {
    index.push_back(index_entry(*line, folder));
    text += index.back().dump() + "\n";
  }
  for (auto line = gone; line != lines.end(); ++line) unlink_sample(folder, *line);
  for (auto line = lines.begin(); line != gone; ++line) link_sample(folder, *line);
  replace_file(folder + "/" + kIndexFile, text);
  return index;
}

std::string noise_warning(const std::vector<json>& index) {
  constexpr double kMuch = 2;
  int noisy = 0;
  double most = 0;
  for (const json& entry : index) {
    const json& fraction = entry.at("noise_fraction");
    if (!fraction.is_number() || fraction.get<double>() <= kMuch) continue;
    ++noisy;
    most = std::max(most, fraction.get<double>());
  }
  if (noisy == 0) return "";
  return fmt::format(
      "rendering noise is more than {:g} times the sensor's in {} of {} samples, {:.1f} times at most: set "
      "render.noise_fraction or more render.samples_per_pixel, or a phone's sensor.full_well_e and "
      "electrons_per_lux_s, as the shipped "
      "recipes do",
      kMuch, noisy, index.size(), most);
}

}  // namespace dualpixel::datasets
