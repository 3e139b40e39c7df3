#pragma once

namespace dualpixel::pipeline {

/// A box from brow to chin, 0.15 m of an adult, in pixels of the picture it was found in; it may reach over the border.
struct Face {
  double x = 0, y = 0, width = 0, height = 0;
  double area() const { return width * height; }
};

}  // namespace dualpixel::pipeline
