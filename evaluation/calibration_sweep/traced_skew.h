#pragma once
#include "pipeline/calibration/calibration.h"
#include "pipeline/disparity/kernel_skew.h"
#include "simulator/lens/lens_sampler.h"
#include "simulator/simulate.h"

namespace dualpixel::evaluation {

/// How the kernels of both views skew behind this lens at one photosite, from the rays of its pupil: such that waves of
/// 0.15 cycles a DP pixel's width along the baseline, and such across it, are shifted as these rays shift them; longer
/// waves, where the blur leaves less than 0.4 of those. Where the lens passes too little light, or disparity hardly
/// changes with depth, that of an ideal split. `pixel_height` is a DP pixel's over its width.
pipeline::SkewCurve trace_skew(const simulator::LensSampler& lens, double pixel_height, int x, int y);

/// The same over the field; one node, where all photosites see the pupil alike.
pipeline::SkewField trace_skew(const simulator::LensSampler& lens, double pixel_height);

/// Gives every focus distance the skew of the simulation's own lens, where its split is one that matchers know
/// (alpha_of_camera()). Throws as focused_lens() does.
void add_traced_skew(const simulator::Simulation& simulation, pipeline::Calibration& calibration);

}  // namespace dualpixel::evaluation
