#include "datasets/recipe/recipe.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <numeric>

#include "capture/error.h"
#include "capture/path_beside.h"
#include "scenes/kinds/kinds.h"
#include "simulator/scene_file_names.h"

namespace dualpixel::datasets {
namespace {

using nlohmann::json;

constexpr std::uint64_t kAnySeed = std::numeric_limits<std::uint64_t>::max();
constexpr double kMostWeight = 1e9;

/// Absolute, so that a plan means the same wherever the data set lies.
std::string absolute_beside(const std::string& recipe, const std::string& name) {
  std::string path = std::filesystem::absolute(path_beside(recipe, name)).lexically_normal().string();
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

/// So many as apply_override() takes: each becomes an object in the one before.
void require_few_names(const Fields& set, const std::string& field) {
  constexpr std::ptrdiff_t kMostNames = 32;
  if (std::count(field.begin(), field.end(), '.') < kMostNames) return;
  set.fail(field, fmt::format("more than {} names", kMostNames));
}

/// An object with `value` in the place of a scene file that `field` names: "lens.file".
json in_scene(const std::string& field, json value) {
  std::size_t end = field.size();
  for (;;) {
    const std::size_t dot = end == 0 ? std::string::npos : field.rfind('.', end - 1);
    const std::size_t begin = dot == std::string::npos ? 0 : dot + 1;
    value = json::object({{field.substr(begin, end - begin), std::move(value)}});
    if (begin == 0) return value;
    end = dot;
  }
}

/// What in_scene() was given.
json out_of_scene(const std::string& field, json scene) {
  for (std::size_t dots = std::count(field.begin(), field.end(), '.') + 1; dots > 0; --dots) {
    json inner = std::move(scene.begin().value());
    scene = std::move(inner);
  }
  return scene;
}

/// The value of a field with all files that it names beside the recipe, not beside each scene.
json with_files_beside(const std::string& recipe, const std::string& field, json value) {
  json scene = in_scene(field, std::move(value));
  simulator::each_file_name(scene, [&](std::string& name) { name = absolute_beside(recipe, name); });
  return out_of_scene(field, std::move(scene));
}

bool names_a_folder(const std::string& kind, const std::string& parameter) {
  const std::vector<scenes::Parameter> all = scenes::parameters_of(scenes::scene_kind(kind));
  return std::any_of(all.begin(), all.end(), [&](const scenes::Parameter& p) {
    return p.name == parameter && p.type == scenes::Parameter::Type::folder;
  });
}

void make_absolute(json& folder, const std::string& recipe) {
  if (folder.is_string() && !folder.get_ref<const std::string&>().empty()) {
    folder = absolute_beside(recipe, folder.get<std::string>());
  }
}

void read_kind(Fields& fields, SceneSource& source, const std::string& recipe) {
  fields.text("kind", source.kind);
  std::vector<std::string> kinds;
  for (const scenes::SceneKind& kind : scenes::scene_kinds()) kinds.emplace_back(kind.name);
  fields.choice("kind", source.kind, kinds);
  double seeds[2] = {1, 1};
  fields.required("seeds").numbers("seeds", seeds, 2);
  constexpr double kMostSeed = 1e15;
  if (!(seeds[0] >= 0 && seeds[0] <= seeds[1] && seeds[1] <= kMostSeed) ||
      seeds[0] != static_cast<double>(static_cast<std::uint64_t>(seeds[0])) ||
      seeds[1] != static_cast<double>(static_cast<std::uint64_t>(seeds[1]))) {
    fields.fail("seeds", fields.raw("seeds").dump() + ": must be [first, last], whole numbers in [0, 1e15]");
  }
  source.seeds = {static_cast<std::uint64_t>(seeds[0]), static_cast<std::uint64_t>(seeds[1])};
  if (!fields.has("set")) return;
  source.set = fields.raw("set");
  if (!source.set.is_object()) fields.fail("set", "must be an object such as {\"objects\": 12}");
  const Fields set = fields.object("set");
  for (auto& [name, value] : source.set.items()) {
    if (name.find('.') == std::string::npos) {  // a parameter; with a dot, a field of the scene file
      if (names_a_folder(source.kind, name)) make_absolute(value, recipe);
      continue;
    }
    require_few_names(set, name);
    value = with_files_beside(recipe, name, std::move(value));
  }
}

SceneSource read_source(Fields fields, const std::string& recipe) {
  SceneSource source;
  const bool file = fields.has("file"), folder = fields.has("folder"), kind = fields.has("kind");
  if (file + folder + kind != 1) fields.fail("file", "give exactly one of file, folder and kind");
  std::string name;
  if (file) source.file = absolute_beside(recipe, (fields.text("file", name), name));
  if (folder) source.folder = absolute_beside(recipe, (fields.text("folder", name), name));
  if (kind) read_kind(fields, source, recipe);
  fields.number("weight", source.weight, 0, kMostWeight);
  fields.done();
  return source;
}

CameraShell read_shell(Fields fields) {
  CameraShell shell;
  shell.distance = read_numbers(fields, "distance", 0.05, 1000);
  shell.elevation_deg = read_numbers(fields, "elevation_deg", -89, 89);
  shell.azimuth_deg = {.kind = Distribution::Kind::uniform, .low = -180, .high = 180};
  if (fields.has("azimuth_deg")) shell.azimuth_deg = read_numbers(fields, "azimuth_deg", -360, 360);
  fields.done();
  return shell;
}

Relations read_relations(Fields fields, const std::string& recipe) {
  Relations relations;
  std::string focus;
  fields.choice("focus", focus, {"surface"});
  relations.focus_on_surface = !focus.empty();
  if (fields.has("exposure_mean")) relations.exposure_mean = read_numbers(fields, "exposure_mean", 1e-3, 0.95);
  if (fields.has("camera_shell")) relations.camera_shell = read_shell(fields.object("camera_shell"));
  if (fields.has("model_size_m")) relations.model_size_m = read_numbers(fields, "model_size_m", 1e-3, 1e6);
  if (fields.has("environments")) {
    std::string folder;
    fields.text("environments", folder);
    relations.environments = absolute_beside(recipe, folder);
  }
  fields.done();
  return relations;
}

/// A field may be set or follow from a relation, not both.
void refuse_conflicts(const Fields& set, const Recipe& recipe) {
  const Relations& r = recipe.relations;
  const auto refuse = [&](bool relation, const char* name, const char* field) {
    const std::string own = field, whole = own.substr(0, own.find('.'));  // the object that it is in
    for (const std::string& given : {own, whole}) {
      if (!relation || !recipe.set.contains(given)) continue;
      set.fail(given, fmt::format("follows from /relations/{}: give one of them", name));
    }
  };
  refuse(r.focus_on_surface, "focus", "camera.focus_distance_m");
  for (const char* field : {"camera.node", "camera.position_m", "camera.look_at_m", "camera.up"}) {
    refuse(r.camera_shell.has_value(), "camera_shell", field);
  }
  refuse(r.model_size_m.has_value(), "model_size_m", "model_size_m");
  refuse(!r.environments.empty(), "environments", "environment.model");
  refuse(!r.environments.empty(), "environments", "environment.path");
  if (recipe.set.contains("gltf")) set.fail("gltf", "belongs to /scenes: samples of one scene share a split");
  if (recipe.set.contains("render.seed")) set.fail("render.seed", "each sample has a seed of its own: leave it out");
  const bool both = recipe.set.contains("exposure.time_s") && recipe.set.contains("exposure.iso");
  if (r.exposure_mean && both) set.fail("exposure.iso", "exposure_mean needs time_s or iso free: set one at most");
  refuse(r.exposure_mean.has_value(), "exposure_mean", "exposure");
}

void read_set(Fields fields, const json& names, Recipe& recipe) {
  for (const auto& [field, value] : names.items()) {
    if (field.empty() || field.find('=') != std::string::npos) fields.fail(field, "is not the name of a field");
    require_few_names(fields, field);
    Distribution d = read_distribution(fields, field);
    for (json& v : d.values) v = with_files_beside(recipe.path, field, std::move(v));
    recipe.set.emplace(field, std::move(d));
  }
  fields.done();
  refuse_conflicts(fields, recipe);
}

void read_split(Fields fields, bool there, Recipe& recipe) {
  if (!there) return;
  for (std::size_t i = 0; i < kSplitCount; ++i) {
    recipe.shares[i] = 0;
    fields.number(kSplits[i].name, recipe.shares[i], 0, 1);
  }
  fields.done();
  const double sum = std::accumulate(recipe.shares.begin(), recipe.shares.end(), 0.0);
  if (!(sum > 0.999 && sum < 1.001)) {
    fields.fail("train", fmt::format("the shares of train, validation and test add up to {:g}: must be 1", sum));
  }
}

/// Every value of a field is drawn in every split: no picture that lights the scene may be among them where there are
/// several.
void refuse_shared_light(const Fields& set, const Recipe& recipe) {
  if (splits_with_a_share(recipe) < 2) return;
  for (const auto& [field, distribution] : recipe.set) {
    for (const json& value : distribution.values) {
      const json scene = in_scene(field, value);
      const json light = scene.value("environment", json());
      if (!light.is_object() || !light.value("path", json()).is_string()) continue;
      set.fail(field, printable(light["path"].get<std::string>()) +
                          ": would be in more than one split: name a folder by relations.environments, whose files are "
                          "shared out");
    }
  }
}

/// So many that a plan takes less than half a gigabyte for them.
void require_few_seeds(const std::vector<Fields>& entries, const Recipe& recipe) {
  constexpr std::uint64_t kMostSeeds = 1'000'000;
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (recipe.scenes[i].kind.empty()) continue;
    const auto [first, last] = recipe.scenes[i].seeds;
    sum += last - first + 1;
    if (sum <= kMostSeeds) continue;
    entries[i].fail("seeds", fmt::format("[{},{}]: {} seeds in all: must be {} at most", first, last, sum, kMostSeeds));
  }
}

void read_keep(Fields& root, Recipe& recipe) {
  read_named(root, "layout", recipe.layout, kLayouts);
  const json& keep = root.raw("keep");
  if (has_own_pictures(recipe.layout)) {
    if (!keep.is_null()) {
      root.fail("keep",
                fmt::format("the {} layout has its own pictures: leave it out", name_of(kLayouts, recipe.layout)));
    }
    return;
  }
  const std::vector<std::string> names = names_of(pictures());
  if (!keep.is_array() || keep.empty()) {
    root.fail("keep", fmt::format("{}must be a list of pictures: '{}'",
                                  keep.is_null() ? "" : printable(keep.dump()) + ": ", fmt::join(names, "', '")));
  }
  for (const json& entry : keep) {
    const std::string name = entry.is_string() ? entry.get<std::string>() : entry.dump();
    if (!find_named(pictures(), name)) root.fail("keep", printable(name) + ": " + must_be_one_of(names, name));
    if (std::find(recipe.keep.begin(), recipe.keep.end(), name) != recipe.keep.end()) {
      root.fail("keep", name + ": is there twice");
    }
    recipe.keep.push_back(name);
  }
}

}  // namespace

Recipe read_recipe(const json& document, const std::string& path) {
  Recipe recipe;
  recipe.path = path;
  recipe.json = document;
  Fields root(recipe.json, path);
  int version = 1;
  std::string title;
  root.required("version").integer("version", version, 1, 1);
  root.text("title", title);
  root.required("count").integer("count", recipe.count, 1, kMostSamples);
  root.integer("seed", recipe.seed, 0, kAnySeed);
  for (const Fields& fields : root.required("scenes").objects("scenes")) {
    recipe.scenes.push_back(read_source(fields, path));
  }
  if (recipe.scenes.empty()) root.fail("scenes", "must be one entry or more");
  require_few_seeds(root.objects("scenes"), recipe);
  recipe.relations = read_relations(root.object("relations"), path);
  read_set(root.object("set"), root.raw("set").is_null() ? json::object() : root.raw("set"), recipe);
  read_split(root.object("split"), root.has("split"), recipe);
  refuse_shared_light(root.object("set"), recipe);
  read_keep(root, recipe);
  root.done();
  return recipe;
}

std::size_t splits_with_a_share(const Recipe& recipe) {
  return static_cast<std::size_t>(
      std::count_if(recipe.shares.begin(), recipe.shares.end(), [](double share) { return share > 0; }));
}

Recipe read_recipe(const std::string& path) { return read_recipe(read_json_file(path), path); }

}  // namespace dualpixel::datasets
