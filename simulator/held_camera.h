#pragma once
#include "simulator/render/camera_view.h"
#include "simulator/scene_file.h"

/// Where the hand holds the camera while a picture is exposed.
namespace dualpixel::simulator {

/// How much later than the picture's middle a row of the sensor is exposed, whose middle is at `row`.
double row_delay_s(const Simulation& s, double row);

/// `view`, moved to where hand_shake() has it in a picture whose middle is exposed at `time_s`; where the shutter
/// rolls, each row at its own time. `first_row`: which row of the sensor is the view's first.
CameraView held_at(const Simulation& s, CameraView view, double time_s, int first_row = 0);

}  // namespace dualpixel::simulator
