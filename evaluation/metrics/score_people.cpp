#include "evaluation/metrics/score_people.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "capture/image/image_io.h"
#include "evaluation/metrics/mask_metrics.h"
#include "pipeline/segmentation/person_mask.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kSide = scenes::kPictureSide_px;
constexpr std::array<int, 2> kWrists = {9, 10};  // COCO's order
constexpr double kHandRadius = 0.75;             // of the face's width

static_assert(scenes::kPictureSide_px == pipeline::kNetworkSize_px);

Image input_of(const scenes::PersonSample& sample) {
  return pipeline::network_input(picture_of(sample), {sample.face[0], sample.face[1], sample.face[2], sample.face[3]});
}

/// Sums, of which a row holds the means.
struct Sums {
  std::size_t samples = 0;
  double iou = 0, filtered_iou = 0, iou_without_face = 0;
  double pixels = 0, gradient = 0, filtered_gradient = 0;
  struct Scene {
    double samples = 0, iou = 0;
  };
  std::map<std::uint64_t, Scene> scenes = {};  ///< by seed

  /// Standard error of the mean IoU. A picture and its composites show the same people, so what they have in common is
  /// drawn once: a mean over clusters of unequal size (Cochran, Sampling Techniques, 1977, section 6.3, a ratio of
  /// sums).
  double iou_error() const {
    const auto n = static_cast<double>(samples), m = static_cast<double>(scenes.size());
    if (m < 2) return std::numeric_limits<double>::quiet_NaN();
    double squares = 0;
    for (const auto& [seed, scene] : scenes) squares += std::pow(scene.iou - scene.samples * iou / n, 2);
    return std::sqrt(squares * m / (m - 1)) / n;
  }

  PeopleRow row(const std::string& name) const {
    const auto n = static_cast<double>(std::max<std::size_t>(1, samples));
    const double area = std::max(1.0, pixels);
    return {name,
            samples,
            iou / n,
            filtered_iou / n,
            iou_error(),
            iou_without_face / n,
            gradient / area,
            filtered_gradient / area};
  }
};

void add_region(Sums& sums, const Image& gradient, const Image& filtered_gradient,
                const std::function<bool(double x, double y)>& inside) {
  double pixels = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      if (!inside(x + 0.5, y + 0.5)) continue;
      pixels += 1;
      sums.gradient += gradient.at(x, y);
      sums.filtered_gradient += filtered_gradient.at(x, y);
    }
  }
  sums.pixels += pixels;
  sums.samples += pixels > 0 ? 1 : 0;
}

}  // namespace

Image picture_of(const scenes::PersonSample& sample) {
  Image picture(kSide, kSide, 3);
  for (std::size_t i = 0; i < picture.data.size(); ++i) {
    picture.data[i] = linear_from_srgb(static_cast<float>(sample.picture[i]) / 255);
  }
  return picture;
}

Image mask_of(const scenes::PersonSample& sample) {
  Image mask(kSide, kSide);
  for (std::size_t i = 0; i < mask.data.size(); ++i) mask.data[i] = static_cast<float>(sample.mask[i]) / 255;
  return mask;
}

Image filtered_mask_of(const scenes::PersonSample& sample, pipeline::PersonNetwork& network) {
  return filtered_mask(network(input_of(sample)), picture_of(sample));
}

PeopleScores score_people(const scenes::PeopleSet& set, pipeline::PersonNetwork& network,
                          const std::function<void(double)>& progress) {
  std::map<std::string, Sums> kinds, tagged;
  std::map<std::string, Sums> regions;
  PeopleScores scores;
  for (std::size_t i = 0; i < set.size(); ++i) {
    const scenes::PersonSample& sample = set[i];
    Image input = input_of(sample);
    const Image truth = mask_of(sample), mask = network(input), filtered = filtered_mask(mask, picture_of(sample));
    for (std::size_t p = 0; p < input.pixel_count(); ++p) input.data[4 * p + 3] = 0;
    const Image gradient = mask_gradient_errors(mask, truth);
    const Image filtered_gradient = mask_gradient_errors(filtered, truth);
    Sums one{0, mask_iou(mask, truth), mask_iou(filtered, truth), mask_iou(network(input), truth)};
    add_region(one, gradient, filtered_gradient, [](double, double) { return true; });
    scores.filtered_iou.push_back(one.filtered_iou);
    const auto add = [&](Sums& sums) {
      sums.samples += 1;
      Sums::Scene& scene = sums.scenes[sample.seed];
      scene.samples += 1, scene.iou += one.iou;
      sums.iou += one.iou, sums.filtered_iou += one.filtered_iou, sums.iou_without_face += one.iou_without_face;
      sums.pixels += one.pixels, sums.gradient += one.gradient, sums.filtered_gradient += one.filtered_gradient;
    };
    add(kinds["all"]);
    add(kinds[sample.composite ? "composites" : "rendered"]);
    add(kinds[sample.people > 1 ? "groups" : "one person"]);
    bool holds = false;
    for (const std::string& tag : sample.tags) {
      holds = holds || tag.starts_with("held:");
      if (tag.starts_with("hair:") || tag.starts_with("hat:") || tag.starts_with("held:")) add(tagged[tag]);
    }

    const float* const face = sample.face;
    add_region(regions["hair"], gradient, filtered_gradient, [&](double x, double y) {
      return x > face[0] - face[2] && x < face[0] + 2 * face[2] && y > face[1] - face[2] && y < face[1] + face[3];
    });
    const auto on_hand = [&](double x, double y) {
      return std::any_of(kWrists.begin(), kWrists.end(), [&](int wrist) {
        const float* const k = sample.keypoints + 3 * wrist;
        return k[2] > 1.5F && std::hypot(x - k[0], y - k[1]) < kHandRadius * face[2];
      });
    };
    add_region(regions["hands"], gradient, filtered_gradient, on_hand);
    if (holds) add_region(regions["hands that hold"], gradient, filtered_gradient, on_hand);
    if (progress) progress(static_cast<double>(i + 1) / static_cast<double>(set.size()));
  }
  for (const char* kind : {"all", "rendered", "composites", "one person", "groups"}) {
    if (kinds.count(kind) != 0) scores.samples.push_back(kinds[kind].row(kind));
  }
  for (const auto& [tag, sums] : tagged) scores.samples.push_back(sums.row(tag));
  for (const auto& [region, sums] : regions) scores.regions.push_back(sums.row(region));
  return scores;
}

}  // namespace dualpixel::evaluation
