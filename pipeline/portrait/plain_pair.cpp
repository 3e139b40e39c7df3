#include "pipeline/portrait/plain_pair.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "capture/error.h"
#include "capture/image/image_io.h"
#include "capture/image/picture_encoding.h"
#include "capture/json_fields.h"
#include "pipeline/disparity/noise_model.h"
#include "pipeline/portrait/photograph.h"

namespace dualpixel::pipeline {
namespace {

constexpr double kLeastRange = 1e-3;  // of the values that a file may hold, between black and white
constexpr double kAssumedFocus_m = 1;
constexpr double kFullScale = 65535;  // of the digital numbers that the views become

struct Metadata {
  std::string encoding;  ///< none: what the picture's file declares
  double black = 0, white = 1;
  std::optional<ViewNoise> noise;
  std::optional<double> focus_distance_m;
  std::optional<std::array<double, 4>> face_px;
  double alpha = 0, focal_length_mm = 0, f_number = 0;  // unknown
};

Metadata read_metadata(const std::string& path) {
  Metadata metadata;
  if (path.empty()) return metadata;
  const nlohmann::json json = read_json_file(path);
  Fields fields(json, path);
  fields.choice("encoding", metadata.encoding, {"srgb", "linear"});
  fields.number("black_level", metadata.black, 0, 1).number("white_level", metadata.white, 0, 1);
  if (metadata.white - metadata.black < kLeastRange) {
    fields.fail(fields.has("white_level") ? "white_level" : "black_level",
                fmt::format("white level {:g}, black level {:g}: white must exceed black by {:g}", metadata.white,
                            metadata.black, kLeastRange));
  }
  if (fields.has("noise")) {
    Fields noise = fields.object("noise");
    metadata.noise.emplace();
    noise.number("shot", metadata.noise->shot, 0, 1).number("read", metadata.noise->read, 0, 1).done();
  }
  if (fields.has("focus_distance_m")) {
    fields.number("focus_distance_m", metadata.focus_distance_m.emplace(), 0.01, INFINITY);
  }
  fields.number("alpha", metadata.alpha, 1e-6, 10);
  fields.number("focal_length_mm", metadata.focal_length_mm, 0.01, 1e5);
  fields.number("f_number", metadata.f_number, 0.1, 1e6);
  if (fields.has("face_px")) {
    metadata.face_px.emplace();
    fields.numbers("face_px", metadata.face_px->data(), 4);
    const std::array<double, 4>& face = *metadata.face_px;
    if (!(face[2] > 0 && face[3] > 0)) {
      fields.fail("face_px", fmt::format("{:g}, {:g}, {:g}, {:g}: must be x, y, width, height, the last two above 0",
                                         face[0], face[1], face[2], face[3]));
    }
  }
  fields.done();
  return metadata;
}

void require_format(const std::string& path) {
  const std::string format = picture_size(path).format;
  if (format == "png" || format == "tiff" || format == "jpeg") return;
  throw InputError(fmt::format("{}: {}: a view must be a PNG, TIFF or JPEG", printable(path), format));
}

/// What both views declare. Halves of one exposure that differ cannot both be right.
PictureEncoding encoding_of(const PlainPair& pair, const Metadata& metadata) {
  for (const std::string& path : {pair.left, pair.right}) require_format(path);
  const PictureEncoding left = picture_encoding(pair.left), right = picture_encoding(pair.right);
  for (const auto& [encoding, path] : {std::pair(left, pair.left), {right, pair.right}}) {
    if (encoding.dng) throw InputError(printable(path) + ": a DNG: a view must be a PNG, TIFF or JPEG");
  }
  if (metadata.encoding.empty() && left.linear != right.linear) {
    throw InputError(
        fmt::format("{}: {} linear light, unlike the left view: --metadata with \"encoding\" says what both are",
                    printable(pair.right), right.linear ? "declares" : "does not declare"));
  }
  return {.linear = left.linear, .profile = left.profile || right.profile};
}

/// What neither the metadata nor the files say.
std::vector<std::string> assumptions(const PictureEncoding& files, const Metadata& metadata) {
  std::vector<std::string> assumed;
  if (metadata.encoding.empty() && !files.linear) {
    assumed.emplace_back(files.profile ? "values are sRGB (color profiles are not applied)" : "values are sRGB");
  }
  if (!metadata.noise) assumed.emplace_back("the views' noise is what they show");
  if (!metadata.focus_distance_m) assumed.push_back(fmt::format("the focus is at {:g} m", kAssumedFocus_m));
  return assumed;
}

/// Linear RGB (or gray), 0 black and 1 clipped.
Image read_view(const std::string& path, const Metadata& metadata, bool linear, bool vertical) {
  const Image picture = read_image(path);
  Image view(picture.width, picture.height, picture.channels < 3 ? 1 : 3);
  const auto black = static_cast<float>(metadata.black);
  const auto range = static_cast<float>(metadata.white - metadata.black);
  for (std::size_t i = 0; i < view.pixel_count(); ++i) {
    for (int c = 0; c < view.channels; ++c) {
      const float stored = picture.data[i * picture.channels + c];
      if (!(stored >= 0 && stored <= 1)) {
        throw InputError(fmt::format("{}: pixel ({}, {}): {}: a view's values must lie in [0, 1]", printable(path),
                                     i % view.width, i / view.width, stored));
      }
      const float signal = ((linear ? stored : linear_from_srgb(stored)) - black) / range;
      view.data[i * view.channels + c] = std::clamp(signal, 0.0f, 1.0f);
    }
  }
  return vertical ? transposed(view) : view;
}

Image gray(const Image& view) {
  if (view.channels == 1) return view;
  Image result(view.width, view.height);
  for (std::size_t i = 0; i < result.data.size(); ++i) {
    const float* rgb = &view.data[3 * i];
    result.data[i] = 0.25f * (rgb[0] + 2 * rgb[1] + rgb[2]);
  }
  return result;
}

template <typename Pixel>
ImageOf<Pixel> columns_as_rows(const ImageOf<Pixel>& image) {
  ImageOf<Pixel> result(image.height, image.width, image.channels);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < image.channels; ++c) result.at(y, x, c) = image.at(x, y, c);
    }
  }
  return result;
}

