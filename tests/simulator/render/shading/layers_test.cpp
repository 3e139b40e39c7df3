// Reflection with glTF's extensions, and what passes glass.
#include "simulator/render/shading/layers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "simulator/render/shading/bsdf.h"
#include "simulator/render/shading/glass.h"

namespace dualpixel::simulator::testing {
namespace {

struct Named {
  std::string name;
  Layers layers;
  float metallic = 0;
  float least = 0;  ///< of the light, for white material seen head-on: the rest is the stated loss
};

std::vector<Named> white_materials() {
  std::vector<Named> all;
  const auto add = [&](const char* name, float metallic, float least) -> Layers& {
    all.push_back({name, {}, metallic, least});
    return all.back().layers;
  };
  add("ior 1.33", 0, 0.98f).ior = 1.33f;
  add("ior 2.4", 0, 0.98f).ior = 2.4f;
  add("ior 0", 0, 0.7f).ior = 0;
  add("specular .5", 0, 0.98f).specular = 0.5f;
  add("specular color", 0, 0.98f).specular_color = {1, 0.4f, 0.2f};
  Layers& coat = add("clearcoat", 0, 0.88f);
  coat.clearcoat = 1, coat.clearcoat_roughness = 0.2f;
  Layers& coated_metal = add("clearcoat on metal", 1, 0.6f);
  coated_metal.clearcoat = 0.7f, coated_metal.clearcoat_roughness = 0.4f;
  Layers& sheen = add("sheen", 0, 0.85f);
  sheen.sheen_color = glm::vec3(1), sheen.sheen_roughness = 0.4f;
  Layers& velvet = add("rough sheen", 0, 0.85f);
  velvet.sheen_color = glm::vec3(1), velvet.sheen_roughness = 0.9f;
  add("skin", 0, 0.93f).subsurface = 1;
  add("half skin", 0, 0.95f).subsurface = 0.5f;
  Layers& all_layers = add("all", 0, 0.6f);
  all_layers = {1.8f, 0.8f, {1, 1, 1}, 0.6f, 0.3f, glm::vec3(0.7f), 0.5f, 0.3f, false, glm::vec3(0)};
  return all;
}

Surface surface_of(const Named& named, float roughness) {
  Surface s;
  s.base_color = glm::vec3(1);
  s.metallic = named.metallic;
  s.roughness = roughness;
  s.layers = &named.layers;
  return s;
}

glm::vec3 direction(double cosine, double phi) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return {float(sine * std::cos(phi)), float(sine * std::sin(phi)), float(cosine)};
}

/// Share of light from everywhere that is reflected to the eye, by the surface's own samples.
double albedo(const Surface& s, glm::vec3 to_eye) {
  constexpr int kSide = 300;
  double sum = 0;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const glm::vec3 d = sample_bsdf(s, to_eye, (i + 0.5f) / kSide, (j + 0.5f) / kSide);
      if (d.z > 0) sum += bsdf(s, to_eye, d).x * d.z / bsdf_pdf(s, to_eye, d);
    }
  }
  return sum / (kSide * kSide);
}

// A white surface in a white furnace: never brighter, and no darker head-on than what it is said to lose, but for
// roughness 1, where light between microfacets is lost. Midpoints of 300 x 300 numbers integrate lobes of these
// roughnesses to .5 %.
TEST(SlowLayers, GiveBackNoMoreThanTheyGet) {
  for (const Named& named : white_materials()) {
    for (const float roughness : {0.25f, 0.5f, 1.0f}) {
      const Surface s = surface_of(named, roughness);
      for (const double cosine : {1.0, 0.7, 0.4, 0.2, 0.08}) {
        EXPECT_LT(albedo(s, direction(cosine, 0.3)), 1.005) << named.name << ", " << roughness << ", " << cosine;
      }
      if (roughness <= 0.5f && named.layers.transmission == 0) {
        EXPECT_GT(albedo(s, direction(1, 0)), named.least) << named.name << ", " << roughness;
      }
    }
  }
}

// Directions that were mirrored are of length 1 but for rounding.
TEST(Layers, AreFiniteWhereACosinePassesOne) {
  for (const Named& named : white_materials()) {
    const glm::vec3 longer(0, 0, 1.0000002f);
    EXPECT_TRUE(std::isfinite(bsdf(surface_of(named, 0.5f), longer, longer).x)) << named.name;
  }
}

