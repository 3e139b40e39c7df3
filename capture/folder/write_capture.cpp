#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "capture/capture.h"
#include "capture/files.h"
#include "capture/folder/capture_check.h"
#include "capture/folder/capture_files.h"
#include "capture/folder/capture_json.h"
#include "capture/image/image_io.h"

namespace dualpixel {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr float kLargestHalf = 65504;

/// A capture's files on their way to disk.
struct Output {
  std::string folder;
  std::vector<FileTask> tasks;
  std::vector<std::string> names;  ///< within the folder, for the manifest

  std::string add(std::string name) {
    names.push_back(std::move(name));
    return folder + "/" + names.back();
  }
};

bool fits_half(const Image& image) {
  return std::all_of(image.data.begin(), image.data.end(), [](float v) { return std::abs(v) <= kLargestHalf; });
}

/// Writes the frames' images; returns "frames" of capture.json.
Json write_frames(const Capture& capture, Output& output) {
  Json frames = Json::array();
  fs::create_directory(output.folder + "/frames");
  for (std::size_t i = 0; i < capture.frames.size(); ++i) {
    const Frame& frame = capture.frames[i];
    Json entry;
    const auto write_image = [&](const char* kind, const ImageU16& pixels) {
      if (pixels.empty()) return;
      const std::string name = fmt::format("frames/{:03}_{}.png", i, kind);
      entry[kind] = name;
      output.tasks.push_back([&pixels, file = output.add(name)] { write_png16(file, pixels); });
    };
    write_image("mosaic", frame.mosaic);
    write_image("left", frame.left);
    write_image("right", frame.right);
    entry["seed"] = frame.seed;
    entry["camera_from_world"] = frame.camera_from_world;
    frames.push_back(entry);
  }
  return frames;
}

/// Adds R, G and B of `image` as channels, after `prefix`.
void add_colors(const std::string& prefix, const Image& image, std::vector<NamedPlane>& channels) {
  int c = 0;
  for (const char* color : {"R", "G", "B"}) channels.push_back({prefix + color, &image, c++});
}

/// Writes the linear RGB images of the truth, with the camera's settings as EXR attributes.
void write_truth_pictures(const Truth& truth, const Capture& capture, Output& output) {
  const auto write_picture = [&](const char* name, std::vector<NamedPlane> channels, const Image& sigma,
                                 double f_number) {
    if (!sigma.empty()) channels.push_back({"sigma", &sigma});
    const bool half = std::all_of(channels.begin(), channels.end(), [](const auto& c) { return fits_half(*c.image); });
    const std::vector<std::pair<std::string, float>> attributes = {
        {"focus", static_cast<float>(capture.camera.focus_distance_m)},
        {"aperture", static_cast<float>(f_number)},
        {"isoSpeed", static_cast<float>(capture.exposure.iso)},
        {"expTime", static_cast<float>(capture.exposure.time_s)}};
    output.tasks.push_back([=, file = output.add(name)] { write_exr(file, channels, half, nullptr, attributes); });
  };
  std::vector<NamedPlane> sharp, wide, views;
  add_colors("", truth.all_in_focus, sharp);
  add_colors("", truth.photograph, wide);
  write_picture(kAllInFocusFile, sharp, truth.all_in_focus_sigma, std::numeric_limits<double>::infinity());
  write_picture(kPhotographFile, wide, truth.photograph_sigma,
                capture.camera.f_number / truth.photograph_aperture_scale);
  if (truth.left.empty()) return;
  add_colors("left.", truth.left, views);
  add_colors("right.", truth.right, views);
  write_picture(kViewsFile, views, truth.views_sigma, capture.camera.f_number);
}

/// Writes the truth's images; returns "truth" of capture.json.
Json write_truth(const Truth& truth, const Capture& capture, Output& output) {
  fs::create_directory(output.folder + "/truth");
  Json entry = {{"geometry", kGeometryFile},
                {"all_in_focus", kAllInFocusFile},
                {"photograph", kPhotographFile},
                {"photograph_aperture_scale", truth.photograph_aperture_scale}};
  if (!truth.photograph_lens.empty()) entry["photograph_lens"] = truth.photograph_lens;
  output.tasks.push_back([&truth, &capture, file = output.add(kGeometryFile)] {
    write_exr(file,
              {{"Z", &truth.depth_m},
               {"blur_px", &truth.blur_px},
               {"disparity_dp_px", &truth.disparity_dp_px},
               {"N.X", &truth.normal, 0},
               {"N.Y", &truth.normal, 1},
               {"N.Z", &truth.normal, 2},
               {"person", &truth.person_mask},
               {"valid", &truth.valid}},
              false, &truth.object_id, {{"focus", static_cast<float>(capture.camera.focus_distance_m)}});
  });
  write_truth_pictures(truth, capture, output);
  if (!truth.left.empty()) entry["views"] = kViewsFile;
  if (truth.noise) {
    entry["noise"] = {{"views", truth.noise->views},
                      {"all_in_focus", truth.noise->all_in_focus},
                      {"photograph", truth.noise->photograph}};
  }
  for (std::size_t i = 0; i < truth.motion.size(); ++i) {
    entry["motion"].push_back(motion_file(i));
    output.tasks.push_back([&image = truth.motion[i], file = output.add(motion_file(i))] {
      write_exr(file, {{"x", &image, 0}, {"y", &image, 1}}, false);
    });
  }
  if (!truth.samples.empty()) {
    entry["sampling"] = kSamplingFile;
    output.tasks.push_back([&truth, file = output.add(kSamplingFile)] {
      write_exr(file, {{"samples", &truth.samples}, {"sigma", &truth.render_sigma}}, false, nullptr, {});
    });
  }
  return entry;
}

}  // namespace

void write_capture(const Capture& capture, const std::string& path) {
  const Json camera = to_json(capture.camera), exposure = to_json(capture.exposure);
  const nlohmann::json provenance = to_json(capture.provenance, path);
  // What read_capture would refuse is not written.
  require_readable(capture.camera, capture.exposure, path);
  check_capture(capture, CaptureCheck(path));

  NewFolder folder(path, kCaptureMarker);
  Output output{folder.path(), {}, {}};
  Json document = {{"format", kCaptureFormat},     {"version", kCaptureFormatVersion},
                   {"conventions", conventions()}, {"camera", camera},
                   {"exposure", exposure},         {"frames", write_frames(capture, output)}};
  if (capture.face_px) document["face_px"] = *capture.face_px;
  if (capture.truth) document["truth"] = write_truth(*capture.truth, capture, output);
  document["provenance"] = provenance;
  run_parallel(output.tasks);

  document["files"] = make_manifest(output.folder, output.names);
  write_file(output.folder + "/" + kCaptureMarker, document.dump(2) + "\n");
  folder.commit();
}

}  // namespace dualpixel
