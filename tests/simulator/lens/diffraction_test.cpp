#include "simulator/lens/diffraction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <map>
#include <vector>

#include "simulator/lens/lens_packet.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/sobol.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

double airy_share(double r) {
  const double x = M_PI * r, j0 = std::cyl_bessel_j(0.0, x), j1 = std::cyl_bessel_j(1.0, x);
  return 1 - j0 * j0 - j1 * j1;
}

/// The Airy pattern's density at radius r, 1 in the middle.
double airy_density(double r) {
  const double x = M_PI * r;
  return x < 1e-6 ? 1 : std::pow(2 * std::cyl_bessel_j(1.0, x) / x, 2);
}

Lens diffracting(double f_number) {
  Lens lens;
  lens.thin = {4.442e-3, f_number, 1};
  lens.diffraction = true;
  return lens;
}

double uniform(std::uint64_t key) { return unit_float(static_cast<std::uint32_t>(hash(key) >> 32)); }

// Rays of the middle of the picture, turned about at the focus plane, are its point spread. The share of light within
// r, in wavelengths times the working f-number, is the Airy pattern's; half of its width at half maximum is r = 0.5145.
// 160000 rays: a share has a standard error of at most 0.00125; the tolerance is four of these, and 0.8 % of the width.
TEST(Diffraction, OfTheWholePupilIsTheAiryPattern) {
  constexpr double kRadii[] = {0.2, 0.5145, 0.8, 1.22, 2, 5};
  constexpr int kPackets = 10000;
  for (const double f_number : {1.8, 2.8, 4.0}) {
    const LensSampler lens(diffracting(f_number), phone_sensor(2, 4, 1e-9));
    for (int color = 0; color < 3; ++color) {
      double within[std::size(kRadii)] = {};
      for (int packet = 0; packet < kPackets; ++packet) {
        alignas(64) float s[4][kPacket], u[2][kPacket];
        for (int i = 0; i < kPacket; ++i) {
          for (int d = 0; d < 4; ++d) s[d][i] = static_cast<float>(uniform(hash(packet, i, d)));
          for (int d = 0; d < 2; ++d) u[d][i] = static_cast<float>(uniform(hash(packet, i, 4 + d)));
        }
        LensPacket rays;
        lens.sample(1, 2, color, s, rays);
        lens.bend(color, u[0], u[1], rays);
        const double working = 1 / (2 * lens.lens().thin.rim_slope());
        const double unit = kFilterWavelengths_m[color] * working / lens.lens().thin.image_distance_m();
        for (int i = 0; i < kPacket; ++i) {
          const double r = std::hypot(rays.origin_x[i] + rays.slope_x[i], rays.origin_y[i] + rays.slope_y[i]) / unit;
          for (std::size_t k = 0; k < std::size(kRadii); ++k) within[k] += r < kRadii[k] ? 1.0 / (16 * kPackets) : 0;
        }
      }
      for (std::size_t k = 0; k < std::size(kRadii); ++k) {
        EXPECT_NEAR(within[k], airy_share(kRadii[k]), 0.005) << f_number << ' ' << color << ' ' << kRadii[k];
      }
    }
  }
}

// What bends more lies nearer to the edge, as uncertainty has it: the bend's length is mapped, its order kept.
TEST(Diffraction, KeepsTheOrderOfTheBends) {
  const Diffraction diffraction(diffracting(1.8).thin);
  double last = 0;
  for (double bend = 0.001; last < 50; bend *= 1.1) {
    const double mapped = bend * diffraction.stretch(static_cast<float>(bend * bend));
    EXPECT_GT(mapped, 0.999 * last);  // between the nodes of the table, where the Airy pattern has a zero
    last = mapped;
  }
}

