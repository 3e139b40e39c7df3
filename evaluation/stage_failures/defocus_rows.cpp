#include <cmath>
#include <functional>
#include <glm/glm.hpp>

#include "capture/image/display.h"
#include "evaluation/experiments/defocus_baselines.h"
#include "evaluation/failures/atlas_camera.h"
#include "evaluation/stage_failures/stage_row.h"
#include "pipeline/defocus/render.h"
#include "pipeline/disparity/match_pixels.h"
#include "pipeline/segmentation/merge_mask.h"

namespace dualpixel::evaluation {
namespace {

// Pictures of two layers whose defocused picture is known: what lies in focus stays, and a layer that is out of focus
// is the mean over its blur disc, its coverage too.

constexpr int kSceneSide = 240;
constexpr float kBlurRadius = 12;
constexpr float kMiddle = (kSceneSide - 1) / 2.0f;

Image painted_scene(int channels, const std::function<glm::vec3(float x, float y)>& of) {
  Image image(kSceneSide, kSceneSide, channels);
  for (int y = 0; y < kSceneSide; ++y) {
    for (int x = 0; x < kSceneSide; ++x) {
      const glm::vec3 value = of(static_cast<float>(x) - kMiddle, static_cast<float>(y) - kMiddle);
      for (int c = 0; c < channels; ++c) image.at(x, y, c) = value[c];
    }
  }
  return image;
}

constexpr glm::vec3 kYellow(0.7f, 0.55f, 0.05f);

/// Blue, with small lamps on it.
glm::vec3 wall_color(float x, float y) {
  const auto on = [](float v) { return static_cast<int>(v + kMiddle) % 24 < 4; };
  return on(x) && on(y) ? glm::vec3(0.8f, 0.7f, 0.6f) : glm::vec3(0.05f, 0.12f, 0.35f);
}

/// Disparity 0 is in focus, 1 is blurred by kBlurRadius.
const pipeline::BlurMapping kMapping{kBlurRadius, 0, 0, 1, kBlurRadius};

Image rendered(const Image& rgb, const Image& disparity, const pipeline::Bokeh& bokeh = {}) {
  return render_defocus(rgb, disparity, blur_radii(disparity, kMapping), kMapping, {}, bokeh).rgb;
}

Image blurred_evenly(const Image& rgb, float radius_px = kBlurRadius) {
  return blur_by_gathering(rgb, Image(rgb.width, rgb.height, 1, radius_px));
}

/// front over back, by the front's coverage; `front` is premultiplied.
Image over(const Image& front, const Image& coverage, const Image& back) {
  Image out = front;
  for (std::size_t i = 0; i < out.data.size(); ++i) out.data[i] += (1 - coverage.data[i / 3]) * back.data[i];
  return out;
}

/// Mean absolute difference over the pixels where `counts` holds.
double mean_error(const Image& picture, const Image& truth, const std::function<bool(float x, float y)>& counts) {
  double sum = 0, values = 0;
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      if (!counts(static_cast<float>(x) - kMiddle, static_cast<float>(y) - kMiddle)) continue;
      for (int c = 0; c < 3; ++c, ++values) sum += std::abs(picture.at(x, y, c) - truth.at(x, y, c));
    }
  }
  return sum / values;
}

/// A yellow disc in focus before the wall, blurred by `radius_px`.
StageOutcome sharp_before_blurred(double radius_px) {
  constexpr float kDisc = 60;
  const auto radius = static_cast<float>(radius_px);
  const auto inside = [](float x, float y) { return std::hypot(x, y) < kDisc; };
  const Image wall = painted_scene(3, wall_color);
  const Image disparity = painted_scene(1, [&](float x, float y) { return glm::vec3(inside(x, y) ? 0 : 1); });
  const Image disc = painted_scene(3, [&](float x, float y) { return inside(x, y) ? kYellow : glm::vec3(0); });
  const Image coverage = painted_scene(1, [&](float x, float y) { return glm::vec3(inside(x, y) ? 1 : 0); });
  const pipeline::BlurMapping mapping{radius_px, 0, 0, 1, radius_px};
  const Image picture =
      render_defocus(over(disc, coverage, wall), disparity, blur_radii(disparity, mapping), mapping).rgb;
  const double error = mean_error(picture, over(disc, coverage, blurred_evenly(wall, radius)),
                                  [&](float x, float y) { return std::abs(std::hypot(x, y) - kDisc) < radius; });
  return {error, encode_for_display(picture)};
}

