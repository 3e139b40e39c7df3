#include "simulator/render/shading/layers.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulator/render/shading/microfacets.h"

namespace dualpixel::simulator {
namespace {

constexpr float kCoatReflects = 0.04f;  // head-on: ior 1.5

float grazing_part(float cosine) { return std::pow(1 - std::clamp(cosine, 0.0f, 1.0f), 5.0f); }

float largest(glm::vec3 rgb) { return std::max({rgb.r, rgb.g, rgb.b}); }

/// Head-on (KHR_materials_ior and _specular).
glm::vec3 head_on_fresnel(const Layers& y) {
  const float ratio = y.ior == 0 ? 1 : (y.ior - 1) / (y.ior + 1);
  return glm::min(ratio * ratio * y.specular_color, glm::vec3(1)) * y.specular;
}

/// What is left below the surface of a dielectric for light that comes and goes at these angles: over the hemisphere,
/// it is what the surface lets through.
float below_surface(const Layers& y, float n_v, float n_l) {
  const float head_on = largest(head_on_fresnel(y));
  const float mean = head_on + (y.specular - head_on) / 21;  // of Schlick's, weighted by the cosine
  const float passes = (1 - largest(fresnel(y, n_v))) * (1 - largest(fresnel(y, n_l)));
  return passes / std::max(1 - mean, 1e-3f);
}

/// Below this, sheen's lobe would hold next to no light at any angle but the last few degrees.
constexpr float kSmoothestSheen = 0.1414214f;

float sheen_alpha(float roughness) {
  const float r = std::max(roughness, kSmoothestSheen);
  return r * r;
}

/// Estevez and Kulla 2017, the fit of equation 3 and its table.
float charlie_lambda(float cosine, float alpha) {
  cosine = std::clamp(cosine, 0.0f, 1.0f);  // rounding may lead beyond, where the fit is no number
  const float t = (1 - alpha) * (1 - alpha);
  const auto fit = [&](float x) {
    const float a = glm::mix(21.5473f, 25.3245f, t), b = glm::mix(3.82987f, 3.32435f, t);
    const float c = glm::mix(0.19823f, 0.16801f, t), d = glm::mix(-1.97760f, -1.27393f, t);
    const float e = glm::mix(-4.32054f, -4.85967f, t);
    return a / (1 + b * std::pow(x, c)) + d * x + e;
  };
  return std::exp(cosine < 0.5f ? fit(cosine) : 2 * fit(0.5f) - fit(1 - cosine));
}

float charlie(float n_v, float n_l, float n_h, float alpha) {
  const float sine = std::sqrt(std::max(1 - n_h * n_h, 0.0f));
  const float density = (2 + 1 / alpha) * std::pow(sine, 1 / alpha) / (2 * kPi);
  return density / ((1 + charlie_lambda(n_v, alpha) + charlie_lambda(n_l, alpha)) * 4 * n_v * n_l);
}

/// Integrals of charlie() over directions of light, for roughnesses and cosines of the eye. Above 1 at low roughness
/// and grazing angles: Lambda is a fit, which does not make up for 1 / (4 n_v n_l) there.
class SheenTable {
 public:
  static constexpr int kSide = 24;

  SheenTable() {
    for (int r = 0; r < kSide; ++r) {
      for (int c = 0; c < kSide; ++c) {
        const float root = coordinate(c);  // of the cosine: closer to the horizon
        integral_[r][c] = integral(sheen_alpha(glm::mix(kSmoothestSheen, 1.0f, coordinate(r))), root * root);
      }
    }
  }

  float at(float roughness, float cosine) const {
    const float rough = (roughness - kSmoothestSheen) / (1 - kSmoothestSheen);
    const float x = std::clamp(rough, 0.0f, 1.0f) * (kSide - 1);
    const float y = std::sqrt(std::clamp(cosine, 0.0f, 1.0f)) * (kSide - 1);
    const int i = std::min(static_cast<int>(x), kSide - 2), j = std::min(static_cast<int>(y), kSide - 2);
    const float fx = x - static_cast<float>(i), fy = y - static_cast<float>(j);
    const auto row = [&](int k) { return glm::mix(integral_[k][j], integral_[k][j + 1], fy); };
    return glm::mix(row(i), row(i + 1), fx);
  }

