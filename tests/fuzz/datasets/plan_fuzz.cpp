#include "datasets/plan/sample_line.h"
#include "tests/fuzz/attempt.h"

/// A line of the plan of a data set.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  return fuzz::attempt([&] { datasets::read_sample_line(fuzz::text(data, size), "fuzz"); });
}
