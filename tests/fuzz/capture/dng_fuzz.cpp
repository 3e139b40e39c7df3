#include "capture/image/dng_picture.h"
#include "capture/image/image_io.h"
#include "capture/image/picture_encoding.h"
#include "tests/fuzz/attempt.h"

/// Digital Negatives, as the program reads a photograph: what it is, then its picture, by LibRaw.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  const std::string path = fuzz::folder() / "photograph.dng";
  write_bytes(path, fuzz::text(data, size));
  return fuzz::attempt([&] {
    if (picture_encoding(path).dng) read_dng(path);
  });
}
