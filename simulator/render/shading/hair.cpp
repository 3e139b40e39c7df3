#include "simulator/render/shading/hair.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulator/render/shading/radiometry.h"

namespace dualpixel::simulator {
namespace {

constexpr float kHornIor = 1.55f;
constexpr int kLobes = 4;  ///< R, TT, TRT, and all after that

float squared(float x) { return x * x; }

float power(float x, int n) {
  float product = 1;
  for (int i = 0; i < n; ++i) product *= x;
  return product;
}

/// Of the modified Bessel function of the first kind, order 0.
float log_bessel(float x) {
  if (x > 12) return x - 0.5f * std::log(2 * kPi * x) + std::log1p(1 / (8 * x));
  float sum = 1, term = 1;
  for (int k = 1; k < 24; ++k) sum += term *= squared(0.5f * x / static_cast<float>(k));
  return std::log(sum);
}

/// A direction by its angles to the strand: sine and cosine of the inclination, azimuth from the eye's.
struct StrandAngles {
  float sine, cosine, azimuth;
};

/// Axes in which the eye's azimuth is 0.
struct StrandFrame {
  glm::vec3 along, towards_eye, sideways;

  StrandFrame(glm::vec3 tangent, glm::vec3 to_eye) : along(tangent) {
    const glm::vec3 flat = to_eye - glm::dot(to_eye, tangent) * tangent;
    const float length = glm::length(flat);
    const glm::vec3 any = std::abs(tangent.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    towards_eye = length > 1e-4f ? flat / length : glm::normalize(glm::cross(tangent, any));
    sideways = glm::cross(tangent, towards_eye);
  }
  StrandAngles angles(glm::vec3 d) const {
    const float sine = std::clamp(glm::dot(d, along), -1.0f, 1.0f);
    return {sine, std::sqrt(1 - sine * sine), std::atan2(glm::dot(d, sideways), glm::dot(d, towards_eye))};
  }
};

/// Of unpolarized light at a smooth surface of horn.
float horn_fresnel(float cosine) {
  const float inside = std::sqrt(1 - (1 - cosine * cosine) / squared(kHornIor));
  const float parallel = (kHornIor * cosine - inside) / (kHornIor * cosine + inside);
  const float crossed = (cosine - kHornIor * inside) / (cosine + kHornIor * inside);
  return 0.5f * (parallel * parallel + crossed * crossed);
}

/// All that depends on the strand and the eye alone.
struct StrandView {
  StrandFrame frame;
  StrandAngles eye;
  float outer_angle, inner_angle;  ///< to the strand's surface, across it: before and after refraction
  float width;                     ///< of the azimuthal lobes
  std::array<float, kLobes> variance, share;
  std::array<glm::vec3, kLobes> attenuation;

  StrandView(const HairStrand& s, glm::vec3 to_eye) : frame(s.tangent, to_eye), eye(frame.angles(to_eye)) {
    const float rough = std::clamp(s.roughness, 0.05f, 1.0f), cosine = std::max(eye.cosine, 1e-3f);
    // Chiang et al. 2016, equations 7 and 8
    const float v = squared(0.726f * rough + 0.812f * rough * rough + 3.7f * power(rough, 20));
    variance = {v, v / 4, 4 * v, 4 * v};
    width = std::sqrt(kPi / 8) * (0.265f * rough + 1.194f * rough * rough + 5.372f * power(rough, 22));
    const float across = std::clamp(s.across, -0.9999f, 0.9999f);
    const float apparent_ior = std::sqrt(squared(kHornIor) - squared(eye.sine)) / cosine;
    outer_angle = std::asin(across), inner_angle = std::asin(across / apparent_ior);
    const float inner_cosine = std::sqrt(1 - squared(eye.sine / kHornIor));
    attenuate(transmitted(s, rough, 2 * std::cos(inner_angle) / inner_cosine),
              horn_fresnel(cosine * std::cos(outer_angle)));
  }

  /// On one way through, `length` radii long. Absorption by color: Chiang et al. 2016, equation 9.
  static glm::vec3 transmitted(const HairStrand& s, float rough, float length) {
    const float scale = 5.969f - 0.215f * rough + 2.532f * power(rough, 2) - 10.73f * power(rough, 3) +
                        5.574f * power(rough, 4) + 0.245f * power(rough, 5);
    const glm::vec3 root = glm::log(glm::clamp(s.color, 1e-4f, 1.0f)) / scale;
    return glm::exp(-root * root * length);
  }

