#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/camera_fit/measurements.h"
#include "simulator/lens/lens_sampler.h"

/// A camera fitted to what was measured on a real one (docs/fit_camera.md).
namespace dualpixel::evaluation {

/// How far a model's figures are from the measured ones: in parts of the grid's root mean square for figures that are
/// `relative`, else as they are.
struct FigureScore {
  std::size_t grid = 0;
  Figure figure = Figure::light;
  struct Errors {
    int count = 0;
    double rms = 0, most = 0, within = 0;  ///< within: share of the places that err by no more than the tolerance
  } fitted, judged;                        ///< at places that the fit used, at the others
};

/// A lens made ready at the focus distance of every grid.
struct PreparedCamera {
  nlohmann::json optics;  ///< the lens but for its split pixel
  std::vector<simulator::LensSampler> at_grid;
};

/// Throws InputError where the lens is none. Where it differs from `like` in the split pixel alone it shares what takes
/// long: a prescription's rays.
PreparedCamera prepare_camera(const CameraMeasurements& measured, const nlohmann::json& lens,
                              const PreparedCamera* like = nullptr);

/// Each figure of a grid as the lens has it, row by row; `samples` rays a place. The light is scaled to fit the
/// measured one best, since its unit is free. NaN where there is no light.
std::vector<std::vector<double>> predict(const CameraMeasurements& measured, const PreparedCamera& camera,
                                         std::size_t grid, int samples);

/// Each figure of each grid against the lens's.
std::vector<FigureScore> score_camera(const CameraMeasurements& measured, const nlohmann::json& lens);

struct FittedValue {
  FittedField field;
  double value = 0;
  std::optional<double> standard_error;  ///< empty at a bound
};

struct CameraFit {
  nlohmann::json lens;
  std::vector<FittedValue> fields;  ///< of the lens that were fitted
  int starts = 0, steps = 0;        ///< steps of all of them together
  double before = 0, after = 0;     ///< mean square error over tolerance of what was fitted
  double after_first = 0;           ///< where the descent from the file's own lens ended
};

/// The lens whose figures are nearest to the measured ones at the fitted places: least squares of errors over their
/// tolerances by Levenberg and Marquardt's method (Marquardt 1963, with Nielsen's 1999 rule for the damping), within
/// the bounds, from the lens of the file and from the best few of points all over the bounds. The first minimum is kept
/// unless another is lower by a tenth. The same result for any number of threads.
CameraFit fit_camera(const CameraMeasurements& measured);

/// The camera as a file that a scene may name (docs/scene.md), to be written to `path`.
nlohmann::ordered_json camera_json(const CameraMeasurements& measured, const nlohmann::json& lens,
                                   const std::string& path);

/// The fit and its fields as lines of text.
std::string to_text(const CameraFit& fit);

/// A line for each figure that errs by much more than its tolerance at the places that judge.
std::vector<std::string> warnings_of(const std::vector<FigureScore>& scores);

/// The scores as lines of text.
std::string to_text(const std::vector<FigureScore>& scores);

}  // namespace dualpixel::evaluation
