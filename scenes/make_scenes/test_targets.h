#pragma once
#include <string>

namespace dualpixel::scenes {

/// A fronto-parallel plane of band-limited texture at 0.88 m: no detail finer than about 8 photosites of the default
/// camera, so that nothing aliases.
void make_calibration_target(const std::string& path);
/// Textured planes, slanted about both axes, from 0.35 to 2 m.
void make_slanted_planes(const std::string& path);
/// Cards, combs and rods of many widths, in front of each other.
void make_occlusion_edges(const std::string& path);

}  // namespace dualpixel::scenes
