#include <sys/mman.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <cmath>
#include <memory>

#include "simulator/scene/scene.h"

namespace dualpixel::simulator {
namespace {

/// In double, so that each byte is the float nearest to its exact value.
DecodeTables make_tables() {
  DecodeTables tables{};
  for (int i = 0; i < 256; ++i) {
    const double x = i / 255.0;
    tables.linear[i] = static_cast<float>(x);
    tables.srgb[i] = static_cast<float>(x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4));
  }
  return tables;
}

/// Asks for large pages for memory that is not written yet. Rays look texels up all over, so that with small pages most
/// look-ups miss the processor's table of pages. Where the system has none, nothing changes.
void ask_for_large_pages(void* memory, std::size_t bytes) {
  void* start = memory;
  if (std::align(static_cast<std::size_t>(sysconf(_SC_PAGESIZE)), 1, start, bytes)) {
    madvise(start, bytes, MADV_HUGEPAGE);
  }
}

}  // namespace

const DecodeTables kDecodeTables = make_tables();

void keep_decoded(Texture& texture) {
  constexpr std::size_t kMostTexels = 1 << 22;
  const std::size_t texels = texture.bytes().size() / 4;
  if (texels > kMostTexels) return;
  texture.decoded.reserve(texels);
  ask_for_large_pages(texture.decoded.data(), texels * sizeof(texture.decoded[0]));
  texture.decoded.resize(texels);
  for (std::size_t i = 0; i < texels; ++i) texture.decoded[i] = decode_texel(texture, i);
}

void keep_decoded(std::vector<Texture>& textures) {
  constexpr std::size_t kMostInAll = 1 << 25;  // texels
  std::size_t in_all = 0, count = 0;
  for (; count < textures.size(); ++count) {
    in_all += textures[count].bytes().size() / 4;
    if (in_all >= kMostInAll) break;
  }
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { keep_decoded(textures[i]); });
}

}  // namespace dualpixel::simulator
