#include "evaluation/experiments/mask_experiment.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>

#include "capture/error.h"
#include "capture/image/image_io.h"
#include "capture/image/read_mask.h"
#include "capture/image/resample.h"
#include "capture/timing.h"
#include "evaluation/metrics/mask_metrics.h"
#include "evaluation/metrics/statistics.h"
#include "evaluation/report/report_images.h"
#include "pipeline/segmentation/person_mask.h"

namespace dualpixel::evaluation {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kWorst = 20;
constexpr int kMaskThumbnail_px = 360;

/// Linear, one or three channels. EXR and HDR files hold linear values, all others sRGB.
Image read_linear(const std::string& path) {
  const std::string format = picture_size(path).format;
  const Image stored = read_image(path);
  Image picture(stored.width, stored.height, stored.channels < 3 ? 1 : 3);
  for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
    for (int c = 0; c < picture.channels; ++c) {
      const float value = stored.data[i * stored.channels + c];
      picture.data[i * picture.channels + c] = format == "openexr" || format == "hdr" ? value : linear_from_srgb(value);
    }
  }
  return picture;
}

Image read_true_mask(const std::string& path, bool labels, const Image& picture) {
  Image mask = read_mask(path);
  if (labels) {
    const float largest = *std::max_element(mask.data.begin(), mask.data.end());
    for (float& value : mask.data) value = largest > 0 && value > 0.5F * largest ? 1 : 0;
  }
  if (!mask.same_size(picture)) {
    throw InputError(fmt::format("{}: {} x {} pixels; its picture has {} x {}", printable(path), mask.width,
                                 mask.height, picture.width, picture.height));
  }
  return mask;
}

struct Scored {
  PictureMaskScore score;
  Image picture, truth, filtered;
};

Scored score(const MaskedPicture& pair, pipeline::PersonNetwork& network) {
  Scored scored;
  PictureMaskScore& s = scored.score;
  s.name = pair.name;
  scored.picture = read_linear(pair.picture);
  scored.truth = read_true_mask(pair.mask, pair.labels, scored.picture);
  const int width = scored.picture.width, height = scored.picture.height;
  pipeline::FoundPeople found;
  s.find_cpu_ms = 1e3 * cpu_seconds([&] { found = pipeline::find_people(scored.picture, pair.faces, network); });
  s.faces = found.faces.size();
  if (found.faces.empty()) {
    scored.filtered = Image(width, height);
    s.iou = s.filtered_iou = mask_iou(scored.filtered, scored.truth);
    return scored;
  }
  Image rgb = scored.picture;
  if (rgb.channels == 1) {
    rgb = Image(width, height, 3);
    for (std::size_t i = 0; i < rgb.data.size(); ++i) rgb.data[i] = scored.picture.data[i / 3];
  }
  scored.filtered = filtered_mask(found.mask, rgb);
  const bool smaller = width < found.mask.width;
  s.iou = mask_iou(smaller ? resize_area(found.mask, width, height) : resize_bilinear(found.mask, width, height),
                   scored.truth);
  s.filtered_iou = mask_iou(scored.filtered, scored.truth);
  const Image small_truth = resize_area(scored.truth, found.mask.width, found.mask.height);
  s.gradient_error = mask_gradient_error(found.mask, small_truth);
  s.filtered_gradient_error =
      mask_gradient_error(resize_area(scored.filtered, found.mask.width, found.mask.height), small_truth);
  return scored;
}

/// A small copy of the picture in gray: orange where the filtered mask covers too much, blue where it is missing.
Image errors_srgb(const Image& picture_linear, const Image& true_mask, const Image& filtered_mask) {
  const double scale = std::min(1.0, 1.0 * kMaskThumbnail_px / std::max(picture_linear.width, picture_linear.height));
  const int width = std::max(1, static_cast<int>(scale * picture_linear.width));
  const int height = std::max(1, static_cast<int>(scale * picture_linear.height));
  const Image picture = resized(picture_linear, width, height), truth = resized(true_mask, width, height);
  const Image filtered = resized(filtered_mask, width, height);
  Image shown(width, height, 3);
  for (std::size_t i = 0; i < shown.pixel_count(); ++i) {
    const float gray = srgb_from_linear(picture.data[i * picture.channels + (picture.channels == 3 ? 1 : 0)]);
    const float error = filtered.data[i] - truth.data[i];
    const float amount = 0.8F * std::abs(error);
    const float orange[3] = {1, 0.5F, 0.1F}, blue[3] = {0.2F, 0.5F, 1};
    for (int c = 0; c < 3; ++c) {
      shown.data[3 * i + c] = gray * (1 - amount) + amount * (error > 0 ? orange[c] : blue[c]);
    }
  }
  return shown;
}

/// The indices of the twenty lowest values, lowest first.
std::vector<std::size_t> worst_of(const std::vector<double>& iou) {
  std::vector<std::size_t> order(iou.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return iou[a] < iou[b]; });
  order.resize(std::min(order.size(), kWorst));
  return order;
}

}  // namespace

std::vector<fs::path> regular_files(const std::string& folder) {
  std::error_code error, unreadable;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(folder, error), end; entry != end; entry.increment(error)) {
    const bool hidden = entry->path().filename().string().starts_with('.');
    if (!hidden && entry->is_regular_file(unreadable)) files.push_back(entry->path());  // a link to nowhere is none
  }
  if (error) throw InputError(printable(folder) + ": cannot be read as a folder: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<MaskedPicture> pair_masks(const std::string& pictures_folder, const std::string& masks_folder) {
  const std::vector<fs::path> masks = regular_files(masks_folder);
  std::vector<MaskedPicture> pairs;
  for (const fs::path& image : regular_files(pictures_folder)) {
    const auto mask =
        std::find_if(masks.begin(), masks.end(), [&](const fs::path& path) { return path.stem() == image.stem(); });
    if (mask == masks.end()) {
      throw InputError(
          fmt::format("{}: {} holds no mask of that name", printable(image.string()), printable(masks_folder)));
    }
    pairs.push_back({image.stem().string(), image.string(), mask->string()});
  }
  if (pairs.empty()) throw InputError(printable(pictures_folder) + ": holds no pictures");
  return pairs;
}

