#pragma once
#include "capture/capture.h"
#include "simulator/render/camera_view.h"
#include "simulator/render/render_scene.h"

namespace dualpixel::simulator {

/// The geometry part of Truth, by the chief ray through each pixel's center and the lens's disparity field; never
/// by matching rendered views. The pictures are left empty.
Truth trace_truth(const RenderScene& scene, const CameraView& camera);

}  // namespace dualpixel::simulator
