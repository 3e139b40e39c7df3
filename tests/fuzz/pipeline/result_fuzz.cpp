#include "pipeline/portrait/result_io.h"
#include "tests/fuzz/attempt.h"

/// result.json, beside the pictures of a result.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dualpixel;
  static const bool written = [] {
    pipeline::PortraitResult result;
    result.input = result.portrait = result.portrait_srgb = Image(4, 4, 3, 0.5F);
    pipeline::write_result(result, {{"mode", "seg"}}, fuzz::folder() / "r");
    return true;
  }();
  write_bytes(fuzz::folder() / "r/result.json", fuzz::text(data, size));
  return fuzz::attempt([&] {
    if (written) pipeline::read_result(fuzz::folder() / "r");
  });
}
