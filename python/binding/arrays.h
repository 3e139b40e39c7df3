#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "capture/image/image.h"

/// Between this library's images and NumPy's arrays of shape (height, width) or (height, width, channels).
namespace dualpixel::python {

namespace py = pybind11;

/// The image's own memory as an array, kept alive by `owner`; read-only where asked. None where it is empty.
template <typename T>
py::object view_of(const ImageOf<T>& image, const py::handle& owner, bool writable = false) {
  if (image.empty()) return py::none();
  std::vector<py::ssize_t> shape = {image.height, image.width};
  if (image.channels > 1) shape.push_back(image.channels);
  py::array_t<T> array(std::move(shape), image.data.data(), owner);
  if (!writable) array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// The image as an array that owns it. None where it is empty.
template <typename T>
py::object moved_to_array(ImageOf<T> image) {
  auto owned = std::make_unique<ImageOf<T>>(std::move(image));
  const ImageOf<T>& kept = *owned;
  const py::capsule owner(owned.release(), [](void* pointer) { delete static_cast<ImageOf<T>*>(pointer); });
  return view_of(kept, owner, true);
}

/// What a function takes: any array that NumPy turns into float32.
using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// A copy; an empty image of None. Throws InputError, that begins with `name`, for an array of another number of axes.
Image image_of(const py::object& array, const std::string& name);

/// JSON as Python's dict, list, ...
py::object to_python(const nlohmann::ordered_json& json);

}  // namespace dualpixel::python
