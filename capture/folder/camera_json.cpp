#include "capture/folder/camera_json.h"

namespace dualpixel {

void read_intrinsics(Fields& fields, Camera& camera) {
  fields.text("name", camera.name);
  fields.required("width_px").integer("width_px", camera.width_px, 2, 65536);
  fields.required("height_px").integer("height_px", camera.height_px, 4, 65536);
  fields.required("pixel_pitch_um").number("pixel_pitch_um", camera.pixel_pitch_um, 0.01, 1000);
  fields.integer("dp_downsample_x", camera.dp_downsample_x, 1, 16);
  fields.integer("dp_downsample_y", camera.dp_downsample_y, 1, 16);
  fields.required("focal_length_mm").number("focal_length_mm", camera.focal_length_mm, 0.01, 1e5);
  fields.required("f_number").number("f_number", camera.f_number, 0.1, 1e6);
  camera.principal_point_px = {camera.width_px / 2.0, camera.height_px / 2.0};
  fields.numbers("principal_point_px", camera.principal_point_px.data(), 2);
}

}  // namespace dualpixel
