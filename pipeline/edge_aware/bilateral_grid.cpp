#include "pipeline/edge_aware/bilateral_grid.h"

#include <algorithm>
#include <bit>

#include "pipeline/rows.h"

namespace dualpixel::pipeline {
namespace {

/// Cell coordinates side by side in one integer, each offset by one so that a neighbour's coordinate cannot borrow:
/// x and y take up to 65537 of 2^17, luma and chroma up to 257 of 2^10.
using Key = std::uint64_t;
constexpr int kShifts[] = {0, 17, 34, 44, 54};
constexpr Key kNoKey = 0;  // every real key has ones in all fields

Key cell_key(const float* rgb, int x, int y, const BilateralGridOptions& options) {
  // Full-range YCbCr (ITU-R BT.601, as JPEG); chroma is centred on 128. The clamp holds what is out of range or NaN.
  const auto level = [](float value) { return value > 0 ? std::min(value, 255.0f) : 0.0f; };
  const float r = level(rgb[0]), g = level(rgb[1]), b = level(rgb[2]);
  const float luma = 0.299f * r + 0.587f * g + 0.114f * b;
  const float cb = level(128 - 0.168736f * r - 0.331264f * g + 0.5f * b);
  const float cr = level(128 + 0.5f * r - 0.418688f * g - 0.081312f * b);
  const Key cells[] = {static_cast<Key>(x / options.cell_px), static_cast<Key>(y / options.cell_px),
                       static_cast<Key>(luma / options.cell_luma), static_cast<Key>(cb / options.cell_chroma),
                       static_cast<Key>(cr / options.cell_chroma)};
  Key key = 0;
  for (int axis = 0; axis < 5; ++axis) key |= (cells[axis] + 1) << kShifts[axis];
  return key;
}

/// Open addressing over exact keys.
class VertexTable {
 public:
  explicit VertexTable(std::size_t most_vertices)
      : mask_(std::bit_ceil(2 * most_vertices) - 1), keys_(mask_ + 1, kNoKey), vertices_(mask_ + 1) {}

  std::int32_t find_or_add(Key key, std::vector<Key>& keys_of_vertices) {
    std::size_t slot = hash(key);
    while (keys_[slot] != kNoKey && keys_[slot] != key) slot = (slot + 1) & mask_;
    if (keys_[slot] == kNoKey) {
      keys_[slot] = key;
      vertices_[slot] = static_cast<std::int32_t>(keys_of_vertices.size());
      keys_of_vertices.push_back(key);
    }
    return vertices_[slot];
  }

  std::int32_t find(Key key, std::int32_t none) const {
    std::size_t slot = hash(key);
    while (keys_[slot] != kNoKey && keys_[slot] != key) slot = (slot + 1) & mask_;
    return keys_[slot] == key ? vertices_[slot] : none;
  }

 private:
  std::size_t hash(Key key) const { return (key * 0x9E3779B97F4A7C15ull >> 20) & mask_; }

  std::size_t mask_;
  std::vector<Key> keys_;
  std::vector<std::int32_t> vertices_;
};

}  // namespace

BilateralGrid make_bilateral_grid(const Image& guide, const BilateralGridOptions& options) {
  BilateralGrid grid;
  grid.width = guide.width;
  grid.height = guide.height;
  std::vector<Key> keys(guide.pixel_count());
  for_rows(guide.height, [&](int y) {
    Key* row = keys.data() + static_cast<std::size_t>(y) * guide.width;
    for (int x = 0; x < guide.width; ++x) row[x] = cell_key(guide.row(y) + 3 * x, x, y, options);
  });

  VertexTable table(keys.size());
  std::vector<Key> key_of_vertex;
  grid.vertex_of_pixel.resize(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const bool repeats = i > 0 && keys[i] == keys[i - 1];
    grid.vertex_of_pixel[i] = repeats ? grid.vertex_of_pixel[i - 1] : table.find_or_add(keys[i], key_of_vertex);
  }
  grid.vertices = static_cast<int>(key_of_vertex.size());

  grid.neighbors.resize(key_of_vertex.size() * BilateralGrid::kNeighbors);
  for_rows(grid.vertices, [&](int vertex) {
    std::int32_t* neighbors = grid.neighbors.data() + static_cast<std::size_t>(vertex) * BilateralGrid::kNeighbors;
    for (const int shift : kShifts) {
      *neighbors++ = table.find(key_of_vertex[vertex] - (Key{1} << shift), grid.vertices);
      *neighbors++ = table.find(key_of_vertex[vertex] + (Key{1} << shift), grid.vertices);
    }
  });
  return grid;
}

}  // namespace dualpixel::pipeline
