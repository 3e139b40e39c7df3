#include "pipeline/segmentation/person_mask.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/error.h"
#include "pipeline/segmentation/fit.h"
#include "pipeline/segmentation/network.h"

namespace dualpixel::pipeline {
namespace {

constexpr double kFaceSigma_px = 21;  // section 3.2

/// Sets the fourth channel; the face is in pixels of `linear`.
void set_face(Framed& in, const Face& face, const Image& linear) {
  const double center_x = face.x + face.width / 2, center_y = face.y + face.height / 2;
  if (!(center_x >= 0 && center_x <= linear.width && center_y >= 0 && center_y <= linear.height)) {
    throw InputError("face: its center must lie in the picture");
  }
  const double x = in.left + center_x * in.width / linear.width, y = in.top + center_y * in.height / linear.height;
  std::array<float, kNetworkSize_px> across{}, down{};  // the Gaussian is a product of the two
  for (int i = 0; i < kNetworkSize_px; ++i) {
    const double dx = i + 0.5 - x, dy = i + 0.5 - y;
    across[i] = static_cast<float>(std::exp(-dx * dx / (2 * kFaceSigma_px * kFaceSigma_px)));
    down[i] = static_cast<float>(std::exp(-dy * dy / (2 * kFaceSigma_px * kFaceSigma_px)));
  }
  for (int row = 0; row < kNetworkSize_px; ++row) {
    for (int column = 0; column < kNetworkSize_px; ++column) in.square.at(column, row, 3) = across[column] * down[row];
  }
}

}  // namespace

OptionFields fields(SeedOptions& options) {
  return {{"least_of_largest", &options.least_of_largest, 0, 1, "area of the largest", "3.3: 1/3"},
          {"least_of_picture", &options.least_of_picture, 0, 1, "area of the picture", "3.3: 0.013 of larger boxes"}};
}

std::vector<Face> seed_faces(const std::vector<Face>& faces, int width_px, int height_px, const SeedOptions& options) {
  double largest = 0;
  for (const Face& face : faces) largest = std::max(largest, face.area());
  std::vector<Face> seeds;
  for (const Face& face : faces) {
    const bool large = face.area() >= options.least_of_largest * largest &&
                       face.area() > options.least_of_picture * width_px * height_px;
    if (large) seeds.push_back(face);
  }
  return seeds;
}

Image network_input(const Image& linear_rgb, const Face& face) {
  Framed in = framed(linear_rgb, kNetworkSize_px, 4);
  set_face(in, face, linear_rgb);
  return in.square;
}

Image person_mask(const Image& linear_rgb, const std::vector<Face>& faces, PersonNetwork& network) {
  Framed in = framed(linear_rgb, kNetworkSize_px, 4);
  Image joined(in.width, in.height);
  for (const Face& face : faces) {
    set_face(in, face, linear_rgb);
    const Image mask = network(in.square);
    for (int y = 0; y < in.height; ++y) {
      for (int x = 0; x < in.width; ++x) joined.at(x, y) = std::max(joined.at(x, y), mask.at(in.left + x, in.top + y));
    }
  }
  return joined;
}

FoundPeople find_people(const Image& linear_rgb, const std::vector<Face>& given, PersonNetwork& network,
                        const SeedOptions& options) {
  FoundPeople found;
  found.detected = given.empty() ? find_faces(linear_rgb) : given;
  std::stable_sort(found.detected.begin(), found.detected.end(),
                   [](const Face& a, const Face& b) { return a.area() > b.area(); });
  found.faces =
      given.empty() ? seed_faces(found.detected, linear_rgb.width, linear_rgb.height, options) : found.detected;
  if (!found.faces.empty()) found.mask = person_mask(linear_rgb, found.faces, network);
  return found;
}

FoundPeople find_people_at(const Image& linear_rgb, const Face& tap, PersonNetwork& network) {
  const double x = tap.x + tap.width / 2, y = tap.y + tap.height / 2;
  FoundPeople found;
  for (const Face& face : find_faces(linear_rgb)) {
    const Image mask = person_mask(linear_rgb, {face}, network);
    const auto at = [](double position, int size, int mask_size) {
      return std::clamp(static_cast<int>(position * mask_size / size), 0, mask_size - 1);
    };
    const bool in_face = x >= face.x && x <= face.x + face.width && y >= face.y && y <= face.y + face.height;
    if (!in_face && !(mask.at(at(x, linear_rgb.width, mask.width), at(y, linear_rgb.height, mask.height)) > 0.5F)) {
      continue;
    }
    found.faces.push_back(face);
    if (found.mask.empty()) found.mask = Image(mask.width, mask.height);
    std::transform(mask.data.begin(), mask.data.end(), found.mask.data.begin(), found.mask.data.begin(),
                   [](float a, float b) { return std::max(a, b); });
  }
  found.detected = found.faces;
  return found;
}

bool anybody_seen(const FoundPeople& found) {
  const std::vector<float>& shares = found.mask.data;
  return std::any_of(shares.begin(), shares.end(), [](float share) { return share > 0.5F; });
}

}  // namespace dualpixel::pipeline
