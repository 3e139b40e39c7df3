#include <pybind11/pybind11.h>

#include <exception>

#include "capture/error.h"
#include "python/binding/bind.h"

PYBIND11_MODULE(_core, module) {
  namespace py = pybind11;
  module.attr("__version__") = DUALPIXEL_VERSION;
  // Its class is Python's own, which the reader without this module throws as well.
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const dualpixel::InputError& error) {
      const py::object type = py::module_::import("dualpixel.errors").attr("InputError");
      PyErr_SetString(type.ptr(), error.what());
    }
  });
  dualpixel::python::bind_captures(module);
  dualpixel::python::bind_simulator(module);
  dualpixel::python::bind_pipeline(module);
  dualpixel::python::bind_evaluation(module);
}
