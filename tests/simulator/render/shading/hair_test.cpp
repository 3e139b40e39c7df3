// The hair model against what it promises.
#include "simulator/render/shading/hair.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "simulator/sampling/hash.h"

namespace dualpixel::simulator::testing {
namespace {

glm::vec3 towards(double sine, double azimuth) {
  const double cosine = std::sqrt(1 - sine * sine);
  return {float(sine), float(cosine * std::cos(azimuth)), float(cosine * std::sin(azimuth))};
}

/// Integral over the sphere: midpoints, equal in solid angle.
template <typename F>
double sphere_integral(F f) {
  constexpr int kRows = 150, kColumns = 300;
  double sum = 0;
  for (int i = 0; i < kRows; ++i) {
    for (int j = 0; j < kColumns; ++j) sum += f(towards(2 * (i + 0.5) / kRows - 1, 2 * M_PI * (j + 0.5) / kColumns));
  }
  return 4 * M_PI * sum / (kRows * kColumns);
}

// White hair in a white furnace is invisible, wherever the eye meets it; colored hair is darker. The density of its
// samples integrates to 1.
TEST(Hair, WhiteGivesBackAllLight) {
  HairStrand s;
  for (const float roughness : {0.25f, 0.9f}) {
    for (const float across : {0.0f, 0.5f, -0.9f}) {
      for (const double sine : {0.0, 0.6, -0.9}) {
        s.roughness = roughness, s.across = across;
        const glm::vec3 to_eye = towards(sine, 0.4);
        s.color = glm::vec3(1);
        const auto scattered = [&](glm::vec3 d) { return hair_scattering(s, to_eye, d).y; };
        EXPECT_NEAR(sphere_integral(scattered), 1, 0.01) << roughness << ", " << across << ", " << sine;
        EXPECT_NEAR(sphere_integral([&](glm::vec3 d) { return hair_pdf(s, to_eye, d); }), 1, 0.01);
        s.color = {0.3f, 0.2f, 0.1f};
        EXPECT_LT(sphere_integral(scattered), 0.9);
      }
    }
  }
}

// The mean of scattering over density is the integral of scattering, by samples and by midpoints.
TEST(Hair, SamplesFollowTheirDensity) {
  HairStrand s;
  s.color = {0.6f, 0.4f, 0.2f}, s.roughness = 0.35f, s.across = 0.3f;
  const glm::vec3 to_eye = towards(0.3, 1);
  // of light from one side, so that a wrong direction shows
  const auto lit = [&](glm::vec3 d) { return hair_scattering(s, to_eye, d).y * (d.y > 0.2f && d.x < 0.4f); };
  double sum = 0, squares = 0;
  constexpr std::uint64_t kSamples = 200000;
  for (std::uint64_t i = 0; i < kSamples; ++i) {
    std::array<float, 4> numbers;
    for (int k = 0; k < 4; ++k) numbers[k] = unit_float(static_cast<std::uint32_t>(hash(i, k) >> 32));
    const glm::vec3 d = sample_hair(s, to_eye, numbers);
    const double value = lit(d) / hair_pdf(s, to_eye, d);
    sum += value, squares += value * value;
  }
  const double mean = sum / kSamples, error = std::sqrt((squares / kSamples - mean * mean) / kSamples);
  EXPECT_NEAR(mean, sphere_integral(lit), 4 * error);
  EXPECT_LT(error, 0.01 * mean);
}

// A smooth strand reflects at its front like a cylinder: met off its middle by sin g, at azimuth 2 g, on that side, and
// at the eye's inclination mirrored; white hair shows it against the light as brightly.
TEST(Hair, ReflectsLikeACylinder) {
  HairStrand s;
  s.color = glm::vec3(0);  // what enters is lost
  s.roughness = 0.1f;
  s.tangent = {1, 0, 0};
  const glm::vec3 to_eye = towards(0.3, 0);
  const double angle = 0.5;
  s.across = across_strand(s.tangent, to_eye, {0, float(std::cos(angle)), float(std::sin(angle))});
  EXPECT_NEAR(std::abs(s.across), std::sin(angle), 1e-6);
  const float there = hair_scattering(s, to_eye, towards(-0.3, 2 * angle)).y;
  EXPECT_GT(there, 20 * hair_scattering(s, to_eye, towards(-0.3, -2 * angle)).y);
  EXPECT_GT(there, 20 * hair_scattering(s, to_eye, towards(0.3, 2 * angle)).y);
}

// Two sides of the model's reciprocity: around the strand, its lobes are the same there and back.
TEST(Hair, IsReciprocalAroundTheStrand) {
  HairStrand s;
  s.color = glm::vec3(0.5f), s.roughness = 0.4f;
  const double azimuth = 1.1;
  // Averaged over a strand, which is met everywhere between its sides.
  const auto mean = [&](double eye, double light) {
    double sum = 0;
    for (int i = 0; i < 400; ++i) {
      s.across = (i + 0.5f) / 200 - 1;
      sum += hair_scattering(s, towards(0.4, eye), towards(-0.4, light)).y / 400;
    }
    return sum;
  };
  EXPECT_NEAR(mean(0, azimuth), mean(azimuth, 0), 0.01 * mean(0, azimuth));
}

}  // namespace
}  // namespace dualpixel::simulator::testing
