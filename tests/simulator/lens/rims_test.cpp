#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "simulator/lens/lens_file.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/lens/prescription/prescription.h"
#include "simulator/lens/prescription/pupil_bounds.h"
#include "simulator/lens/prescription/pupil_reach.h"
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

// Two rims, and one that hides the pupil's middle, whose samples are lost as they were: closed forms again.
TEST(Rims, OfAnAberratedLensHaveTheirLight) {
  const auto light_at_the_edge = [](std::vector<Aberrations::Rim> rims) {
    Lens lens;
    lens.thin = {4.442e-3, 1.8, 1000};
    Aberrations& a = lens.model.emplace<Aberrations>();
    a.image_radius_mm = 1e3 * 3e-6 * 999.5;
    a.rims = std::move(rims);
    a.falloff = Aberrations::Falloff::none;
    return light_of(LensSampler(lens, phone_sensor(2000, 4, 3e-6)), 1999, 2, 1024).mean;
  };
  // on both sides, so far that they do not meet: each takes what is not shared
  EXPECT_NEAR(light_at_the_edge({{1, .3}, {1, -.3}}), shared_area(1, .6), 2e-3);
  EXPECT_NEAR(light_at_the_edge({{.6, .8}}), shared_area(.6, .8), 2e-3);
}

// Two discs, one of which wanders off with the distance from the axis: between the table's places the reach is the
// region's to a thousandth, and less by no more than the corner where the discs meet is cut.
TEST(Rims, ReachIsTheRegionsBetweenPlacesToo) {
  PupilBounds bounds{};
  bounds.image_radius_mm = 2;
  constexpr double kRadius = 1.2;
  const auto inside = [](double r_mm, double x, double y) {
    return std::hypot(x, y) <= 1 && std::hypot(x, y - 0.35 * r_mm * r_mm / 2) <= kRadius;
  };
  const PupilReaches reaches = find_reaches(bounds, [&](double r_mm, const PupilPositions& at, bool passes[kPacket]) {
    for (int i = 0; i < kPacket; ++i) passes[i] = inside(r_mm, at.x[i], at.y[i]);
  });
  for (int trial = 0; trial < 2000; ++trial) {
    const double r_mm = 2 * unit_float(static_cast<std::uint32_t>(hash(trial, 0)));
    const double angle = 2 * M_PI * unit_float(static_cast<std::uint32_t>(hash(trial, 1)));
    PupilPositions at;
    std::fill_n(at.x, kPacket, static_cast<float>(std::cos(angle)));
    std::fill_n(at.y, kPacket, static_cast<float>(std::sin(angle)));
    std::fill_n(at.area, kPacket, 1.0f);
    reaches.at(r_mm, 2).draw_in(at);
    const double reach = std::hypot(at.x[0], at.y[0]);
    EXPECT_TRUE(inside(r_mm, 0.99 * at.x[0], 0.99 * at.y[0])) << r_mm << ' ' << angle << ' ' << reach;
    EXPECT_FALSE(inside(r_mm, 1.003 * at.x[0], 1.003 * at.y[0])) << r_mm << ' ' << angle << ' ' << reach;
    EXPECT_NEAR(at.area[0], reach * reach, 1e-5);
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
    // with photosites over which the pupil moves, each ray traced
    auto& model = std::get<PrescriptionModel>(lens.model);
    model.exact_trace = true;
    const LensSampler coarse(lens, phone_sensor(100, 100, 1e-3 * radius_mm / std::hypot(50, 50)));
    const double r_mm = 1e3 * glm::length(coarse.sensor().middle_m(85, 85));
    const Light light = light_of(coarse, 85, 85, 64);
    EXPECT_NEAR(light.mean, bounds.at(r_mm).pass_area / bounds.nodes[0].pass_area, 0.004) << name;
    EXPECT_LT(light.blocked, 0.01) << name;
  }
}

}  // namespace
}  // namespace dualpixel::simulator::testing
