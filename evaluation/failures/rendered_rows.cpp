#include "evaluation/failures/rendered_rows.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "evaluation/failures/atlas_scene.h"
#include "scenes/procedural/noise.h"

namespace dualpixel::evaluation {
namespace {

constexpr double kWall = 4;    // blur of a wall that is far from all limits but the one that is swept, DP px
constexpr double kReach = 24;  // blur at infinity, where no row needs more, DP px

struct RenderedRow {
  const char *name, *title, *sweep, *key;
  std::vector<double> values;
  void (*build)(AtlasScene& scene, double value);
  const char* note = "";
  bool log = false;
  double reach_dp_px = kReach;                   ///< blur at infinity: the larger, the nearer is the focus
  void (*process)(ViewSample& views) = nullptr;  ///< what a phone does to them before it hands them out
};

void add_plain_wall(AtlasScene& scene) { add_wall(scene, add_paint(scene, pink_paint(scene, 0)), kWall); }

/// Twice the noise of rendering that other rows have, in a quarter of the time, where hair costs much. It is
/// common to both views, and much of it would pull all methods to 0.
void allow_noise(AtlasScene& scene) { scene.document["render"]["noise_fraction"] = 0.3; }

std::vector<RenderedRow> texture_scenes() {
  return {
      {"parallel",
       "Structure parallel to the baseline",
       "angle of the lines to the baseline, degrees",
       "angle_deg",
       {90, 45, 20, 10, 5, 2, 1, 0},
       [](AtlasScene& scene, double angle) { add_wall(scene, add_paint(scene, striped_paint(scene, angle)), kWall); },
       "Lines along the baseline look the same at any disparity."},
      {"texture",
       "No texture",
       "contrast over the noise of one frame",
       "contrast_over_noise",
       {8, 4, 2, 1, 0.5, 0.25, 0.12, 0},
       [](AtlasScene& scene, double ratio) {
         add_wall(scene, add_paint(scene, pink_paint(scene, 0, ratio * relative_noise(scene))), kWall);
       },
       "Where noise is all there is to see, any disparity fits it."},
      {"repetition",
       "Repetition",
       "period, DP px",
       "period_dp_px",
       {24, 20, 16, 12, 8, 6, 4, 3},
       [](AtlasScene& scene, double period) {
         const Paint grating = [=](double x, double) {
           return kAtlasMean * (1 + 0.5 * std::sin(2 * std::numbers::pi * x / period));
         };
         add_wall(scene, add_paint(scene, grating), kWall);
       },
       "Upright waves fit each other at every whole period; the finest are lost in the blur."},
  };
}

/// Every other row made anew from its neighbors, and nothing said of the noise.
void interpolate_rows(ViewSample& views) {
  for (Image* view : {&views.left, &views.right}) {
    for (int y = 1; y + 1 < view->height; y += 2) {
      for (int x = 0; x < view->width; ++x) view->at(x, y) = 0.5f * (view->at(x, y - 1) + view->at(x, y + 1));
    }
  }
  views.sensor.noise.reset();
}

RenderedRow row_of_darkness(const char* name, const char* title, void (*build)(AtlasScene& scene, double lux),
                            const char* note, void (*process)(ViewSample& views) = nullptr) {
  return {
      name,   title,  "illumination, lux", "illumination_lux", {400, 100, 30, 10, 3, 1, 0.3, 0.1}, build, note, true,
      kReach, process};
}

std::vector<RenderedRow> light_scenes() {
  return {
      row_of_darkness(
          "noise", "Noise",
          [](AtlasScene& scene, double lux) {
            scene.illumination_lux = lux;
            add_plain_wall(scene);
          },
          "Exposed for at most 1/15 s, three frames merged."),
      row_of_darkness(
          "interpolated", "Noise of rows that were interpolated from half as many",
          [](AtlasScene& scene, double lux) {
            scene.illumination_lux = lux;
            scene.camera = with_side(scene.camera, 2 * kAtlasSide_px);
            add_plain_wall(scene);
          },
          "Every other row is the mean of its neighbors, as in a Pixel 4's views, and matchers are not told the noise. "
          "Pictures are twice as wide as elsewhere: it takes that many tiles to notice.",
          interpolate_rows),
      {"saturation",
       "Saturation",
       "mean exposure over what fills the wells of a view",
       "exposure_over_view_white",
       {0.25, 0.5, 0.75, 1, 1.25, 1.5, 2, 3, 4},
       [](AtlasScene& scene, double level) {
         scene.illumination_lux = 20000;  // ISO 100, where the wells are full before the digital range is
         scene.level = level;
         add_plain_wall(scene);
       },
       "Each half of a photosite has a well of its own, and fills it by itself."},
  };
}

std::vector<RenderedRow> depth_scenes() {
  return {
      {"edges",
       "Depth edges",
       "blur of the wall minus that of the strips, DP px",
       "blur_step_dp_px",
       {0, 1, 2, 4, 6, 8, 12, 16, 24},
       [](AtlasScene& scene, double step) {
         add_strips(scene, {32, 64}, -step / 2, step / 2);
       },
       "Strips of 32 DP px before a wall, the focus between them.",
       false,
       48},
      {"thin",
       "Thin structures",
       "width of the strips, DP px",
       "width_dp_px",
       {96, 64, 48, 32, 24, 16, 12, 8, 4, 2},
       [](AtlasScene& scene, double width) {
         add_strips(scene, {width, 2 * width}, -4, 4);
       },
       "Strips and gaps of one width; the strips are 8 DP px of blur before the wall.",
       true},
      {"defocus",
       "Defocus behind the focus",
       "blur diameter, DP px",
       "blur_dp_px",
       {0, 2, 4, 6, 8, 12, 16, 24, 32, 45, 60, 80},
       [](AtlasScene& scene, double blur) { add_wall(scene, add_paint(scene, pink_paint(scene, 0)), blur); },
       "In a camera, disparity and blur grow together: this is also the row of the range that is searched.",
       false,
       100},
      {"near_defocus",
       "Defocus in front of the focus",
       "blur diameter, DP px",
       "blur_dp_px",
       {0, -2, -4, -6, -8, -12, -16, -24, -32, -45, -60, -80},
       [](AtlasScene& scene, double blur) { add_wall(scene, add_paint(scene, pink_paint(scene, 0)), blur); },
       "As the row before, with the halves exchanged.",
       false,
       100},
      {"slant",
       "Range of disparity in one picture",
       "blur at the sides, DP px",
       "blur_at_sides_dp_px",
       {0, 2, 4, 8, 16, 32, 48, 64},
       [](AtlasScene& scene, double blur) {
         const double slope = blur / (0.5 * side_dp_px(scene.camera));
         add_surface(scene, add_paint(scene, pink_paint(scene, 0)), whole_picture(scene), [&](double x, double y) {
           return point_seen_at(scene.camera, x, y, depth_of_blur(scene.camera, slope * x));
         });
       },
       "A plane that leans from before the focus, on the left, to behind it.",
       false,
       100},
  };
}

/// A print under glass, in which small lamps behind the camera shine `ratio` times as bright as the print.
void build_highlights(AtlasScene& scene, double ratio) {
  constexpr int kLamps = 30;
  constexpr double kLamp_dp_px = 2.4, kLampBlur = 16;
  // no share of the noise: lamps that clip would ask for samples without end
  scene.document["render"] = {{"noise_fraction", nullptr}, {"samples_per_pixel", 64}};
  add_plain_wall(scene);
  const double pane_m = 0.999 * depth_of_blur(scene.camera, kWall);
  add_pane(scene, pane_m);
  const double nits = ratio * scene.mean * white_nits(scene) / kPaneReflects;
  const int lamp = scene.glb.add_material({.color = glm::vec3(0), .emission_nits = glm::vec3(nits)});
  const double side = side_dp_px(scene.camera);
  for (int i = 0; i < kLamps; ++i) {
    const double x = side * (scenes::hash01(scene.draw, i, 0) - 0.5),
                 y = side * (scenes::hash01(scene.draw, i, 1) - 0.5);
    add_surface(scene, lamp, {x, x + kLamp_dp_px, y, y + kLamp_dp_px}, mirrored(at_blur(scene, kLampBlur), pane_m));
  }
}

/// A wall through a pane that reflects another one, `ratio` times as bright.
void build_reflection(AtlasScene& scene, double ratio) {
  constexpr double kPane = -6, kReflected = 12;
  const double transmits = 1 - kPaneReflects, equal = kPaneReflects / transmits;
  const double wall = std::min(equal / ratio, 1.0), reflected = std::min(ratio / equal, 1.0);
  scene.mean = kAtlasMean * (wall * transmits + reflected * kPaneReflects);
  scene.document["render"] = {{"noise_fraction", nullptr}, {"samples_per_pixel", 64}, {"max_bounces", 1}};
  const double pane_m = depth_of_blur(scene.camera, kPane);
  add_wall(scene, add_paint(scene, pink_paint(scene, 0), wall), kWall);
  add_pane(scene, pane_m);
  add_surface(scene, add_paint(scene, pink_paint(scene, 1), reflected), whole_picture(scene),
              mirrored(at_blur(scene, kReflected), pane_m));
}

/// Waving strands, 1.2 DP px wide and 4 apart, before a wall.
void build_hair(AtlasScene& scene, double blur_step) {
  constexpr double kWidth = 1.2, kApart = 4, kSegment = 6, kSwing = 3, kWave = 20;
  allow_noise(scene);
  add_wall(scene, add_paint(scene, pink_paint(scene, 0)), blur_step / 2);
  const double depth_m = depth_of_blur(scene.camera, -blur_step / 2);
  const Window all = whole_picture(scene);
  const double width_m = kWidth * point_seen_at(scene.camera, 1, 0, depth_m).x;
  std::vector<glm::vec3> points;
  std::vector<glm::uvec2> segments;
  for (double left = all.left; left < all.right; left += kApart) {
    const double phase = 2 * std::numbers::pi * scenes::hash01(scene.draw + 1, static_cast<int>(left));
    for (double y = all.top; y < all.bottom; y += kSegment) {
      const double x = left + kSwing * std::sin(y / kWave + phase);
      points.push_back(point_seen_at(scene.camera, x, y, depth_m));
      if (y > all.top) segments.emplace_back(points.size() - 2, points.size() - 1);
    }
  }
  const std::vector<float> widths(points.size(), static_cast<float>(width_m));
  const std::vector<glm::vec3> colors(points.size(), glm::vec3(static_cast<float>(kAtlasMean)));
  const int material = scene.glb.add_material(-1, glm::vec3(1), false, 0.3f);
  scene.glb.add_person_hair("hair", points, widths, colors, segments, material);
  const double nits = white_nits(scene);
  scene.document["environment"] = {{"model", "constant"}, {"nits", {nits, nits, nits}}};
}

std::vector<RenderedRow> material_scenes() {
  return {
      {"highlights",
       "Specular highlights",
       "brightness over the surface",
       "brightness_ratio",
       {0, 1, 3, 10, 30, 100},
       build_highlights,
       "Lamps mirrored by a varnished print lie far behind it, and so does their disparity."},
      {"reflection",
       "Reflections in glass",
       "reflected over transmitted light",
       "reflected_over_transmitted",
       {0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6, 6.4},
       build_reflection,
       "Two walls are seen at once, each with its own disparity; true is that behind the pane."},
      {"hair",
       "Fine hair",
       "blur of the wall minus that of the hair, DP px",
       "blur_step_dp_px",
       {0, 2, 4, 6, 8, 12, 16, 24},
       build_hair,
       "Strands of 1.2 DP px, 4 apart, the focus between them and the wall.",
       false,
       48},
  };
}

double half_side_mm(const AtlasCamera& camera) {
  return 0.5e-3 * camera.sensor.width_px * camera.sensor.pixel_pitch_um;
}

std::vector<RenderedRow> lens_scenes() {
  return {
      {"split_offset",
       "Split beside the middle of the pixel",
       "offset, pupil radii",
       "offset_pupil_radii",
       {0, 0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 0.98},
       [](AtlasScene& scene, double offset) {
         scene.camera = with_plain_lens(scene.camera, {{"split_offset", offset}, {"split", {{"model", "hard"}}}});
         add_wall(scene, add_paint(scene, pink_paint(scene, 0)),
                  kWall / 2);  // a hard split's disparity is twice a ramp's
       },
       "An ideal lens of the camera's focal length and f-number before a hard split; one view gets ever less of the "
       "light."},
      {"vignetting",
       "Pupil cut by vignetting",
       "offset of the cutting disc at the sides, pupil radii",
       "offset_pupil_radii",
       {0, 0.6, 1.2, 1.8, 2.4, 3, 4},
       [](AtlasScene& scene, double cut) {
         const double half_mm = half_side_mm(scene.camera);
         scene.camera = with_plain_lens(
             scene.camera,
             {{"image_radius_mm", half_mm}, {"rims", nlohmann::json::array({{{"radius", 1}, {"shift", cut}}})}});
         add_plain_wall(scene);
       },
       "An ideal lens whose pupil is cut the more the farther from the middle of this small picture; from 2 on the "
       "corners "
       "are dark."},
      {"fringes",
       "Color fringes",
       "shift of red and of blue at the sides, DP px",
       "shift_dp_px",
       {0, 1, 2, 4, 8, 16, 32},
       [](AtlasScene& scene, double shift) {
         const double half_mm = half_side_mm(scene.camera);
         const double share = shift / (0.5 * side_dp_px(scene.camera));
         scene.camera =
             with_plain_lens(scene.camera, {{"image_radius_mm", half_mm}, {"lateral_color", {share, -share}}});
         add_plain_wall(scene);
       },
       "No value breaks a method: the views are read from green photosites alone."},
  };
}

/// A card that moves to the right before a wall.
void build_motion(AtlasScene& scene, double dp_px_a_frame) {
  constexpr double kBlur = 3, kHalfCard = 48;
  add_wall(scene, add_paint(scene, pink_paint(scene, 0)), kBlur);
  const Window all = whole_picture(scene);
  add_surface(scene, add_paint(scene, pink_paint(scene, 1)), {-kHalfCard, kHalfCard, all.top, all.bottom},
              at_blur(scene, -kBlur));
  const double interval_s = std::max(exposure_of(scene).time_s, 0.04);
  const float a_frame_m = point_seen_at(scene.camera, dp_px_a_frame, 0, depth_of_blur(scene.camera, -kBlur)).x;
  scene.glb.move_last_node(0, glm::vec3(0), 1, {a_frame_m / static_cast<float>(interval_s), 0, 0});
  scene.document["burst"] = {{"interval_s", interval_s}, {"animation", true}, {"exposure_poses", 4}};
}

void build_shake(AtlasScene& scene, double scale) {
  add_plain_wall(scene);
  scene.document["burst"] = {{"hand_shake", scale}, {"hand_shake_seed", scene.draw + 1}, {"exposure_poses", 8}};
}

std::vector<RenderedRow> motion_scenes() {
  return {
      {"motion",
       "Things that move",
       "DP px from frame to frame",
       "dp_px_a_frame",
       {0, 4, 8, 16, 32, 64, 128},
       build_motion,
       "A card before a wall, blurred by its way in each exposure; true is the middle of the first frame's."},
      {"shake",
       "Hand shake",
       "amplitude over that of a hand",
       "hand_shake",
       {0, 1, 2, 4, 8, 16, 32, 64},
       build_shake,
       "The camera moves in 1/15 s of exposure and from frame to frame."},
      {"rolling",
       "Rolling shutter",
       "from the top row to the bottom row, ms",
       "readout_ms",
       {0, 5, 10, 20, 30, 45, 60},
       [](AtlasScene& scene, double readout_ms) {
         build_shake(scene, 2);
         scene.document["sensor"]["row_time_us"] = 1e3 * readout_ms / scene.camera.sensor.height_px;
       },
       "No value breaks a method: both views of a row are read together, and bend alike. The hand shakes twice as "
       "much as usual."},
  };
}

}  // namespace

std::vector<FailureRow> rendered_failure_rows(const AtlasCamera& camera) {
  std::vector<FailureRow> all;
  for (const auto& group :
       {texture_scenes(), light_scenes(), depth_scenes(), material_scenes(), lens_scenes(), motion_scenes()}) {
    for (const RenderedRow& row : group) {
      const auto make = [camera = focused_for(camera, row.reach_dp_px), build = row.build, process = row.process](
                            double value, unsigned draw) {
        AtlasScene scene{camera, draw};
        scene.glb.set_generator("dualpixel experiment failures", 1);
        build(scene, value);
        ViewSample views = take_views(scene);
        if (process) process(views);
        return views;
      };
      all.push_back({row.name, row.title, row.sweep, row.key, row.values, make, row.log, row.note});
    }
  }
  return all;
}

}  // namespace dualpixel::evaluation