ImageU16 digital_numbers(const Image& signal) {
  ImageU16 stored(signal.width, signal.height);
  std::transform(signal.data.begin(), signal.data.end(), stored.data.begin(),
                 [](float value) { return static_cast<std::uint16_t>(std::lround(kFullScale * value)); });
  return stored;
}

/// Refuses a pair whose metadata state another lens than the calibrated one.
void require_same_lens(const PlainPair& files, const Camera& camera, const Camera& calibrated) {
  for (const auto& [field, value] :
       {std::pair{"focal_length_mm", &Camera::focal_length_mm}, {"f_number", &Camera::f_number}}) {
    const double stated = camera.*value, expected = calibrated.*value;
    if (stated > 0 && std::abs(stated - expected) > 0.01 * expected) {
      throw InputError(fmt::format("{}: /{}: {:g}: must be the calibrated camera's, {:g}", printable(files.metadata),
                                   field, stated, expected));
    }
  }
}

}  // namespace

Image transposed(const Image& image) { return columns_as_rows(image); }

Capture upright(PlainPairCapture pair, bool vertical_split) {
  Capture capture = std::move(pair.capture);
  if (!vertical_split) return capture;
  std::swap(capture.camera.width_px, capture.camera.height_px);
  for (Frame& frame : capture.frames) {
    for (ImageU16* view : {&frame.left, &frame.right}) *view = columns_as_rows(*view);
  }
  if (capture.face_px) {
    const auto [x, y, width, height] = *capture.face_px;
    capture.face_px = {y, x, height, width};
  }
  return capture;
}

Image even_sided(const Image& image) {
  Image result(image.width + image.width % 2, image.height + image.height % 2, image.channels);
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) {
      const int u = std::min(x, image.width - 1), v = std::min(y, image.height - 1);
      for (int c = 0; c < image.channels; ++c) result.at(x, y, c) = image.at(u, v, c);
    }
  }
  return result;
}

