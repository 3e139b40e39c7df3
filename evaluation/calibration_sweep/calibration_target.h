#pragma once
#include <cstdint>

#include "capture/image/image.h"
#include "simulator/lens/lens_sampler.h"

/// Views of a calibration target, a textured plane, through a simulated camera. No ray tracer is needed: the
/// intersection of a lens's ray with a plane has a closed form.
namespace dualpixel::evaluation {

struct CalibrationTarget {
  double distance_m = 1;  ///< planar depth on the axis
  double tilt_x_deg = 0;  ///< its right side is this much farther away
  std::uint64_t texture_seed = 1;
  int finest_px =
      32;  ///< width of the texture's smallest cells, photosites: a power of two; the largest are four times as wide
};

/// The target as it is printed: three octaves of smooth noise of equal contrast, 0.1 .. 0.9, mean 0.5. It repeats.
/// Texel (i, j) is centered at ((i - width / 2) * texel_m, (j - height / 2) * texel_m) from the axis, x to the
/// right and y down; bilinear in between. It is printed for its distance: it looks the same size from any.
struct TargetPrint {
  Image texture;
  double texel_m = 0;
};
TargetPrint print_target(const CalibrationTarget& target, const simulator::LensSampler& lens);

/// A simulated camera, focused, for render_target(). Its pixels may be blocks of DP pixels: what is averaged anyway
/// needs no finer picture, and a block's rays as one net have far less noise than each pixel's own.
struct TargetCamera {
  simulator::LensSampler lens;
  int width = 0, height = 0;      ///< of the views
  Image left_light, right_light;  ///< shading of the views
};
TargetCamera make_target_camera(const simulator::LensSampler& lens, int width, int height);

/// Light of both views, over what the axis of the undivided pixel would see of white: 0..1.
struct TargetViews {
  Image left, right;
};

/// Each view is the mean of the texture over `rays` a pixel (a multiple of 16; mirrored pairs over the
/// pixel's whole area), weighed as the view weighs them, times the view's shading. Shading is a smooth fit: how many of
/// so few rays the lens happens to block must not show, for 0.3 % of light looks like 0.1 DP px of disparity on so
/// coarse a texture. The same bytes for any number of threads.
TargetViews render_target(const TargetCamera& camera, const CalibrationTarget& target, int rays);

}  // namespace dualpixel::evaluation
