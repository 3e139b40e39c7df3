#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "capture/image/image.h"
#include "pipeline/edge_aware/options.h"
#include "pipeline/option_field.h"

/// The bilateral grid of Barron and Poole 2016, "The Fast Bilateral Solver", section 2: pixels that are near in x, y,
/// Y, Cb and Cr share a vertex; vertices one cell apart along one of the five axes are neighbors.
namespace dualpixel::pipeline {

OptionFields fields(BilateralGridOptions& options);

struct BilateralGrid {
  static constexpr int kNeighbors = 10;  ///< two along each axis: left, right, up, down, less and more Y, Cb, Cr
  BilateralGridOptions cells;
  int width = 0;  ///< of the guide
  int height = 0;
  std::vector<int> column_begins;  ///< first pixel of each tile along x, and the width; a tile is a cell of x and y
  std::vector<int> row_begins;
  int vertices = 0;
  std::vector<std::int32_t> vertex_of_pixel;
  std::vector<std::int32_t> neighbors;      ///< kNeighbors for each vertex; `vertices`: none
  std::vector<std::int32_t> first_of_tile;  ///< first vertex of each tile, row by row, and `vertices` at the end
  std::vector<std::uint32_t> color;         ///< of each vertex: cells along Cr, Cb and Y, 10 bits each, from 1 on

  int columns() const { return static_cast<int>(column_begins.size()) - 1; }
  int rows() const { return static_cast<int>(row_begins.size()) - 1; }
};

/// `guide` is RGB or gray, 0..255; what is outside counts as the nearest level, NaN as 0. Cells are told apart by their
/// five integer coordinates, never by a hash alone; along chroma they are centered on gray, lest rounding split it.
/// Vertices are in the order of their tiles, row by row, then of their colors.
///
/// There are at most as many vertices as pixels: 4 bytes a pixel and 44 a vertex, whatever the guide holds, and while
/// it is made some 16 for each pixel of a tile and thread. Throws InputError where the guide is empty, has 2^31 pixels
/// or more or another number of channels, or a cell is not 1 to 1e6.
BilateralGrid make_bilateral_grid(const Image& guide, const BilateralGridOptions& options = {});

/// A picture from `channels` values for each vertex: each pixel takes the mean over the vertices less than a cell away
/// along every axis, weighted by the product of 1 - distance: multilinear interpolation where all 32 corners exist,
/// continuous in position and color in any case. A look-up by vertex_of_pixel would show the cells' borders. Vertices
/// whose values are not a number are left out; pixels near no other vertex are not a number either. `guide` is the
/// grid's own. Time grows with the vertices that share a tile.
Image interpolate(const BilateralGrid& grid, const Image& guide, std::span<const float> values, int channels);

}  // namespace dualpixel::pipeline
