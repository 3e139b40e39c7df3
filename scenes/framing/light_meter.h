#pragma once
#include "simulator/ready_scene.h"
#include "simulator/render/camera_view.h"

namespace dualpixel::scenes {

/// Seconds at ISO 100 that make the mean of the picture's signal, clipped at white, this share of white: of the green
/// photosites, in each of a grid of them, through the lens with its shading. Throws InputError where the scene is
/// black; `field` names what asked.
double metered_seconds(double mean, const simulator::Simulation& simulation, simulator::ReadyScene& ready,
                       const simulator::CameraView& camera, const char* field);

}  // namespace dualpixel::scenes
