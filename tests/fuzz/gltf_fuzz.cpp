#include <cstddef>
#include <cstdint>
#include <string>

#include "capture/error.h"
#include "simulator/scene/gltf/gltf.h"

/// libFuzzer: any bytes must become a scene or an InputError. No file is read, for the glTF has no folder.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    dualpixel::simulator::read_gltf_bytes(std::string(reinterpret_cast<const char*>(data), size), "fuzz", "");
  } catch (const dualpixel::InputError&) {
  }
  return 0;
}