Calibration calibration_of(const PlainPair& files, PlainPairCapture& pair, Calibration calibration) {
  const Camera& own = calibration.camera;
  if (!pair.focus_stated) {
    throw InputError((files.metadata.empty() ? "--metadata" : printable(files.metadata)) +
                     ": /focus_distance_m: is required by --calibration");
  }
  if (own.dp_downsample_x != own.dp_downsample_y) {
    throw InputError(fmt::format("--calibration: DP pixels of {} x {} photosites: must be square, as a pair's are",
                                 own.dp_downsample_x, own.dp_downsample_y));
  }
  const auto [width, height] =
      files.vertical_split ? std::pair{own.dp_height(), own.dp_width()} : std::pair{own.dp_width(), own.dp_height()};
  if (pair.width != width || pair.height != height) {
    throw InputError(fmt::format("{}: {} x {} pixels: must be {} x {}, as the views of the calibrated camera",
                                 printable(files.left), pair.width, pair.height, width, height));
  }
  Camera& camera = pair.capture.camera;
  require_same_lens(files, camera, own);
  camera.principal_point_px = {own.principal_point_px[0] / own.dp_downsample_x,
                               own.principal_point_px[1] / own.dp_downsample_y};
  calibration.camera = camera;
  return calibration;
}

PlainPairCapture read_plain_pair(const PlainPair& pair) {
  const Metadata metadata = read_metadata(pair.metadata);
  const PictureEncoding files = encoding_of(pair, metadata);
  const bool linear = metadata.encoding.empty() ? files.linear : metadata.encoding == "linear";
  const Image left = read_view(pair.left, metadata, linear, pair.vertical_split);
  const Image right = read_view(pair.right, metadata, linear, pair.vertical_split);
  if (!left.same_size(right) || left.channels != right.channels) {
    const auto described = [&](const Image& view) {
      const auto [width, height] = pair.vertical_split ? std::pair{view.height, view.width}  // as in the file
                                                       : std::pair{view.width, view.height};
      return fmt::format("{} x {} pixels in {}", width, height, view.channels == 1 ? "gray" : "RGB");
    };
    throw InputError(
        fmt::format("{}: {}; the left view has {}", printable(pair.right), described(right), described(left)));
  }

  const Image left_gray = gray(left), right_gray = gray(right);
  const ViewNoise noise = metadata.noise ? *metadata.noise : estimate_noise(left_gray, right_gray);
  Capture capture;
  capture.camera = {.name = "plain pair",
                    .width_px = left.width + left.width % 2,
                    .height_px = left.height + left.height % 2,
                    .dp_downsample_x = 1,
                    .dp_downsample_y = 1,
                    .focal_length_mm = metadata.focal_length_mm,
                    .f_number = metadata.f_number,
                    .focus_distance_m = metadata.focus_distance_m.value_or(kAssumedFocus_m),
                    .alpha = metadata.alpha};
  capture.exposure = {.bits = 16,
                      .white_level_dn = kFullScale,
                      .dp_noise = {noise.shot * kFullScale, noise.read * kFullScale * kFullScale}};
  capture.face_px = metadata.face_px;
  if (capture.face_px && pair.vertical_split) {
    auto& [x, y, width, height] = *capture.face_px;
    capture.face_px = {y, x, height, width};
  }
  Frame& frame = capture.frames.emplace_back();
  frame.left = digital_numbers(even_sided(left_gray));
  frame.right = digital_numbers(even_sided(right_gray));
  Image picture(left.width, left.height, 3);
  for (std::size_t i = 0; i < picture.data.size(); ++i) {
    const std::size_t stored = left.channels == 1 ? i / 3 : i;
    picture.data[i] = 0.5f * (left.data[stored] + right.data[stored]);
  }
  capture.exposure.mosaic_noise = noise_of(picture);
  PlainPairCapture result{.capture = std::move(capture),
                          .picture = even_sided(picture),
                          .width = left.width,
                          .height = left.height,
                          .focus_stated = metadata.focus_distance_m.has_value(),
                          .assumed = assumptions(files, metadata)};
  if (pair.vertical_split) std::swap(result.width, result.height);
  return result;
}

}  // namespace dualpixel::pipeline
