#include "pipeline/portrait/photograph.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture/error.h"
#include "capture/image/dng_picture.h"
#include "capture/image/image_io.h"
#include "capture/image/picture_encoding.h"
#include "pipeline/disparity/noise_model.h"

namespace dualpixel::pipeline {
namespace {

constexpr double kNoiseScale = 65535;  // of the digital numbers that the noise is stated in

void require_size(const std::string& path, int width, int height) {
  if (static_cast<double>(width) * height <= kMostMegapixels * 1e6) return;
  throw InputError(fmt::format("{}: {} x {} pixels; a photograph of at most {} megapixels is allowed", printable(path),
                               width, height, kMostMegapixels));
}

void require_usable(const std::string& path) {
  const PictureSize size = picture_size(path);
  if (size.format != "png" && size.format != "tiff" && size.format != "jpeg") {
    throw InputError(
        fmt::format("{}: {}: a photograph must be a JPEG, PNG, TIFF or DNG", printable(path), size.format));
  }
  require_size(path, size.width, size.height);
  const std::vector<std::string>& names = size.channels;
  const bool gray = names.size() == 1 || (names.size() == 2 && names[1] == "A");
  const bool rgb = names.size() >= 3 && names.size() <= 4 && names[0] == "R" && names[1] == "G" && names[2] == "B";
  if (gray || rgb) return;
  throw InputError(fmt::format("{}: channels {}: a photograph must be gray or RGB, with or without alpha",
                               printable(path), printable(fmt::format("{}", fmt::join(names, ", ")))));
}

/// Linear RGB of what the file stores.
Image decoded(const std::string& path, bool linear) {
  const Image stored = read_image(path);
  const int colors = stored.channels < 3 ? 1 : 3;
  Image rgb(stored.width, stored.height, 3);
  for (std::size_t i = 0; i < rgb.data.size(); ++i) {
    const float value = stored.data[i / 3 * stored.channels + (colors == 1 ? 0 : i % 3)];
    if (!(value >= 0 && value <= 1)) {
      throw InputError(fmt::format("{}: pixel ({}, {}): {}: a photograph's values must lie in [0, 1]", printable(path),
                                   i / 3 % rgb.width, i / 3 / rgb.width, value));
    }
    rgb.data[i] = linear ? value : linear_from_srgb(value);
  }
  return rgb;
}

bool has_color(const Image& rgb) {
  for (std::size_t i = 0; i < rgb.data.size(); i += 3) {
    if (rgb.data[i] != rgb.data[i + 1] || rgb.data[i] != rgb.data[i + 2]) return true;
  }
  return false;
}

}  // namespace

NoiseProfile noise_of(const Image& rgb) {
  if (!has_color(rgb)) return {};
  Image green(rgb.width, rgb.height);
  for (std::size_t i = 0; i < green.data.size(); ++i) green.data[i] = rgb.data[3 * i + 1];
  const ViewNoise noise = estimate_noise(green, {});
  return {noise.shot * kNoiseScale, noise.read * kNoiseScale * kNoiseScale};
}

Image turned_upright(const Image& stored, int orientation) {
  if (orientation == 1) return stored;
  const bool on_its_side = orientation >= 5;
  const bool from_right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_below = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  Image upright(on_its_side ? stored.height : stored.width, on_its_side ? stored.width : stored.height,
                stored.channels);
  for (int y = 0; y < upright.height; ++y) {
    for (int x = 0; x < upright.width; ++x) {
      int u = on_its_side ? y : x, v = on_its_side ? x : y;
      if (from_right) u = stored.width - 1 - u;
      if (from_below) v = stored.height - 1 - v;
      for (int c = 0; c < stored.channels; ++c) upright.at(x, y, c) = stored.at(u, v, c);
    }
  }
  return upright;
}

Photograph read_photograph(const std::string& path) {
  const PictureEncoding encoding = picture_encoding(path);
  Photograph photograph;
  if (encoding.dng) {
    photograph.picture = turned_upright(read_dng(path), encoding.orientation);
    require_size(path, photograph.picture.width, photograph.picture.height);
  } else {
    require_usable(path);
    photograph.picture = turned_upright(decoded(path, encoding.linear), encoding.orientation);
    if (!encoding.linear) {
      photograph.assumed.emplace_back(encoding.profile ? "its values are sRGB (its color profile is not applied)"
                                                       : "its values are sRGB");
    }
  }
  photograph.assumed.emplace_back("its noise is what its smoothest parts show");
  Capture& capture = photograph.capture;
  capture.camera = {.name = "photograph", .width_px = photograph.picture.width, .height_px = photograph.picture.height};
  capture.exposure = {.bits = 16, .white_level_dn = kNoiseScale, .mosaic_noise = noise_of(photograph.picture)};
  capture.frames.emplace_back();
  return photograph;
}

}  // namespace dualpixel::pipeline
