#pragma once
#include <glm/glm.hpp>
#include <vector>

namespace dualpixel::simulator {

class LensSampler;

/// One ray of a photosite's center: in front of the lens it passes depth D at origin_m + slope D.
struct PupilRay {
  glm::dvec2 origin_m, slope;
  double left = 0, right = 0;  ///< its weight in each view
};

/// The rays of a photosite's center, green, all over the pupil; denser where rims cut it, by as much as their weights
/// are less.
struct PupilRays {
  std::vector<PupilRay> rays;  ///< those that light passes along
  /// What a ray misses the chief ray by, per unit of depth, becomes photosites on the sensor.
  glm::dmat2 photosites_per_slope{1};
};

/// `samples`: a multiple of 16.
PupilRays trace_pupil(const LensSampler& lens, int x, int y, int samples);

}  // namespace dualpixel::simulator
