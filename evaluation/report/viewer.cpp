#include "evaluation/report/viewer.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "capture/error.h"
#include "evaluation/report/page.h"
#include "evaluation/report/report_images.h"

namespace dualpixel::evaluation {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kLargestCode = 32767;
constexpr std::int16_t kMissingCode = -32768;

const char* name_of(LayerColors colors) {
  switch (colors) {
    case LayerColors::light:
      return "light";
    case LayerColors::gray:
      return "gray";
    case LayerColors::diverging:
      return "diverging";
    default:
      return "picture";
  }
}

/// Every n-th pixel of a map, each the middle one of n x n.
Image every_nth(const Image& map, int n) {
  Image kept((map.width + n - 1) / n, (map.height + n - 1) / n);
  for (int y = 0; y < kept.height; ++y) {
    for (int x = 0; x < kept.width; ++x) {
      kept.at(x, y) = map.at(std::min(n * x + n / 2, map.width - 1), std::min(n * y + n / 2, map.height - 1));
    }
  }
  return kept;
}

/// `step`, doubled until the largest value fits.
double step_for(const std::vector<Image>& maps, double step) {
  float largest = 0;
  for (const Image& map : maps) {
    for (const float value : map.data) {
      if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
    }
  }
  while (largest > kLargestCode * step) step *= 2;
  return step;
}

/// The pictures of one viewer, each once however many results share it.
struct PictureList {
  std::map<std::string, std::size_t> index;
  std::string html;

  std::size_t add(const Image& srgb, const std::string& name) {
    const std::string uri = jpeg_data_uri(srgb);
    const auto [entry, added] = index.emplace(uri, index.size());
    if (added) html += html_image({.title = name, .caption = "", .data_uri = uri});
    return entry->second;
  }
};

Json layer_json(const ViewerLayer& layer, PictureList& pictures) {
  const auto text = [](const std::string& s) { return printable(s, 1000); };
  Json json = {{"name", text(layer.name)},        {"note", text(layer.note)}, {"unit", text(layer.unit)},
               {"colors", name_of(layer.colors)}, {"low", layer.low},         {"high", layer.high}};
  if (!layer.against.empty()) json["against"] = text(layer.against);
  if (layer.difference_of) {
    json["of"] = {text(layer.difference_of->first), text(layer.difference_of->second)};
    json["step"] = layer.step;
    if (!layer.fits.empty()) json["fits"] = layer.fits;
    return json;
  }
  json["planes"] = Json::array();
  if (layer.colors == LayerColors::picture) {
    for (const Image& image : layer.images) {
      json["planes"].push_back(image.empty() ? Json() : Json{{"image", pictures.add(image, layer.name)}});
    }
    return json;
  }
  json["step"] = step_for(layer.images, layer.step);
  for (const Image& map : layer.images) {
    if (map.empty()) {
      json["planes"].push_back(nullptr);
      continue;
    }
    const int every = (map.width + kViewerWidthPx - 1) / kViewerWidthPx;
    json["every"] = every;
    json["width"] = map.width;
    json["height"] = map.height;
    const Image kept = every_nth(map, every);
    json["planes"].push_back({{"w", kept.width}, {"h", kept.height}, {"data", base64(pack_map(kept, json["step"]))}});
  }
  return json;
}

/// The 256 colors from -1 to 1, as base64 of RGB bytes.
std::string diverging_scale() {
  Image ramp(256, 1);
  for (int x = 0; x < ramp.width; ++x) ramp.at(x, 0) = static_cast<float>(x) / 127.5f - 1;
  const Image colors = diverging_colors(ramp, 1);
  std::string bytes;
  for (const float value : colors.data) bytes += static_cast<char>(std::lround(255 * std::clamp(value, 0.0f, 1.0f)));
  return base64(bytes);
}

}  // namespace

std::string pack_map(const Image& map, double step) {
  const int width = map.width;
  const std::size_t count = map.pixel_count();
  std::vector<std::int16_t> codes(count);
  std::string bytes(2 * count, '\0');
  for (std::size_t i = 0; i < count; ++i) {
    const double code = std::round(static_cast<double>(map.data[i]) / step);
    codes[i] = std::isfinite(code) ? static_cast<std::int16_t>(std::clamp<double>(code, -kLargestCode, kLargestCode))
                                   : kMissingCode;
    const std::size_t x = i % static_cast<std::size_t>(width), y = i / static_cast<std::size_t>(width);
    const auto row = static_cast<std::size_t>(width);
    const int left = x > 0 ? codes[i - 1] : y > 0 ? codes[i - row] : 0;
    const int above = y > 0 ? codes[i - row] : left;
    const int corner = x > 0 && y > 0 ? codes[i - row - 1] : above;
    // the median of left, above and their plane: Weinberger et al. 1996, "LOCO-I"
    const int predicted = corner >= std::max(left, above)   ? std::min(left, above)
                          : corner <= std::min(left, above) ? std::max(left, above)
                                                            : left + above - corner;
    const auto error = static_cast<std::int16_t>(codes[i] - predicted);  // modulo 2^16, as the reader adds
    const auto folded = static_cast<std::uint16_t>(2 * error ^ error >> 15);
    bytes[i] = static_cast<char>(folded & 255);
    bytes[count + i] = static_cast<char>(folded >> 8);
  }
  uLongf size = compressBound(bytes.size());
  std::string deflated(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(deflated.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                bytes.size(), Z_BEST_COMPRESSION) != Z_OK) {
    throw std::runtime_error("zlib: cannot deflate a map");
  }
  deflated.resize(size);
  return deflated;
}

std::string html_viewer(const Viewer& viewer) {
  PictureList pictures;
  Json json = {{"width", viewer.width}, {"height", viewer.height}, {"results", Json::array()}};
  for (const std::string& name : viewer.results) json["results"].push_back(printable(name));
  json["signs"] = diverging_scale();
  json["layers"] = Json::array();
  for (const ViewerLayer& layer : viewer.layers) {
    const bool shown = layer.difference_of || std::any_of(layer.images.begin(), layer.images.end(),
                                                          [](const Image& image) { return !image.empty(); });
    if (shown) json["layers"].push_back(layer_json(layer, pictures));
  }
  // "<" could end the element; within JSON's strings, the only place where one can be, \u003c means the same
  std::string data;
  for (const char c : json.dump(-1, ' ', false, Json::error_handler_t::replace)) {
    if (c == '<') {
      data += "\\u003c";
    } else {
      data += c;
    }
  }
  return "<figure class=\"viewer\">" + pictures.html + "<script type=\"application/json\">" + data +
         "</script></figure>\n";
}

}  // namespace dualpixel::evaluation
