#include "evaluation/study/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <random>
#include <set>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "evaluation/report/page.h"
#include "evaluation/report/page_files.h"
#include "evaluation/report/report_images.h"
#include "evaluation/study/crops.h"
#include "pipeline/portrait/result_io.h"

namespace dualpixel::evaluation {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kWidest_px = 900;   // of a whole picture on the page
constexpr int kJpegQuality = 95;  // its own artifacts must not decide
constexpr std::size_t kMostMethods = 32, kMostScenes = 4096;

/// Names are kept as JSON, which holds UTF-8 alone.
void require_utf8(const std::string& where, const std::string& name) {
  try {
    (void)Json(name).dump();
  } catch (const Json::exception&) {
    throw InputError(fmt::format("{}: {}: must be UTF-8", printable(where), printable(name)));
  }
}

std::set<std::string> scenes_in(const std::string& folder) {
  std::error_code error;
  std::set<std::string> names;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (fs::is_regular_file(entry->path() / "result.json")) names.insert(entry->path().filename().string());
  }
  if (error) throw InputError(fmt::format("{}: cannot be read: {}", printable(folder), error.message()));
  if (names.empty()) {
    throw InputError(
        fmt::format("{}: holds no folder with a result.json: needs one for each scene", printable(folder)));
  }
  return names;
}

/// Those of the first method; refuses others that have not the same.
std::set<std::string> common_scenes(const std::vector<MethodFolder>& methods) {
  std::set<std::string> scenes = scenes_in(methods.front().second);
  for (const auto& [name, folder] : methods) {
    const std::set<std::string> own = scenes_in(folder);
    std::vector<std::string> differ;
    std::set_symmetric_difference(scenes.begin(), scenes.end(), own.begin(), own.end(), std::back_inserter(differ));
    if (!differ.empty()) {
      throw InputError(fmt::format("{}: {} '{}', which {} does {}: all methods need the same scenes", printable(folder),
                                   own.count(differ.front()) != 0 ? "has" : "lacks", printable(differ.front()),
                                   printable(methods.front().second), own.count(differ.front()) != 0 ? "not" : "have"));
    }
  }
  if (scenes.size() > kMostScenes) {
    throw InputError(fmt::format("{}: {} scenes; must be at most {}", printable(methods.front().second), scenes.size(),
                                 kMostScenes));
  }
  return scenes;
}

Json page_picture(const Image& portrait, const std::vector<Crop>& crops) {
  const int width = std::min(portrait.width, kWidest_px);
  const int height = std::max(1, static_cast<int>(std::lround(1.0 * portrait.height * width / portrait.width)));
  Json parts = Json::array();
  for (const Crop& crop : crops) parts.push_back(jpeg_data_uri(cropped(portrait, crop), kJpegQuality));
  return {{"whole", jpeg_data_uri(resized(portrait, width, height), kJpegQuality)}, {"crops", parts}};
}

/// The pictures of one scene, those of `order[0]`, `order[1]` ... of the methods.
Json page_scene(const std::vector<MethodFolder>& methods, const std::string& scene, const std::vector<int>& order) {
  std::vector<Image> portraits;
  Image mask;
  for (const auto& [name, folder] : methods) {
    const std::string path = (fs::path(folder) / scene).string();
    const pipeline::StoredResult stored = pipeline::read_result(path);
    portraits.push_back(stored.result.portrait_srgb);
    if (!portraits.front().same_size(portraits.back())) {
      throw InputError(fmt::format("{}: {} x {} pixels; must be {} x {}, as that of '{}'", printable(path),
                                   portraits.back().width, portraits.back().height, portraits.front().width,
                                   portraits.front().height, printable(methods.front().first)));
    }
    if (mask.data.empty()) mask = stored.result.mask;
  }
  const std::vector<Crop> crops = crops_that_differ(portraits, mask);
  Json pictures = Json::array();
  for (const int method : order) pictures.push_back(page_picture(portraits[method], crops));
  return pictures;
}

