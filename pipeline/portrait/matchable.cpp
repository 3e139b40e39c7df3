#include "pipeline/portrait/matchable.h"

#include "capture/error.h"

namespace dualpixel::pipeline {

void require_matchable(const Camera& camera, const std::string& file, const std::string& field) {
  if (camera.dp_downsample_x * camera.dp_downsample_y != 1) return;
  throw InputError(printable(file) + ": " + field + ": 1 x 1: views under a color mosaic cannot be matched; 2 x 2 can");
}

}  // namespace dualpixel::pipeline
