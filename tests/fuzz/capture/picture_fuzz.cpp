#include "capture/image/image_io.h"
#include "capture/image/picture_encoding.h"
#include "tests/fuzz/attempt.h"

/// Pictures: EXR, PNG, TIFF, JPEG, HDR; their values, how they are encoded, and the IDs of an EXR.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  const std::string path = fuzz::folder() / "picture";
  write_bytes(path, fuzz::text(data, size));
  const auto read_each = [&](auto... read) { (fuzz::attempt([&] { read(path); }), ...); };
  read_each(read_image, picture_encoding, read_exr_ids);
  return 0;
}
