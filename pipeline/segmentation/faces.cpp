#include "pipeline/segmentation/faces.h"

#include <algorithm>
#include <mutex>

#include "pipeline/segmentation/face_network.h"
#include "pipeline/segmentation/fit.h"

namespace dualpixel::pipeline {
namespace {

constexpr double kLeastScore = 0.5;  // chosen on drawn people (docs/segmentation.md)

/// Nothing in here may wait for TBB's workers: one that waits takes other work, which may come here for the lock.
std::vector<float> face_map(const Image& square) {
  static std::mutex one_at_a_time;
  const std::scoped_lock lock(one_at_a_time);
  static FaceNetwork network;
  return network(square);
}

}  // namespace

std::vector<Face> find_faces(const Image& linear_rgb) {
  const Framed in = framed(linear_rgb, kFacePicture_px, 3);
  const double per_x = static_cast<double>(linear_rgb.width) / in.width;
  const double per_y = static_cast<double>(linear_rgb.height) / in.height;
  std::vector<Face> faces;
  for (const auto& [face, score] :
       faces_of_map(face_map(in.square).data(), kFacePicture_px / kFaceCell_px, kLeastScore)) {
    const double center_x = face.x + face.width / 2 - in.left, center_y = face.y + face.height / 2 - in.top;
    if (!(center_x >= 0 && center_x <= in.width && center_y >= 0 && center_y <= in.height)) continue;
    faces.push_back({(face.x - in.left) * per_x, (face.y - in.top) * per_y, face.width * per_x, face.height * per_y});
  }
  std::stable_sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.area() > b.area(); });
  return faces;
}

}  // namespace dualpixel::pipeline
