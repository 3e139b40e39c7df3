#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "simulator/render/camera_view.h"
#include "simulator/scene/scene.h"
#include "simulator/scene_file.h"

/// The simulator from end to end: scene + lens + sensor -> capture with truth.
namespace dualpixel::simulator {

struct RenderScene;

/// Reads glTF and environment that `simulation` names, animated objects where they are at `time_s` if
/// Simulation::animation is set. `decode_textures`: faster rays for more memory, see keep_decoded(). Throws InputError,
/// also where nothing in them gives light.
Scene load_scene(const Simulation& simulation, double time_s = 0, bool decode_textures = true);

/// The camera as its captures describe it.
Camera describe_camera(const Simulation& simulation);

/// Pose of the camera: camera axes to the world's. Throws InputError where the scene has no such camera.
glm::mat4 camera_pose(const Simulation& simulation, const Scene& scene);

/// The lens over its sensor, ready to draw rays (up to a second for a prescription). Throws InputError where no light
/// passes it.
LensSampler prepare_lens(const Simulation& simulation);

/// The same of another lens or a part of the sensor.
LensSampler prepare_lens(const Simulation& simulation, const Lens& lens, const SensorGrid& sensor);

/// The lens that truth's photograph looks through, where it is another than the ideal one, over a sensor of the same
/// field of view.
std::optional<LensSampler> prepare_photograph_lens(const Simulation& simulation);

/// The lines of Simulation::warnings, and one where that lens leaves a part of the photograph dark.
std::vector<std::string> warnings_of(const Simulation& simulation);

/// Both: the camera, ready to render.
CameraView place_camera(const Simulation& simulation, const Scene& scene);

/// `stage` is called with what is being done and the fraction of it that is.
using StageCallback = std::function<void(const std::string& stage, double fraction)>;

/// Throws InputError where simulate() would before it renders anything: where an animation makes triangles appear or
/// vanish, or where pictures and scenes would not fit into this machine's memory.
void require_renderable(const Simulation& simulation, const Scene& scene);

/// `scene` is load_scene(simulation). Where something moves, each frame is rendered at its own time with random numbers
/// of its own; else all frames share one render. Truth is the first frame's, with the motion to the others. Throws
/// as require_renderable() does.
Capture simulate(const Simulation& simulation, const Scene& scene, const StageCallback& stage = {});

/// The same with place_camera()'s result, where the caller has it already.
Capture simulate(const Simulation& simulation, const Scene& scene, const CameraView& camera,
                 const StageCallback& stage = {});

/// The same of a scene that is ready for rays: its light is kept from one call to the next, and changes no byte.
Capture simulate(const Simulation& simulation, RenderScene& world, const CameraView& camera,
                 const StageCallback& stage = {});

}  // namespace dualpixel::simulator
