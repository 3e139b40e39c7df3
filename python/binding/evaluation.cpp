#include <nlohmann/json.hpp>

#include "evaluation/metrics/scoring.h"
#include "python/binding/arrays.h"
#include "python/binding/bind.h"

namespace dualpixel::python {
namespace {

py::object score_arrays(const HeldCapture& held, const py::object& disparity, const py::object& confidence,
                        const py::object& sigma, const py::object& portrait) {
  const evaluation::Estimate estimate{image_of(disparity, "disparity"), image_of(confidence, "confidence"),
                                      image_of(sigma, "sigma"), image_of(portrait, "portrait")};
  nlohmann::ordered_json json;
  {
    const py::gil_scoped_release released;
    json = evaluation::to_json(evaluation::score_estimate(held.capture, "capture", estimate));
  }
  json.erase("capture");  // a path, of which there is none
  return to_python(json);
}

}  // namespace

void bind_evaluation(py::module_& module) {
  module.def("score", score_arrays, py::arg("capture"), py::arg("disparity"), py::arg("confidence"), py::arg("sigma"),
             py::arg("portrait"));
}

}  // namespace dualpixel::python
