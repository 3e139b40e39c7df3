#include "evaluation/camera_fit/measurements.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "simulator/lens/lens_file.h"
#include "simulator/scene_file.h"

namespace dualpixel::evaluation {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostPlaces = 1024;  ///< along one side of a grid
constexpr std::size_t kMostGrids = 64, kMostFitted = 64;

/// Rows of numbers, null where nothing was measured.
std::vector<double> read_rows(Fields& grid, const FigureRow& figure, std::size_t columns, std::size_t rows) {
  const nlohmann::json& table = grid.raw(figure.name);
  if (!table.is_array() || table.size() != rows) {
    grid.fail(figure.name, fmt::format("must have {} rows, one for each number of y", rows));
  }
  std::vector<double> values;
  for (const nlohmann::json& row : table) {
    if (!row.is_array() || row.size() != columns) {
      grid.fail(figure.name, fmt::format("each row must have {} numbers, one for each number of x", columns));
    }
    for (const nlohmann::json& cell : row) {
      const double value = cell.is_number() ? cell.get<double>() : std::numeric_limits<double>::quiet_NaN();
      if (!cell.is_null() && !(value >= figure.low && value <= figure.high)) {
        grid.fail(figure.name,
                  fmt::format("{}: must be null or a number in [{:g}, {:g}]", cell.dump(), figure.low, figure.high));
      }
      values.push_back(value);
    }
  }
  return values;
}

MeasuredGrid read_grid(Fields grid) {
  MeasuredGrid g;
  grid.required("focus_distance_m").number("focus_distance_m", g.focus_distance_m, 1e-3, kInfinite);
  grid.number("depth_m", g.depth_m, 1e-3, kInfinite);
  grid.number("unit_um", g.unit_um, 1e-3, 1e4);
  grid.required("x").list("x", g.x, 0, 1, kMostPlaces);
  grid.required("y").list("y", g.y, 0, 1, kMostPlaces);
  for (const auto& [key, places] : {std::pair{"x", &g.x}, {"y", &g.y}}) {
    if (places->empty()) grid.fail(key, "must have at least one number");
  }
  for (const FigureRow& figure : kFigures) {
    if (!grid.has(figure.name)) continue;
    g.figures.push_back({figure.value, read_rows(grid, figure, g.x.size(), g.y.size())});
    const bool of_a_target = figure.value != Figure::light && figure.value != Figure::left_share;
    if (of_a_target) grid.required("depth_m");
    if (of_a_target && figure.relative) grid.required("unit_um");
  }
  grid.done();
  return g;
}

/// Whether the grid has a figure that is fitted at one of the places that are.
bool has_fitted_figure(const MeasuredGrid& grid) {
  return std::any_of(grid.figures.begin(), grid.figures.end(), [&](const MeasuredGrid::Values& figure) {
    if (!row_of(kFigures, figure.figure).fitted) return false;
    for (std::size_t i = 0; i < figure.values.size(); ++i) {
      if (!std::isnan(figure.values[i]) && is_fitted_place(i % grid.x.size(), i / grid.x.size())) return true;
    }
    return false;
  });
}

FittedField read_fitted(Fields fields, const nlohmann::json& lens) {
  FittedField f;
  fields.required("field").text("field", f.pointer);
  fields.required("low").number("low", f.low, -1e9, 1e9);
  fields.required("high").number("high", f.high, -1e9, 1e9);
  fields.done();
  if (!(f.low < f.high)) fields.fail("high", fmt::format("{}: must be above low, {}", f.high, f.low));
  double start = 0;
  try {
    start = lens.at(nlohmann::json::json_pointer(f.pointer)).get<double>();
  } catch (const nlohmann::json::exception&) {
    fields.fail("field", printable(f.pointer) + ": must be the JSON pointer of a number of the lens, as /split/k");
  }
  if (!(start >= f.low && start <= f.high)) {
    fields.fail("field",
                fmt::format("{}: starts at {}, outside of [{}, {}]", printable(f.pointer), start, f.low, f.high));
  }
  return f;
}

/// Each bound must be a number that the lens may have there, the other fields as they start.
void check_bounds(const CameraMeasurements& m) {
  for (std::size_t i = 0; i < m.fit.size(); ++i) {
    for (const auto& [name, bound] : {std::pair{"low", m.fit[i].low}, {"high", m.fit[i].high}}) {
      nlohmann::json lens = m.lens;
      lens[nlohmann::json::json_pointer(m.fit[i].pointer)] = bound;
      try {
        simulator::read_lens(lens, m.path, "/lens", m.grids.front().focus_distance_m);
      } catch (const InputError& error) {
        const std::string file = printable(m.path) + ": ", what = error.what();
        throw InputError(fmt::format("{}/fit/{}/{}: {}: no lens may have it: {}", file, i, name, bound,
                                     what.starts_with(file) ? what.substr(file.size()) : what));
      }
    }
  }
}

/// Where the target is in focus, what disparity there is comes from aberrations alone.
void warn_of_focus(CameraMeasurements& m) {
  for (std::size_t i = 0; i < m.grids.size(); ++i) {
    const MeasuredGrid& grid = m.grids[i];
    const bool disparity = std::any_of(grid.figures.begin(), grid.figures.end(),
                                       [](const auto& f) { return f.figure == Figure::disparity; });
    if (!disparity || grid.depth_m != grid.focus_distance_m) continue;
    m.warnings.push_back(
        fmt::format("{}: /grids/{}/depth_m: {}: is the focus distance, where a lens has no disparity "
                    "but that of its aberrations",
                    printable(m.path), i, grid.depth_m));
  }
}

}  // namespace

CameraMeasurements read_camera_measurements(const nlohmann::json& json, const std::string& path) {
  CameraMeasurements m;
  m.path = path;
  Fields root(json, path);
  int version = 1;
  root.required("version").integer("version", version, 1, 1);
  root.text("name", m.name);
  root.text("source", m.source);
  root.text("derived", m.derived);
  root.required("lens");
  m.lens = root.raw("lens");
  m.sensor_json = root.has("sensor") ? root.raw("sensor") : nlohmann::json::object();
  m.sensor = simulator::read_sensor(root.object("sensor"));
  require_valid(within("sensor", check(m.sensor)), path);
  for (Fields& fields : root.required("fit").objects("fit")) {
    const FittedField& field = m.fit.emplace_back(read_fitted(fields, m.lens));
    if (std::count_if(m.fit.begin(), m.fit.end(), [&](const FittedField& f) { return f.pointer == field.pointer; }) >
        1) {
      fields.fail("field", printable(field.pointer) + ": is named before: must be named once");
    }
  }
  for (Fields& fields : root.required("grids").objects("grids")) {
    m.grids.push_back(read_grid(fields));
    simulator::read_lens(m.lens, path, "/lens", m.grids.back().focus_distance_m);
  }
  if (m.fit.empty() || m.fit.size() > kMostFitted) {
    root.fail("fit", fmt::format("must have 1 to {} fields", kMostFitted));
  }
  if (m.grids.empty() || m.grids.size() > kMostGrids) {
    root.fail("grids", fmt::format("must have 1 to {} grids", kMostGrids));
  }
  if (std::none_of(m.grids.begin(), m.grids.end(), has_fitted_figure)) {
    root.fail("grids",
              "no figure at a place that is fitted: must have one that does not only judge, where column + row, "
              "counted from 0, is even");
  }
  root.done();
  check_bounds(m);
  warn_of_focus(m);
  return m;
}

}  // namespace dualpixel::evaluation
