#pragma once
#include <optional>

#include "simulator/render/path_state.h"
#include "simulator/render/render_scene.h"

/// Paths through glass. Passing it is no reflection: whatever the most reflections are, glass shows what is behind it.
namespace dualpixel::simulator {

/// Of the active camera rays, which hold their nearest hits, those that meet glass from outside; false: none. They are
/// followed both ways, each with its share of the light, since a way taken by chance leaves noise that both views
/// share.
bool find_divided(const RenderScene& world, const RayPacket& rays, const Paths& paths, int lanes[kPacket]);

/// Leads the active paths, whose rays hold their nearest hits, on through glass. Those that stay for what glass
/// reflects keep their hit, those that end in it are active no longer. Beyond the last reflection none stay; nor do
/// camera rays at the first glass, where what is reflected is followed beside them.
void pass_glass(const RenderScene& world, const PathOptions& options, const SampleIndices& indices, int bounce,
                RayPacket& rays, Paths& paths);

/// Takes off what glass keeps of `light` along shadow rays, active ones that nothing hides. Light goes straight through
/// solid glass, too: what it loses is right, but it is not gathered into caustics.
void dim_by_glass(const RenderScene& world, const int active[kPacket], const int hidden[kPacket], const RayPacket& rays,
                  Vec3Packet& light);

/// What truth says that a ray sees: the first surface that is not a clear, thin pane that lets half of the light
/// through or more. Solid glass is such a surface.
std::optional<Hit> seen_surface(const RenderScene& world, const Ray& ray);

}  // namespace dualpixel::simulator
