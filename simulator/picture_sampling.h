#pragma once
#include <optional>

#include "capture/capture.h"
#include "simulator/render/adaptive.h"
#include "simulator/render/render_scene.h"
#include "simulator/scene_file.h"

/// How each picture of a capture is sampled: the two views, the all-in-focus picture and the photograph all keep the
/// scene file's goal, or get its number of samples.
namespace dualpixel::simulator {

/// What each photosite of a picture is sampled with.
struct PictureSampling {
  SampleMap map;                      ///< its errors are those of the samples alone
  std::optional<ErrorTarget> target;  ///< of a half photosite, what map.error_ratio is over; empty: not known by tile
  double light = 0;                   ///< square error of light at points of surfaces, over the target's
};

/// What the two views may be off by where the scene file sets a goal for it.
std::optional<ErrorTarget> goal_of(const Simulation& simulation, const ErrorTarget& sensor_noise, double unit_per_nit);

/// Gives `world` the light cache of the scene file; where there is a goal, of so many samples that its square error, as
/// measured with them, takes half at most of what the goal allows in the picture where it shows most. A cache that
/// `world` has is kept where it is the same.
void prepare_light(const Simulation& simulation, RenderScene& world, const CameraView& view,
                   const std::optional<ErrorTarget>& goal);

/// Each pose draws a net of its own, and errors of independent nets average: of P poses each may have sqrt(P) times
/// the error of their mean. Counts stay powers of two, and at least 2, one for each half of the pupil.
/// Without a goal, samples_of_pose().
PictureSampling sample_views(const Simulation& simulation, RenderScene& world, const CameraView& view,
                             const ErrorTarget& sensor_noise, const std::optional<ErrorTarget>& goal,
                             const ProgressCallback& progress);

/// Samples of each photosite in one pose, where the scene file sets neither a goal nor a time.
std::uint32_t samples_of_pose(const Simulation& simulation);

/// Of a picture that is not divided, through the ideal lens that `picture` says; `picture.samples_per_pixel` where
/// there is no goal. Its goal is that of the views in both halves together: the same share of the noise of a whole
/// photosite, or of the white level.
PictureSampling sample_picture(const Simulation& simulation, RenderScene& world, const CameraView& view,
                               const RenderOptions& picture, const std::optional<ErrorTarget>& goal,
                               const ProgressCallback& progress);

/// RMS over the picture of error over target, of the mean of `count` pictures that share their light. Needs a target.
double expected_error(const PictureSampling& sampling, int count);

/// Standard error of each half photosite in its own filter's color, nits, of such a mean; empty without a target.
/// `half_nits` is the radiance that it sees.
Image standard_error(const PictureSampling& sampling, int count, const Image& half_nits);

/// Variance of half photosites that the samples of such a mean leave, without that of light: sum over the picture, over
/// the sum of what `noise` has of it (a ratio at each photosite has no bound where it is black). Needs a target.
double sample_variance(const PictureSampling& sampling, int count, const Image& half_nits, const ErrorTarget& noise);

/// RMS over the picture of a half photosite's error at `picture.samples_per_pixel`, nits over what `white` has of its
/// color, from a few photosites: of the mean of `count` such pictures that share their light.
double measure_error(RenderScene& world, const CameraView& view, const RenderOptions& picture, int count,
                     const std::array<double, 3>& white);

}  // namespace dualpixel::simulator
