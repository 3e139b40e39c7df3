#pragma once
#include <array>
#include <glm/glm.hpp>

namespace dualpixel::simulator {
class LensSampler;
}

/// What a camera's lens and split pixel do at one place of the field, as figures that can be measured on a real camera.
namespace dualpixel::evaluation {

/// One view's picture of a point. Upright, meters on the sensor, from where the chief ray has the point.
struct BlurKernel {
  double light = 0;  ///< illumination over that of the undivided pixel on the axis
  glm::dvec2 centroid_m{0};
  glm::dvec2 sigma_m{0};  ///< standard deviations along x and y
  double skew_x = 0;      ///< third central moment along x over sigma_x^3
};

struct PointFigures {
  BlurKernel left, right;
  glm::dvec2 sum_sigma_m{0};  ///< of both views' kernels together
};

/// The kernels of a point at planar depth `depth_m` (infinity is allowed) that is seen at photosite (x, y): moments of
/// `samples` rays (a multiple of 16) in green light, exact to first order in the kernel's size. A view without light
/// has light 0.
PointFigures trace_point(const simulator::LensSampler& lens, int x, int y, double depth_m, int samples);

}  // namespace dualpixel::evaluation
