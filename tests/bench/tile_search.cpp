#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>
#include <vector>

#include "pipeline/disparity/paper/match.h"
#include "pipeline/disparity/tile_disparity.h"
#include "tests/pipeline/texture.h"

/// The paper's search for the disparity of tiles at 1344 x 1008, by brute force as it is shipped and by FFT (Wadhwa et
/// al. 2018, section 4.1: 4 and 40 ms on a phone). CPU time of all threads.
namespace dualpixel::pipeline {
namespace {

constexpr int kWidth = 1344, kHeight = 1008, kTile = 8, kRange = 3;
constexpr int kLength = 16;  // a tile's row and the range on both of its sides, up to a power of two

Image view(double shift_dp_px) { return textured(Texture(3, 1.0 / 8), kWidth, kHeight, shift_dp_px); }

void by_brute_force(benchmark::State& state) {
  const Image left = view(0), right = view(1.2);
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(match_tiles(left, right));
}
BENCHMARK(by_brute_force)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

/// What one tile needs, kept for the next.
struct Buffers {
  Eigen::FFT<float> fft;
  std::vector<std::complex<float>> rows, spectrum, product, correlation;
  Buffers() : rows(kLength), spectrum(kLength), product(kLength), correlation(kLength) {}
};

/// The shift of the least sum of squared differences, whole pixels: those of the two windows by themselves, less twice
/// their correlation, which is a product of spectra. The left row is the real part of a signal and the right row the
/// imaginary part, so that one transform gives both spectra.
int shift_of_tile(Buffers& buffers, const Image& left, const Image& right, int x0, int y0) {
  auto& [fft, rows, spectrum, product, correlation] = buffers;
  std::fill(product.begin(), product.end(), 0);
  std::array<float, 2 * kRange + 1> squares{};
  for (int y = y0; y < y0 + kTile; ++y) {
    const float *l = left.row(y) + x0, *r = right.row(y) + x0 - kRange;
    for (int x = 0; x < kTile + 2 * kRange; ++x) rows[x] = {x < kTile ? l[x] : 0, r[x]};
    for (int shift = 0; shift <= 2 * kRange; ++shift) {
      for (int x = 0; x < kTile; ++x) squares[shift] += r[x + shift] * r[x + shift];
    }
    fft.fwd(spectrum.data(), rows.data(), kLength);
    for (int k = 0; k < kLength; ++k) {
      const std::complex<float> a = spectrum[k], b = std::conj(spectrum[(kLength - k) % kLength]);
      product[k] += std::conj(0.5F * (a + b)) * std::complex<float>(0, -0.5F) * (a - b);
    }
  }
  fft.inv(correlation.data(), product.data(), kLength);
  int best = 0;
  for (int shift = 1; shift <= 2 * kRange; ++shift) {
    if (squares[shift] - 2 * correlation[shift].real() < squares[best] - 2 * correlation[best].real()) best = shift;
  }
  return best - kRange;
}

void by_fft(benchmark::State& state) {
  const Image left = view(0), right = view(1.2);
  Buffers buffers;
  Image shifts(kWidth / kTile, kHeight / kTile);
  for ([[maybe_unused]] auto _ : state) {
    for (int v = 0; v < shifts.height; ++v) {
      for (int u = 1; u < shifts.width - 1; ++u) {
        shifts.at(u, v) = static_cast<float>(shift_of_tile(buffers, left, right, u * kTile, v * kTile));
      }
    }
  }
  const Image found = match_tiles(left, right).disparity_dp_px;
  for (int v = 0; v < shifts.height; ++v) {
    for (int u = 1; u < shifts.width - 1; ++u) {
      if (std::abs(found.at(u, v) - shifts.at(u, v)) > 0.51F) return state.SkipWithError("finds another shift");
    }
  }
}
BENCHMARK(by_fft)->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

}  // namespace
}  // namespace dualpixel::pipeline
