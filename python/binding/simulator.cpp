#include <pybind11/stl.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "python/binding/arrays.h"
#include "python/binding/bind.h"
#include "scenes/framing/resolve_scene.h"
#include "scenes/framing/scene_document.h"
#include "simulator/lens/lens_file.h"
#include "simulator/plan/lens_report.h"
#include "simulator/ready_scene.h"
#include "simulator/simulate.h"

namespace dualpixel::python {
namespace {

/// A document of the caller's: `text`, or the file `path` where that is empty; with its overrides.
nlohmann::json document_of(const std::string& text, const std::string& path,
                           const std::vector<std::string>& overrides) {
  nlohmann::json json = text.empty() ? scenes::read_scene_document(path) : parse_json(text, path);
  simulator::apply_overrides(json, overrides);
  return json;
}

/// `progress` may be None. Ctrl-C ends the work at the next report.
simulator::StageCallback reporting_to(const py::object& progress) {
  return [&progress](const std::string& stage, double fraction) {
    const py::gil_scoped_acquire acquired;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!progress.is_none()) progress(stage, fraction);
  };
}

Capture render_scene(const std::string& text, const std::string& path, const std::vector<std::string>& overrides,
                     const simulator::StageCallback& report, std::vector<std::string>& warnings) {
  std::unique_ptr<simulator::ReadyScene> ready;
  const simulator::Simulation simulation = simulator::read_simulation(
      scenes::resolve_scene(document_of(text, path, overrides), path, ready, warnings), path);
  make_ready(simulation, ready);
  for (const std::string& warning : simulator::warnings_of(simulation)) warnings.push_back(warning);
  warnings.insert(warnings.end(), ready->scene.warnings.begin(), ready->scene.warnings.end());
  Capture capture =
      simulator::simulate(simulation, ready->world, simulator::place_camera(simulation, ready->scene), report);
  capture.provenance.program = "dualpixel " DUALPIXEL_VERSION;
  if (text.empty()) capture.provenance.scene_file = std::filesystem::path(path).filename().string();
  capture.provenance.gltf_xxh64 = ready->gltf_xxh64;
  return capture;
}

std::shared_ptr<HeldCapture> simulate_scene(const std::string& text, const std::string& path,
                                            const std::vector<std::string>& overrides, const py::object& progress) {
  const simulator::StageCallback report = reporting_to(progress);
  std::vector<std::string> warnings;
  std::shared_ptr<HeldCapture> held;
  {
    const py::gil_scoped_release released;
    held = std::make_shared<HeldCapture>(render_scene(text, path, overrides, report, warnings));
  }
  for (const std::string& warning : warnings) {
    if (PyErr_WarnEx(PyExc_UserWarning, warning.c_str(), 1) != 0) throw py::error_already_set();
  }
  return held;
}

py::object report_on_lens(const std::string& text, const std::string& path, const std::vector<std::string>& overrides,
                          std::optional<double> focus_distance_m, std::optional<int> width_px,
                          std::optional<int> height_px, std::optional<double> pixel_pitch_um) {
  nlohmann::ordered_json report;
  {
    const py::gil_scoped_release released;
    report = to_json(simulator::report_lens(document_of(text, path, overrides), path,
                                            {focus_distance_m, width_px, height_px, pixel_pitch_um}));
  }
  return to_python(report);
}

}  // namespace

void bind_simulator(py::module_& module) {
  module.def("simulate", simulate_scene, py::arg("text"), py::arg("path"), py::arg("overrides"), py::arg("progress"));
  module.def("lens", report_on_lens, py::arg("text"), py::arg("path"), py::arg("overrides"),
             py::arg("focus_distance_m"), py::arg("width_px"), py::arg("height_px"), py::arg("pixel_pitch_um"));
}

}  // namespace dualpixel::python
