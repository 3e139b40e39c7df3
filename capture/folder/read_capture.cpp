#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/files.h"
#include "capture/folder/capture_check.h"
#include "capture/folder/capture_files.h"
#include "capture/folder/capture_json.h"
#include "capture/image/image_io.h"
#include "capture/json_fields.h"

namespace dualpixel {
namespace {

namespace fs = std::filesystem;

/// A capture that is being read: the tasks read its files into `capture`.
struct Input {
  std::string file;  ///< capture.json, for messages
  CaptureCheck check;
  CaptureFiles files;
  std::vector<FileTask> tasks;
};

/// Reads an entry of "frames".
void read_frame(Fields fields, const std::string& pointer, Input& input, Frame& frame) {
  const auto read = [&](const char* kind, ImageU16& pixels) {
    std::string name;
    fields.text(kind, name);
    if (!fields.has(kind)) return;
    input.tasks.push_back([&files = input.files, &pixels, name, field = pointer + "/" + kind] {
      pixels = read_image_u16(files.verified(name, field), 1);
    });
  };
  read("mosaic", frame.mosaic);
  // views come in pairs; only beside a mosaic may they be missing
  if (fields.has("left") || fields.has("right") || !fields.has("mosaic")) fields.required("left").required("right");
  read("left", frame.left);
  read("right", frame.right);
  fields.integer("seed", frame.seed, 0, std::numeric_limits<std::uint64_t>::max());
  fields.numbers("camera_from_world", frame.camera_from_world.data(), frame.camera_from_world.size());
  fields.done();
}

void read_frames(const nlohmann::json& frames, Input& input, Capture& capture) {
  input.check.require(frames.is_array() && !frames.empty() && frames.size() <= kMostFrames, "/frames",
                      fmt::format("{} of {} entries; must be an array of 1 to {} frames", frames.type_name(),
                                  frames.size(), kMostFrames));
  capture.frames.resize(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string pointer = fmt::format("/frames/{}", i);
    read_frame(Fields(frames[i], input.file, pointer), pointer, input, capture.frames[i]);
  }
}

void read_motion(const nlohmann::json& motion, Input& input, Truth& truth) {
  truth.motion.resize(motion.size());
  for (std::size_t i = 0; i < motion.size(); ++i) {
    const std::string pointer = fmt::format("/truth/motion/{}", i);
    input.check.require(motion[i].is_string(), pointer, "must be a path");
    input.tasks.push_back(
        [&files = input.files, &image = truth.motion[i], name = motion[i].get<std::string>(), pointer] {
          const std::vector<Image> planes = read_exr(files.verified(name, pointer), {"x", "y"});
          image = Image(planes[0].width, planes[0].height, 2);
          for (std::size_t j = 0; j < image.data.size(); ++j) image.data[j] = planes[j % 2].data[j / 2];
        });
  }
}

/// Joins three planes from `first` on.
Image join(const std::vector<Image>& planes, std::size_t first) {
  Image image(planes[first].width, planes[first].height, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = planes[first + i % 3].data[i / 3];
  return image;
}

void read_geometry(const std::string& file, Truth& truth) {
  std::vector<Image> planes =
      read_exr(file, {"Z", "blur_px", "disparity_dp_px", "person", "valid", "N.X", "N.Y", "N.Z"});
  truth.depth_m = std::move(planes[0]);
  truth.blur_px = std::move(planes[1]);
  truth.disparity_dp_px = std::move(planes[2]);
  truth.person_mask = std::move(planes[3]);
  truth.valid = std::move(planes[4]);
  truth.normal = join(planes, 5);
  truth.object_id = read_exr_ids(file);
}

bool has_sigma(const std::string& file) {
  const std::vector<std::string> channels = picture_size(file).channels;
  return std::find(channels.begin(), channels.end(), "sigma") != channels.end();
}

void read_pictures(const std::string& all_in_focus, const std::string& photograph, const std::string& views,
                   Input& input, Truth& truth) {
  const auto read_picture = [&](const std::string& name, const char* pointer, Image& image, Image& sigma) {
    input.tasks.push_back([&input, &image, &sigma, name, pointer] {
      const std::string file = input.files.verified(name, pointer);
      if (has_sigma(file)) {
        std::vector<Image> planes = read_exr(file, {"R", "G", "B", "sigma"});
        image = join(planes, 0);
        sigma = std::move(planes[3]);
        return;
      }
      image = read_image(file);
      input.check.require(image.channels == 3, pointer, "must have the channels R, G, B");
    });
  };
  read_picture(all_in_focus, "/truth/all_in_focus", truth.all_in_focus, truth.all_in_focus_sigma);
  read_picture(photograph, "/truth/photograph", truth.photograph, truth.photograph_sigma);
  if (views.empty()) return;
  input.tasks.push_back([&files = input.files, &truth, views] {
    const std::string file = files.verified(views, "/truth/views");
    const std::vector<Image> planes = read_exr(file, {"left.R", "left.G", "left.B", "right.R", "right.G", "right.B"});
    truth.left = join(planes, 0);
    truth.right = join(planes, 3);
    if (has_sigma(file)) truth.views_sigma = std::move(read_exr(file, {"sigma"})[0]);
  });
}

void read_noise(Fields fields, Truth& truth) {
  TruthNoise& noise = truth.noise.emplace();
  constexpr double kMost = std::numeric_limits<double>::max();
  for (const auto& [name, value] :
       {std::pair{"views", &noise.views}, {"all_in_focus", &noise.all_in_focus}, {"photograph", &noise.photograph}}) {
    fields.required(name).number(name, *value, 0, kMost);
  }
  fields.done();
}

/// Reads "truth".
void read_truth(Fields fields, Input& input, Truth& truth) {
  std::string geometry, all_in_focus, photograph, views, sampling;
  fields.required("geometry").text("geometry", geometry);
  fields.required("all_in_focus").text("all_in_focus", all_in_focus);
  fields.required("photograph").text("photograph", photograph);
  fields.required("photograph_aperture_scale");
  fields.number("photograph_aperture_scale", truth.photograph_aperture_scale, 1e-3, 1e3);
  fields.text("photograph_lens", truth.photograph_lens);
  fields.text("views", views);
  if (fields.has("noise")) read_noise(fields.object("noise"), truth);
  fields.text("sampling", sampling);
  const nlohmann::json& motion = fields.raw("motion");
  input.check.require(motion.is_null() || (motion.is_array() && motion.size() < kMostFrames), "/truth/motion",
                      "must be an array of paths, one for each frame but the first");
  fields.done();
  read_motion(motion, input, truth);
  if (!sampling.empty()) {
    input.tasks.push_back([&files = input.files, &truth, sampling] {
      std::vector<Image> planes = read_exr(files.verified(sampling, "/truth/sampling"), {"samples", "sigma"});
      truth.samples = std::move(planes[0]);
      truth.render_sigma = std::move(planes[1]);
    });
  }
  input.tasks.push_back(
      [&files = input.files, &truth, geometry] { read_geometry(files.verified(geometry, "/truth/geometry"), truth); });
  read_pictures(all_in_focus, photograph, views, input, truth);
}

}  // namespace

Capture read_capture(const std::string& path, bool with_truth) {
  std::error_code error;
  if (!fs::is_directory(path, error)) throw InputError(printable(path) + ": is not a capture: no such folder");
  const std::string file = path + "/" + kCaptureMarker;
  if (!fs::exists(file, error)) throw InputError(printable(path) + ": is not a capture: it has no capture.json");
  const nlohmann::json document = read_json_file(file);
  const CaptureCheck check(file);

  Fields fields(document, file);
  std::string format;
  int version = 0;
  fields.required("format").choice("format", format, {kCaptureFormat});
  fields.required("version").integer("version", version, kCaptureFormatVersion, kCaptureFormatVersion);
  check_conventions(fields.required("conventions").object("conventions"));

  Capture capture;
  capture.camera = read_camera(fields.required("camera").object("camera"));
  capture.exposure = read_exposure(fields.required("exposure").object("exposure"));
  if (fields.has("face_px")) {
    fields.numbers("face_px", capture.face_px.emplace().data(), 4);
    const auto& [x, y, width, height] = *capture.face_px;
    check.require(width > 0 && height > 0, "/face_px",
                  "must be x, y, width, height in photosites, the last two above 0");
  }
  if (fields.has("provenance")) {
    const nlohmann::json& provenance = fields.raw("provenance");
    check.require(provenance.is_object(), "/provenance", "must be an object");
    capture.provenance = read_provenance(provenance);
  }

  Input input{file, check, CaptureFiles(path, fields.raw("files"), check), {}};
  read_frames(fields.required("frames").raw("frames"), input, capture);
  if (fields.has("truth") && with_truth) read_truth(fields.object("truth"), input, capture.truth.emplace());
  fields.done();

  run_parallel(input.tasks);
  check_capture(capture, check);
  return capture;
}

}  // namespace dualpixel
