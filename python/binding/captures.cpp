#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/folder/capture_json.h"
#include "pipeline/portrait/photograph.h"
#include "python/binding/arrays.h"
#include "python/binding/bind.h"

namespace dualpixel::python {
namespace {

using Holder = std::shared_ptr<HeldCapture>;

/// A read-only property that shows an image of `Owner`.
template <typename Owner, typename Pixel>
void show(py::class_<Owner, std::shared_ptr<Owner>>& type, const char* name, ImageOf<Pixel> Owner::*image) {
  type.def_property_readonly(
      name, [image](const py::object& self) { return view_of(self.cast<const Owner&>().*image, self); });
}

py::object camera_of(const HeldCapture& held) {
  py::object camera = to_python(to_json(held.capture.camera));
  camera["focus_distance_m"] = held.capture.camera.focus_distance_m;  // JSON has no infinity
  return camera;
}

void bind_frame(py::module_& module) {
  py::class_<Frame, std::shared_ptr<Frame>> frame(module, "Frame");
  show(frame, "mosaic", &Frame::mosaic);
  show(frame, "left", &Frame::left);
  show(frame, "right", &Frame::right);
  frame.def_readonly("seed", &Frame::seed);
  frame.def_property_readonly("camera_from_world", [](const Frame& self) {
    return py::array_t<double>(std::vector<py::ssize_t>{4, 4}, self.camera_from_world.data());
  });
}

void bind_truth(py::module_& module) {
  py::class_<Truth, std::shared_ptr<Truth>> truth(module, "Truth");
  show(truth, "depth", &Truth::depth_m);
  show(truth, "blur", &Truth::blur_px);
  show(truth, "disparity", &Truth::disparity_dp_px);
  show(truth, "normal", &Truth::normal);
  show(truth, "object_id", &Truth::object_id);
  show(truth, "person_mask", &Truth::person_mask);
  show(truth, "valid", &Truth::valid);
  show(truth, "all_in_focus", &Truth::all_in_focus);
  show(truth, "photograph", &Truth::photograph);
  show(truth, "left", &Truth::left);
  show(truth, "right", &Truth::right);
  truth.def_readonly("photograph_aperture_scale", &Truth::photograph_aperture_scale);
  truth.def_property_readonly("motion", [](const py::object& self) {
    py::list motion;
    for (const Image& image : self.cast<const Truth&>().motion) motion.append(view_of(image, self));
    return motion;
  });
}

}  // namespace

void HeldCapture::lies_in(const std::string& path) {
  folder = std::filesystem::absolute(path).lexically_normal().string();
  hash = file_hash(folder + "/capture.json");
}

void bind_captures(py::module_& module) {
  bind_frame(module);
  bind_truth(module);
  py::class_<HeldCapture, Holder> capture(module, "Capture");
  capture.def(py::init([](const std::filesystem::path& path, bool truth) {
                const py::gil_scoped_release released;
                std::error_code unreadable;  // then it is no photograph, and the capture's reader says why
                if (std::filesystem::is_regular_file(path, unreadable)) {
                  pipeline::Photograph photograph = pipeline::read_photograph(path.string());
                  auto held = std::make_shared<HeldCapture>(std::move(photograph.capture));
                  held->photograph = std::move(photograph.picture);
                  held->assumed = std::move(photograph.assumed);
                  held->folder = std::filesystem::absolute(path).lexically_normal().string();
                  held->hash = file_hash(held->folder);
                  return held;
                }
                auto held = std::make_shared<HeldCapture>(read_capture(path.string(), truth));
                held->lies_in(path.string());
                return held;
              }),
              py::arg("path"), py::arg("truth") = true);
  show(capture, "left", &HeldCapture::left);
  show(capture, "right", &HeldCapture::right);
  capture.def_property_readonly("frames", [](const Holder& self) {
    std::vector<std::shared_ptr<Frame>> frames;
    for (Frame& frame : self->capture.frames) frames.emplace_back(self, &frame);
    return frames;
  });
  capture.def_property_readonly("truth", [](const Holder& self) {
    return self->capture.truth ? std::shared_ptr<Truth>(self, &*self->capture.truth) : nullptr;
  });
  capture.def_property_readonly("camera", camera_of);
  capture.def_property_readonly("exposure",
                                [](const HeldCapture& self) { return to_python(to_json(self.capture.exposure)); });
  capture.def_property_readonly("face_px", [](const HeldCapture& self) { return self.capture.face_px; });
  capture.def_property_readonly(
      "provenance", [](const HeldCapture& self) { return to_python(to_json(self.capture.provenance, "capture")); });
  capture.def(
      "write",
      [](HeldCapture& self, const std::filesystem::path& path) {
        if (self.photograph) throw InputError(printable(self.folder) + ": is a photograph, no capture to be written");
        write_capture(self.capture, path.string());
        self.lies_in(path.string());
      },
      py::arg("path"), py::call_guard<py::gil_scoped_release>());
}

}  // namespace dualpixel::python
