#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>

#include "capture/camera_json.h"
#include "capture/capture.h"
#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/image_io.h"
#include "capture/json_fields.h"

namespace dualpixel {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;
using Task = std::function<void()>;

constexpr const char* kFormat = "dualpixel-capture";
constexpr const char* kMarker = "capture.json";
constexpr const char* kGeometryFile = "truth/geometry.exr";
constexpr const char* kAllInFocusFile = "truth/all_in_focus.exr";
constexpr const char* kPhotographFile = "truth/photograph.exr";
constexpr const char* kSamplingFile = "truth/sampling.exr";
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kMostFrames = 1000;
constexpr float kLargestHalf = 65504;

/// Of the motion from the first frame to frame i + 1.
std::string motion_file(std::size_t i) { return fmt::format("truth/motion_{:03}.exr", i + 1); }

void run_parallel(const std::vector<Task>& tasks) {
  tbb::parallel_for(std::size_t{0}, tasks.size(), [&](std::size_t i) { tasks[i](); });
}

// ---- what must hold of a capture, written or read ----

/// Throws InputError "where: /field: why" for whatever docs/capture.md forbids and the ranges of single fields do not
/// catch.
class Check {
 public:
  explicit Check(const std::string& where) : where_(where) {}

  void that(bool holds, const std::string& field, const std::string& why) const {
    if (!holds) throw InputError(fmt::format("{}: {}: {}", printable(where_), field, why));
  }

  template <typename T>
  void size(const ImageOf<T>& image, int width, int height, int channels, const std::string& field) const {
    that(image.width == width && image.height == height && image.channels == channels &&
             image.data.size() == image.pixel_count() * channels,
         field,
         fmt::format("{} x {} pixels of {} channels; the camera calls for {} x {} of {}", image.width, image.height,
                     image.channels, width, height, channels));
  }