/// A branch 16 px wide, blurred by `radius_px`, before the wall, which is in focus and seen through that blur.
StageOutcome blurred_before_sharp(double radius_px) {
  constexpr float kHalf = 8;
  const auto radius = static_cast<float>(radius_px);
  const pipeline::BlurMapping mapping{radius_px, 0, 0, 1, radius_px};
  const auto inside = [=](float x) { return std::abs(x) < kHalf; };
  const Image wall = painted_scene(3, wall_color);
  const Image branch = painted_scene(3, [&](float x, float) { return inside(x) ? kYellow : glm::vec3(0); });
  const Image coverage = painted_scene(1, [&](float x, float) { return glm::vec3(inside(x) ? 1 : 0); });
  const Image disparity = painted_scene(1, [&](float x, float) { return glm::vec3(inside(x) ? -1 : 0); });
  const Image picture =
      render_defocus(over(branch, coverage, wall), disparity, blur_radii(disparity, mapping), mapping).rgb;
  const Image truth = over(blurred_evenly(branch, radius), blurred_evenly(coverage, radius), wall);
  const double error = mean_error(picture, truth, [&](float x, float) { return std::abs(x) < kHalf + radius; });
  return {error, encode_for_display(picture)};
}

/// Lamps of that brightness over white on a dark wall, all out of focus; the sensor clips them at white.
StageOutcome clipped_lamps(double brightness, bool recover) {
  constexpr float kLamp = 3, kApart = 60, kDark = 0.02f;
  const auto is_lamp = [](float x, float y) {
    const auto from = [](float v) { return v - kApart * std::round(v / kApart); };
    return std::hypot(from(x), from(y)) < kLamp;
  };
  const auto light = static_cast<float>(brightness);
  const Image scene = painted_scene(3, [&](float x, float y) { return glm::vec3(is_lamp(x, y) ? light : kDark); });
  Image clipped = scene;
  for (float& value : clipped.data) value = std::min(value, 1.0f);
  pipeline::Bokeh bokeh;
  bokeh.recover_highlights = recover;
  const Image picture = rendered(clipped, Image(kSceneSide, kSceneSide, 1, 1.0f), bokeh);
  const Image truth = blurred_evenly(scene);
  double missing = 0, lamps = 0;
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    missing += std::min(truth.data[i], 1.0f) - picture.data[i];
    lamps += std::min(truth.data[i], 1.0f) - kDark;
  }
  return {std::abs(missing / lamps), encode_for_display(picture)};
}

/// The disc and the wall again, but the person mask reaches beyond the disc and brings the wall into focus.
StageOutcome mask_too_large(double beyond_px) {
  constexpr float kDisc = 60;
  const auto reach = kDisc + static_cast<float>(beyond_px);
  const Image wall = painted_scene(3, wall_color);
  const auto inside = [](float radius) {
    return painted_scene(1, [=](float x, float y) { return glm::vec3(std::hypot(x, y) < radius ? 1 : 0); });
  };
  const Image coverage = inside(kDisc);
  const Image disc =
      painted_scene(3, [&](float x, float y) { return std::hypot(x, y) < kDisc ? kYellow : glm::vec3(0); });
  pipeline::PixelDisparity map{coverage, Image(kSceneSide, kSceneSide, 1, 1.0f), {}};
  for (float& value : map.disparity_dp_px.data) value = 1 - value;
  const Image flat = pipeline::flatten_person(std::move(map), inside(reach), 0).disparity_dp_px;
  const Image picture = rendered(over(disc, coverage, wall), flat);
  const Image truth = over(disc, coverage, blurred_evenly(wall));
  const double error = mean_error(picture, truth, [&](float x, float y) {
    return std::abs(std::hypot(x, y) - kDisc - kBlurRadius / 2) < kBlurRadius / 2;
  });
  return {error, encode_for_display(picture)};
}

/// Two people on a floor, the left one in focus at a meter, the right one at `depth_m`; the mask covers both. At the
/// paper's size, with its constants and its phone.
StageOutcome second_person(double depth_m) {
  constexpr double kFocus_m = 1, kWall_m = 5;
  constexpr float kFeet = 90, kLeft = -55, kRight = 60;  // of who stands at a meter, from the horizon down; aside
  constexpr int kWidth_px = 2688;
  AtlasCamera phone = atlas_camera("thin");
  phone.lens = simulator::refocused(phone.lens, kFocus_m);
  const simulator::ThinLens& thin = phone.lens.thin;
  const auto disparity_at = [&](double depth) {
    return static_cast<float>(phone.lens.split.alpha(thin.rim_slope()) * thin.blur_diameter_m(depth) /
                              dp_pitch_m(phone));
  };
  const auto in_person = [](float x, float y, float middle, double depth) {
    const float u = (x - middle) * static_cast<float>(depth), v = y * static_cast<float>(depth);
    return std::hypot(u, v + 50) < 22 || (std::abs(u) < 32 && v > -24 && v < kFeet);
  };
  const auto in_left = [&](float x, float y) { return in_person(x, y, kLeft, kFocus_m); };
  const auto in_right = [&](float x, float y) { return in_person(x, y, kRight, depth_m); };
  const Image truth = painted_scene(1, [&](float x, float y) {
    const double floor_m = y > 0 ? std::min(kWall_m, kFeet / static_cast<double>(y)) : kWall_m;
    return glm::vec3(disparity_at(in_left(x, y) ? kFocus_m : in_right(x, y) ? depth_m : floor_m));
  });
  const Image mask =
      painted_scene(1, [&](float x, float y) { return glm::vec3(in_left(x, y) || in_right(x, y) ? 1 : 0); });
  const Image rgb = painted_scene(3, [&](float x, float y) {
    const bool square = (static_cast<int>(x + kMiddle) / 6 + static_cast<int>(y + kMiddle) / 6) % 2 == 0;
    const bool person = in_left(x, y) || in_right(x, y);
    return (person ? kYellow : glm::vec3(0.3f, 0.4f, 0.5f)) * (square ? 1.0f : 0.5f);
  });
  const pipeline::BlurMapping mapping = pipeline::make_blur_mapping(kFocus_m, 0, kWidth_px, true);
  const Image flat =
      pipeline::flatten_person({truth, Image(kSceneSide, kSceneSide, 1, 1.0f), {}}, mask, 0).disparity_dp_px;
  const Image radius = blur_radii(flat, mapping);
  const Image picture = render_defocus(rgb, flat, radius, mapping).rgb;
  const auto middle_of_right = static_cast<int>(kMiddle + kRight);
  const double beside_feet = mapping.radius_px(disparity_at(depth_m));  // the floor there is as far as they are
  return {beside_feet - radius.at(middle_of_right, static_cast<int>(kMiddle)), encode_for_display(picture)};
}

