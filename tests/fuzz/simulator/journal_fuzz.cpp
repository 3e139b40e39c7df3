#include "simulator/journal.h"
#include "simulator/render/sample_map.h"
#include "simulator/render/views.h"
#include "tests/fuzz/attempt.h"

/// The journal of a render, and the pixels of a tile that it holds.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  write_bytes(fuzz::folder() / "journal", fuzz::text(data, size));
  return fuzz::attempt([&] {
    simulator::Journal journal(fuzz::folder() / "journal", 1);
    simulator::Views views{Image(1, 1, 3), Image(1, 1, 3)};
    for (const std::uint64_t render : {0, 1}) journal.restore(render, {0, 0, 1, 0, 1, 1}, views);
  });
}
