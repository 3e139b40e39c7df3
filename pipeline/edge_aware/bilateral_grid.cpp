#include "pipeline/edge_aware/bilateral_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "capture/error.h"
#include "capture/image/rows.h"

namespace dualpixel::pipeline {
namespace {

/// Cells along Cr, Cb and Y side by side, from 1 on so that a neighbor's coordinate cannot borrow: they take up to 257
/// of 2^10.
using Key = std::uint32_t;
constexpr Key kNoKey = 0;
constexpr Key kOne[] = {1, 1 << 10, 1 << 20};  // a step along Y, Cb, Cr

/// Where colors lie along the grid's axes, in cells; cell k holds k <= position < k + 1.
struct Positions {
  std::vector<float> luma, cb, cr;
};

/// Row `y` of the guide. Full-range YCbCr (ITU-R BT.601, as JPEG).
void locate(const Image& guide, int y, const BilateralGridOptions& cells, Positions& to) {
  const auto level = [](float value) { return value > 0 ? std::min(value, 255.0f) : 0.0f; };
  const float per_luma = 1 / cells.cell_luma, per_chroma = 1 / cells.cell_chroma;
  // Gray lies in the middle of cell `middle`, which is as many cells from 0 as 128 levels are, rounded up.
  const float middle = std::ceil(128 * per_chroma) + 0.5f;
  const int count = guide.width;
  float *luma = to.luma.data(), *blue = to.cb.data(), *red = to.cr.data();
  if (guide.channels == 1) {
    const float* gray = guide.row(y);
    for (int i = 0; i < count; ++i) luma[i] = level(gray[i]) * per_luma;
    std::fill_n(blue, count, middle);
    std::fill_n(red, count, middle);
    return;
  }
  const float* rgb = guide.row(y);
  for (int i = 0; i < count; ++i) {
    const float r = level(rgb[3 * i]), g = level(rgb[3 * i + 1]), b = level(rgb[3 * i + 2]);
    luma[i] = (0.299f * r + 0.587f * g + 0.114f * b) * per_luma;
    blue[i] = (-0.168736f * r - 0.331264f * g + 0.5f * b) * per_chroma + middle;
    red[i] = (0.5f * r - 0.418688f * g - 0.081312f * b) * per_chroma + middle;
  }
}

/// Where the middle of pixel x lies, in cells.
double cell_position(int x, float cell_px) { return (x + 0.5) / cell_px; }

/// First pixel of each cell along x or y, and the end.
std::vector<int> cell_begins(int size, float cell_px) {
  std::vector<int> begins;
  for (int x = 0; x < size; ++x) {
    if (static_cast<int>(cell_position(x, cell_px)) >= static_cast<int>(begins.size())) begins.push_back(x);
  }
  begins.push_back(size);
  return begins;
}

int longest(const std::vector<int>& begins) {
  int length = 0;
  for (std::size_t i = 1; i < begins.size(); ++i) length = std::max(length, begins[i] - begins[i - 1]);
  return length;
}

/// What one task needs to find the vertices of a row of tiles.
struct Workspace {
  Positions positions;
  std::vector<Key> keys;  // of the row's pixels
  std::vector<Key> slots;
  std::vector<std::int32_t> vertex_of_slot, rank;
  std::vector<std::pair<Key, std::int32_t>> found;  // of the tile, and where it stood before sorting

  explicit Workspace(const BilateralGrid& grid)
      : positions{std::vector<float>(grid.width), std::vector<float>(grid.width), std::vector<float>(grid.width)} {
    const int tile_height = longest(grid.row_begins), tile_width = longest(grid.column_begins);
    keys.resize(static_cast<std::size_t>(grid.width) * tile_height);
    slots.resize(std::bit_ceil(2 * static_cast<std::size_t>(tile_height) * tile_width));
    vertex_of_slot.resize(slots.size());
  }

