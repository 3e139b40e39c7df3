#include "simulator/journal.h"
#include "tests/fuzz/attempt.h"

/// The journal of a render.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  write_bytes(fuzz::folder() / "journal", fuzz::text(data, size));
  return fuzz::attempt([&] { const simulator::Journal journal(fuzz::folder() / "journal", 1); });
}
