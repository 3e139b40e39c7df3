#include "capture/image/npy.h"
#include "tests/fuzz/attempt.h"

/// NumPy files.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  write_bytes(fuzz::folder() / "a.npy", fuzz::text(data, size));
  return fuzz::attempt([&] { read_npy(fuzz::folder() / "a.npy"); });
}