 private:
  static float coordinate(int i) { return static_cast<float>(i) / (kSide - 1); }

  static float integral(float alpha, float cosine) {
    constexpr int kSteps = 32;
    const float n_v = std::max(cosine, 1e-3f);
    const glm::vec3 to_eye(std::sqrt(1 - n_v * n_v), 0, n_v);
    float sum = 0;
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {                   // half of the circle, the other is its mirror image
        const float s = (i + 0.5f) / kSteps, n_l = s * s;  // closer to the horizon, where sheen is
        const glm::vec3 to_light = around({0, 0, 1}, n_l, kPi * (j + 0.5f) / kSteps);
        const float n_h = glm::normalize(to_eye + to_light).z;
        sum += charlie(n_v, n_l, n_h, alpha) * n_l * 2 * s;
      }
    }
    return sum * 2 * kPi / (kSteps * kSteps);
  }

  std::array<std::array<float, kSide>, kSide> integral_;
};

float sheen_integral(float roughness, float cosine) {
  static const SheenTable table;
  return table.at(roughness, cosine);
}

/// Chandrasekhar's H function of a deep layer, by albedo of single scattering = 1 - gamma^2 (Hapke 2002, equation 13:
/// within 1 %).
float chandrasekhar_h(float cosine, float gamma) {
  const float x = std::max(cosine, 1e-4f), r = (1 - gamma) / (1 + gamma);
  return 1 / (1 - (1 - gamma * gamma) * x * (r + (0.5f - r * x) * std::log((1 + x) / x)));
}

/// Reflection of the layer over that of a white Lambertian surface. `albedo` is of even light, to which a fit finds
/// gamma (Kulla and Conty 2017: even phase, no surface).
float deep_layer(float albedo, float n_v, float n_l) {
  const float a = std::clamp(albedo, 0.0f, 1.0f);
  const float gamma = std::max(4.09712f + 4.20863f * a - std::sqrt(9.59217f + 41.6808f * a + 17.7126f * a * a), 0.0f);
  return 0.25f * (1 - gamma * gamma) * chandrasekhar_h(n_v, gamma) * chandrasekhar_h(n_l, gamma) /
         std::max(n_v + n_l, 1e-4f);
}

/// What is diffuse below the surface, times pi.
glm::vec3 diffuse_below(const Surface& s, float n_v, float n_l) {
  const float share = s.layers->subsurface;
  if (share == 0) return s.base_color;
  glm::vec3 deep;
  for (int c = 0; c < 3; ++c) deep[c] = deep_layer(s.base_color[c], n_v, n_l);
  return glm::mix(s.base_color, deep, share);
}

/// How often each lobe is sampled.
struct LobeShares {
  float cosine, surface, coat;
};

LobeShares shares_of(const Surface& s) {
  const Layers& y = *s.layers;
  const float diffuse = std::max((1 - s.metallic) * (1 - y.transmission), largest(y.sheen_color));
  const float sum = diffuse + 1 + y.clearcoat;
  return {diffuse / sum, 1 / sum, y.clearcoat / sum};
}

}  // namespace

glm::vec3 fresnel(const Layers& y, float cosine) {
  const glm::vec3 head_on = head_on_fresnel(y);
  return head_on + (y.specular - head_on) * grazing_part(cosine);
}

float coat_reflects(const Layers& y, float cosine) {
  return y.clearcoat * (kCoatReflects + (1 - kCoatReflects) * grazing_part(cosine));
}

float sheen_albedo(float roughness, float cosine) { return std::min(sheen_integral(roughness, cosine), 1.0f); }

