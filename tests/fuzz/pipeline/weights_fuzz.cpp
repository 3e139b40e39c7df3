#include "pipeline/segmentation/weights.h"
#include "tests/fuzz/attempt.h"

/// Weights of the person network: safetensors.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  return fuzz::attempt([&] { pipeline::parse_weights(fuzz::text(data, size), "fuzz"); });
}
