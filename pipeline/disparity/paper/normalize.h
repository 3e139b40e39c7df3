#pragma once
#include "capture/image/image.h"
#include "pipeline/option_field.h"

/// Local normalization of a DP view: takes out the lens shading that differs between the views (Wadhwa et al. 2018,
/// supplement, "DP Normalization").
namespace dualpixel::pipeline {

struct NormalizeOptions {
  int window_px = 9;         ///< side of the square window, DP pixels, odd (supplement: 9 x 9)
  float std_floor = 0.001f;  ///< added to the standard deviation, normalized signal (supplement: 0.001)
  /// Share of the views' white from which a pixel is clipped; ours: a tile's confidence falls by its share of them.
  float clipped = 0.98f;
};

OptionFields fields(NormalizeOptions& options);

/// Throws InputError where a value is out of its range.
void check(const NormalizeOptions& options);

/// (view - local mean) / (local standard deviation + std_floor); windows end at the picture's border. Values that are
/// not finite count as 0. Throws InputError where an option is out of range.
Image normalize_locally(const Image& view, const NormalizeOptions& options = {});

}  // namespace dualpixel::pipeline
