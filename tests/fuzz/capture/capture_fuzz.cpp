#include "capture/capture.h"
#include "tests/fuzz/attempt.h"

/// capture.json, beside pictures of a capture that has one frame and truth.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  static const bool written = [] {
    Capture capture;
    capture.camera = {.name = "toy",
                      .width_px = 16,
                      .height_px = 8,
                      .pixel_pitch_um = 1.4,
                      .focal_length_mm = 4.4,
                      .f_number = 1.8,
                      .focus_distance_m = 1.25};
    capture.exposure = {.bits = 10, .black_level_dn = 64, .white_level_dn = 1023};
    capture.frames.push_back({.left = ImageU16(8, 2, 1, 100), .right = ImageU16(8, 2, 1, 100)});
    write_capture(capture, fuzz::folder() / "c");
    return true;
  }();
  write_bytes(fuzz::folder() / "c/capture.json", fuzz::text(data, size));
  return fuzz::attempt([&] { read_capture(fuzz::folder() / "c", written); });
}
