#include "pipeline/portrait/result_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/image_io.h"
#include "capture/json_fields.h"
#include "capture/names.h"
#include "pipeline/portrait/options.h"

namespace dualpixel::pipeline {
namespace {

constexpr const char* kFormat = "dualpixel-result";
constexpr const char* kSigma = "sigma_dp_px";
constexpr const char* kMarker = "result.json";
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct MapName {
  const char* channel;
  Image PortraitResult::*image;
};
constexpr MapName kMaps[] = {{"disparity_dp_px", &PortraitResult::disparity_dp_px},
                             {"confidence", &PortraitResult::confidence},
                             {"mask", &PortraitResult::mask},
                             {"blur_radius_px", &PortraitResult::blur_radius_px}};

std::vector<NamedPlane> rgb_planes(const Image& image) {
  return {{"R", &image, 0}, {"G", &image, 1}, {"B", &image, 2}};
}

Image read_rgb(const std::string& path) {
  const std::vector<Image> planes = read_exr(path, {"R", "G", "B"});
  Image image(planes[0].width, planes[0].height, 3);
  for (int c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < planes[c].data.size(); ++i) image.data[i * 3 + c] = planes[c].data[i];
  }
  return image;
}

std::vector<StageTime> read_stages(const nlohmann::json& stages, const Fields& fields, const std::string& file) {
  if (!stages.is_array()) fields.fail("stages", "must be an array");
  std::vector<StageTime> times;
  for (std::size_t i = 0; i < stages.size(); ++i) {
    StageTime& time = times.emplace_back();
    Fields stage(stages[i], file, fmt::format("/stages/{}", i));
    stage.required("name").text("name", time.name);
    stage.required("ms").number("ms", time.ms, 0, kInfinity);
    stage.required("peak_rss_mb").number("peak_rss_mb", time.peak_rss_mb, 0, kInfinity);
    stage.done();
  }
  return times;
}

void require_size(const Image& image, const Image& reference, const std::string& file) {
  if (image.same_size(reference)) return;
  throw InputError(fmt::format("{}: {} x {} pixels; input.exr has {} x {}", printable(file), image.width, image.height,
                               reference.width, reference.height));
}

/// Empty where it is not said.
std::string made_in_mode(const nlohmann::json& provenance, const std::string& file) {
  const auto mode = provenance.find("mode");
  if (mode == provenance.end()) return "";
  for (const Named<Mode>& each : kModes) {
    if (each.value != Mode::automatic && *mode == each.name) return std::string(each.name);
  }
  throw InputError(fmt::format("{}: /provenance/mode: {}: must be \"dp\", \"dp+seg\" or \"seg\"", printable(file),
                               printable(mode->dump())));
}

}  // namespace

nlohmann::ordered_json to_json(const PortraitResult& result, const nlohmann::ordered_json& provenance) {
  nlohmann::ordered_json json = {{"format", kFormat},
                                 {"version", kResultFormatVersion},
                                 {"provenance", provenance},
                                 {"focus_disparity_dp_px", result.focus_disparity_dp_px},
                                 {"base_frame", result.base_frame},
                                 {"stages", nlohmann::ordered_json::array()}};
  for (const StageTime& stage : result.stages) {
    json["stages"].push_back({{"name", stage.name}, {"ms", stage.ms}, {"peak_rss_mb", stage.peak_rss_mb}});
  }
  return json;
}

