#pragma once
#include <functional>
#include <optional>

#include "scenes/drawn/meter.h"
#include "simulator/ready_scene.h"
#include "simulator/render/camera_view.h"

namespace dualpixel::scenes {

/// Seconds at ISO 100.
struct MeteredExposure {
  double seconds = 0;
  bool reaches_mean = true;  ///< else so much is black, or white so low, that none does: the brightest just clips

  /// What is missed, by the camera that was set to it or because no exposure gives the mean.
  std::optional<MissedExposure> missed(std::optional<MissedExposure> by_camera = {}) const;
};

/// The signal at which the picture clips in an exposure of so many seconds at ISO 100: 1, or less where the wells are
/// full before, below ISO 100.
using WhiteOfExposure = std::function<double(double seconds)>;

/// The exposure that makes the mean of the picture's signal, clipped at white, this share of white: of the green
/// photosites, in each of a grid of them, through the lens with its shading. Throws InputError where the scene is
/// black; `field` names what asked.
MeteredExposure meter_for_mean(double mean, const simulator::Simulation& simulation, simulator::ReadyScene& ready,
                               const simulator::CameraView& camera, const char* field, const WhiteOfExposure& white);

}  // namespace dualpixel::scenes
