#include "pipeline/disparity/tile_disparity.h"

#include <fmt/format.h>

#include "capture/error.h"

namespace dualpixel::pipeline {

void require_views(const Image& left, const Image& right) {
  if (!left.same_size(right)) {
    throw InputError(fmt::format("disparity: right view: {} x {}: must have the left view's size, {} x {}", right.width,
                                 right.height, left.width, left.height));
  }
  for (const Image* view : {&left, &right}) {
    if (view->channels > 1) {
      throw InputError(fmt::format("disparity: {} view: {} channels: must have one", view == &left ? "left" : "right",
                                   view->channels));
    }
  }
}

}  // namespace dualpixel::pipeline
