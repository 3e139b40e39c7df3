#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>

#include "capture/option_ranges.h"

namespace dualpixel::simulator {

class TileStore;

using ProgressCallback = std::function<void(double fraction)>;

/// How samples are spread over pixel, pupil and lights. All but the last are there to be charted against it
/// (`dualpixel bench render`).
enum class Sampling {
  random,   ///< independent numbers
  padded,   ///< planar nets, one for the pixel, one for the pupil, paired at random
  joint,    ///< one net of four dimensions
  mirrored  ///< joint, in pairs that oppose each other in the pupil
};

struct RenderOptions {
  int samples_per_pixel = 16;  ///< 1 .. 65536; powers of two sample best
  int max_bounces = 0;         ///< 0: emitted and direct light, also as a mirror shows it; n: n further reflections
  std::uint64_t seed = 1;
  /// Set: instead of the lens the ideal one with its chief rays is looked through, its pupil this much wider; 0 is a
  /// pinhole.
  std::optional<double> ideal_aperture_scale;
  Sampling sampling = Sampling::mirrored;
  /// Set: every photosite sees light as the R, G or B filter (0, 1, 2) does, instead of its own.
  std::optional<int> color;
  int first_row = 0, end_row = std::numeric_limits<int>::max();  ///< of the tiles that are rendered; others stay black
  TileStore* store = nullptr;  ///< set: tiles that it knows are not rendered, others are added
};

inline constexpr OptionRange<RenderOptions> kRenderRanges[] = {
    {"samples_per_pixel", &RenderOptions::samples_per_pixel, 1, 65536},
    {"max_bounces", &RenderOptions::max_bounces, 0, 1000},
};

inline std::optional<OptionProblem> check(const RenderOptions& render) { return check_ranges(render, kRenderRanges); }

/// How diffuse light is computed at points of surfaces and interpolated between them, instead of at every sample.
struct LightCacheOptions {
  double light_spacing_px = 4;   ///< photosites between points, as the camera sees them; 0: all light is sampled
  int light_samples = 64;        ///< of each point; powers of two sample best
  double light_memory_mb = 256;  ///< that points may take; beyond it they are computed again where they are needed

  bool operator==(const LightCacheOptions&) const = default;
};

inline constexpr OptionRange<LightCacheOptions> kLightCacheRanges[] = {
    {"light_spacing_px", &LightCacheOptions::light_spacing_px, 0, 1000},
    {"light_samples", &LightCacheOptions::light_samples, 16, 65536},
    {"light_memory_mb", &LightCacheOptions::light_memory_mb, 1, 1e6},
};

}  // namespace dualpixel::simulator
