#pragma once
#include <string>

#include "capture/capture.h"

namespace dualpixel::pipeline {

/// Throws InputError where the camera's views are dense (1 x 1): half-photosites under a color mosaic hold nothing
/// that could be matched. `file` and `field` begin the message.
void require_matchable(const Camera& camera, const std::string& file, const std::string& field);

}  // namespace dualpixel::pipeline