// What a rough white pane lets through, by its own samples, and what it and its layers reflect: no more than it gets.
TEST(SlowLayers, PanesPassAndReflectNoMoreThanTheyGet) {
  for (const float coat : {0.0f, 1.0f}) {
    for (const float sheen : {0.0f, 1.0f}) {
      Layers y;
      y.ior = 1.5f, y.transmission = 1, y.clearcoat = coat, y.sheen_color = glm::vec3(sheen), y.sheen_roughness = 0.5f;
      const Named pane{"pane", y};
      for (const float roughness : {0.3f, 0.6f, 1.0f}) {
        const Surface s = surface_of(pane, roughness);
        for (const double cosine : {1.0, 0.5, 0.17, 0.08}) {
          constexpr int kSide = 300;
          const glm::vec3 to_eye = direction(cosine, 0.3);
          double passes = 0;
          for (int i = 0; i < kSide * kSide; ++i) {
            const int column = i % kSide, row = i / kSide;
            const float u = (column + 0.5f) / kSide, v = (row + 0.5f) / kSide;
            passes += sample_passage(s, to_eye, false, 1, u, v).share.x / (kSide * kSide);
          }
          EXPECT_LT(passes + albedo(s, to_eye), 1.005) << coat << ' ' << sheen << ' ' << roughness << ' ' << cosine;
        }
      }
    }
  }
}

TEST(Layers, AreReciprocal) {
  for (const Named& named : white_materials()) {
    const Surface s = surface_of(named, 0.45f);
    for (int i = 0; i < 64; ++i) {
      const int column = i % 8, row = i / 8;
      const glm::vec3 a = direction((column + 0.5) / 8, 0.1 * i), b = direction((row + 0.5) / 8, 2 - 0.3 * i);
      const glm::vec3 there = bsdf(s, a, b), back = bsdf(s, b, a);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(there[c], back[c], 1e-4f * there[c]) << named.name << ", pair " << i;
    }
  }
}

// The mean of cosine / density over samples is the integral of the cosine over the half space, pi.
TEST(Layers, SamplesFollowTheirDensity) {
  for (const Named& named : white_materials()) {
    const Surface s = surface_of(named, 0.5f);
    if (bsdf_pdf(s, {0, 0, 1}, direction(0.3, 0)) < 0.02f) continue;  // no lobe that reaches everywhere
    constexpr int kSide = 512;
    double sum = 0;
    for (int i = 0; i < kSide; ++i) {
      for (int j = 0; j < kSide; ++j) {
        const glm::vec3 to_eye = direction(0.8, 0), d = sample_bsdf(s, to_eye, (i + 0.5f) / kSide, (j + 0.5f) / kSide);
        if (d.z > 0) sum += d.z / bsdf_pdf(s, to_eye, d);
      }
    }
    EXPECT_NEAR(sum / (kSide * kSide), M_PI, 0.01 * M_PI) << named.name;
  }
}

// An ior of nearly 1.5 looks as glTF's plain dielectric does, away from grazing angles, where that one gains light.
TEST(Layers, GoOverIntoThePlainMaterial) {
  Surface plain;
  plain.base_color = glm::vec3(0.6f);
  plain.roughness = 0.5f;
  Surface layered = plain;
  Layers layers;
  layers.ior = 1.5001f;
  layered.layers = &layers;
  for (const double cosine : {1.0, 0.8, 0.6}) {
    EXPECT_NEAR(albedo(layered, direction(cosine, 0)), albedo(plain, direction(cosine, 0)), 0.02) << cosine;
  }
}

// Fresnel's equations for light of both polarizations, head-on: ((n - 1) / (n + 1))^2; and Schlick's 1 at the horizon.
TEST(Layers, FresnelIsThatOfTheIor) {
  Layers y;
  for (const float ior : {1.0f, 1.33f, 1.5f, 2.4f}) {
    y.ior = ior;
    EXPECT_NEAR(fresnel(y, 1).x, std::pow((ior - 1) / (ior + 1), 2), 1e-6);
    EXPECT_NEAR(fresnel(y, 0).x, 1, 1e-6);
  }
}

/// Chandrasekhar's H function at midpoints of cosines, by iterating the equation that defines it.
struct DeepLayer {
  static constexpr int kSide = 200;
  double gamma = 0;
  std::vector<double> h;

  static double cosine(int i) { return (i + 0.5) / kSide; }
  explicit DeepLayer(double g) : gamma(g), h(kSide, 1.0) {
    for (int iteration = 0; iteration < 200; ++iteration) {
      std::vector<double> next;
      for (int i = 0; i < kSide; ++i) {
        double sum = 0;
        for (int j = 0; j < kSide; ++j) sum += cosine(j) * h[j] / (cosine(i) + cosine(j)) / kSide;
        next.push_back(1 / (gamma + 0.5 * (1 - gamma * gamma) * sum));
      }
      h = next;
    }
  }
  /// Of light from everywhere.
  double albedo() const {
    double moment = 0;
    for (int i = 0; i < kSide; ++i) moment += h[i] * cosine(i) / kSide;
    return 1 - 2 * gamma * moment;
  }
};

