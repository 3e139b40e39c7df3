#pragma once
#include <algorithm>
#include <cmath>

#include "capture/image/image.h"

namespace dualpixel::pipeline {

/// A face drawn from a few shaded ovals, brow to chin about `size_px` high, that a detector for photographs takes for
/// one.
inline void draw_face(Image& picture, double center_x, double center_y, double size_px) {
  struct Oval {
    double x, y, rx, ry, softness, value;  // in face sizes about the center; linear light
  };
  const Oval ovals[] = {
      {0, -0.12, 0.62, 0.78, 0.10, 0.03},                                                 // hair
      {0, 0.02, 0.48, 0.64, 0.06, 0.45},                                                  // face
      {-0.21, -0.25, 0.15, 0.025, 0.5, 0.05},                                             // brows
      {0.21, -0.25, 0.15, 0.025, 0.5, 0.05},   {-0.21, -0.13, 0.13, 0.07, 0.6, 0.16},     // eye sockets
      {0.21, -0.13, 0.13, 0.07, 0.6, 0.16},    {-0.21, -0.125, 0.055, 0.045, 0.4, 0.02},  // eyes
      {0.21, -0.125, 0.055, 0.045, 0.4, 0.02}, {0, 0.14, 0.10, 0.03, 0.8, 0.14},          // under the nose
      {0, 0.33, 0.17, 0.04, 0.6, 0.10},                                                   // mouth
      {0, 0.43, 0.12, 0.02, 0.9, 0.28},                                                   // under the lip
  };
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const double u = (x + 0.5 - center_x) / size_px, v = (y + 0.5 - center_y) / size_px;
      for (const Oval& oval : ovals) {
        const double r = std::hypot((u - oval.x) / oval.rx, (v - oval.y) / oval.ry);
        const auto cover = static_cast<float>(std::clamp((1 + oval.softness / 2 - r) / oval.softness, 0.0, 1.0));
        for (int c = 0; c < picture.channels; ++c) {
          float& value = picture.at(x, y, c);
          value += cover * (static_cast<float>(oval.value) - value);
        }
      }
    }
  }
}

}  // namespace dualpixel::pipeline
