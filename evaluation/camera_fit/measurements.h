#pragma once
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "simulator/lens/lens.h"
#include "simulator/sensor/sensor.h"

/// Figures that were measured on a real camera, as docs/fit_camera.md describes their file.
namespace dualpixel::evaluation {

/// What can be measured at a place of the field. Lengths are in the grid's pixels, `unit_um` each.
enum class Figure {
  light,
  left_share,
  disparity,
  left_sigma_x,
  right_sigma_x,
  left_sigma_y,
  right_sigma_y,
  left_skew_x,
  right_skew_x,
  sum_sigma_ratio
};

struct FigureRow {
  const char* name;  ///< in measurement files
  const char* description;
  double low, high;
  double tolerance;  ///< an error of one unit in the fit
  Figure value;
  bool relative;  ///< errors count in parts of the grid's root mean square, otherwise as they are
  bool fitted;    ///< others only judge
};
inline constexpr double kLongest_px = 1e5;
inline constexpr FigureRow kFigures[] = {
    {"light", "of both views; any unit, the same over a grid", 0, 1e12, 0.02, Figure::light, true, true},
    {"left_share", "of the light of both views", 0, 1, 0.02, Figure::left_share, false, true},
    {"disparity_px", "right centroid minus left", -kLongest_px, kLongest_px, 0.04, Figure::disparity, true, true},
    {"left_sigma_x_px", "width of the left kernel", 0, kLongest_px, 0.06, Figure::left_sigma_x, true, true},
    {"right_sigma_x_px", "width of the right kernel", 0, kLongest_px, 0.06, Figure::right_sigma_x, true, true},
    {"left_sigma_y_px", "height of the left kernel", 0, kLongest_px, 0.06, Figure::left_sigma_y, true, true},
    {"right_sigma_y_px", "height of the right kernel", 0, kLongest_px, 0.06, Figure::right_sigma_y, true, true},
    {"left_skew_x", "skew of the left kernel", -100, 100, 0.1, Figure::left_skew_x, false, false},
    {"right_skew_x", "skew of the right kernel", -100, 100, 0.1, Figure::right_skew_x, false, false},
    {"sum_sigma_ratio", "sigma_x over sigma_y of both kernels", 0, 100, 0.06, Figure::sum_sigma_ratio, false, false},
};

/// Figures at the places of one grid, with one focus and one depth.
struct MeasuredGrid {
  double focus_distance_m = 1;
  double depth_m = 1;        ///< of the target, from the entrance pupil; infinity is allowed
  double unit_um = 1;        ///< length of a pixel of the figures
  std::vector<double> x, y;  ///< places as parts of the picture's width and height, from the top left
  struct Values {
    Figure figure;
    std::vector<double> values;  ///< row by row; NaN: none at this place
  };
  std::vector<Values> figures;
};

/// Whether the fit uses a place: every second one, as on a chess board.
inline bool is_fitted_place(std::size_t column, std::size_t row) { return (column + row) % 2 == 0; }

/// A number of the lens that the fit may change.
struct FittedField {
  std::string pointer;  ///< JSON pointer inside `lens`
  double low = 0, high = 0;
};

struct CameraMeasurements {
  std::string path;  ///< of the file
  std::string name, source, derived;
  nlohmann::json lens;         ///< to start from
  nlohmann::json sensor_json;  ///< as it stands
  simulator::SensorOptions sensor;
  std::vector<FittedField> fit;
  std::vector<MeasuredGrid> grids;
  std::vector<std::string> warnings;  ///< a line for each thing that can be, but is seldom meant
};

/// Throws InputError: unknown fields, values out of range, grids of another size than their places, none with a figure
/// that is fitted, fields of the fit that are no number of the lens, lie outside of their bounds or are named twice.
CameraMeasurements read_camera_measurements(const nlohmann::json& json, const std::string& path);

}  // namespace dualpixel::evaluation
