#include "pipeline/segmentation/faces.h"

#include <algorithm>
#include <mutex>

#include "capture/image/display.h"
#include "pipeline/segmentation/face_network.h"
#include "pipeline/segmentation/fit.h"
#include "pipeline/segmentation/network.h"

namespace dualpixel::pipeline {
namespace {

constexpr double kLeastScore = 0.5;  // chosen on drawn people (docs/segmentation.md)

/// A picture in the middle of the network's square.
struct Framed {
  Image square;
  int left, top, width, height;
};

Framed framed(const Image& linear_rgb) {
  const Image small = encode_for_display(fitted(linear_rgb, kFacePicture_px));
  Framed result{Image(kFacePicture_px, kFacePicture_px, 3, -0.5F), (kFacePicture_px - small.width) / 2,
                (kFacePicture_px - small.height) / 2, small.width, small.height};
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      for (int c = 0; c < 3; ++c) result.square.at(result.left + x, result.top + y, c) = small.at(x, y, c) - 0.5F;
    }
  }
  return result;
}

}  // namespace

bool has_face_detector() { return has_person_network(); }

std::vector<Face> find_faces(const Image& linear_rgb) {
  static std::mutex one_at_a_time;
  const std::scoped_lock lock(one_at_a_time);
  static FaceNetwork network;
  return find_faces(linear_rgb, network, kLeastScore);
}

std::vector<Face> find_faces(const Image& linear_rgb, FaceNetwork& network, double least_score) {
  const Framed in = framed(linear_rgb);
  const double per_x = static_cast<double>(linear_rgb.width) / in.width;
  const double per_y = static_cast<double>(linear_rgb.height) / in.height;
  std::vector<Face> faces;
  for (const auto& [face, score] :
       faces_of_map(network(in.square).data(), kFacePicture_px / kFaceCell_px, least_score)) {
    const double center_x = face.x + face.width / 2 - in.left, center_y = face.y + face.height / 2 - in.top;
    if (!(center_x >= 0 && center_x <= in.width && center_y >= 0 && center_y <= in.height)) continue;
    faces.push_back({(face.x - in.left) * per_x, (face.y - in.top) * per_y, face.width * per_x, face.height * per_y});
  }
  std::stable_sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.area() > b.area(); });
  return faces;
}

}  // namespace dualpixel::pipeline
