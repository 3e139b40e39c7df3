#pragma once
#include <nlohmann/json_fwd.hpp>

#include "capture/capture.h"

namespace dualpixel::datasets {

inline constexpr int kQuantiles = 21;  ///< at 0, 5, ... 100 %

/// What a sample's pixels are like: quantiles of "disparity_dp_px" and, where valid, of "depth_m" (a list of kQuantiles
/// numbers; none where nothing is valid), "valid_share", "person_share", and of the undivided first frame
/// "mean_signal" (clipped at white) and "clipped_share" (from .98 of where the wells of the halves, or the digital
/// range, are full). Of every fourth pixel and row at most. Needs truth.
nlohmann::ordered_json statistics_of(const Capture& capture);

/// The undivided picture without noise as a small one to look at: sRGB, 0..1, at most 160 pixels wide.
Image preview_of(const Capture& capture);

}  // namespace dualpixel::datasets