 private:
  const std::string& where_;
};

void check_frame(const Frame& frame, const Capture& capture, const std::string& field, const Check& check) {
  const Camera& camera = capture.camera;
  if (!frame.mosaic.empty()) check.size(frame.mosaic, camera.width_px, camera.height_px, 1, field + "/mosaic");
  check.that(frame.mosaic.empty() == capture.frames.front().mosaic.empty(), field + "/mosaic",
             "either every frame has a mosaic or none");
  check.size(frame.left, camera.dp_width(), camera.dp_height(), 1, field + "/left");
  check.size(frame.right, camera.dp_width(), camera.dp_height(), 1, field + "/right");
  const int largest = (1 << capture.exposure.bits) - 1;
  for (const ImageU16* image : {&frame.mosaic, &frame.left, &frame.right}) {
    const auto high = std::max_element(image->data.begin(), image->data.end());
    check.that(
        image->empty() || *high <= largest, field,
        fmt::format("holds the digital number {}, beyond {} bits", image->empty() ? 0 : *high, capture.exposure.bits));
  }
  for (const double value : frame.camera_from_world) {
    check.that(std::isfinite(value), field + "/camera_from_world", "must be finite");
  }
}

void check_truth(const Truth& truth, const Camera& camera, const Check& check) {
  const int width = camera.width_px, height = camera.height_px;
  check.that(truth.photograph_aperture_scale > 0, "/truth/photograph_aperture_scale", "must be positive");
  check.size(truth.depth_m, width, height, 1, "/truth/Z");
  check.size(truth.blur_px, width, height, 1, "/truth/blur_px");
  check.size(truth.disparity_dp_px, width, height, 1, "/truth/disparity_dp_px");
  check.size(truth.normal, width, height, 3, "/truth/N");
  check.size(truth.object_id, width, height, 1, "/truth/id");
  check.size(truth.person_mask, width, height, 1, "/truth/person");
  check.size(truth.valid, width, height, 1, "/truth/valid");
  check.size(truth.all_in_focus, width, height, 3, "/truth/all_in_focus");
  check.size(truth.photograph, width, height, 3, "/truth/photograph");

  for (std::size_t i = 0; i < truth.motion.size(); ++i) {
    const std::string field = fmt::format("/truth/motion/{}", i);
    check.size(truth.motion[i], width, height, 2, field);
    check.that(std::none_of(truth.motion[i].data.begin(), truth.motion[i].data.end(),
                            [](float v) { return std::isnan(v) || v == -kInfinity; }),
               field, "must be finite, or infinite behind the camera");
  }
  if (!truth.samples.empty() || !truth.render_sigma.empty()) {
    check.size(truth.samples, width, height, 1, "/truth/samples");
    check.size(truth.render_sigma, width, height, 1, "/truth/render_sigma");
  }

  const auto all = [](const Image& image, auto holds) {
    return std::all_of(image.data.begin(), image.data.end(), holds);
  };
  const auto finite = [](float v) { return std::isfinite(v); };
  check.that(all(truth.valid, [](float v) { return v == 0 || v == 1; }), "/truth/valid", "must be 0 or 1");
  check.that(all(truth.person_mask, [](float v) { return v >= 0 && v <= 1; }), "/truth/person", "must lie in [0, 1]");
  check.that(all(truth.blur_px, finite), "/truth/blur_px", "must be finite");
  check.that(all(truth.disparity_dp_px, finite), "/truth/disparity_dp_px", "must be finite");
  check.that(all(truth.normal, finite), "/truth/N", "must be finite");
  check.that(all(truth.all_in_focus, finite), "/truth/all_in_focus", "must be finite");
  check.that(all(truth.photograph, finite), "/truth/photograph", "must be finite");
  check.that(all(truth.samples, [](float v) { return v >= 1 && v <= 65536; }), "/truth/samples",
             "must lie in [1, 65536]");
  check.that(all(truth.render_sigma, [](float v) { return v >= 0 && std::isfinite(v); }), "/truth/render_sigma",
             "must be finite and 0 or more");
  for (std::size_t i = 0; i < truth.depth_m.data.size(); ++i) {
    const float depth_m = truth.depth_m.data[i];
    check.that(truth.valid.data[i] == 1 ? depth_m > 0 && std::isfinite(depth_m) : depth_m == kInfinity, "/truth/Z",
               "must be positive and finite where valid is 1, infinite where it is 0");
  }
}

void check_capture(const Capture& capture, const std::string& where) {
  const Check check(where);
  const Camera& camera = capture.camera;
  check.that(camera.width_px % 2 == 0, "/camera/width_px", "must be even");
  check.that(camera.height_px % 4 == 0, "/camera/height_px", "must be a multiple of 4");
  check.that(camera.width_px % camera.dp_downsample_x == 0, "/camera/dp_downsample_x", "must divide width_px");
  check.that(camera.height_px % camera.dp_downsample_y == 0, "/camera/dp_downsample_y", "must divide height_px");
  check.that(
      camera.focus_distance_m > camera.focal_length_mm * 1e-3, "/camera/focus_distance_m",
      fmt::format("{:g} m lies inside the focal length of {:g} mm", camera.focus_distance_m, camera.focal_length_mm));
  const Exposure& exposure = capture.exposure;
  check.that(exposure.white_level_dn <= (1 << exposure.bits) - 1, "/exposure/white_level_dn",
             fmt::format("{:g} is beyond {} bits", exposure.white_level_dn, exposure.bits));
  check.that(exposure.black_level_dn < exposure.white_level_dn, "/exposure/black_level_dn",
             fmt::format("{:g} must be below the white level {:g}", exposure.black_level_dn, exposure.white_level_dn));
  check.that(std::all_of(exposure.white_balance.begin(), exposure.white_balance.end(),
                         [](double gain) { return gain > 0 && std::isfinite(gain); }),
             "/exposure/white_balance", "gains must be positive");
  check.that(!capture.frames.empty() && capture.frames.size() <= kMostFrames, "/frames",
             fmt::format("{} frames; 1 to {} are allowed", capture.frames.size(), kMostFrames));
  for (std::size_t i = 0; i < capture.frames.size(); ++i) {
    check_frame(capture.frames[i], capture, fmt::format("/frames/{}", i), check);
  }
  if (!capture.truth) return;
  check_truth(*capture.truth, camera, check);
  const std::size_t moved = capture.truth->motion.size();
  check.that(moved == 0 || moved == capture.frames.size() - 1, "/truth/motion",
             fmt::format("{} of them: one for each frame but the first, or none", moved));
}

// ---- JSON ----

/// JSON has no infinity.
json number_or_inf(double value) { return std::isinf(value) ? json("inf") : json(value); }

/// Fixed by this format's version; written so that a reader needs nothing else, and checked on reading.
json conventions() {
  return {{"axes", "opencv"},
          {"pixel_center", 0.5},
          {"depth", "planar z from the entrance pupil, metres"},
          {"disparity", "right(x + d) = left(x), DP pixels; negative in front of the focus plane"},
          {"left_view", "light that crossed the pupil at x < 0"},
          {"camera_from_world", "row-major 4x4, points are columns, metres"}};
}

json to_json(const Camera& camera) {
  return {{"name", camera.name},
          {"width_px", camera.width_px},
          {"height_px", camera.height_px},
          {"pixel_pitch_um", camera.pixel_pitch_um},
          {"cfa", camera.cfa},
          {"dp_downsample_x", camera.dp_downsample_x},
          {"dp_downsample_y", camera.dp_downsample_y},
          {"focal_length_mm", camera.focal_length_mm},
          {"f_number", camera.f_number},
          {"focus_distance_m", number_or_inf(camera.focus_distance_m)},
          {"principal_point_px", camera.principal_point_px},
          {"split", camera.split},
          {"alpha", camera.alpha}};
}

json to_json(const NoiseProfile& noise) { return {{"shot_dn", noise.shot_dn}, {"read_dn2", noise.read_dn2}}; }

json to_json(const Exposure& exposure) {
  return {{"time_s", exposure.time_s},
          {"iso", exposure.iso},
          {"bits", exposure.bits},
          {"black_level_dn", exposure.black_level_dn},
          {"white_level_dn", exposure.white_level_dn},
          {"mosaic_noise", to_json(exposure.mosaic_noise)},
          {"dp_noise", to_json(exposure.dp_noise)},
          {"white_balance", exposure.white_balance},
          {"lux_s_per_unit", exposure.lux_s_per_unit}};
}

Camera read_camera(Fields fields) {
  Camera camera;
  camera.focus_distance_m = 0;
  read_intrinsics(fields, camera);
  fields.choice("cfa", camera.cfa, {"RGGB", "BGGR", "GRBG", "GBRG"});
  fields.required("focus_distance_m").number("focus_distance_m", camera.focus_distance_m, 1e-4, kInfinity);
  fields.choice("split", camera.split, {"hard", "ramp", "microlens", "table", "unknown"});
  fields.number("alpha", camera.alpha, 0, 10);
  fields.done();
  return camera;
}

NoiseProfile read_noise(Fields fields) {
  NoiseProfile noise;
  fields.number("shot_dn", noise.shot_dn, 0, 1e6);
  fields.number("read_dn2", noise.read_dn2, 0, 1e10);
  fields.done();
  return noise;
}

Exposure read_exposure(Fields fields) {
  Exposure exposure;
  fields.number("time_s", exposure.time_s, 0, 1e6);
  fields.number("iso", exposure.iso, 0, 1e8);
  fields.required("bits").integer("bits", exposure.bits, 8, 16);
  fields.required("black_level_dn").number("black_level_dn", exposure.black_level_dn, 0, 65535);
  fields.required("white_level_dn").number("white_level_dn", exposure.white_level_dn, 0, 65535);
  exposure.mosaic_noise = read_noise(fields.object("mosaic_noise"));
  exposure.dp_noise = read_noise(fields.object("dp_noise"));
  fields.numbers("white_balance", exposure.white_balance.data(), 3);
  fields.number("lux_s_per_unit", exposure.lux_s_per_unit, 0, 1e12);
  fields.done();
  return exposure;
}

void check_conventions(Fields fields) {
  const json expected = conventions();
  for (const auto& [key, value] : expected.items()) {
    if (fields.required(key).raw(key) != nlohmann::json(value)) fields.fail(key, "must be " + value.dump());
  }
  fields.done();
}

// ---- files of the folder ----

/// The files of a capture that is being read: where they are, and what its manifest says of them.
class Folder {
 public:
  Folder(const std::string& path, const nlohmann::json& manifest, const Check& check) : path_(path), check_(check) {
    if (manifest.is_null()) return;
    check_.that(manifest.is_array(), "/files", "must be an array");
    has_manifest_ = true;
    for (std::size_t i = 0; i < manifest.size(); ++i) {
      const std::string pointer = fmt::format("/files/{}", i);
      Fields fields(manifest[i], path_ + "/" + kMarker, pointer);
      std::string name;
      Entry entry;
      fields.required("path").text("path", name);
      fields.required("bytes").integer("bytes", entry.bytes, 0, std::numeric_limits<std::uint64_t>::max());
      fields.required("xxh64").text("xxh64", entry.xxh64);
      fields.done();
      check_.that(entries_.emplace(name, entry).second, pointer + "/path", printable(name) + " is listed twice");
      std::string file = locate(name, pointer + "/path");
      std::error_code error;
      const auto bytes = fs::file_size(file, error);
      if (error) throw InputError(printable(file) + ": is listed in capture.json but cannot be read");
      if (bytes != entry.bytes) {
        throw InputError(fmt::format("{}: has {} bytes; capture.json says {}", printable(file), bytes, entry.bytes));
      }
    }
  }

