#pragma once
#include <optional>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "pipeline/portrait/options.h"

/// Where the subject is, as far as it is known before the picture is analyzed.
namespace dualpixel::pipeline {

struct KnownSubject {
  std::vector<Face> faces;  ///< largest first
  std::optional<Face> tap;
  std::string source;                 ///< of the faces: "given", "capture", or "" where there are none
  std::vector<std::string> warnings;  ///< for people
};

/// The options' faces and tap; where they name neither, Capture::face_px, unless its center lies outside the picture.
/// In pixels of the upright picture. Throws InputError where a face or the tap has its center outside the picture or no
/// area.
KnownSubject known_subject(const Capture& capture, const PortraitOptions& options);

/// The square that a tap at (x, y) stands for: a tenth of the picture's shorter side, about as large as a face.
Face tapped_region(double x, double y, const Camera& camera);

/// The face in the picture with its axes exchanged.
Face transposed(const Face& face);

}  // namespace dualpixel::pipeline