  void attenuate(glm::vec3 passes, float reflects) {
    attenuation[0] = glm::vec3(reflects);
    attenuation[1] = squared(1 - reflects) * passes;
    attenuation[2] = attenuation[1] * passes * reflects;
    attenuation[3] = attenuation[2] * passes * reflects / (1.0f - passes * reflects);
    float sum = 0;
    for (int p = 0; p < kLobes; ++p) sum += share[p] = luminance(attenuation[p]);
    for (float& s : share) s /= sum;
  }

  /// Where lobe `p` leaves, from the eye's azimuth.
  float exit_azimuth(int p) const {
    return 2 * static_cast<float>(p) * inner_angle - 2 * outer_angle + static_cast<float>(p) * kPi;
  }

  /// Both factors of one lobe: along the strand (d'Eon et al. 2011), and around it, a logistic distribution.
  float lobe(int p, const StrandAngles& light) const {
    const float v = variance[p];
    const float log_along = log_bessel(eye.cosine * light.cosine / v) - eye.sine * light.sine / v - 1 / v -
                            std::log(v * (1 - std::exp(-2 / v)));
    return std::exp(log_along) * around(p, light.azimuth);
  }

  float around(int p, float azimuth) const {
    if (p == kLobes - 1) return 1 / (2 * kPi);
    const float off = std::remainder(azimuth - exit_azimuth(p), 2 * kPi);
    const float e = std::exp(-std::abs(off) / width);
    return e / (width * squared(1 + e)) / (1 - 2 * below());
  }

  /// Share of the logistic distribution below -pi, which is cut off, as that above pi.
  float below() const { return 1 / (1 + std::exp(kPi / width)); }
};

}  // namespace

float across_strand(glm::vec3 tangent, glm::vec3 to_eye, glm::vec3 offset_over_radius) {
  return std::clamp(-glm::dot(StrandFrame(tangent, to_eye).sideways, offset_over_radius), -1.0f, 1.0f);
}

glm::vec3 hair_scattering(const HairStrand& s, glm::vec3 to_eye, glm::vec3 to_light) {
  const StrandView view(s, to_eye);
  const StrandAngles light = view.frame.angles(to_light);
  glm::vec3 sum(0);
  for (int p = 0; p < kLobes; ++p) sum += view.attenuation[p] * view.lobe(p, light);
  return sum;
}

float hair_pdf(const HairStrand& s, glm::vec3 to_eye, glm::vec3 to_light) {
  const StrandView view(s, to_eye);
  const StrandAngles light = view.frame.angles(to_light);
  float sum = 0;
  for (int p = 0; p < kLobes; ++p) sum += view.share[p] * view.lobe(p, light);
  return sum;
}

glm::vec3 sample_hair(const HairStrand& s, glm::vec3 to_eye, const std::array<float, 4>& numbers) {
  const StrandView view(s, to_eye);
  int p = 0;
  for (float left = numbers[0]; p < kLobes - 1 && left >= view.share[p]; ++p) left -= view.share[p];
  // around the mirrored eye's cone
  const float v = view.variance[p], u = std::max(numbers[1], 1e-6f);
  const float cosine = std::clamp(1 + v * std::log(u + (1 - u) * std::exp(-2 / v)), -1.0f, 1.0f);
  const float sideways = std::sqrt(1 - cosine * cosine) * std::cos(2 * kPi * numbers[2]);
  const float sine = std::clamp(-cosine * view.eye.sine + sideways * view.eye.cosine, -1.0f, 1.0f);
  float azimuth = 2 * kPi * numbers[3];
  if (p < kLobes - 1) {
    const float below = view.below(), at = below + numbers[3] * (1 - 2 * below);
    azimuth = view.exit_azimuth(p) + std::clamp(-view.width * std::log(1 / at - 1), -kPi, kPi);
  }
  const StrandFrame& f = view.frame;
  return glm::normalize(sine * f.along + std::sqrt(1 - sine * sine) *
                                             (std::cos(azimuth) * f.towards_eye + std::sin(azimuth) * f.sideways));
}

}  // namespace dualpixel::simulator
