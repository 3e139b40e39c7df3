#pragma once
#include <optional>

#include "scenes/drawn/meter.h"
#include "simulator/ready_scene.h"
#include "simulator/render/camera_view.h"

namespace dualpixel::scenes {

/// Seconds at ISO 100.
struct MeteredExposure {
  double seconds = 0;
  bool reaches_mean = true;  ///< else so much is black that no exposure does: the brightest is just not clipped

  /// What is missed, by the camera that was set to it or because of the black.
  std::optional<MissedExposure> missed(std::optional<MissedExposure> by_camera = {}) const;
};

/// The exposure that makes the mean of the picture's signal, clipped at white, this share of white: of the green
/// photosites, in each of a grid of them, through the lens with its shading. Throws InputError where the scene is
/// black; `field` names what asked.
MeteredExposure meter_for_mean(double mean, const simulator::Simulation& simulation, simulator::ReadyScene& ready,
                               const simulator::CameraView& camera, const char* field);

}  // namespace dualpixel::scenes
