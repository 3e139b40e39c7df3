#include "pipeline/portrait/subject.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture/error.h"

namespace dualpixel::pipeline {
namespace {

bool centered_in(const Face& face, int width, int height) {
  const double x = face.x + face.width / 2, y = face.y + face.height / 2;
  return x >= 0 && x <= width && y >= 0 && y <= height;
}

void require_in_picture(const char* what, const Face& face, int width, int height) {
  if (face.width > 0 && face.height > 0 && centered_in(face, width, height)) return;
  throw InputError(
      fmt::format("{}: x {:g}, y {:g}, width {:g}, height {:g}: must have an area, and its center in the "
                  "picture of {} x {} pixels",
                  what, face.x, face.y, face.width, face.height, width, height));
}

}  // namespace

Face tapped_region(double x, double y, const Camera& camera) {
  constexpr double kSide = 0.1;  // of the picture's shorter side
  const double side = kSide * std::min(camera.width_px, camera.height_px);
  return {x - side / 2, y - side / 2, side, side};
}

Face transposed(const Face& face) { return {face.y, face.x, face.height, face.width}; }

KnownSubject known_subject(const Capture& capture, const PortraitOptions& options) {
  int width = capture.camera.width_px, height = capture.camera.height_px;
  if (options.transposed) std::swap(width, height);
  KnownSubject known{.faces = options.faces, .tap = options.tap, .source = options.faces.empty() ? "" : "given"};
  for (const Face& face : known.faces) require_in_picture("face", face, width, height);
  if (known.tap) require_in_picture("tap", *known.tap, width, height);
  if (known.faces.empty() && !known.tap && capture.face_px) {
    const auto& [x, y, w, h] = *capture.face_px;
    const Face face = options.transposed ? transposed(Face{x, y, w, h}) : Face{x, y, w, h};
    if (centered_in(face, width, height)) {
      known.faces.push_back(face);
      known.source = "capture";
    } else {
      known.warnings.push_back(fmt::format(
          "the capture's /face_px {:g}, {:g}, {:g}, {:g} has its center outside the picture of {} x {}; not used", x, y,
          w, h, capture.camera.width_px, capture.camera.height_px));
    }
  }
  std::stable_sort(known.faces.begin(), known.faces.end(),
                   [](const Face& a, const Face& b) { return a.area() > b.area(); });
  return known;
}

}  // namespace dualpixel::pipeline
