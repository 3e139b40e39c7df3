#include "pipeline/segmentation/faces.h"

#ifdef DUALPIXEL_DLIB
#include <dlib/image_processing/frontal_face_detector.h>

#include <algorithm>
#include <cmath>

#include "capture/image/display.h"
#include "pipeline/segmentation/fit.h"

namespace dualpixel::pipeline {
namespace {

constexpr int kDetectorSize_px = 640;

/// Luma of the picture as a display would show it, `longer_side_px` on its longer side.
dlib::array2d<unsigned char> gray_picture(const Image& linear_rgb, int longer_side_px) {
  const Image srgb = encode_for_display(fitted(linear_rgb, longer_side_px));
  dlib::array2d<unsigned char> gray(srgb.height, srgb.width);
  for (int y = 0; y < srgb.height; ++y) {
    for (int x = 0; x < srgb.width; ++x) {
      const float luma = 0.299F * srgb.at(x, y, 0) + 0.587F * srgb.at(x, y, 1) + 0.114F * srgb.at(x, y, 2);
      gray[y][x] = static_cast<unsigned char>(std::lround(255 * luma));
    }
  }
  return gray;
}

}  // namespace

bool has_face_detector() { return true; }

std::vector<Face> find_faces(const Image& linear_rgb) {
  static const dlib::frontal_face_detector kDetector = dlib::get_frontal_face_detector();  // 0.3 s to unpack
  dlib::frontal_face_detector detector = kDetector;
  std::vector<Face> faces;
  for (const int size_px : {kDetectorSize_px, 2 * kDetectorSize_px}) {
    const dlib::array2d<unsigned char> gray = gray_picture(linear_rgb, size_px);
    const double per_x = static_cast<double>(linear_rgb.width) / static_cast<double>(gray.nc());
    const double per_y = static_cast<double>(linear_rgb.height) / static_cast<double>(gray.nr());
    for (const dlib::rectangle& box : detector(gray)) {
      faces.push_back({static_cast<double>(box.left()) * per_x, static_cast<double>(box.top()) * per_y,
                       static_cast<double>(box.width()) * per_x, static_cast<double>(box.height()) * per_y});
    }
    if (!faces.empty()) break;
  }
  std::stable_sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.area() > b.area(); });
  return faces;
}

}  // namespace dualpixel::pipeline

#else
#include "capture/error.h"

namespace dualpixel::pipeline {

bool has_face_detector() { return false; }

std::vector<Face> find_faces(const Image&) {
  throw InputError("face detector: this build has no dlib; name the face, or install libdlib-dev and build again");
}

}  // namespace dualpixel::pipeline

#endif
