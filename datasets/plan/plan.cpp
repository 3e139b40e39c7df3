#include "datasets/plan/plan.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "datasets/render/relations.h"
#include "scenes/kinds/kinds.h"
#include "simulator/simulate.h"

namespace dualpixel::datasets {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kFormat = "dualpixel-dataset";

/// Position k of a sequence that fills [0, 1) evenly (Weyl 1916), whatever its length: `step` is irrational.
double weyl(double start, double step, int k) {
  const double at = start + step * k;
  return at - std::floor(at);
}

constexpr double kGoldenStep = 0.6180339887498949, kRootStep = 0.41421356237309515;

std::size_t split_of(const Recipe& recipe, int k) {
  double left = weyl(Draws(recipe.seed, 0, "split").uniform(), kGoldenStep, k);
  std::size_t last = 0;
  for (std::size_t i = 0; i < kSplitCount; ++i) {
    if (recipe.shares[i] <= 0) continue;
    last = i;
    if (left < recipe.shares[i]) return i;
    left -= recipe.shares[i];
  }
  return last;
}

const Asset& scene_of(const Recipe& recipe, const SplitAssets& assets, int k) {
  return assets.scene_at(weyl(Draws(recipe.seed, 0, "scene").uniform(), kRootStep, k));
}

/// Positions in all grids of a recipe, which go through all combinations: each is a digit of k.
class GridPositions {
 public:
  explicit GridPositions(int k) : left_(static_cast<std::size_t>(k)) {}

  std::size_t next(const Distribution& distribution) {
    if (distribution.kind != Distribution::Kind::grid) return 0;
    const std::size_t position = left_ % distribution.values.size();
    left_ /= distribution.values.size();
    return position;
  }

 private:
  std::size_t left_;
};

/// Values of the recipe's "set".
void draw_set(const Recipe& recipe, int k, GridPositions& grids, SampleLine& line) {
  for (const auto& [field, distribution] : recipe.set) {
    const std::size_t position = grids.next(distribution);
    line.set[field] = draw(distribution, {recipe.seed, static_cast<std::uint64_t>(k), field}, position);
  }
}

void draw_relations(const Recipe& recipe, const SplitAssets& assets, const Asset& scene, int k, GridPositions& grids,
                    SampleLine& line) {
  const Relations& r = recipe.relations;
  const auto index = static_cast<std::uint64_t>(k);
  const auto number = [&](const Distribution& d, const char* name) {
    return draw(d, {recipe.seed, index, name}, grids.next(d));
  };
  line.relations = json::object();
  if (r.focus_on_surface) {
    Draws at(recipe.seed, index, "focus");
    const auto digits = [](double u) { return std::round(u * 1e4) / 1e4; };
    const double x = digits(at.uniform());
    line.relations["focus_at"] = {x, digits(at.uniform())};
  }
  if (r.exposure_mean) line.relations["exposure_mean"] = number(*r.exposure_mean, "exposure_mean");
  if (r.camera_shell) {
    line.relations["camera_shell"] = {{"distance", number(r.camera_shell->distance, "distance")},
                                      {"elevation_deg", number(r.camera_shell->elevation_deg, "elevation_deg")},
                                      {"azimuth_deg", number(r.camera_shell->azimuth_deg, "azimuth_deg")}};
  }
  if (r.model_size_m) {
    // one size for each model, whatever sample shows it
    const Draws of_model(recipe.seed, 0, "model_size_m " + scene.geometry());
    const std::size_t values = std::max<std::size_t>(r.model_size_m->values.size(), 1);
    line.set["model_size_m"] = draw(*r.model_size_m, of_model, Draws(of_model).bits() % values);
  }
  if (!assets.environments.empty()) {
    const std::uint64_t bits = Draws(recipe.seed, index, "environment").bits();
    const std::string& path = assets.environments[bits % assets.environments.size()];
    line.set["environment"] = {{"model", "file"}, {"path", path}};
  }
}

bool sets_light(const json& set) {
  for (const auto& [field, value] : set.items()) {
    if (field.starts_with("environment.")) return true;
  }
  return false;
}

/// Of a drawn scene what is known before it is drawn; only its environment's model hangs on its seed.
json scene_file_of(const SampleLine& line, const Asset& asset) {
  const json& scene = line.scene;
  const bool by_seed = asset.seed && (sets_light(line.set) || sets_light(scene.value("set", json::object())));
  if (!by_seed) return asset.origin->scene_file;
  return scenes::scene_file_start(scenes::scene_kind(scene.at("kind").get<std::string>()), order_of(scene));
}

/// Bytes of pictures. Throws InputError where the line is no scene. `warning`: the first thing that is seldom meant.
std::uint64_t check_line(const SampleLine& line, const Asset& asset, std::string& warning) {
  json scene = with_set(scene_file_of(line, asset), line);
  stand_in_for_relations(line, scene);
  const simulator::Simulation simulation = simulator::read_simulation(scene, asset.path());
  if (simulation.time_budget_s) {
    throw InputError(printable(asset.path()) +
                     ": /render/time_budget_s: a sample must not depend on the machine's speed: "
                     "give samples_per_pixel or noise_fraction");
  }
  if (!simulation.warnings.empty()) warning = simulation.warnings.front();
  return picture_bytes(simulator::describe_camera(simulation), line.layout, line.keep);
}

json about(const Plan& plan, const Recipe& recipe, const std::string& text) {
  json splits;
  for (std::size_t i = 0; i < kSplitCount; ++i) {
    splits[kSplits[i].name] = {{"samples", plan.samples[i]}, {"scenes", plan.scenes[i]}};
  }
  return {{"format", kFormat},          {"version", 1},     {"program", "dualpixel " DUALPIXEL_VERSION},
          {"recipe", recipe.json},      {"splits", splits}, {"bytes_per_sample", std::llround(plan.bytes_per_sample)},
          {"plan_xxh64", hash_of(text)}};
}

json read_about(const std::string& folder) {
  const std::string path = folder + "/" + kDatasetFile;
  json about = read_json_file(path);
  if (!about.is_object() || about.value("format", json()) != kFormat || about.value("version", json()) != 1) {
    throw InputError(fmt::format("{}: /format: is no data set of this version: must be \"{}\", and /version 1",
                                 printable(path), kFormat));
  }
  return about;
}

/// Whether a data set's description was written for the first lines of a plan, or for all.
bool tells_of_first_lines(const json& about, const std::string& text) {
  const json recipe = about.value("recipe", json());
  const json count = recipe.is_object() ? recipe.value("count", json()) : json();
  if (!count.is_number_unsigned()) return false;
  std::size_t end = 0;
  for (auto left = count.get<std::uint64_t>(); left > 0; --left) {
    end = text.find('\n', end) + 1;
    if (end == 0) return false;
  }
  return about.value("plan_xxh64", json()) == hash_of(std::string_view(text).substr(0, end));
}

}  // namespace

