#pragma once
#include "simulator/render/path_state.h"
#include "simulator/render/render_scene.h"

/// Light along paths through the scene, sixteen at a time. Diffuse light comes from points on surfaces, where it was
/// computed once for all paths; reflections that depend on the direction are sampled by each path.
namespace dualpixel::simulator {

/// Follows all active paths from reflection `bounce` on to the last, and adds up their radiance.
void trace_paths(const RenderScene& world, const PathOptions& options, const SampleIndices& indices, int bounce,
                 RayPacket& rays, Paths& paths);

}  // namespace dualpixel::simulator
