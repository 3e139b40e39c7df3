#pragma once
#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "capture/capture.h"

/// What `dualpixel._core` is made of: python/dualpixel/_core.pyi says how Python sees it.
namespace dualpixel::python {

/// A capture that Python holds, with its first frame's views as the normalized signal.
struct HeldCapture {
  explicit HeldCapture(Capture loaded)
      : capture(std::move(loaded)),
        left(normalized(capture.frames.front().left, capture.exposure)),
        right(normalized(capture.frames.front().right, capture.exposure)) {}

  Capture capture;
  Image left, right;
  std::optional<Image> photograph;  ///< the picture, where it was no capture's; `folder` and `hash` are then the file's
  std::vector<std::string> assumed;  ///< of the photograph
  std::string folder, hash;          ///< where it was read or written, and of capture.json there; empty: nowhere yet

  void lies_in(const std::string& path);
};

void bind_captures(pybind11::module_& module);
void bind_simulator(pybind11::module_& module);
void bind_pipeline(pybind11::module_& module);
void bind_evaluation(pybind11::module_& module);

}  // namespace dualpixel::python
