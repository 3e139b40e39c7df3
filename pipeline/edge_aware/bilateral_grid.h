#pragma once
#include <cstdint>
#include <vector>

#include "capture/image.h"

/// The bilateral grid of Barron and Poole 2016, "The Fast Bilateral Solver", section 2: pixels that are near in x, y,
/// Y, Cb and Cr share a vertex; vertices one cell apart along one of the five axes are neighbours.
namespace dualpixel::pipeline {

struct BilateralGridOptions {
  float cell_px = 8;      ///< side of a cell along x and y, pixels of the guide; at least 1
  float cell_luma = 8;    ///< along Y, of 255 levels; at least 1. 8, 8, 8 as the authors' public code
  float cell_chroma = 8;  ///< along Cb and Cr, of 255 levels; at least 1
};

struct BilateralGrid {
  static constexpr int kNeighbors = 10;  ///< two along each axis
  int width = 0;                         ///< of the guide
  int height = 0;
  int vertices = 0;
  std::vector<std::int32_t> vertex_of_pixel;
  std::vector<std::int32_t> neighbors;  ///< kNeighbors for each vertex; `vertices` stands for none
};

/// `guide` is RGB, 0..255, at most 65536 pixels a side. Cells are told apart by their five integer coordinates, never
/// by a hash alone. Vertices are numbered in the order in which rows, from the top, first touch them.
BilateralGrid make_bilateral_grid(const Image& guide, const BilateralGridOptions& options = {});

}  // namespace dualpixel::pipeline