constexpr const char *kDefocus = "defocus", *kBesideEdge = "mean error beside the edge, of white";
constexpr double kVisible = 0.02;
constexpr const char* kWhyVisible =
    "Five levels of 255 in linear light: an edge of that contrast is seen on even ground.";

std::vector<StageRow> rows_of_layers() {
  return {
      {kDefocus,
       "halos",
       "Halos around what is sharp",
       "blur radius of the wall behind, px",
       "radius_px",
       {2, 4, 8, 12, 16, 24, 30},
       kBesideEdge,
       kVisible,
       false,
       kWhyVisible,
       [](double radius, unsigned) { return sharp_before_blurred(radius); },
       false,
       "On both sides of a disc's outline, as far as the wall is blurred. No value breaks it."},
      {kDefocus,
       "thin_foreground",
       "Thin things in front",
       "blur radius of a branch, px",
       "radius_px",
       {0.5, 1, 2, 4, 8, 12, 16, 24},
       kBesideEdge,
       kVisible,
       false,
       kWhyVisible,
       [](double radius, unsigned) { return blurred_before_sharp(radius); },
       true,
       "A branch 16 px wide before a wall in focus, which should be seen through the branch's blur. What it hides is "
       "not "
       "known and not made up: the branch stays solid, with a rim of blur around it, and none under 5.5 px."},
      {kDefocus,
       "wrong_mask",
       "A mask that is too large",
       "how far it reaches beyond the person, px",
       "beyond_px",
       {0, 1, 2, 4, 8, 12},
       kBesideEdge,
       kVisible,
       false,
       kWhyVisible,
       [](double beyond, unsigned) { return mask_too_large(beyond); },
       false,
       "Mode dp+seg brings into focus what the mask covers; measured within 12 px of the person, as far as the wall is "
       "blurred. A mask that is too small leaves disparity's own answer."},
      {kDefocus,
       "two_depths",
       "Two people at two depths",
       "distance of the second person, m; the first is at 1 m",
       "distance_m",
       {1, 1.05, 1.1, 1.2, 1.4, 2, 4},
       "blur radius that the second person lacks, px",
       2,
       false,
       "The floor beside their feet is blurred by that much, and they are not: an outline is seen.",
       [](double depth, unsigned) { return second_person(depth); },
       false,
       "The paper's failure (b): mode dp+seg brings everyone into focus who is in the mask. Mode dp does not."},
  };
}

std::vector<StageRow> rows_of_highlights() {
  return {
      {kDefocus,
       "highlights",
       "Clipped highlights",
       "brightness of lamps over white",
       "over_white",
       {1, 1.5, 2, 4, 8, 16},
       "light that is missing from the lamps' discs, share",
       0.5,
       false,
       "Half of the light is missing.",
       [](double brightness, unsigned) { return clipped_lamps(brightness, false); },
       true,
       "Lamps 6 px wide, blurred by 12 px, with the default options."},
      {kDefocus,
       "dim_highlights",
       "Clipped highlights, recovered",
       "brightness of lamps over white",
       "over_white",
       {8, 6, 4, 3, 2, 1.5},
       "light that is missing from the lamps' discs, or too much, share",
       0.5,
       false,
       "Half of the light is missing, or as much too much.",
       [](double brightness, unsigned) { return clipped_lamps(brightness, true); },
       true,
       "With `--recover-highlights`. A clipped pixel does not say how bright it was; where little else in the picture "
       "is bright, some ten times white is assumed. Of brighter lamps light is missing again."},
  };
}

}  // namespace

std::vector<StageRow> defocus_rows() {
  std::vector<StageRow> rows = rows_of_layers();
  for (const StageRow& row : rows_of_highlights()) rows.push_back(row);
  return rows;
}

}  // namespace dualpixel::evaluation
