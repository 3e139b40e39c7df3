#include "pipeline/calibration/calibration.h"
#include "tests/fuzz/attempt.h"

/// calibration.json.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  return fuzz::attempt([&] { pipeline::read_calibration(parse_json(fuzz::text(data, size), "fuzz"), "fuzz"); });
}