  /// The path of a file that capture.json names, inside the folder and equal to what the manifest says.
  std::string verified(const std::string& name, const std::string& pointer) const {
    std::string file = locate(name, pointer);
    require_regular_file(file);
    if (has_manifest_) {
      const auto entry = entries_.find(name);
      check_.that(entry != entries_.end(), pointer, printable(name) + " is not listed under /files");
      if (file_hash(file) != entry->second.xxh64) {
        throw InputError(printable(file) + ": its xxh64 is not the one in capture.json: the file was changed");
      }
    }
    return file;
  }

 private:
  struct Entry {
    std::uint64_t bytes = 0;
    std::string xxh64;
  };

  /// Refuses names that lead out of the folder, by their text or by a link.
  std::string locate(const std::string& name, const std::string& pointer) const {
    const fs::path relative(name);
    const bool inside = !name.empty() && name.find('\0') == std::string::npos && relative.is_relative() &&
                        std::find(relative.begin(), relative.end(), "..") == relative.end();
    check_.that(inside, pointer, printable(name) + ": must be a path inside the capture's folder");
    std::error_code error;
    const fs::path root = fs::canonical(path_, error);
    const fs::path file = fs::weakly_canonical(root / relative, error);
    check_.that(!error && std::mismatch(root.begin(), root.end(), file.begin(), file.end()).first == root.end(),
                pointer, printable(name) + ": leads out of the capture's folder");
    return (fs::path(path_) / relative).string();
  }

