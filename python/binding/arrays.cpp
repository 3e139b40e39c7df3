#include "python/binding/arrays.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture/error.h"

namespace dualpixel::python {

Image image_of(const py::object& array, const std::string& name) {
  if (array.is_none()) return {};
  const FloatArray values = FloatArray::ensure(array);
  if (!values) {
    PyErr_Clear();
    throw InputError(name + ": must be an array of numbers");
  }
  if ((values.ndim() != 2 && values.ndim() != 3) || values.size() == 0) {
    throw InputError(
        fmt::format("{}: an array of {} axes and {} values: must have the shape (height, width) or "
                    "(height, width, channels)",
                    name, values.ndim(), values.size()));
  }
  const auto side = [&](py::ssize_t axis) { return static_cast<int>(values.shape(axis)); };
  Image image(side(1), side(0), values.ndim() == 3 ? side(2) : 1);
  std::copy_n(values.data(), image.data.size(), image.data.begin());
  return image;
}

py::object to_python(const nlohmann::ordered_json& json) {
  const std::string text = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  return py::module_::import("json").attr("loads")(text);
}

}  // namespace dualpixel::python
