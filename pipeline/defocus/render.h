#pragma once
#include "pipeline/defocus/defocused.h"
#include "pipeline/defocus/layers.h"
#include "pipeline/defocus/options.h"

/// Synthetic defocus from disparity (Wadhwa et al. 2018, sections 5.2 and 5.3).
namespace dualpixel::pipeline {

/// Blurs linear `rgb` by `radius_px` (blur_radius.h's r(x), full-resolution px): bands of disparity are blurred at half
/// resolution, the in-focus one by brute force and the others in the gradient domain, laid behind each other from front
/// to back at that resolution into two stacks, behind what is sharp and in front of it, enlarged, and divided by the
/// alpha that they add up to. (In the in-focus band the aperture's polygon is that of behind the focus on both sides:
/// at such small radii the difference is not visible.) Pixels whose radius is below half a pixel are the input's own,
/// laid over the in-focus band and all behind it; up to 1.5 px they blend over. Only blurred things nearer than the
/// focus may cover them.
///
/// Departures from sections 5.2 and 5.3: tents are divided by their sum (layers.h) and composited by another operator
/// than "over" (rgba.h). The paper enlarges each of the five layers and lays them at full size; within each stack
/// layers are as smooth as their blur, so that two enlargements in place of five save most of the time at little error.
/// And the paper takes the whole in-focus band's pixels from the input: their radius goes up to r_brute, 5.5 px, where
/// the blur would end in a step.
///
/// `rgb` must be finite. Pixels whose disparity is not finite are taken to be in focus; radii are clamped to
/// [0, r_max], and those that are no numbers count as 0. Throws InputError where the maps' sizes are not the picture's,
/// or for an aperture that cannot be.
Defocused render_defocus(const Image& rgb, const Image& disparity_dp_px, const Image& radius_px,
                         const BlurMapping& mapping, const LayerOptions& options = {}, const Bokeh& bokeh = {});

}  // namespace dualpixel::pipeline
