#pragma once
#include "capture/image/image.h"
#include "pipeline/option_field.h"

/// Local normalization of a DP view: takes out the lens shading that differs between the views (Wadhwa et al. 2018,
/// supplement, "DP Normalization").
namespace dualpixel::pipeline {

struct NormalizeOptions {
  int window_px = 9;         ///< side of the square window, DP pixels, odd (supplement: 9 x 9)
  float std_floor = 0.001f;  ///< added to the standard deviation, normalized signal (supplement: 0.001)
  float clipped = 0.98f;     ///< share of the views' white from which a pixel tells nothing; ours, not in the paper
};

OptionFields fields(NormalizeOptions& options);

/// Throws InputError where a value is out of its range.
void check(const NormalizeOptions& options);

/// The view with NaN where it is `level` or more; empty where it is so nowhere.
Image without_clipped(const Image& view, float level);

/// (view - local mean) / (local standard deviation + std_floor); windows end at the picture's border. Values that are
/// not finite are left out of the windows, and NaN in the answer. Throws InputError where an option is out of range.
Image normalize_locally(const Image& view, const NormalizeOptions& options = {});

}  // namespace dualpixel::pipeline