// A ray at rho pupil radii along y bends across the edge by a normal number of deviation ~ 1/(1 - rho), along it by one
// of ~ 1/sqrt(1 - rho^2), and the map keeps the direction. So the median of |along / across|, that of a ratio of two
// normal numbers, is sqrt((1 - rho) / (1 + rho)). Of n it has a standard error of pi / (2 sqrt(n)) of itself: 0.6 %,
// four of these.
TEST(Diffraction, BendsMostAcrossTheNearestEdge) {
  constexpr int kRays = 65536;
  const Lens lens = diffracting(1.8);
  const Diffraction diffraction(lens.thin);
  for (const double rho : {0.2, 0.6, 0.9}) {
    std::vector<double> ratios;
    for (int packet = 0; packet < kRays / kPacket; ++packet) {
      alignas(64) float u[2][kPacket];
      LensPacket rays{};
      for (int i = 0; i < kPacket; ++i) {
        for (int d = 0; d < 2; ++d) u[d][i] = static_cast<float>(uniform(hash(packet, i, d)));
        rays.origin_y[i] = static_cast<float>(rho * 0.5 * lens.thin.pupil_diameter_m());
      }
      diffraction.bend(540e-9, u[0], u[1], rays);
      for (int i = 0; i < kPacket; ++i) ratios.push_back(std::abs(rays.slope_x[i] / rays.slope_y[i]));
    }
    std::nth_element(ratios.begin(), ratios.begin() + kRays / 2, ratios.end());
    EXPECT_NEAR(ratios[kRays / 2] / std::sqrt((1 - rho) / (1 + rho)), 1, 4 * M_PI / 2 / std::sqrt(kRays)) << rho;
  }
}

/// The disparity of a texture of `frequency` (per meter on the sensor) that a blur of diameter b_m spreads, in meters:
/// of waves of length lambda_m through a ramp split, or where that is 0 of rays. The transfer of a view is the
/// autocorrelation of its pupil (Goodman, Introduction to Fourier Optics, ch. 6), whose amplitude is the root of the
/// view's share and whose phase is that of defocus; across the texture's lines one integral is left.
double disparity_of_waves(double frequency, double b_m, double lambda_m, double working, double k) {
  constexpr int kSteps = 20000;
  const double apart = 2 * lambda_m * working * frequency;  // of the two points that interfere, pupil radii
  std::complex<double> left, right;
  for (int i = 0; i < kSteps; ++i) {
    const double x = (2 * i + 1.0) / kSteps - 1, near = std::abs(x) + 0.5 * apart;
    if (near >= 1) continue;
    const double chord = std::sqrt(1 - near * near), p = x + 0.5 * apart, q = x - 0.5 * apart;
    const auto light = chord * std::polar(1.0, -M_PI * b_m * frequency * x);
    right += light * std::sqrt((1 + p / k) * (1 + q / k));
    left += light * std::sqrt((1 - p / k) * (1 - q / k));
  }
  return std::arg(left * std::conj(right)) / (2 * M_PI * frequency);
}

/// The same of rays.
double disparity_of(const std::vector<std::array<double, 3>>& rays, double frequency) {
  std::complex<double> left, right;
  for (const auto& [place, left_light, right_light] : rays) {
    const auto turn = std::polar(1.0, -2 * M_PI * frequency * place);
    left += left_light * turn;
    right += right_light * turn;
  }
  return std::arg(left * std::conj(right)) / (2 * M_PI * frequency);
}