// Skin without a surface above it is a deep layer that scatters evenly: its H function solves Chandrasekhar's equation,
// here by iteration. Hapke's formula errs by 1 % in each H, the fit of gamma by about 1 % of the albedo.
TEST(Layers, SkinIsADeepLayer) {
  for (const double gamma : {0.15, 0.3, 0.6}) {
    const DeepLayer deep(gamma);
    Layers y;
    y.specular = 0, y.subsurface = 1;
    Surface s;
    s.base_color = glm::vec3(float(deep.albedo())), s.roughness = 1, s.layers = &y;
    double reflected = 0;
    for (const int i : {10, 60, 120, 190}) {
      for (int j = 0; j < DeepLayer::kSide; ++j) {
        const double a = DeepLayer::cosine(i), b = DeepLayer::cosine(j);
        const double f = (1 - gamma * gamma) * deep.h[i] * deep.h[j] / (4 * M_PI * (a + b));
        EXPECT_NEAR(bsdf(s, direction(a, 0.3), direction(b, 2)).x, f, 0.04 * f) << gamma << ", " << a << ", " << b;
      }
    }
    constexpr int kAngles = 20;
    for (int i = 0; i < kAngles; ++i) {
      const double cosine = (i + 0.5) / kAngles;
      reflected += 2 * cosine / kAngles * albedo(s, direction(cosine, 0));
    }
    EXPECT_NEAR(reflected, deep.albedo(), 0.03 * deep.albedo()) << gamma;
  }
}

TEST(Layers, SheenTableIsTheIntegral) {
  for (const float roughness : {0.3f, 0.6f, 1.0f}) {
    for (const double cosine : {0.9, 0.5, 0.2}) {
      Layers y;
      y.sheen_color = glm::vec3(1), y.sheen_roughness = roughness;
      Surface s;
      s.base_color = glm::vec3(0), s.layers = &y, s.roughness = 1;
      y.specular = 0;  // nothing but sheen
      constexpr int kSide = 400;
      double sum = 0;
      for (int i = 0; i < kSide; ++i) {
        for (int j = 0; j < kSide; ++j) {
          const glm::vec3 d = direction((i + 0.5) / kSide, 2 * M_PI * (j + 0.5) / kSide);
          sum += bsdf(s, direction(cosine, 0), d).x * d.z;
        }
      }
      EXPECT_NEAR(2 * M_PI * sum / (kSide * kSide), sheen_albedo(roughness, float(cosine)), 0.01)
          << roughness << ", " << cosine;
    }
  }
}

// Charlie's lobe as published reflects up to 1.57 of the light at low roughness and grazing angles.
TEST(Layers, SheenGainsNothingAtGrazingAngles) {
  Layers y;
  y.sheen_color = glm::vec3(1), y.specular = 0;  // nothing but sheen
  Surface s;
  s.base_color = glm::vec3(0), s.layers = &y, s.roughness = 1;
  for (const float roughness : {0.0f, 0.15f, 0.2f, 0.25f, 1.0f}) {
    y.sheen_roughness = roughness;
    for (const double cosine : {0.002, 0.01, 0.02, 0.03, 0.06}) {
      constexpr int kSide = 400;
      double sum = 0;
      for (int i = 0; i < kSide; ++i) {
        for (int j = 0; j < kSide; ++j) {
          const double root = (i + 0.5) / kSide;  // of the cosine: closer to the horizon, where sheen is
          const glm::vec3 d = direction(root * root, 2 * M_PI * (j + 0.5) / kSide);
          sum += bsdf(s, direction(cosine, 0), d).x * d.z * 2 * root;
        }
      }
      const double reflected = 2 * M_PI * sum / (kSide * kSide);
      EXPECT_LT(reflected, 1.005) << roughness << ", " << cosine;
      EXPECT_GT(reflected, 0.5) << roughness << ", " << cosine;
    }
  }
}