glm::vec3 layered_bsdf(const Surface& s, glm::vec3 to_eye, glm::vec3 to_light) {
  const Layers& y = *s.layers;
  const float n_l = glm::dot(s.normal, to_light);
  const float n_v = std::max(glm::dot(s.normal, to_eye), 1e-4f);
  if (n_l <= 0) return glm::vec3(0);
  const glm::vec3 half = glm::normalize(to_eye + to_light);
  const float n_h = std::max(glm::dot(s.normal, half), 0.0f), v_h = glm::dot(to_eye, half);
  const float alpha = ggx_alpha(s.roughness);
  const float lobe = ggx_visibility(n_l, n_v, alpha) * ggx_density(n_h, alpha);
  const glm::vec3 diffuse = (1 - y.transmission) * below_surface(y, n_v, n_l) * diffuse_below(s, n_v, n_l) / kPi;
  const glm::vec3 dielectric = diffuse + fresnel(y, v_h) * lobe;
  const glm::vec3 metal = (s.base_color + (1.0f - s.base_color) * grazing_part(v_h)) * lobe;
  glm::vec3 f = glm::mix(dielectric, metal, s.metallic);
  if (const float sheen = largest(y.sheen_color); sheen > 0) {
    const float most = std::max(sheen_integral(y.sheen_roughness, n_v), sheen_integral(y.sheen_roughness, n_l));
    const float lobe_of_sheen = charlie(n_v, n_l, n_h, sheen_alpha(y.sheen_roughness)) / std::max(most, 1.0f);
    f = (1 - sheen * std::min(most, 1.0f)) * f + y.sheen_color * lobe_of_sheen;
  }
  if (y.clearcoat > 0) {
    const float coat_alpha = ggx_alpha(y.clearcoat_roughness);
    const float coat = ggx_visibility(n_l, n_v, coat_alpha) * ggx_density(n_h, coat_alpha);
    f = (1 - coat_reflects(y, n_v)) * (1 - coat_reflects(y, n_l)) * f + coat_reflects(y, v_h) * coat;
  }
  return f;
}

glm::vec3 layered_diffuse_bsdf(const Surface& s) {
  constexpr float kMiddle = 0.6f;  // of the angles, about
  const Layers& y = *s.layers;
  const float coat = 1 - coat_reflects(y, kMiddle);
  const float sheen =
      largest(y.sheen_color) > 0 ? 1 - largest(y.sheen_color) * sheen_albedo(y.sheen_roughness, kMiddle) : 1;
  return (1 - s.metallic) * (1 - y.transmission) * below_surface(y, kMiddle, kMiddle) * sheen * coat * coat *
         diffuse_below(s, kMiddle, kMiddle) / kPi;
}

float layered_pdf(const Surface& s, glm::vec3 to_eye, glm::vec3 to_light) {
  const LobeShares share = shares_of(s);
  const glm::vec3 half = glm::normalize(to_eye + to_light);
  const float n_h = std::max(glm::dot(s.normal, half), 0.0f);
  const float per_half = n_h / (4 * std::max(glm::dot(to_eye, half), 1e-4f));
  return share.cosine * std::max(glm::dot(s.normal, to_light), 0.0f) / kPi +
         share.surface * ggx_density(n_h, ggx_alpha(s.roughness)) * per_half +
         share.coat * ggx_density(n_h, ggx_alpha(s.layers->clearcoat_roughness)) * per_half;
}

glm::vec3 sample_layered(const Surface& s, glm::vec3 to_eye, float u, float v) {
  const LobeShares share = shares_of(s);
  if (u < share.cosine) return around(s.normal, std::sqrt(std::max(1 - u / share.cosine, 0.0f)), 2 * kPi * v);
  u -= share.cosine;
  const bool coat = u >= share.surface;
  u = std::clamp(coat ? (u - share.surface) / share.coat : u / share.surface, 0.0f, 0x1.fffffep-1f);
  const float alpha = ggx_alpha(coat ? s.layers->clearcoat_roughness : s.roughness);
  const glm::vec3 half = sample_ggx(s.normal, alpha, u, v);
  return 2 * glm::dot(to_eye, half) * half - to_eye;
}

}  // namespace dualpixel::simulator
