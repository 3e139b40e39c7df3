#include "capture/image/image_io.h"
#include "tests/fuzz/attempt.h"

/// Pictures: EXR, PNG, TIFF, JPEG, HDR.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  write_bytes(fuzz::folder() / "picture", fuzz::text(data, size));
  return fuzz::attempt([&] { read_image(fuzz::folder() / "picture"); });
}