TEST(Glass, RefractsBySnellAndReflectsInFullBeyondTheCriticalAngle) {
  const float sine = 0.5f;
  const glm::vec3 to_eye(sine, 0, std::sqrt(1 - sine * sine));
  glm::vec3 inside, back;
  ASSERT_TRUE(refract(to_eye, {0, 0, 1}, 1 / 1.5f, inside));
  EXPECT_NEAR(-inside.x, sine / 1.5f, 1e-6);
  EXPECT_LT(inside.z, 0);
  ASSERT_TRUE(refract(inside * glm::vec3(1, 1, -1), {0, 0, 1}, 1.5f, back));
  EXPECT_NEAR(std::abs(back.x), sine, 1e-6);
  EXPECT_FALSE(refract({0.7f, 0, std::sqrt(0.51f)}, {0, 0, 1}, 1.5f, back));  // beyond asin(1 / 1.5)
}

// What passes and what is reflected make up all light, on both sides of a clear surface, and what passes one way passes
// the other.
TEST(Glass, PassesWhatItDoesNotReflect) {
  Layers y;
  y.transmission = 1, y.solid = true;
  Surface s;
  s.base_color = glm::vec3(1), s.roughness = 0, s.layers = &y;
  for (const double cosine : {1.0, 0.7, 0.3}) {
    const glm::vec3 to_eye = direction(cosine, 0);
    EXPECT_NEAR(passing(s, float(cosine), false).x + fresnel(y, float(cosine)).x, 1, 1e-6);
    const Passage in = sample_passage(s, to_eye, false, 0.5f, 0, 0);
    EXPECT_NEAR(in.share.x, passing(s, float(cosine), false).x, 1e-6);
    int reflected = 0;
    constexpr int kChoices = 10000;
    for (int i = 0; i < kChoices; ++i) {
      const Passage out = sample_passage(s, -in.direction, true, (i + 0.5f) / kChoices, 0, 0);
      EXPECT_NEAR(out.share.x, 1, 1e-6);
      reflected += out.direction.z > 0;
      if (out.direction.z < 0) {
        EXPECT_NEAR(-out.direction.z, cosine, 1e-5);
      }
    }
    EXPECT_NEAR(double(reflected) / kChoices, fresnel(y, float(cosine)).x, 2e-4);
  }
}

// A share of the light that enters is transmitted: of solid glass, half of it goes in and all of that comes out. An ior
// of 0 reflects its specular color head-on, and lets the rest pass.
TEST(Glass, TransmissionAndIorOfZero) {
  Layers y;
  y.transmission = 0.5f, y.solid = true;
  Surface s;
  s.base_color = glm::vec3(1), s.roughness = 0, s.layers = &y;
  EXPECT_NEAR(passing(s, 1, false).x, 0.5 * 0.96, 1e-6);
  EXPECT_NEAR(passing(s, 1, true).x, 0.96, 1e-6);
  EXPECT_NEAR(sample_passage(s, {0, 0, 1}, false, 0.5f, 0, 0).share.x, 0.5 * 0.96, 1e-6);
  EXPECT_NEAR(sample_passage(s, {0, 0, 1}, true, 0.5f, 0, 0).share.x, 1, 1e-6);
  y.transmission = 1, y.ior = 0, y.specular_color = glm::vec3(0.25f);
  EXPECT_NEAR(sample_passage(s, {0, 0, 1}, false, 0.5f, 0, 0).share.x, 0.75, 1e-6);
  const Passage tilted = sample_passage(s, direction(0.8, 0), false, 0.5f, 0, 0);
  EXPECT_NEAR(tilted.direction.x, -0.6 / 1.5, 1e-6);
}

// Rough glass in a furnace: reflection and passage together give back no more than they get, and lose little.
TEST(Glass, RoughGlassGainsNothing) {
  for (const bool solid : {false, true}) {
    for (const float roughness : {0.1f, 0.3f, 0.6f}) {
      Layers y;
      y.transmission = 1, y.solid = solid;
      Surface s;
      s.base_color = glm::vec3(1), s.roughness = roughness, s.layers = &y;
      for (const double cosine : {1.0, 0.6, 0.3}) {
        const glm::vec3 to_eye = direction(cosine, 0);
        constexpr int kSide = 200;
        double passed = 0;
        for (int i = 0; i < kSide; ++i) {
          for (int j = 0; j < kSide; ++j) {
            passed += sample_passage(s, to_eye, false, 0, (i + 0.5f) / kSide, (j + 0.5f) / kSide).share.x;
          }
        }
        const double all = passed / (kSide * kSide) + albedo(s, to_eye);
        EXPECT_LT(all, 1.005) << roughness << ", " << cosine;
        EXPECT_GT(all, 1 - 0.4 * roughness) << roughness << ", " << cosine;
      }
    }
  }
}

}  // namespace
}  // namespace dualpixel::simulator::testing
