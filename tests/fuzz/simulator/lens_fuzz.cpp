#include "simulator/lens/lens_file.h"
#include "tests/fuzz/attempt.h"

/// Lenses.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  return fuzz::attempt([&] { simulator::read_lens(parse_json(fuzz::text(data, size), "fuzz"), "fuzz", "", 1); });
}
