#include "datasets/render/sample_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/folder/capture_files.h"
#include "capture/folder/capture_json.h"
#include "capture/image/image_io.h"
#include "capture/json_fields.h"
#include "datasets/pictures/statistics.h"

namespace dualpixel::datasets {

using nlohmann::json;

namespace {

/// What the statistics are of, too, whatever is kept.
void require_finite(const Truth& truth) {
  const auto finite = [](const Image& image) {
    return std::all_of(image.data.begin(), image.data.end(), [](float value) { return std::isfinite(value); });
  };
  if (finite(truth.left) && finite(truth.right) && finite(truth.disparity_dp_px) && std::isfinite(truth.noise->views)) {
    return;
  }
  throw InputError("the views' light, the error of its estimate, or disparity is not finite");
}

std::vector<std::string> names_of_files(const SampleLine& line) {
  std::vector<std::string> names = picture_files(line.layout, line.keep);
  names.emplace_back(kPreviewFile);
  return names;
}

}  // namespace

std::string sample_folder(const std::string& dataset, const SampleLine& line) {
  return dataset + "/" + kSamplesFolder + "/" + line.name;
}

bool is_there(const std::string& dataset, const SampleLine& line) {
  std::error_code error;
  return std::filesystem::exists(sample_folder(dataset, line) + "/" + kSampleFile, error);
}

void write_sample(const SampleLine& line, const RenderedSample& sample, const std::string& dataset) {
  const Capture& capture = sample.capture;
  require_finite(*capture.truth);
  const std::string path = sample_folder(dataset, line);
  NewFolder folder(path, kSampleFile);
  write_pictures(capture, line.layout, line.keep, folder.path());
  write_png8(folder.path() + "/" + kPreviewFile, preview_of(capture));
  nlohmann::ordered_json document = {{"format", "dualpixel-sample"},
                                     {"version", 1},
                                     {"line", nlohmann::ordered_json::parse(to_text(line))},
                                     {"camera", to_json(capture.camera)},
                                     {"exposure", to_json(capture.exposure)},
                                     {"camera_from_world", capture.frames.front().camera_from_world}};
  if (sample.missed_exposure) document["missed_exposure"] = scenes::to_json(*sample.missed_exposure);
  if (!sample.scene_warnings.empty()) document["scene_warnings"] = sample.scene_warnings;
  if (capture.face_px) document["face_px"] = *capture.face_px;
  document["noise"]["views"] = capture.truth->noise->views;
  if (!capture.truth->all_in_focus.empty()) document["noise"]["all_in_focus"] = capture.truth->noise->all_in_focus;
  if (!capture.truth->photograph.empty()) document["noise"]["photograph"] = capture.truth->noise->photograph;
  document["statistics"] = statistics_of(capture);
  document["provenance"] = to_json(capture.provenance, path);
  document["files"] = make_manifest(folder.path(), names_of_files(line));
  write_file(folder.path() + "/" + kSampleFile, document.dump(2) + "\n");
  folder.commit();
}

std::vector<SampleFile> files_of_sample(const std::string& dataset, const SampleLine& line, const json& document) {
  const std::string folder = sample_folder(dataset, line), path = folder + "/" + kSampleFile;
  Fields fields(document, path);
  if (fields.required("line").raw("line") != json::parse(to_text(line))) fields.fail("line", "is not that of the plan");
  std::vector<SampleFile> files;
  std::vector<std::string> names;
  for (Fields entry : fields.required("files").objects("files")) {
    SampleFile file;
    entry.required("path").text("path", file.name);
    entry.required("xxh64").text("xxh64", file.xxh64);
    names.push_back(file.name);
    files.push_back(std::move(file));
  }
  const std::vector<std::string> kept = names_of_files(line);
  if (names != kept) fields.fail("files", fmt::format("must name {}, as the plan has it", fmt::join(kept, ", ")));
  for (const std::string& name : names) {
    std::error_code error;
    const std::string file = folder + "/" + name;
    const auto type = std::filesystem::symlink_status(file, error).type();
    if (type != std::filesystem::file_type::regular) {  // a link might lead anywhere
      throw InputError(printable(file) +
                       (type == std::filesystem::file_type::not_found ? ": no such file" : ": is not a regular file"));
    }
  }
  return files;
}

std::string fault_of_sample(const std::string& dataset, const SampleLine& line) {
  const std::string folder = sample_folder(dataset, line);
  try {
    const json document = read_json_file(folder + "/" + kSampleFile);
    for (const SampleFile& file : files_of_sample(dataset, line, document)) {
      const std::string path = folder + "/" + file.name;
      if (file_hash(path) != file.xxh64) return printable(path) + ": the file was changed";
    }
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

void require_no_link(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_symlink(path, error)) throw InputError(printable(path) + ": is a link: must be a folder");
}

}  // namespace dualpixel::datasets
