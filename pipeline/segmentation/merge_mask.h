#pragma once
#include <array>

#include "capture/image/image.h"
#include "pipeline/option_field.h"

/// Disparity and a person mask combined, so that the whole person is in focus (Wadhwa et al. 2018, section 4.3).
namespace dualpixel::pipeline {

struct PixelDisparity;

struct MergeMaskOptions {
  float interior = 0.94f;  ///< mask value above which a pixel counts as interior (section 4.3)
};

OptionFields fields(MergeMaskOptions& options);

/// Mean disparity over the rectangle `face` (x, y, width, height, in pixels of `map`), weighted by confidence; the
/// plain mean where confidence is 0 throughout, 0 where the rectangle lies outside.
float face_disparity(const PixelDisparity& map, const std::array<double, 4>& face);

/// The same over the interior of the mask, for a person whose face is not known; 0 where there is no interior.
float interior_disparity(const PixelDisparity& map, const Image& mask, const MergeMaskOptions& options = {});

/// Sets the interior of the mask to disparity `person_dp_px`, with confidence 1. `mask` is of the map's size, 0..1.
PixelDisparity flatten_person(PixelDisparity map, const Image& mask, float person_dp_px,
                              const MergeMaskOptions& options = {});

}  // namespace dualpixel::pipeline
