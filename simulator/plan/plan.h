#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "simulator/plan/steps.h"
#include "simulator/scene/scene.h"
#include "simulator/scene_file.h"

/// "Model no more than a scene needs": the cheapest lens model, bounce count, spacing and samples of light at points,
/// effects (effects.h) and sample count whose disparity errors, added in quadrature, stay within a tolerance, in DP px
/// RMS over the picture. The reference has everything on: the most accurate model of the scene's lens, 8 bounces,
/// points of light without end (light sampled by every path where the scene file has none), all effects, endless
/// samples.
///
/// Lens models, from the most accurate: exact trace of the prescription, its polynomials, its aberrated twin, the thin
/// lens; an aberrated lens has only itself and the thin lens. Their error is traced, not rendered: disparity at the
/// same point of the sensor, for the depth that the scene has there, against the reference's (DisparityCoefficients),
/// RMS over 432 field points. What else a cheaper model changes (LensDifferences) is shown and does not count: truth
/// moves with a displaced picture, and who needs the light, the blur or the colors of a lens asks for its model.
///
/// Bounces, light, effects and samples are measured on pilot renders of tiles spread over the frame (the whole sensor,
/// where it is small), through the most accurate model short of the exact trace, without effects, by what they do to a
/// matcher (simulator/plan/match_error.h) in windows that have texture.
///   Samples  renders that differ by their seeds alone scatter by their error. Measured at 16 and 64 samples with
///            8 bounces, and scaled to fewer bounces that have more noise at 16; from there on to the next it is taken
///            to fall as 1/sqrt(samples), the least that sampling does, but for the part that light at points has: it
///            is measured by renders that differ in nothing else, and falls with the samples of each point alone. The
///            windows are made of two more renders: one that a window is made of matches it too well.
///   Bounces  two pairs of renders, n bounces and 8 with the same random numbers; the mean product of the two pairs'
///            differences is the mean square of what is no noise. A window whose two pictures correlate by less than
///            0.8 cannot be matched: it is lost and counts as an error of 1 DP px.
///   Effects  likewise, each added by itself, without bounces. Of things that move by themselves no effect is measured.
///   Light    likewise, points twice as far apart as the scene file has them against those. Interpolation errs with the
///            square of the distance: of their difference, 4/3 is the error of the one and 1/3 that of the other.
///            Half as far apart is offered too, by the same law: a twelfth. The noise of light doubles with the
///            distance, and is halved by four times as many samples of each point. All this is measured with 8 bounces
///            and, where every window can be matched without any, with none; the worse counts.
/// Three standard errors, from the scatter over the windows, are added to each mean square. Windows count whose
/// disparity the capture's own sensor noise, its burst merged, blurs by no more than the tolerance. Where fewer than 6
/// windows have texture, up to four times as many are looked at, unless the whole sensor already is; where fewer than 6
/// still have, bounces, light, effects and samples stay as the scene file has them, and the plan says so.
///
/// Where nothing keeps the tolerance, the plan is the cheapest within a tenth of the least error that there is: it may
/// take far less than that of a tolerance that can just be kept.
///
/// The choice is by the time that the pilots took on this machine, in steps of a factor of sqrt(2), so that it is
/// rarely another one the next time: the plan that a capture was made with is kept in it. Times are for the left and
/// right view of the full sensor, in one frame. Where effects cost the same, those of the scene file are chosen.
namespace dualpixel::simulator {

/// One step of each kind.
struct PlanChoice {
  std::size_t lens = 0, bounce = 0, light = 0, light_samples = 0;
  std::vector<bool> effects;  ///< which of Plan::effects are simulated
  std::size_t sample = 0;
};

struct Plan {
  double tolerance_dp_px = 0;
  std::uint64_t seed = 0;
  std::vector<LensStep> lenses;     ///< from the cheapest to the reference
  std::vector<BounceStep> bounces;  ///< likewise; as the scene file has it alone where `windows_textured` is too few
  std::vector<LightStep> lights;    ///< likewise
  std::vector<LightSampleStep> light_samples;  ///< likewise
  std::vector<EffectStep> effects;             ///< all that the simulation can have
  std::vector<SampleStep> samples;             ///< powers of two, from 16 to beyond the chosen
  PlanChoice chosen;
  std::size_t pilot_lens = 0;  ///< through which the pilots were rendered
  int windows = 0, windows_textured = 0;
  double photosites = 0;
  int frames = 1;        ///< of the burst, that are rendered each by itself
  bool measured = true;  ///< bounces, light, effects and samples; otherwise left as the scene file has them
  bool met = true;       ///< the tolerance is; otherwise the choice is within a tenth of the least error

  double error_dp_px(const PlanChoice& choice) const;
  double picture_s(const PlanChoice& choice) const;
};

/// Throws InputError where the sensor is smaller than a window, and where the lens or the camera cannot be used.
/// Progress is of the pilot renders.
Plan plan(const Simulation& simulation, const Scene& scene, double tolerance_dp_px, std::uint64_t seed,
          const ProgressCallback& progress = {});

/// The same simulation with the plan's choice; a measured one replaces all that the scene file says of
/// samples.
Simulation planned(const Simulation& file, const Plan& plan);

}  // namespace dualpixel::simulator
