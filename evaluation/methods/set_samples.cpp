#include "evaluation/methods/set_samples.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/error.h"
#include "capture/folder/capture_json.h"
#include "capture/image/map_file.h"
#include "capture/json_fields.h"
#include "capture/names.h"
#include "capture/views.h"
#include "datasets/plan/plan.h"
#include "datasets/render/sample_folder.h"
#include "pipeline/disparity/match_pixels.h"

namespace dualpixel::evaluation {
namespace {

namespace fs = std::filesystem;

constexpr float kUnknownDpPx = std::numeric_limits<float>::quiet_NaN();

/// A picture of a sample, in whichever of the two layouts.
Image kept_picture(const std::string& folder, const std::string& name) {
  for (const char* ending : {".npy", ".exr"}) {
    if (fs::exists(folder + "/" + name + ending)) return read_map(folder + "/" + name + ending, "Y");
  }
  throw InputError(printable(folder) + ": has no " + name +
                   ": the recipe must keep left, right, view_disparity_dp_px " +
                   "and view_valid, in the layout exr or npy");
}

bool is_dense(const Camera& camera) { return camera.dp_downsample_x * camera.dp_downsample_y == 1; }

/// A sample of dense views as one of DP pixels of 2 x 2.
ViewSample of_green_means(const ViewSample& dense, const std::string& cfa) {
  constexpr int kSide = 2;
  ViewSample sample{dense.name,
                    pipeline::green_means(dense.left, cfa),
                    pipeline::green_means(dense.right, cfa),
                    {},
                    pipeline::sensor_of_green_means(dense.sensor)};
  sample.truth_dp_px = Image(sample.left.width, sample.left.height);
  for (int y = 0; y < sample.left.height; ++y) {
    for (int x = 0; x < sample.left.width; ++x) {
      sample.truth_dp_px.at(x, y) = dense.truth_dp_px.at(kSide * x + 1, kSide * y + 1) / kSide;
    }
  }
  return sample;
}

ViewSample sample_of_data_set(const std::string& folder) {
  const std::string file = folder + "/" + datasets::kSampleFile;
  const nlohmann::json document = read_json_file(file);
  Fields fields(document, file);
  const Exposure exposure = read_exposure(fields.required("exposure").object("exposure"));
  ViewSample sample{fs::path(folder).filename(), kept_picture(folder, "left"), kept_picture(folder, "right"),
                    kept_picture(folder, "view_disparity_dp_px"), pipeline::view_sensor(exposure)};
  const Image valid = kept_picture(folder, "view_valid");
  for (const Image* image : std::initializer_list<const Image*>{&sample.right, &sample.truth_dp_px, &valid}) {
    if (!image->same_size(sample.left)) throw InputError(printable(folder) + ": its pictures differ in size");
  }
  for (std::size_t i = 0; i < valid.data.size(); ++i) {
    if (valid.data[i] != 1) sample.truth_dp_px.data[i] = kUnknownDpPx;
  }
  const Camera camera = read_camera(fields.required("camera").object("camera"));
  sample.sensor = of_camera(sample.sensor, camera);
  return is_dense(camera) ? of_green_means(sample, camera.cfa) : sample;
}

ViewSample sample_of_capture(const std::string& folder) {
  const Capture capture = read_capture(folder, true);
  require_views(capture, folder);
  if (!capture.truth) throw InputError(printable(folder) + ": holds no truth to score against");
  ViewSample sample =
      view_sample(capture, normalized(capture.frames[0].left, capture.exposure),
                  normalized(capture.frames[0].right, capture.exposure), pipeline::view_sensor(capture.exposure));
  sample.name = fs::path(folder).filename();
  return sample;
}

}  // namespace

std::vector<std::string> sample_folders(const std::string& set, const std::string& split) {
  std::vector<std::string> folders;
  std::error_code error;
  if (fs::exists(set + "/" + datasets::kPlanFile, error)) {
    for (const datasets::SampleLine& line : datasets::read_plan(set)) {
      const bool wanted = split.empty() || split == name_of(datasets::kSplits, line.split);
      if (wanted && datasets::is_there(set, line)) folders.push_back(datasets::sample_folder(set, line));
    }
  } else if (!split.empty()) {
    throw InputError(printable(set) + ": is no data set, which alone has splits: leave out --split");
  } else if (fs::is_directory(set, error)) {
    for (const auto& entry : fs::directory_iterator(set)) {
      if (fs::exists(entry.path() / "capture.json", error)) folders.push_back(entry.path().string());
    }
    std::sort(folders.begin(), folders.end());
  }
  if (folders.empty()) {
    throw InputError(printable(set) +
                     ": holds no samples: must be a data set that is rendered, or a folder of captures");
  }
  return folders;
}

ViewSample view_sample(const Capture& capture, Image left, Image right, const pipeline::ViewSensor& sensor) {
  const Camera& camera = capture.camera;
  ViewSample sample{"", std::move(left), std::move(right),
                    Image(camera.dp_width(), camera.dp_height(), 1, kUnknownDpPx), of_camera(sensor, camera)};
  for (int y = 0; y < camera.dp_height(); ++y) {
    for (int x = 0; x < camera.dp_width(); ++x) {
      const int u = x * camera.dp_downsample_x + camera.dp_downsample_x / 2;
      const int v = y * camera.dp_downsample_y + camera.dp_downsample_y / 2;
      if (capture.truth->valid.at(u, v) == 1) sample.truth_dp_px.at(x, y) = capture.truth->disparity_dp_px.at(u, v);
    }
  }
  return pipeline::is_dense_mosaic(capture) ? of_green_means(sample, camera.cfa) : sample;
}

ViewSample read_view_sample(const std::string& folder) {
  return fs::exists(folder + "/" + datasets::kSampleFile) ? sample_of_data_set(folder) : sample_of_capture(folder);
}

}  // namespace dualpixel::evaluation
