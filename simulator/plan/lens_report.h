#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "simulator/lens/disparity_field.h"
#include "simulator/lens/lens.h"
#include "simulator/lens/prescription/lens_analysis.h"
#include "simulator/sampling/sensor_grid.h"

/// Everything that `dualpixel lens` says about a lens, worked out once for the terminal, for programs and for the page
/// (evaluation/report/lens_page.h).
namespace dualpixel::simulator {

/// What a lens file may say about its source; longer text is cut.
inline constexpr std::size_t kLongestNoteBytes = 2000;

/// The polynomials of a prescription against its exact trace, at one distance from the axis.
struct FastFormError {
  double field = 0;   ///< of the sensor's half diagonal
  double rms_px = 0;  ///< of single rays, as lengths on the sensor, photosites
  double largest_px = 0;
  double disagreeing = 0;      ///< share of rays that only one of the two blocks
  double disparity_dp_px = 0;  ///< at infinity, what rendering is about
};

/// A field point on one of the sensor's middle lines.
struct CutPoint {
  double field = 0;  ///< from the center, in half widths (or half heights)
  DisparityCoefficients coefficients;
  double alpha = 0;  ///< centroid disparity in photosites over signed blur diameter; 0 where there is no blur
};

struct LensReport {
  Lens lens;
  SensorGrid sensor;
  std::vector<FieldAnalysis> fields;    ///< of a prescription focused on infinity
  std::vector<double> field_of_radius;  ///< their chief rays' heights over the image radius
  std::vector<CutPoint> horizontal, vertical;
  std::vector<FastFormError> fast_form;
  std::vector<std::string> warnings;
};

/// A sensor for the lens, its center on the axis. Pitch 0: it fills the lens's picture, or 1.4 um where the lens has
/// none of its own.
SensorGrid sensor_for(const Lens& lens, int width_px, int height_px, double pixel_pitch_um);

LensReport report_lens(const Lens& lens, const SensorGrid& sensor);

/// What may differ from what a file says. Empty: what it says; where it says nothing, a focus distance of 1 m and a
/// sensor of 2688 x 2016 photosites that fills the lens's picture.
struct LensView {
  std::optional<double> focus_distance_m;
  std::optional<int> width_px, height_px;
  std::optional<double> pixel_pitch_um;
};

inline constexpr double kNearestLensFocus_m = 0.001;
inline constexpr int kLensViewSide_px[] = {2, 32768};
inline constexpr double kLensViewPitch_um[] = {0.1, 1000};

/// The same of a lens file, or of the lens and sensor of a camera file or a scene; `json` came from `path`. Throws
/// InputError.
LensReport report_lens(const nlohmann::json& json, const std::string& path, const LensView& view);

nlohmann::ordered_json to_json(const LensReport& report);
std::string to_text(const LensReport& report);

}  // namespace dualpixel::simulator