// Rays near the rim bend most. Out of focus they are those that differ most in the two views, so diffraction pulls the
// disparity of fine texture towards 0, by up to an eighth here; and waves do the same. Bends are an approximation: the
// pull is asked to be theirs to a third, and to three standard errors of 64 batches of rays.
TEST(Diffraction, PullsTheDisparityOfBlurAsWavesDo) {
  constexpr int kBatches = 64, kPackets = 1024;
  constexpr double kDpPixel_m = 2.8e-6;
  Lens lens = diffracting(1.8);
  lens.thin.focus_distance_m = 0.5;
  const LensSampler sampler(lens, phone_sensor(2, 4, 1e-9));
  const ThinLens& thin = lens.thin;
  const double working = 1 / (2 * thin.rim_slope()), image_m = thin.image_distance_m();
  for (const double b_um : {4.0, 8.0, 14.0}) {
    const double blur = b_um * 1e-6 / (thin.pupil_diameter_m() * image_m);  // dioptres behind the focus
    const double distance_m = 1 / (1 / thin.focus_distance_m - blur);
    std::map<double, std::vector<double>> pulls;
    for (int batch = 0; batch < kBatches; ++batch) {
      std::vector<std::array<double, 3>> straight, bent;
      for (int packet = 0; packet < kPackets; ++packet) {
        alignas(64) float s[4][kPacket], u[2][kPacket];
        joint_samples(packet * kPacket, hash(batch), s);
        for (int i = 0; i < kPacket; ++i) {
          for (int d = 0; d < 2; ++d) u[d][i] = static_cast<float>(uniform(hash(batch, packet * kPacket + i, d)));
        }
        LensPacket rays;
        sampler.sample(1, 2, 1, s, rays);
        for (auto* kept : {&straight, &bent}) {
          for (int i = 0; i < kPacket; ++i) {
            const double place_m = image_m * (rays.origin_x[i] / distance_m + rays.slope_x[i]);
            kept->push_back({place_m, rays.left[i], rays.right[i]});
          }
          sampler.bend(1, u[0], u[1], rays);
        }
      }
      for (const double cycles : {0.05, 0.1, 0.15}) {
        const double frequency = cycles / kDpPixel_m;
        pulls[cycles].push_back(std::abs(disparity_of(bent, frequency)) - std::abs(disparity_of(straight, frequency)));
      }
    }
    for (const auto& [cycles, batches] : pulls) {
      const double frequency = cycles / kDpPixel_m;
      const double of_waves =
          std::abs(disparity_of_waves(frequency, b_um * 1e-6, kFilterWavelengths_m[1], working, lens.split.k)) -
          std::abs(disparity_of_waves(frequency, b_um * 1e-6, 0, working, lens.split.k));
      double mean = 0, variance = 0;
      for (const double pull : batches) mean += pull / kBatches;
      for (const double pull : batches) variance += std::pow(pull - mean, 2) / (kBatches - 1);
      const double standard_error = std::sqrt(variance / kBatches);
      EXPECT_LT(of_waves, 0);
      EXPECT_NEAR(mean, of_waves, std::abs(of_waves) / 3 + 3 * standard_error) << b_um << ' ' << cycles;
    }
  }
}

// A point in focus, rendered: a source one photosite wide, at three f-numbers with photosites in proportion. The mean
// distance of its light from its center within the picture, against the Airy pattern averaged over photosite and
// source. Some 15000 of the samples meet the source: 0.5 %; 3 % is asked for.
TEST(SlowDiffraction, ARenderedPointInFocusHasAirysWidth) {
  constexpr int kSide = 16;
  for (const double f_number : {1.8, 2.8, 4.0}) {
    const double pitch_m = 0.3e-6 * f_number / 1.8;
    const CameraView camera{glm::mat4(1), LensSampler(diffracting(f_number), phone_sensor(kSide, kSide, pitch_m))};
    const ThinLens& thin = camera.lens.lens().thin;
    const auto half = static_cast<float>(0.5 * pitch_m / thin.image_distance_m());
    Scene scene;
    scene.materials = {glowing(1000)};
    scene.meshes = {make_quad({-half, -half, 1}, {2 * half, 0, 0}, {0, 2 * half, 0}, 0)};
    const Image seen = undivided(render_views(RenderScene(scene), camera, {.samples_per_pixel = 16384}));
    const double unit_px = kFilterWavelengths_m[1] / (2 * thin.rim_slope()) / pitch_m;  // of green
    double light = 0, moment = 0, airy_light = 0, airy_moment = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        if ((x + y) % 2 == 0) continue;  // green photosites: the others have other wavelengths
        const double r = std::hypot(x + 0.5 - 0.5 * kSide, y + 0.5 - 0.5 * kSide);
        light += seen.at(x, y, 1), moment += r * seen.at(x, y, 1);
        for (int k = 0; k < 256; ++k) {  // positions on the photosite and on the source
          const auto at = [k](int shift) { return ((k >> shift & 3) + 0.5) / 4 - 0.5; };
          const double dx = x + 0.5 - 0.5 * kSide + at(0) + at(4), dy = y + 0.5 - 0.5 * kSide + at(2) + at(6);
          const double density = airy_density(std::hypot(dx, dy) / unit_px);
          airy_light += density, airy_moment += r * density;
        }
      }
    }
    EXPECT_NEAR(moment / light / (airy_moment / airy_light), 1, 0.03) << f_number;
  }
}

}  // namespace
}  // namespace dualpixel::simulator::testing