MaskMeans means_of(const std::vector<PictureMaskScore>& scores) {
  MaskMeans means;
  means.count = scores.size();
  for (const PictureMaskScore& p : scores) {
    means.with_face += p.faces > 0 ? 1 : 0;
    means.iou += p.iou;
    means.filtered_iou += p.filtered_iou;
    if (p.faces == 0) continue;
    means.iou_found += p.iou;
    means.filtered_iou_found += p.filtered_iou;
    means.gradient_error += p.gradient_error;
    means.filtered_gradient_error += p.filtered_gradient_error;
  }
  const auto all = static_cast<double>(means.count);
  const double found = std::max(1.0, static_cast<double>(means.with_face));
  for (double* sum : {&means.iou, &means.filtered_iou}) *sum /= all;
  for (double* sum :
       {&means.iou_found, &means.filtered_iou_found, &means.gradient_error, &means.filtered_gradient_error}) {
    *sum /= found;
  }
  std::vector<double> times;
  for (const PictureMaskScore& p : scores) times.push_back(p.find_cpu_ms);
  if (!times.empty()) means.find_cpu_ms = median(times);
  return means;
}

PictureMasks score_pictures(const std::vector<MaskedPicture>& pictures, pipeline::PersonNetwork& network,
                            const std::function<void(double)>& progress) {
  PictureMasks masks;
  std::vector<double> iou;
  for (const MaskedPicture& picture : pictures) {
    masks.pictures.push_back(score(picture, network).score);
    iou.push_back(masks.pictures.back().filtered_iou);
    progress(static_cast<double>(iou.size()) / static_cast<double>(pictures.size()));
  }
  for (const std::size_t i : worst_of(iou)) {
    const Scored again = score(pictures[i], network);  // in place of keeping all pictures in memory
    masks.worst.push_back({again.score.name,
                           fmt::format("IoU {:.3f} after filtering, {:.3f} before, faces {}", again.score.filtered_iou,
                                       again.score.iou, again.score.faces),
                           errors_srgb(again.picture, again.truth, again.filtered)});
  }
  return masks;
}

PeopleMasks score_people_masks(const scenes::PeopleSet& set, pipeline::PersonNetwork& network,
                               const std::function<void(double)>& progress) {
  PeopleMasks masks;
  masks.scores = score_people(set, network, progress);
  for (const std::size_t i : worst_of(masks.scores.filtered_iou)) {
    masks.worst.push_back(
        {std::to_string(i),
         fmt::format("IoU {:.3f} after filtering; {}", masks.scores.filtered_iou[i], fmt::join(set[i].tags, ", ")),
         errors_srgb(picture_of(set[i]), mask_of(set[i]), filtered_mask_of(set[i], network))});
  }
  return masks;
}

Json to_json(const std::vector<PictureMaskScore>& pictures, const NetworkId& network) {
  const MaskMeans means = means_of(pictures);
  Json json = {{"format", "dualpixel-experiment-segmentation"},
               {"version", 1},
               {"person_weights_hash", network.weights_hash},
               {"person_network", network.precision},
               {"count", means.count},
               {"without_face", means.count - means.with_face},
               {"mean_iou", means.iou},
               {"mean_iou_filtered", means.filtered_iou},
               {"median_find_cpu_ms", means.find_cpu_ms}};
  if (means.with_face > 0) {
    json["mean_iou_where_found"] = means.iou_found;
    json["mean_iou_filtered_where_found"] = means.filtered_iou_found;
    json["gradient_error"] = means.gradient_error;
    json["gradient_error_filtered"] = means.filtered_gradient_error;
  }
  json["pictures"] = Json::array();
  for (const PictureMaskScore& p : pictures) {
    Json picture = {{"name", printable(p.name)},
                    {"faces", p.faces},
                    {"iou", p.iou},
                    {"iou_filtered", p.filtered_iou},
                    {"find_cpu_ms", p.find_cpu_ms}};
    if (p.faces > 0) {
      picture["gradient_error"] = p.gradient_error;
      picture["gradient_error_filtered"] = p.filtered_gradient_error;
    }
    json["pictures"].push_back(std::move(picture));
  }
  return json;
}

Json to_json(const PeopleScores& scores, const std::string& people_hash, const NetworkId& network) {
  Json json = {{"format", "dualpixel-experiment-segmentation-people"},
               {"version", 1},
               {"people_hash", people_hash},
               {"person_weights_hash", network.weights_hash},
               {"person_network", network.precision},
               {"samples", Json::array()},
               {"regions", Json::array()}};
  for (const PeopleRow& row : scores.samples) {
    json["samples"].push_back({{"name", printable(row.name)},
                               {"samples", row.samples},
                               {"iou", row.iou},
                               {"iou_standard_error", row.iou_error},
                               {"iou_filtered", row.filtered_iou},
                               {"iou_without_face_channel", row.iou_without_face},
                               {"gradient_error", row.gradient_error},
                               {"gradient_error_filtered", row.filtered_gradient_error}});
  }
  for (const PeopleRow& row : scores.regions) {
    json["regions"].push_back({{"name", row.name},
                               {"samples", row.samples},
                               {"gradient_error", row.gradient_error},
                               {"gradient_error_filtered", row.filtered_gradient_error}});
  }
  return json;
}

}  // namespace dualpixel::evaluation