void write_result(const PortraitResult& result, const nlohmann::ordered_json& provenance, const std::string& path) {
  NewFolder folder(path, kMarker);
  const auto file = [&](const char* name) { return folder.path() + "/" + name; };
  write_exr(file("input.exr"), rgb_planes(result.input), true);
  write_exr(file("portrait.exr"), rgb_planes(result.portrait), true);
  write_png8(file("portrait.png"), result.portrait_srgb);

  std::vector<NamedPlane> maps;
  for (const MapName& map : kMaps) {
    const Image& image = result.*map.image;
    if (!image.empty()) maps.push_back({map.channel, &image});
  }
  if (!maps.empty()) write_exr(file("maps.exr"), maps, false);
  if (!result.matched_disparity_dp_px.empty()) {
    std::vector<NamedPlane> matched = {{"disparity_dp_px", &result.matched_disparity_dp_px},
                                       {"confidence", &result.matched_confidence}};
    if (!result.matched_sigma_dp_px.empty()) matched.push_back({kSigma, &result.matched_sigma_dp_px});
    write_exr(file("matched.exr"), matched, false);
  }

  write_file(file(kMarker),
             to_json(result, provenance).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  folder.commit();
}

StoredResult read_result(const std::string& path) {
  const auto file = [&](const char* name) { return path + "/" + name; };
  StoredResult stored;
  PortraitResult& result = stored.result;

  stored.json = read_json_file(file(kMarker));
  Fields fields(stored.json, file(kMarker));
  std::string format;
  int version = 0;
  fields.required("format").choice("format", format, {kFormat});
  fields.required("version").integer("version", version, kResultFormatVersion, kResultFormatVersion);
  const nlohmann::json& provenance = fields.required("provenance").raw("provenance");
  if (!provenance.is_object()) fields.fail("provenance", "must be an object");
  stored.mode = made_in_mode(provenance, file(kMarker));
  fields.number("focus_disparity_dp_px", result.focus_disparity_dp_px, -1e6, 1e6);
  fields.integer("base_frame", result.base_frame, 0, 999);
  result.stages = read_stages(fields.required("stages").raw("stages"), fields, file(kMarker));
  fields.done();

  result.input = read_rgb(file("input.exr"));
  result.portrait = read_rgb(file("portrait.exr"));
  result.portrait_srgb = read_image(file("portrait.png"));
  require_size(result.portrait, result.input, file("portrait.exr"));
  require_size(result.portrait_srgb, result.input, file("portrait.png"));

  const bool has_maps = std::filesystem::exists(file("maps.exr"));
  if (has_maps) {
    const std::vector<std::string> stored_channels = picture_size(file("maps.exr")).channels;
    std::vector<std::string> channels;
    std::vector<Image PortraitResult::*> images;
    for (const MapName& map : kMaps) {
      if (std::find(stored_channels.begin(), stored_channels.end(), map.channel) == stored_channels.end()) continue;
      channels.push_back(map.channel);
      images.push_back(map.image);
    }
    if (channels.empty()) throw InputError(printable(file("maps.exr")) + ": holds none of the maps of a result");
    std::vector<Image> planes = read_exr(file("maps.exr"), channels);
    require_size(planes.front(), result.input, file("maps.exr"));
    for (std::size_t i = 0; i < planes.size(); ++i) result.*images[i] = std::move(planes[i]);
  }
  if (result.disparity_dp_px.empty() != result.confidence.empty()) {
    throw InputError(printable(file("maps.exr")) + ": disparity_dp_px and confidence must come together");
  }
  if (result.disparity_dp_px.empty() && (stored.mode == "dp" || stored.mode == "dp+seg")) {
    throw InputError(fmt::format("{}: {}, which /provenance/mode \"{}\" makes", printable(file("maps.exr")),
                                 has_maps ? "lacks disparity_dp_px" : "is missing", stored.mode));
  }
  if (std::filesystem::exists(file("matched.exr"))) {
    const std::vector<std::string> stored_channels = picture_size(file("matched.exr")).channels;
    std::vector<std::string> channels = {"disparity_dp_px", "confidence"};
    if (std::find(stored_channels.begin(), stored_channels.end(), kSigma) != stored_channels.end()) {
      channels.emplace_back(kSigma);
    }
    std::vector<Image> matched = read_exr(file("matched.exr"), channels);
    result.matched_disparity_dp_px = std::move(matched[0]);
    result.matched_confidence = std::move(matched[1]);
    if (matched.size() > 2) result.matched_sigma_dp_px = std::move(matched[2]);
  }
  return stored;
}

void require_own_capture(const StoredResult& stored, const std::string& capture_path, const std::string& result_path) {
  const nlohmann::json provenance = stored.json["provenance"];
  const nlohmann::json hash = provenance.value("capture_hash", nlohmann::json());
  if (provenance.contains("picture_hash")) {
    throw InputError(fmt::format("{}: is a result of the photograph {}, not of {}", printable(result_path),
                                 printable(provenance.value("picture", nlohmann::json("unnamed")).dump()),
                                 printable(capture_path)));
  }
  const auto of_pair = provenance.find("left_hash");
  if (hash.is_null() && of_pair != provenance.end()) {
    const std::string left = capture_path + "/frames/000_left.png", right = capture_path + "/frames/000_right.png";
    if (*of_pair == file_hash(left) && provenance.value("right_hash", nlohmann::json()) == file_hash(right)) return;
    throw InputError(
        fmt::format("{}: is a result of a plain pair, {} and {}, which are not the views of {}: score its "
                    "maps by --disparity and --portrait, or run the portrait of the capture",
                    printable(result_path), printable(provenance.value("left", nlohmann::json("unnamed")).dump()),
                    printable(provenance.value("right", nlohmann::json("unnamed")).dump()), printable(capture_path)));
  }
  if (hash.is_null() || hash == file_hash(capture_path + "/capture.json")) return;
  throw InputError(
      fmt::format("{}: is not a result of {} as it is now: its capture was {}, of the hash {}; "
                  "score it against that, or run the portrait again",
                  printable(result_path), printable(capture_path),
                  printable(provenance.value("capture", nlohmann::json("unnamed")).dump()), printable(hash.dump())));
}

}  // namespace dualpixel::pipeline