  /// Vertex of the tile, by open addressing over exact keys.
  std::int32_t find_or_add(Key key) {
    const std::size_t mask = slots.size() - 1;
    std::size_t slot = (key * 0x9E3779B1u >> 12) & mask;
    while (slots[slot] != kNoKey && slots[slot] != key) slot = (slot + 1) & mask;
    if (slots[slot] == kNoKey) {
      slots[slot] = key;
      vertex_of_slot[slot] = static_cast<std::int32_t>(found.size());
      found.emplace_back(key, vertex_of_slot[slot]);
    }
    return vertex_of_slot[slot];
  }
};

/// Finds the vertices of one row of tiles: their colors, tile by tile; vertex_of_pixel counts from the tile's first.
void find_vertices(const Image& guide, int line, Workspace& work, BilateralGrid& grid, std::vector<Key>& colors) {
  const int width = guide.width, top = grid.row_begins[line], bottom = grid.row_begins[line + 1];
  for (int y = top; y < bottom; ++y) {
    locate(guide, y, grid.cells, work.positions);
    Key* keys = work.keys.data() + static_cast<std::size_t>(y - top) * width;
    const Positions& at = work.positions;
    for (int x = 0; x < width; ++x) {
      const int luma = static_cast<int>(at.luma[x]), cb = static_cast<int>(at.cb[x]), cr = static_cast<int>(at.cr[x]);
      keys[x] = static_cast<Key>((luma + 1) | (cb + 1) << 10 | (cr + 1) << 20);
    }
  }
  for (int column = 0; column < grid.columns(); ++column) {
    const int left = grid.column_begins[column], right = grid.column_begins[column + 1];
    std::fill(work.slots.begin(), work.slots.end(), kNoKey);
    work.found.clear();
    Key last = kNoKey;
    std::int32_t vertex = 0;
    for (int y = top; y < bottom; ++y) {
      const Key* keys = work.keys.data() + static_cast<std::size_t>(y - top) * width;
      std::int32_t* to = grid.vertex_of_pixel.data() + static_cast<std::size_t>(y) * width;
      for (int x = left; x < right; ++x) {
        if (keys[x] != last) vertex = work.find_or_add(last = keys[x]);
        to[x] = vertex;
      }
    }
    std::sort(work.found.begin(), work.found.end());
    work.rank.resize(work.found.size());
    for (std::size_t i = 0; i < work.found.size(); ++i) {
      work.rank[work.found[i].second] = static_cast<std::int32_t>(i);
      colors.push_back(work.found[i].first);
    }
    for (int y = top; y < bottom; ++y) {
      std::int32_t* to = grid.vertex_of_pixel.data() + static_cast<std::size_t>(y) * width;
      for (int x = left; x < right; ++x) to[x] = work.rank[to[x]];
    }
    grid.first_of_tile[static_cast<std::size_t>(line) * grid.columns() + column] =
        static_cast<std::int32_t>(work.found.size());
  }
}

/// Makes neighbors of the vertices of tile `a` and those of tile `b` whose color is `step` more.
void link(BilateralGrid& grid, int a, int b, Key step, int neighbor) {
  std::int32_t j = grid.first_of_tile[b];
  const std::int32_t end = grid.first_of_tile[b + 1];
  for (std::int32_t i = grid.first_of_tile[a]; i < grid.first_of_tile[a + 1]; ++i) {
    while (j < end && grid.color[j] < grid.color[i] + step) ++j;
    if (j == end || grid.color[j] != grid.color[i] + step) continue;
    grid.neighbors[static_cast<std::size_t>(i) * BilateralGrid::kNeighbors + neighbor + 1] = j;
    grid.neighbors[static_cast<std::size_t>(j) * BilateralGrid::kNeighbors + neighbor] = i;
  }
}

/// A vertex as interpolation meets it: the middle of its cell in color, and its value.
struct NearVertex {
  float luma, cb, cr, value;
};

/// Those of one row of tiles; none where there is no such row. What has no value is put out of every pixel's reach.
void find_near(const BilateralGrid& grid, int line, std::span<const float> values, int channels, int channel,
               std::vector<NearVertex>& near) {
  near.clear();
  if (line < 0 || line >= grid.rows()) return;
  const std::int32_t* first = grid.first_of_tile.data() + static_cast<std::size_t>(line) * grid.columns();
  for (std::int32_t v = first[0]; v < first[grid.columns()]; ++v) {
    const float value = values[static_cast<std::size_t>(v) * channels + channel];
    // cells count from 1
    const NearVertex vertex{static_cast<float>(grid.color[v] & 1023) - 0.5f,
                            static_cast<float>(grid.color[v] >> 10 & 1023) - 0.5f,
                            static_cast<float>(grid.color[v] >> 20) - 0.5f, value};
    near.push_back(std::isnan(value) ? NearVertex{-1e6f, 0, 0, 0} : vertex);
  }
}

/// A few pixels of a row between the same four tiles: as many as a vector register holds.
struct Segment {
  static constexpr int kPixels = 8;
  float luma[kPixels] = {}, cb[kPixels] = {}, cr[kPixels] = {};
  float position[kPixels] = {};  ///< weight of the tile's position
  float weights[kPixels] = {}, sums[kPixels] = {};

