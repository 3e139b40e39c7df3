#include "capture/image/image_io.h"
#include "pipeline/portrait/plain_pair.h"
#include "tests/fuzz/attempt.h"

/// The metadata of a plain pair.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  static const bool written = (write_png8(fuzz::folder() / "v.png", Image(8, 8, 1, 0.5F)), true);
  write_bytes(fuzz::folder() / "m.json", fuzz::text(data, size));
  const std::string view = fuzz::folder() / "v.png";
  return fuzz::attempt([&] { pipeline::read_plain_pair({view, view, fuzz::folder() / "m.json", !written}); });
}
