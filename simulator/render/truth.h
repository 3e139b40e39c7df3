#pragma once
#include "capture/capture.h"
#include "simulator/render/camera_view.h"
#include "simulator/render/render_scene.h"

namespace dualpixel::simulator {

/// The geometry part of Truth, by the chief ray through each pixel's center and the lens's disparity field; never
/// by matching rendered views. The person mask alone is the share of each photosite, so that hair covers a part of it;
/// strands that the middle of no photosite meets within two of them are missed. The pictures are left empty.
Truth trace_truth(const RenderScene& scene, const CameraView& camera);

/// The same of rows [first_row, end_row) of a truth that has its size.
void trace_truth_rows(const RenderScene& world, const CameraView& camera, int first_row, int end_row, Truth& truth);

/// Nothing is seen anywhere: its size, for trace_truth_rows.
Truth empty_truth(const SensorGrid& sensor);

}  // namespace dualpixel::simulator
