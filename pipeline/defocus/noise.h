#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "capture/capture.h"
#include "capture/image/image.h"
#include "pipeline/option_field.h"

/// Synthetic noise for what the blur has smoothed (Wadhwa et al. 2018, section 5.3 and supplement, "Noise generation").
///
/// It departs from the paper in two ways. Noise is added in linear light, before the gamma curve: there its variance is
/// known, shot * v + read, and the curve then shapes it as it shapes the sharp part's own. And its level is that of the
/// capture's noise profile at the blurred picture's value, where the paper measures the input's around each pixel:
/// texture would count as noise there.
namespace dualpixel::pipeline {

struct NoiseOptions {
  std::array<int, 3> periods_px = {59, 61, 67};  ///< l_i, relatively prime (section 5.3); the paper gives no values
  int feather_px = 16;                           ///< width over which patches fade into each other; ours
  float high_pass_sigma_px = 6;                  ///< noise coarser than this is taken out; ours
};

OptionFields fields(NoiseOptions& options);

/// A square RGB picture that repeats without a seam. The sum of all patches is to the noise of a demosaicked picture
/// what 1 is to the standard deviation of its photosites.
using NoisePatch = Image;

/// The supplement's procedure with a simulated flat field for the photographed one: a flat gray mosaic with white
/// noise, demosaicked as pictures are (so the noise is correlated as theirs is), high-passed, feathered at its edges,
/// laid out four times at a spacing of l, cropped to l x l. Divided by the root of the summed squared alphas, which
/// keeps the variance even where copies overlap (the supplement divides by alpha, for which it dips). One patch for
/// each period.
std::vector<NoisePatch> make_noise_patches(std::uint64_t seed, const NoiseOptions& options = {});

/// Noise of the merged picture: variance of a channel whose normalized, white-balanced signal is v:
///     gain * (shot * v + gain * read)
/// (the gain of the color's white balance, times that of lens shading)
/// of the camera's colors. Those of linear sRGB are theirs through the matrix, for demosaicking makes the three depend
/// on each other.
struct NoiseLevel {
  double shot = 0;
  double read = 0;
  std::array<double, 3> gains = {1, 1, 1};
  Matrix3 color_matrix = kIdentity3;  ///< from the camera's balanced colors to linear sRGB
};

/// Of a merged burst of `frames` mosaics (merge.h).
NoiseLevel merged_noise(const Exposure& exposure, int frames);

/// B_noisy = B + sigma(B) M_blur sum_i s_i N_i(x mod l_i), in place; pixels with `blurred` 0 stay as they are. s_i is 1
/// or -1, at random for each copy of a patch: copies of one sign, as the paper has them, would correlate by a third one
/// period apart, and noise is as good upside down. `shading_gain`: what each pixel was multiplied by against lens
/// shading (capture/shading.h), its noise with it; empty: by none.
void add_noise(Image& rgb, const Image& blurred, const std::vector<NoisePatch>& patches, const NoiseLevel& level,
               const Image& shading_gain = {});

}  // namespace dualpixel::pipeline
