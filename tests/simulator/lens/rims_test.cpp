#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "simulator/lens/lens_file.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/lens/prescription/prescription.h"
#include "simulator/lens/prescription/pupil_bounds.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/sobol.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

struct Light {
  double mean = 0, deviation = 0;  ///< of `samples` samples' light; of one photosite from the next, over the mean
  double blocked = 0;              ///< share of samples
};

/// Of both views together, in green.
Light light_of(const LensSampler& lens, int x, int y, int samples) {
  constexpr int kPhotosites = 1024;
  Light light;
  double square = 0;
  for (int k = 0; k < kPhotosites; ++k) {
    double sum = 0;
    for (int first = 0; first < samples; first += kPacket) {
      alignas(64) float s[4][kPacket];
      LensPacket rays;
      mirrored_samples(static_cast<std::uint32_t>(first / 2), hash(k), s);
      lens.sample(x, y, 1, s, rays);
      for (int i = 0; i < kPacket; ++i) {
        const double weight = rays.left[i] + rays.right[i];
        sum += weight / samples;
        light.blocked += weight == 0 ? 1.0 / (static_cast<double>(samples) * kPhotosites) : 0;
      }
    }
    light.mean += sum / kPhotosites;
    square += sum * sum / kPhotosites;
  }
  light.deviation = std::sqrt(std::max(square - light.mean * light.mean, 0.0)) / light.mean;
  return light;
}

/// Area of what two discs share, whose centers are `apart`, over that of the first, of radius 1.
double shared_area(double radius, double apart) {
  const double a = std::acos((apart * apart + 1 - radius * radius) / (2 * apart));
  const double b = std::acos((apart * apart + radius * radius - 1) / (2 * apart * radius));
  return (a - 0.5 * std::sin(2 * a) + radius * radius * (b - 0.5 * std::sin(2 * b))) / M_PI;
}

// Two discs that part with the field leave what they share: closed form, to the net's 2e-3. No sample is lost, so that
// 64 of them have the same light to a percent, where those of the whole pupil scatter by 1.8 to 4.5 %.
TEST(Rims, OfAnAberratedLensTakeNoSamples) {
  Lens lens;
  lens.thin = {4.442e-3, 1.8, 1};
  Aberrations& a = lens.model.emplace<Aberrations>();
  a.image_radius_mm = 3;
  a.rims = {{.radius = 1.1, .shift = 0.9}};
  a.falloff = Aberrations::Falloff::none;
  const LensSampler sampler(lens, phone_sensor(2000, 4, 3e-6));  // the last column at h = 1
  for (const double h : {0.3, 0.6, 0.9}) {
    const int x = 1000 + static_cast<int>(1000 * h * sampler.lens().thin.image_distance_m() / 4.442e-3);
    const double at_m = sampler.sensor().middle_m(x, 2).x;
    const double apart = 0.9 * at_m / (3e-3 * sampler.lens().thin.image_distance_m() / 4.442e-3);
    const Light light = light_of(sampler, x, 2, 64);
    EXPECT_NEAR(light.mean, shared_area(1.1, apart), 2e-3) << h;
    EXPECT_EQ(light.blocked, 0) << h;
    EXPECT_LT(light.deviation, 0.01) << h;
  }
}

// Of a prescription the region that the rims leave is looked up between nodes, and its polynomials differ a little from
// its rays: of 200 samples one at most is lost, where 4 of 100 lie outside of it in the ellipse of directions. Light is
// what a grid of traced directions says that passes (PupilBounds::pass_area), whose cells are .4 % of it at the edge.
TEST(Rims, OfAPrescriptionTakeHardlyAny) {
  for (const std::string name : {"phone_6p_4.2mm_f1.8", "phone_7p_4.9mm_f1.85", "double_gauss_100mm_f5"}) {
    Lens lens = read_lens_file(DUALPIXEL_SOURCE_DIR "/lens_models/" + name + ".json", 3);
    lens.split.kind = SplitKind::hard;  // which loses nothing
    const Prescription& prescription = *prescription_of(lens);
    const double radius_mm = prescription.image_radius_mm;
    const LensSampler sampler(lens, phone_sensor(2000, 2000, 1e-3 * radius_mm / std::hypot(1000, 1000)));
    const PupilBounds bounds = find_pupil(prescription, prescription.wavelengths_nm[1], radius_mm);
    for (const double field : {0.0, 0.3, 0.6, 0.95}) {
      const int at = 1000 + static_cast<int>(999 * field);
      const Light light = light_of(sampler, at, at, 64);
      const double r_mm = 1e3 * glm::length(sampler.sensor().middle_m(at, at));
      EXPECT_NEAR(light.mean, bounds.at(r_mm).pass_area / bounds.nodes[0].pass_area, 0.004) << name << ' ' << field;
      EXPECT_LT(light.blocked, 0.005) << name << ' ' << field;
      EXPECT_LT(light.deviation, 0.012) << name << ' ' << field;
    }
  }
}

}  // namespace
}  // namespace dualpixel::simulator::testing
