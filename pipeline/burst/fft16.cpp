#include "pipeline/burst/fft16.h"

#include <algorithm>

namespace dualpixel::pipeline::fft16 {
namespace {

/// cos and sin of 2 pi k / 16.
constexpr float kCos[10] = {1,     0.92387953f, 0.70710678f, 0.38268343f, 0, -0.38268343f, -0.70710678f, -0.92387953f,
                            -1.0f, -0.92387953f};
constexpr float kSin[10] = {0,           0.38268343f, 0.70710678f, 0.92387953f, 1,
                            0.92387953f, 0.70710678f, 0.38268343f, 0,           -0.38268343f};

/// Four samples to their transform, exp(-2 pi i k x / 4).
inline void transform_4(Lanes re[4], Lanes im[4]) {
  const Lanes even_re = re[0] + re[2], even_im = im[0] + im[2];
  const Lanes odd_re = re[1] + re[3], odd_im = im[1] + im[3];
  const Lanes even_less_re = re[0] - re[2], even_less_im = im[0] - im[2];
  const Lanes odd_less_re = re[1] - re[3], odd_less_im = im[1] - im[3];
  re[0] = even_re + odd_re;
  im[0] = even_im + odd_im;
  re[1] = even_less_re + odd_less_im;
  im[1] = even_less_im - odd_less_re;
  re[2] = even_re - odd_re;
  im[2] = even_im - odd_im;
  re[3] = even_less_re - odd_less_im;
  im[3] = even_less_im + odd_less_re;
}

/// One half of the columns along the row index, by 4 x 4 (Cooley & Tukey 1965).
inline void transform_rows(Lanes (&re)[kTile][kHalves], Lanes (&im)[kTile][kHalves], int half) {
  Lanes step_re[4][4], step_im[4][4];  // [frequency mod 4][row mod 4]
#pragma GCC unroll 4
  for (int row = 0; row < 4; ++row) {
    Lanes four_re[4], four_im[4];
    for (int k = 0; k < 4; ++k) {
      four_re[k] = re[row + 4 * k][half];
      four_im[k] = im[row + 4 * k][half];
    }
    transform_4(four_re, four_im);
    step_re[0][row] = four_re[0];
    step_im[0][row] = four_im[0];
#pragma GCC unroll 4
    for (int k = 1; k < 4; ++k) {
      const float c = kCos[k * row], s = kSin[k * row];
      step_re[k][row] = four_re[k] * c + four_im[k] * s;
      step_im[k][row] = four_im[k] * c - four_re[k] * s;
    }
  }
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) {
    transform_4(step_re[k], step_im[k]);
    for (int m = 0; m < 4; ++m) {
      re[k + 4 * m][half] = step_re[k][m];
      im[k + 4 * m][half] = step_im[k][m];
    }
  }
}

void transform_rows(Lanes (&re)[kTile][kHalves], Lanes (&im)[kTile][kHalves]) {
  for (int half = 0; half < kHalves; ++half) transform_rows(re, im, half);
}

inline void transpose_8(const Lanes in[8], Lanes out[8]) {
  Lanes pairs[8], fours[8];
  for (int k = 0; k < 8; k += 2) {
    pairs[k] = __builtin_shufflevector(in[k], in[k + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    pairs[k + 1] = __builtin_shufflevector(in[k], in[k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (int k = 0; k < 8; k += 4) {
    for (int m = 0; m < 2; ++m) {
      fours[k + m] = __builtin_shufflevector(pairs[k + m], pairs[k + m + 2], 0, 1, 8, 9, 4, 5, 12, 13);
      fours[k + m + 2] = __builtin_shufflevector(pairs[k + m], pairs[k + m + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    }
  }
  for (int k = 0; k < 4; ++k) {
    out[k] = __builtin_shufflevector(fours[k], fours[k + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    out[k + 4] = __builtin_shufflevector(fours[k], fours[k + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

void transpose(Lanes (&rows)[kTile][kHalves]) {
  Lanes block[kHalves][kHalves][kLanes];  // [half of rows][half of columns][row]
  for (int v = 0; v < kHalves; ++v) {
    for (int h = 0; h < kHalves; ++h) {
      Lanes in[kLanes];
      for (int k = 0; k < kLanes; ++k) in[k] = rows[kLanes * v + k][h];
      transpose_8(in, block[v][h]);
    }
  }
  for (int v = 0; v < kHalves; ++v) {
    for (int h = 0; h < kHalves; ++h) {
      for (int k = 0; k < kLanes; ++k) rows[kLanes * h + k][v] = block[v][h][k];
    }
  }
}

void multiply_rows(ComplexTile& tile, const Phases& phases) {
  for (int row = 0; row < kTile; ++row) {
    const float c = phases.re[row], s = phases.im[row];
    for (int half = 0; half < kHalves; ++half) {
      const Lanes re = tile.re[row][half], im = tile.im[row][half];
      tile.re[row][half] = re * c - im * s;
      tile.im[row][half] = re * s + im * c;
    }
  }
}

}  // namespace

void transform(ComplexTile& tile, const Phases& along_x, const Phases& along_y) {
  transform_rows(tile.re, tile.im);
  multiply_rows(tile, along_y);
  transpose(tile.re);
  transpose(tile.im);
  transform_rows(tile.re, tile.im);
  multiply_rows(tile, along_x);
}

void transform(ComplexTile& tile) {
  transform_rows(tile.re, tile.im);
  transpose(tile.re);
  transpose(tile.im);
  transform_rows(tile.re, tile.im);
}

void transform_back(ComplexTile& spectrum) {
  // with real and imaginary parts exchanged, the transform is its own inverse
  transform_rows(spectrum.im, spectrum.re);
  transpose(spectrum.re);
  transpose(spectrum.im);
  transform_rows(spectrum.im, spectrum.re);
}

}  // namespace dualpixel::pipeline::fft16
