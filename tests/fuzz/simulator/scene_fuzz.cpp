#include "simulator/scene_file.h"
#include "tests/fuzz/attempt.h"

/// Scene files.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  return fuzz::attempt([&] { simulator::read_simulation(parse_json(fuzz::text(data, size), "fuzz"), "fuzz"); });
}