  std::string path_;
  const Check& check_;
  bool has_manifest_ = false;
  std::map<std::string, Entry> entries_;
};

bool fits_half(const Image& image) {
  return std::all_of(image.data.begin(), image.data.end(), [](float v) { return std::abs(v) <= kLargestHalf; });
}

void write_truth(const Truth& truth, const Capture& capture, const std::string& folder, std::vector<Task>& tasks) {
  const auto picture_attributes = [&capture](double f_number) {
    return std::vector<std::pair<std::string, float>>{{"focus", static_cast<float>(capture.camera.focus_distance_m)},
                                                      {"aperture", static_cast<float>(f_number)},
                                                      {"isoSpeed", static_cast<float>(capture.exposure.iso)},
                                                      {"expTime", static_cast<float>(capture.exposure.time_s)}};
  };
  tasks.push_back([&truth, &capture, file = folder + "/" + kGeometryFile] {
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
  const auto picture = [&](const char* name, const Image& image, double f_number) {
    tasks.push_back([&image, file = folder + "/" + name, attributes = picture_attributes(f_number)] {
      write_exr(file, {{"R", &image, 0}, {"G", &image, 1}, {"B", &image, 2}}, fits_half(image), nullptr, attributes);
    });
  };
  picture(kAllInFocusFile, truth.all_in_focus, kInfinity);
  picture(kPhotographFile, truth.photograph, capture.camera.f_number / truth.photograph_aperture_scale);
  for (std::size_t i = 0; i < truth.motion.size(); ++i) {
    tasks.push_back([&image = truth.motion[i], file = folder + "/" + motion_file(i)] {
      write_exr(file, {{"x", &image, 0}, {"y", &image, 1}}, false);
    });
  }
  if (truth.samples.empty()) return;
  tasks.push_back([&truth, file = folder + "/" + kSamplingFile] {
    write_exr(file, {{"samples", &truth.samples}, {"sigma", &truth.render_sigma}}, false, nullptr, {});
  });
}

/// Reads "truth" of capture.json; the files are read by `tasks`, into `truth`.
void read_truth(Fields fields, const Folder& folder, Truth& truth, std::vector<Task>& tasks, const Check& check) {
  std::string geometry, all_in_focus, photograph, sampling;
  fields.required("geometry").text("geometry", geometry);
  fields.required("all_in_focus").text("all_in_focus", all_in_focus);
  fields.required("photograph").text("photograph", photograph);
  fields.required("photograph_aperture_scale");
  fields.number("photograph_aperture_scale", truth.photograph_aperture_scale, 1e-3, 1e3);
  fields.text("sampling", sampling);
  const nlohmann::json& motion = fields.raw("motion");
  check.that(motion.is_null() || (motion.is_array() && motion.size() < kMostFrames), "/truth/motion",
             "must be an array of paths, one for each frame but the first");
  fields.done();
  truth.motion.resize(motion.size());
  for (std::size_t i = 0; i < motion.size(); ++i) {
    const std::string pointer = fmt::format("/truth/motion/{}", i);
    check.that(motion[i].is_string(), pointer, "must be a path");
    tasks.push_back([&folder, &image = truth.motion[i], name = motion[i].get<std::string>(), pointer] {
      const std::vector<Image> planes = read_exr(folder.verified(name, pointer), {"x", "y"});
      image = Image(planes[0].width, planes[0].height, 2);
      for (std::size_t j = 0; j < image.data.size(); ++j) image.data[j] = planes[j % 2].data[j / 2];
    });
  }
  if (!sampling.empty()) {
    tasks.push_back([&folder, &truth, sampling] {
      std::vector<Image> planes = read_exr(folder.verified(sampling, "/truth/sampling"), {"samples", "sigma"});
      truth.samples = std::move(planes[0]);
      truth.render_sigma = std::move(planes[1]);
    });
  }
  tasks.push_back([&folder, &truth, geometry] {
    std::string file = folder.verified(geometry, "/truth/geometry");
    std::vector<Image> planes =
        read_exr(file, {"Z", "blur_px", "disparity_dp_px", "person", "valid", "N.X", "N.Y", "N.Z"});
    truth.depth_m = std::move(planes[0]);
    truth.blur_px = std::move(planes[1]);
    truth.disparity_dp_px = std::move(planes[2]);
    truth.person_mask = std::move(planes[3]);
    truth.valid = std::move(planes[4]);
    truth.normal = Image(truth.depth_m.width, truth.depth_m.height, 3);
    for (std::size_t i = 0; i < truth.normal.data.size(); ++i) truth.normal.data[i] = planes[5 + i % 3].data[i / 3];
    truth.object_id = read_exr_ids(file);
  });
  const auto picture = [&](const std::string& name, const char* pointer, Image& image) {
    tasks.push_back([&folder, &image, &check, name, pointer] {
      image = read_image(folder.verified(name, pointer));
      check.that(image.channels == 3, pointer, "must have the channels R, G, B");
    });
  };
  picture(all_in_focus, "/truth/all_in_focus", truth.all_in_focus);
  picture(photograph, "/truth/photograph", truth.photograph);
}

}  // namespace

void write_capture(const Capture& capture, const std::string& path) {
  // What read_capture would refuse is not written.
  const nlohmann::json camera = to_json(capture.camera), exposure = to_json(capture.exposure);
  read_camera(Fields(camera, path, "/camera"));
  read_exposure(Fields(exposure, path, "/exposure"));
  check_capture(capture, path);
  NewFolder folder(path, kMarker);
  const std::string root = folder.path();
  std::vector<Task> tasks;
  std::vector<std::string> names;

  json frames = json::array();
  fs::create_directory(root + "/frames");
  for (std::size_t i = 0; i < capture.frames.size(); ++i) {
    const Frame& frame = capture.frames[i];
    json entry;
    const auto image = [&](const char* kind, const ImageU16& pixels) {
      if (pixels.empty()) return;
      const std::string name = fmt::format("frames/{:03}_{}.png", i, kind);
      entry[kind] = name;
      names.push_back(name);
      tasks.push_back([&pixels, file = root + "/" + name] { write_png16(file, pixels); });
    };
    image("mosaic", frame.mosaic);
    image("left", frame.left);
    image("right", frame.right);
    entry["seed"] = frame.seed;
    entry["camera_from_world"] = frame.camera_from_world;
    frames.push_back(entry);
  }

  json document = {{"format", kFormat},
                   {"version", kCaptureFormatVersion},
                   {"conventions", conventions()},
                   {"camera", to_json(capture.camera)},
                   {"exposure", to_json(capture.exposure)},
                   {"frames", frames}};
  if (capture.face_px) document["face_px"] = *capture.face_px;
  if (capture.truth) {
    fs::create_directory(root + "/truth");
    write_truth(*capture.truth, capture, root, tasks);
    for (const char* name : {kGeometryFile, kAllInFocusFile, kPhotographFile}) names.emplace_back(name);
    document["truth"] = {{"geometry", kGeometryFile},
                         {"all_in_focus", kAllInFocusFile},
                         {"photograph", kPhotographFile},
                         {"photograph_aperture_scale", capture.truth->photograph_aperture_scale}};
    for (std::size_t i = 0; i < capture.truth->motion.size(); ++i) {
      names.push_back(motion_file(i));
      document["truth"]["motion"].push_back(names.back());
    }
    if (!capture.truth->samples.empty()) {
      names.emplace_back(kSamplingFile);
      document["truth"]["sampling"] = kSamplingFile;
    }
  }
  document["provenance"] = capture.provenance;
  run_parallel(tasks);

  std::vector<json> manifest(names.size());
  tbb::parallel_for(std::size_t{0}, names.size(), [&](std::size_t i) {
    std::string file = root + "/" + names[i];
    const std::string bytes = read_file(file);
    manifest[i] = {{"path", names[i]}, {"bytes", bytes.size()}, {"xxh64", hash_of(bytes)}};
  });
  document["files"] = manifest;
  write_file(root + "/" + kMarker, document.dump(2) + "\n");
  folder.commit();
}

Capture read_capture(const std::string& path, bool with_truth) {
  std::error_code error;
  if (!fs::is_directory(path, error)) throw InputError(printable(path) + ": is no capture: no such folder");
  const std::string where = path + "/" + kMarker;
  if (!fs::exists(where, error)) throw InputError(printable(path) + ": is no capture: it has no capture.json");
  const nlohmann::json document = read_json_file(where);
  const Check check(where);

  Fields fields(document, where);
  std::string format;
  int version = 0;
  fields.required("format").choice("format", format, {kFormat});
  fields.required("version").integer("version", version, kCaptureFormatVersion, kCaptureFormatVersion);
  check_conventions(fields.required("conventions").object("conventions"));

  Capture capture;
  capture.camera = read_camera(fields.required("camera").object("camera"));
  capture.exposure = read_exposure(fields.required("exposure").object("exposure"));
  if (fields.has("face_px")) {
    fields.numbers("face_px", capture.face_px.emplace().data(), 4);
    const auto& [x, y, width, height] = *capture.face_px;
    check.that(width > 0 && height > 0, "/face_px", "must be x, y, width, height in photosites, the last two above 0");
  }
  if (fields.has("provenance")) {
    capture.provenance = fields.raw("provenance");
    check.that(capture.provenance.is_object(), "/provenance", "must be an object");
  }

  const Folder folder(path, fields.raw("files"), check);
  std::vector<Task> tasks;
  const nlohmann::json& frames = fields.required("frames").raw("frames");
  check.that(frames.is_array() && !frames.empty() && frames.size() <= kMostFrames, "/frames",
             fmt::format("must be an array of 1 to {} frames", kMostFrames));
  capture.frames.resize(frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string pointer = fmt::format("/frames/{}", i);
    Fields entry(frames[i], where, pointer);
    Frame& frame = capture.frames[i];
    const auto image = [&](const char* kind, ImageU16& pixels) {
      std::string name;
      entry.text(kind, name);
      if (!entry.has(kind)) return;
      tasks.push_back([&folder, &pixels, name, field = pointer + "/" + kind] {
        pixels = read_image_u16(folder.verified(name, field), 1);
      });
    };
    image("mosaic", frame.mosaic);
    entry.required("left").required("right");
    image("left", frame.left);
    image("right", frame.right);
    entry.integer("seed", frame.seed, 0, std::numeric_limits<std::uint64_t>::max());
    entry.numbers("camera_from_world", frame.camera_from_world.data(), frame.camera_from_world.size());
    entry.done();
  }
  if (fields.has("truth") && with_truth) {
    read_truth(fields.object("truth"), folder, capture.truth.emplace(), tasks, check);
  }
  fields.done();

  run_parallel(tasks);
  check_capture(capture, where);
  return capture;
}

}  // namespace dualpixel
