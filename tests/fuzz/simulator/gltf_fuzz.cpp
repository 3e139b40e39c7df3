#include "simulator/scene/gltf/gltf.h"
#include "tests/fuzz/attempt.h"

/// glTF and GLB. Of other files, it may name those beside the seeds: `out.bin` of 256 bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  static const std::string beside = fuzz::folder().write("out.bin", std::string(256, 1));
  return fuzz::attempt([&] { simulator::read_gltf_bytes(fuzz::text(data, size), "fuzz", fuzz::folder().path); });
}