  Segment(const Positions& at, int left, int count) {
    std::copy_n(at.luma.data() + left, count, luma);
    std::copy_n(at.cb.data() + left, count, cb);
    std::copy_n(at.cr.data() + left, count, cr);
  }

  void add(const NearVertex& vertex) {
    for (int i = 0; i < kPixels; ++i) {
      const float weight = position[i] * std::max(1 - std::abs(luma[i] - vertex.luma), 0.0f) *
                           std::max(1 - std::abs(cb[i] - vertex.cb), 0.0f) *
                           std::max(1 - std::abs(cr[i] - vertex.cr), 0.0f);
      weights[i] += weight;
      sums[i] += weight * vertex.value;
    }
  }
};

}  // namespace

OptionFields fields(BilateralGridOptions& options) {
  return {{"cell_px", &options.cell_px, 1, 1e6, "px of the guide", "ours"},
          {"cell_luma", &options.cell_luma, 1, 1e6, "levels of 255", "ours"},
          {"cell_chroma", &options.cell_chroma, 1, 1e6, "levels of 255", "ours"}};
}

BilateralGrid make_bilateral_grid(const Image& guide, const BilateralGridOptions& options) {
  if (guide.empty() || (guide.channels != 1 && guide.channels != 3)) {
    throw InputError("bilateral grid: the guide must be a picture of 1 or 3 channels");
  }
  if (guide.pixel_count() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
    throw InputError("bilateral grid: the guide must have under 2^31 pixels");
  }
  check_options("grid", options);
  BilateralGrid grid;
  grid.cells = options;
  grid.width = guide.width;
  grid.height = guide.height;
  grid.column_begins = cell_begins(guide.width, options.cell_px);
  grid.row_begins = cell_begins(guide.height, options.cell_px);
  const int rows = grid.rows(), columns = grid.columns();

  // Tiles share no vertex, so their rows can be searched side by side.
  grid.vertex_of_pixel.resize(guide.pixel_count());
  std::vector<std::vector<Key>> colors(rows);
  grid.first_of_tile.resize(static_cast<std::size_t>(rows) * columns + 1);
  tbb::parallel_for(tbb::blocked_range<int>(0, rows), [&](const tbb::blocked_range<int>& lines) {
    Workspace work(grid);
    for (int line = lines.begin(); line < lines.end(); ++line) find_vertices(guide, line, work, grid, colors[line]);
  });
  for (std::int32_t& tile : grid.first_of_tile) {
    const std::int32_t size = tile;
    tile = grid.vertices;
    grid.vertices += size;
  }

  grid.color.resize(grid.vertices);
  grid.neighbors.resize(static_cast<std::size_t>(grid.vertices) * BilateralGrid::kNeighbors);
  tbb::parallel_for(0, rows, [&](int line) {
    const std::int32_t* first = grid.first_of_tile.data() + static_cast<std::size_t>(line) * columns;
    std::copy(colors[line].begin(), colors[line].end(), grid.color.begin() + *first);
    std::fill(grid.neighbors.begin() + static_cast<std::ptrdiff_t>(*first) * BilateralGrid::kNeighbors,
              grid.neighbors.begin() + static_cast<std::ptrdiff_t>(first[columns]) * BilateralGrid::kNeighbors,
              grid.vertices);
    for (int y = grid.row_begins[line]; y < grid.row_begins[line + 1]; ++y) {
      std::int32_t* to = grid.vertex_of_pixel.data() + static_cast<std::size_t>(y) * grid.width;
      for (int column = 0; column < columns; ++column) {
        for (int x = grid.column_begins[column]; x < grid.column_begins[column + 1]; ++x) to[x] += first[column];
      }
    }
  });
  tbb::parallel_for(0, rows, [&](int line) {
    for (int column = 0; column < columns; ++column) {
      const int tile = line * columns + column;
      if (column + 1 < columns) link(grid, tile, tile + 1, 0, 0);
      if (line + 1 < rows) link(grid, tile, tile + columns, 0, 2);
      for (int axis = 0; axis < 3; ++axis) link(grid, tile, tile, kOne[axis], 4 + 2 * axis);
    }
  });
  return grid;
}

Image interpolate(const BilateralGrid& grid, const Image& guide, std::span<const float> values, int channels) {
  const int width = grid.width, rows = grid.rows(), columns = grid.columns();
  // Pixels between the middles of four tiles form a block; at the border there are fewer tiles.
  const auto block_begins = [&](int size, int tiles) {
    std::vector<int> begins(tiles + 2, size);
    for (int x = size - 1; x >= 0; --x) begins[std::lround(cell_position(x, grid.cells.cell_px))] = x;
    begins[0] = 0;
    return begins;
  };
  const std::vector<int> block_columns = block_begins(width, columns), block_rows = block_begins(grid.height, rows);
  const auto weight_of_second = [&](int x) {  // of the two tiles, whose middles lie on either side
    const double at = cell_position(x, grid.cells.cell_px) + 0.5;
    return static_cast<float>(at - std::floor(at));
  };
  std::vector<float> across[2] = {std::vector<float>(width), std::vector<float>(width)};
  for (int x = 0; x < width; ++x) across[0][x] = 1 - (across[1][x] = weight_of_second(x));

  Image out(width, grid.height, channels);
  tbb::parallel_for(tbb::blocked_range<int>(0, rows + 1), [&](const tbb::blocked_range<int>& lines) {
    Positions at{std::vector<float>(width), std::vector<float>(width), std::vector<float>(width)};
    std::vector<NearVertex> near[2];  // of the rows of tiles above and below
    for (int line = lines.begin(); line < lines.end(); ++line) {
      for (int c = 0; c < channels; ++c) {
        for (int k = 0; k < 2; ++k) find_near(grid, line - 1 + k, values, channels, c, near[k]);
        for (int y = block_rows[line]; y < block_rows[line + 1]; ++y) {
          locate(guide, y, grid.cells, at);
          const float second = weight_of_second(y);
          for (int block = 0; block <= columns; ++block) {
            for (int left = block_columns[block]; left < block_columns[block + 1]; left += Segment::kPixels) {
              const int count = std::min(block_columns[block + 1] - left, Segment::kPixels);
              Segment segment(at, left, count);
              for (int corner = 0; corner < 4; ++corner) {
                const int row = line - 1 + corner / 2, column = block - 1 + corner % 2;
                if (row < 0 || row >= rows || column < 0 || column >= columns) continue;
                std::copy_n(across[corner % 2].data() + left, count, segment.position);
                const float down = corner / 2 ? second : 1 - second;
                for (float& weight : segment.position) weight *= down;
                const std::int32_t* first = grid.first_of_tile.data() + static_cast<std::size_t>(row) * columns;
                for (std::int32_t v = first[column]; v < first[column + 1]; ++v) {
                  segment.add(near[corner / 2][v - *first]);
                }
              }
              float* to = out.row(y) + static_cast<std::ptrdiff_t>(left) * channels + c;
              for (int i = 0; i < count; ++i) to[i * channels] = segment.sums[i] / segment.weights[i];
            }
          }
        }
      }
    }
  });
  return out;
}

}  // namespace dualpixel::pipeline
