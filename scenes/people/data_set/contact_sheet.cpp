#include "scenes/people/data_set/contact_sheet.h"

#include <algorithm>
#include <utility>

namespace dualpixel::scenes {
namespace {

struct Color {
  float r, g, b;
};

void set_pixel(Image& image, int x, int y, Color color) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  image.at(x, y, 0) = color.r, image.at(x, y, 1) = color.g, image.at(x, y, 2) = color.b;
}

/// The picture with its mask outlined.
void paint_picture(Image& sheet, const PeopleSample& s, int left, int top) {
  const auto mask_at = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < kPictureSide_px && y < kPictureSide_px &&
           s.mask[static_cast<std::size_t>(y) * kPictureSide_px + x] > 127;
  };
  for (int y = 0; y < kPictureSide_px; ++y) {
    for (int x = 0; x < kPictureSide_px; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * kPictureSide_px + x;
      for (int c = 0; c < 3; ++c) sheet.at(left + x, top + y, c) = static_cast<float>(s.picture[3 * at + c]) / 255;
      const bool edge =
          mask_at(x, y) && !(mask_at(x - 1, y) && mask_at(x + 1, y) && mask_at(x, y - 1) && mask_at(x, y + 1));
      if (edge) set_pixel(sheet, left + x, top + y, {0, 1, 0.3f});
    }
  }
}

void paint_face(Image& sheet, const PeopleSample& s, int left, int top) {
  const int x0 = static_cast<int>(s.face.x), y0 = static_cast<int>(s.face.y), side = static_cast<int>(s.face.z);
  for (int k = 0; k <= side; ++k) {
    for (const auto& [x, y] : {std::pair{x0 + k, y0}, {x0 + k, y0 + side}, {x0, y0 + k}, {x0 + side, y0 + k}}) {
      if (x >= 0 && y >= 0 && x < kPictureSide_px && y < kPictureSide_px)
        set_pixel(sheet, left + x, top + y, {1, 0.9f, 0});
    }
  }
}

void paint_keypoints(Image& sheet, const PeopleSample& s, int left, int top) {
  for (const glm::vec3& k : s.keypoints) {
    if (k.z < 0.5f) continue;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (k.z < 1.5f && dx == 0 && dy == 0) continue;
        set_pixel(sheet, left + static_cast<int>(k.x) + dx, top + static_cast<int>(k.y) + dy,
                  k.z > 1.5f ? Color{1, 0, 0.2f} : Color{0.2f, 0.6f, 1});
      }
    }
  }
}

}  // namespace

Image contact_sheet(const std::vector<PeopleSample>& samples, int most, int columns) {
  const int n = std::min(static_cast<int>(samples.size()), most), rows = (n + columns - 1) / columns;
  Image sheet(std::min(columns, n) * kPictureSide_px, rows * kPictureSide_px, 3);
  for (int i = 0; i < n; ++i) {
    const PeopleSample& s = samples[i];
    const int left = i % columns * kPictureSide_px, top = i / columns * kPictureSide_px;
    paint_picture(sheet, s, left, top);
    paint_face(sheet, s, left, top);
    paint_keypoints(sheet, s, left, top);
  }
  return sheet;
}

}  // namespace dualpixel::scenes