std::string page_of(const Json& pictures) {
  // Data URIs, digits and names of fields alone: nothing to escape.
  return html_page("Which do you prefer?",
                   "<h1>Which do you prefer?</h1>\n<main id=\"study\"></main>\n<script type=\"application/json\">" +
                       pictures.dump() + "</script>\n",
                   "", std::string(study_script()));
}

}  // namespace

StudyFiles make_study(const std::vector<MethodFolder>& methods, std::uint64_t seed) {
  if (methods.size() < 2 || methods.size() > kMostMethods) {
    throw InputError(fmt::format("--portraits: {} methods; must be 2 to {}", methods.size(), kMostMethods));
  }
  StudyFiles files;
  std::set<std::string> names;
  for (const auto& [name, folder] : methods) {
    require_utf8("--portraits", name);
    if (!names.insert(name).second) throw InputError(fmt::format("--portraits: {}: is given twice", printable(name)));
    files.study.methods.push_back(name);
  }
  std::mt19937_64 random(seed);
  Json scenes = Json::array();
  for (const std::string& scene : common_scenes(methods)) {
    require_utf8(methods.front().second, scene);
    std::vector<int> order(methods.size());
    std::iota(order.begin(), order.end(), 0);
    for (std::size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[random() % (i + 1)]);
    scenes.push_back(page_scene(methods, scene, order));
    files.study.scenes.push_back({scene, order});
  }
  files.study.id = hash_of(scenes.dump());
  files.page_html = page_of({{"study", files.study.id}, {"scenes", scenes}});
  return files;
}

Json to_json(const Study& study) {
  Json scenes = Json::array();
  for (const Study::Scene& scene : study.scenes) {
    scenes.push_back({{"name", scene.name}, {"method_of_picture", scene.method_of_picture}});
  }
  return {{"format", "dualpixel study"},
          {"version", 1},
          {"study", study.id},
          {"methods", study.methods},
          {"scenes", scenes}};
}

Study read_study(const std::string& path) {
  const nlohmann::json json = read_json_file(path);
  Fields fields(json, path);
  Study study;
  std::string format;
  int version = 0;
  fields.required("format").choice("format", format, {"dualpixel study"});
  fields.required("version").integer("version", version, 1, 1);
  fields.required("study").text("study", study.id);
  const nlohmann::json& methods = fields.required("methods").raw("methods");
  const auto is_name = [](const nlohmann::json& value) { return value.is_string(); };
  if (!methods.is_array() || !std::all_of(methods.begin(), methods.end(), is_name)) {
    fields.fail("methods", "must be an array of names");
  }
  study.methods = methods.get<std::vector<std::string>>();
  if (std::set<std::string>(study.methods.begin(), study.methods.end()).size() != study.methods.size()) {
    fields.fail("methods", "must be different names");
  }
  if (study.methods.size() < 2 || study.methods.size() > kMostMethods) {
    fields.fail("methods", fmt::format("{}: must be 2 to {}", study.methods.size(), kMostMethods));
  }
  for (Fields& scene : fields.required("scenes").objects("scenes")) {
    Study::Scene read;
    std::vector<double> order;
    scene.required("name").text("name", read.name);
    scene.required("method_of_picture").list("method_of_picture", order, 0, 31, kMostMethods);
    std::vector<double> sorted = order, all(study.methods.size());
    std::sort(sorted.begin(), sorted.end());
    std::iota(all.begin(), all.end(), 0);
    read.method_of_picture.assign(order.begin(), order.end());
    if (sorted != all) scene.fail("method_of_picture", fmt::format("must hold each of 0 to {} once", all.size() - 1));
    scene.done();
    study.scenes.push_back(std::move(read));
  }
  if (study.scenes.empty()) fields.fail("scenes", "must be one or more");
  fields.done();
  return study;
}

}  // namespace dualpixel::evaluation
