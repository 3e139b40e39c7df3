#include "evaluation/failures/run_atlas.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/names.h"
#include "evaluation/failures/failure_atlas.h"
#include "evaluation/failures/rendered_rows.h"

namespace dualpixel::evaluation {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kAtlasVersion = 3;
constexpr const char* kIdeal = "ideal";

std::vector<DisparityMethod> methods_of(const std::vector<std::string>& texts) {
  const bool is_chosen = std::any_of(texts.begin(), texts.end(), names_matcher);
  std::vector<DisparityMethod> methods;
  if (!is_chosen) {
    for (const pipeline::Matcher& matcher : pipeline::matchers()) methods.push_back(method_of(matcher));
  }
  return methods_named(texts, std::move(methods));
}

std::vector<FailureRow> rows_of(const AtlasOptions& options, Json& camera) {
  std::vector<FailureRow> all;
  if (options.camera == kIdeal) {
    all = ideal_failure_rows();
    camera = kIdeal;
  } else {
    const AtlasCamera of_rows = atlas_camera(options.camera);
    all = rendered_failure_rows(of_rows);
    camera = of_rows.document;
    if (fs::exists(options.camera)) camera["xxh64"] = file_hash(options.camera);
  }
  if (options.rows.empty()) return all;
  std::vector<FailureRow> chosen;
  for (const std::string& name : options.rows) {
    const FailureRow* row = find_named(all, name);
    if (!row) refuse_name("--row", name, names_of(all));
    if (!find_named(chosen, name)) chosen.push_back(*row);
  }
  return chosen;
}

/// What `path` holds of an earlier call that asked for the same.
std::optional<FailureSweep> kept_row(const std::string& path, const std::string& key) {
  if (!fs::exists(path)) return {};
  const Json kept = Json::parse(read_file(path), nullptr, false);
  if (!kept.is_object() || kept.value("key", "") != key || !kept.contains("row")) return {};
  if (kept.value("xxh64", "") != hash_of(kept["row"].dump())) return {};  // damaged
  return sweep_of_json(kept["row"]);
}

void require_own_folder(const std::string& folder) {
  std::error_code error;
  if (!fs::exists(folder, error) || holds_nothing(folder)) return;
  if (fs::exists(folder + "/rows", error) || fs::exists(folder + "/" + kAtlasFile, error)) return;
  throw InputError(printable(folder) + ": exists, and is no failure atlas: name a new folder");
}

}  // namespace

void run_failure_atlas(const AtlasOptions& options, const std::string& folder,
                       const std::function<void(double)>& progress) {
  const std::vector<DisparityMethod> methods = methods_of(options.methods);
  Json camera;
  const std::vector<FailureRow> rows = rows_of(options, camera);
  require_own_folder(folder);
  require_writable(folder + "/" + kAtlasFile);
  std::vector<FailureSweep> sweeps;
  for (const FailureRow& row : rows) {
    const Json asked = {DUALPIXEL_VERSION, kAtlasVersion, camera, options.methods, options.draws, row.name, row.values};
    const std::string key = hash_of(asked.dump()), path = folder + "/rows/" + row.name + ".json";
    std::optional<FailureSweep> sweep = kept_row(path, key);
    const auto step = [&](double fraction) {
      if (progress) progress((static_cast<double>(sweeps.size()) + fraction) / static_cast<double>(rows.size()));
    };
    if (!sweep) {
      sweep = measure_row(row, methods, options.draws, step);
      const Json json = to_json(*sweep, true);
      replace_file(path, Json{{"key", key}, {"xxh64", hash_of(json.dump())}, {"row", json}}.dump() + "\n");
    }
    sweeps.push_back(std::move(*sweep));
    step(0);
  }
  const std::string camera_name = fs::path(options.camera).filename().string();  // not where it lies on this machine
  Json document = {{"format", "dualpixel-experiment-failures"}, {"version", kAtlasVersion}, {"camera", camera_name}};
  document["draws"] = options.draws;
  for (const FailureSweep& sweep : sweeps) document["rows"].push_back(to_json(sweep, false));
  replace_file(
      folder + "/failures.html",
      to_page(sweeps, options.camera == kIdeal ? "Closed forms: no renderer, lens or sensor has a part in these views."
                                               : fmt::format("Rendered through the camera '{}'.", camera_name)));
  replace_file(folder + "/" + kAtlasFile, document.dump(2) + "\n");
}

}  // namespace dualpixel::evaluation
