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

/// Whoever learns from a data set shall not find a NaN in it.
void require_finite(const Truth& truth) {
  const auto finite = [](const Image& image) {
    return std::all_of(image.data.begin(), image.data.end(), [](float value) { return std::isfinite(value); });
  };
  if (finite(truth.left) && finite(truth.right) && std::isfinite(truth.noise->views)) return;
  throw InputError("the views' light, or the error of its estimate, is not finite");
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
  std::vector<std::string> files = write_pictures(capture, line.layout, line.keep, folder.path());
  write_png8(folder.path() + "/" + kPreviewFile, preview_of(capture));
  files.emplace_back(kPreviewFile);
  nlohmann::ordered_json document = {{"format", "dualpixel-sample"},
                                     {"version", 1},
                                     {"line", nlohmann::ordered_json::parse(to_text(line))},
                                     {"camera", to_json(capture.camera)},
                                     {"exposure", to_json(capture.exposure)},
                                     {"camera_from_world", capture.frames.front().camera_from_world}};
  if (sample.missed_exposure) document["missed_exposure"] = scenes::to_json(*sample.missed_exposure);
  if (capture.face_px) document["face_px"] = *capture.face_px;
  document["noise"]["views"] = capture.truth->noise->views;
  if (!capture.truth->all_in_focus.empty()) document["noise"]["all_in_focus"] = capture.truth->noise->all_in_focus;
  if (!capture.truth->photograph.empty()) document["noise"]["photograph"] = capture.truth->noise->photograph;
  document["statistics"] = statistics_of(capture);
  document["provenance"] = to_json(capture.provenance, path);
  document["files"] = make_manifest(folder.path(), files);
  write_file(folder.path() + "/" + kSampleFile, document.dump(2) + "\n");
  folder.commit();
}

std::string fault_of_sample(const std::string& dataset, const SampleLine& line) {
  const std::string folder = sample_folder(dataset, line), path = folder + "/" + kSampleFile;
  try {
    const json document = read_json_file(path);
    if (!document.is_object() || document.value("line", json()) != json::parse(to_text(line))) {
      return printable(path) + ": /line: is not that of the plan";
    }
    Fields fields(document, path);
    for (Fields entry : fields.required("files").objects("files")) {
      std::string name, hash;
      entry.required("path").text("path", name);
      entry.required("xxh64").text("xxh64", hash);
      if (name.find('/') != std::string::npos) entry.fail("path", printable(name) + ": must lie in the folder");
      if (file_hash(folder + "/" + name) != hash) return printable(folder + "/" + name) + ": the file was changed";
    }
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

}  // namespace dualpixel::datasets