SampleLine plan_line(const Recipe& recipe, const Assets& assets, int k) {
  SampleLine line;
  line.index = k;
  line.name = sample_name(k);
  const std::size_t split = split_of(recipe, k);
  line.split = kSplits[split].value;
  const Asset& scene = scene_of(recipe, assets[split], k);
  line.scene = scene.scene();
  line.seed = simulator::hash(recipe.seed, static_cast<std::uint64_t>(k));
  line.set = json::object();
  GridPositions grids(k);
  draw_set(recipe, k, grids, line);
  draw_relations(recipe, assets[split], scene, k, grids, line);
  line.layout = recipe.layout;
  line.keep = recipe.keep;
  return line;
}

Plan make_plan(const Recipe& recipe) {
  Plan plan;
  const Assets assets = gather_assets(recipe, plan.warnings);
  plan.lines.resize(static_cast<std::size_t>(recipe.count));
  std::vector<std::uint64_t> bytes(plan.lines.size());
  std::vector<std::string> faults(plan.lines.size()), warnings(plan.lines.size());
  tbb::parallel_for(std::size_t{0}, plan.lines.size(), [&](std::size_t k) {
    plan.lines[k] = plan_line(recipe, assets, static_cast<int>(k));
    try {
      const auto split = static_cast<std::size_t>(plan.lines[k].split);
      bytes[k] = check_line(plan.lines[k], scene_of(recipe, assets[split], static_cast<int>(k)), warnings[k]);
    } catch (const InputError& error) {
      faults[k] = error.what();
    }
  });
  for (std::size_t k = 0; k < faults.size(); ++k) {
    if (faults[k].empty()) continue;
    throw InputError(fmt::format("{}: sample {}: {}", printable(recipe.path), k, faults[k]));
  }
  const auto warned = std::count_if(warnings.begin(), warnings.end(), [](const auto& line) { return !line.empty(); });
  if (warned > 0) {
    const auto first = std::find_if(warnings.begin(), warnings.end(), [](const auto& line) { return !line.empty(); });
    plan.warnings.push_back(fmt::format("{}: {} of {} samples, the first is {}: {}", printable(recipe.path), warned,
                                        warnings.size(), first - warnings.begin(), *first));
  }
  std::array<std::set<json>, kSplitCount> used;
  for (std::size_t k = 0; k < plan.lines.size(); ++k) {
    const auto split = static_cast<std::size_t>(plan.lines[k].split);
    ++plan.samples[split];
    used[split].insert(plan.lines[k].scene);
    plan.bytes_per_sample += static_cast<double>(bytes[k]) / static_cast<double>(plan.lines.size());
  }
  for (std::size_t i = 0; i < kSplitCount; ++i) plan.scenes[i] = used[i].size();
  return plan;
}

void write_plan(const Plan& plan, const Recipe& recipe, const std::string& folder) {
  std::string text;
  for (const SampleLine& line : plan.lines) text += to_text(line) + "\n";
  const std::string description = about(plan, recipe, text).dump(2) + "\n";
  std::error_code error;
  if (fs::exists(folder + "/" + kDatasetFile, error)) {
    const json there = read_about(folder);
    const std::string lines = read_file(folder + "/" + kPlanFile);
    if (!text.starts_with(lines) || !tells_of_first_lines(there, text)) {
      throw InputError(printable(folder) + ": holds another plan, whose lines may not change: choose another folder");
    }
    if (lines == text && there["plan_xxh64"] == hash_of(text)) return;
    // killed in between, the next plan goes on here
    replace_file(folder + "/" + kPlanFile, text);
    replace_file(folder + "/" + kDatasetFile, description);
    return;
  }
  NewFolder out(folder, kDatasetFile);
  write_file(out.path() + "/" + kPlanFile, text);
  write_file(out.path() + "/" + kDatasetFile, description);
  out.commit();
}

std::vector<SampleLine> read_plan(const std::string& folder) {
  const json about = read_about(folder);
  const std::string path = folder + "/" + kPlanFile, text = read_file(path);
  if (about.value("plan_xxh64", json()) != hash_of(text)) {
    throw InputError(printable(path) +
                     ": was changed since, or planning was cut short: plan the same recipe here again");
  }
  std::vector<SampleLine> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(
        read_sample_line(text.substr(begin, end - begin), fmt::format("{}: line {}", path, lines.size() + 1)));
    begin = end + 1;
  }
  return lines;
}

}  // namespace dualpixel::datasets
