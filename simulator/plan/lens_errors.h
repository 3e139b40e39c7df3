#pragma once
#include <cstdint>
#include <vector>

#include "simulator/plan/steps.h"
#include "simulator/render/render_scene.h"
#include "simulator/scene_file.h"

namespace dualpixel::simulator {

/// Fills the errors, differences and times of all lens steps; the last one is the reference. Disparity is traced, not
/// rendered, at 432 field points, one in each cell of a grid over the sensor, for the depth that the scene has there.
void measure_lens_errors(const Simulation& simulation, const RenderScene& world, std::uint64_t seed,
                         std::vector<LensStep>& steps);

}  // namespace dualpixel::simulator
