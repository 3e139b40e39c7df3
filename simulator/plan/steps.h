#pragma once
#include <string>

#include "simulator/lens/lens.h"
#include "simulator/plan/effects.h"

/// The steps from the cheapest to the most accurate simulation, along each of the choices of a plan, with the disparity
/// error that each leaves.
namespace dualpixel::simulator {

/// A lens that may replace another one.
struct LensCandidate {
  std::string name;
  Lens lens;
};

/// What else of a picture another lens changes: RMS of the difference from the reference's, over the points of the
/// field where both can be told; NaN where none can.
struct LensDifferences {
  double picture_shift_px = 0;  ///< photosites by which the picture is displaced, in green
  double color_shift_px = 0;    ///< photosites by which red is displaced against blue, where the pupil is whole
  double blur_px = 0;           ///< diameter of the blur, photosites
  double light = 0;             ///< of both views, over that of the axis
  double left_share = 0;        ///< the left view's share of the light
};

struct LensStep {
  LensCandidate candidate;
  double error_dp_px = 0;
  double error_95_dp_px = 0;      ///< 95th percentile
  LensDifferences differences;    ///< shown beside disparity, by which the choice is made
  double seconds_per_sample = 0;  ///< of the lens alone, on all threads
};

struct BounceStep {
  int bounces = 0;
  double error_dp_px = 0;
  int lost_windows = 0;           ///< those that count as 1 DP px
  double noise = 1;               ///< error of 16 samples over that with 8 bounces, at least 1
  double seconds_per_sample = 0;  ///< whole, on all threads, behind the pilot's lens, with light at points found
  double light_seconds = 0;       ///< of finding it, per photosite, at the scene file's spacing
};

/// Diffuse light at points of surfaces.
struct LightStep {
  double spacing_px = 0;   ///< photosites between them; 0: all light is sampled
  double error_dp_px = 0;  ///< of interpolation
  int lost_windows = 0;    ///< those that count as 1 DP px
  double noise = 1;        ///< of light at points, over that at the scene file's spacing
  double making = 1;       ///< time of finding it over that at the scene file's spacing
};

/// Samples of light at each point.
struct LightSampleStep {
  int samples = 0;
  double error_dp_px = 0;  ///< the part of noise that more camera samples do not reduce
  double making = 1;       ///< time of finding light over that with the scene file's samples
};

/// An effect that can be left out.
struct EffectStep {
  Effect effect;
  double error_dp_px = 0;         ///< without it
  int lost_windows = 0;           ///< those that count as 1 DP px
  double seconds_per_sample = 0;  ///< that it adds
  int least_samples = 1;          ///< that it takes: two of each pose
};

struct SampleStep {
  int samples = 0;
  double error_dp_px = 0;  ///< with the chosen bounces; without noise of light at points
};

}  // namespace dualpixel::simulator
