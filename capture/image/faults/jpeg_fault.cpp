#include "capture/image/faults/jpeg_fault.h"

#include <istream>

namespace dualpixel {
namespace {

constexpr int kStart = 0xd8, kEnd = 0xd9, kScan = 0xda, kTemporary = 0x01;

bool is_restart(int marker) { return marker >= 0xd0 && marker <= 0xd7; }

/// The next marker's second byte; -1 where the file ends. Whatever comes before it is passed over: in compressed data
/// 0xff is followed by 0.
int next_marker(std::istream& jpeg) {
  for (int byte = jpeg.get(); byte >= 0; byte = jpeg.get()) {
    if (byte != 0xff) continue;
    int marker = jpeg.get();
    while (marker == 0xff) marker = jpeg.get();
    if (marker != 0) return marker;
  }
  return -1;
}

}  // namespace

std::optional<std::string> fault_of_jpeg(std::istream& jpeg) {
  const auto ends_early = [] { return std::optional<std::string>("the file ends before the JPEG does"); };
  for (int marker = next_marker(jpeg); marker != kEnd; marker = next_marker(jpeg)) {
    if (marker < 0) return ends_early();
    if (marker == kStart || marker == kTemporary || is_restart(marker)) continue;
    const int high = jpeg.get(), low = jpeg.get();
    if (low < 0) return ends_early();
    if (256 * high + low < 2) return "a segment of it has no length";
    if (marker != kScan) jpeg.ignore(256 * high + low - 2);  // a scan's header is as good as its data
  }
  return {};
}

}  // namespace dualpixel
