// Which lights samples go to, and that they go there as often as they say.
#include "simulator/render/shading/near_lights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "simulator/render/shading/lights.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/sobol.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

constexpr glm::vec3 kUp(0, -1, 0);

PunctualLight lamp_at(glm::vec3 position, float candela) {
  PunctualLight lamp;
  lamp.position = position;
  lamp.intensity = glm::vec3(candela);
  return lamp;
}

/// A street of square lamps, 10 m apart along x and 3 m above the ground y = 0 (up is -y). Every third is half as
/// bright.
Scene street(int count) {
  Scene scene;
  scene.materials = {diffuse(0.5f), glowing(1000), glowing(500)};
  const float length_m = 10.0f * static_cast<float>(count);
  scene.meshes = {make_quad({-5, 0, -5}, {length_m, 0, 0}, {0, 0, 10}, 0)};
  for (int i = 0; i < count; ++i) {
    const glm::vec3 corner(10.0f * static_cast<float>(i) - 0.1f, -3, -0.1f);
    scene.meshes.push_back(make_quad(corner, {0.2f, 0, 0}, {0, 0, 0.2f}, i % 3 == 2 ? 2 : 1));
  }
  return scene;
}

NearLights near_lights(const Scene& scene) { return {scene, {glm::vec3(-5, -3, -5), glm::vec3(135, 0, 5)}}; }

/// All lanes of a packet on one surface.
NearLights::Choice choice_at(const NearLights& near, glm::vec3 point, glm::vec3 normal, LightKinds kinds) {
  Vec3Packet points, normals;
  for (int i = 0; i < kPacket; ++i) points.set(i, point), normals.set(i, normal);
  NearLights::Choice choice;
  near.choose(points, normals, kinds, choice);
  return choice;
}

float probability(const NearLights& near, glm::vec3 point, glm::vec3 normal, LightKinds kinds, std::size_t triangle) {
  return near.probability(point, normal, near.weights(point, normal, kinds), static_cast<int>(triangle));
}

// Every hundred-thousandth of [0, 1) is picked once: a light has as many as its probability says, but for one at each
// end of its stretch, and one for rounding.
TEST(NearLights, PickEachLightAsOftenAsItsProbabilitySays) {
  Scene scene = street(40);  // more lamps than groups
  scene.lights = {lamp_at({3, -2, 0}, 500), lamp_at({200, -2, 0}, 2)};
  const NearLights near = near_lights(scene);
  constexpr int kCount = 100000;
  for (const LightKinds kinds : {LightKinds::all, LightKinds::soft, LightKinds::hard}) {
    for (const glm::vec3 point : {glm::vec3(0), glm::vec3(7, -2.9f, 1), glm::vec3(180, 0, 4)}) {
      const glm::vec3 normal = glm::normalize(glm::vec3(0.2f, -1, 0.1f));
      const NearLights::Choice choice = choice_at(near, point, normal, kinds);
      std::vector<int> times(scene.lights.size() + near.triangles().size());
      std::vector<float> stated(times.size());
      for (int i = 0; i < kCount; ++i) {
        float u = (i + 0.5f) / kCount;
        const NearLights::Picked picked = near.pick(choice, 5, u);
        ++times[picked.light];
        stated[picked.light] = picked.probability;
        ASSERT_GE(u, 0);
        ASSERT_LT(u, 1);
      }
      for (std::size_t light = 0; light < times.size(); ++light) {
        EXPECT_NEAR(times[light], stated[light] * kCount, 3) << light;
        if (light < scene.lights.size() || kinds == LightKinds::hard) continue;
        const double of_triangle = probability(near, point, normal, kinds, light - scene.lights.size());
        EXPECT_NEAR(times[light], of_triangle * kCount, 3) << light;
      }
      EXPECT_EQ(times[0] + times[1] == 0, kinds == LightKinds::soft);
      EXPECT_EQ(times[0] + times[1] == kCount, kinds == LightKinds::hard);
    }
  }
}

// One meter below the first of fourteen lamps, .1 % of the light comes from the others: sum over n of (1 / (1 + 100
// n^2)) ^1.5. The lamp gets half of all samples for that, and by average light its part of the other half, as ten lamps
// are bright and four half as bright.
TEST(NearLights, PreferTheOneCloseBy) {
  const NearLights near = near_lights(street(14));
  const auto of_first_lamp = [&](glm::vec3 point) {
    return probability(near, point, kUp, LightKinds::soft, 0) + probability(near, point, kUp, LightKinds::soft, 1);
  };
  EXPECT_NEAR(of_first_lamp({0, -2, 0}), 0.5 + 0.5 / 12, 2e-3);
  EXPECT_LT(of_first_lamp({100, 0, 0}), 0.05);
}

TEST(NearLights, KnowWhatOneLampContributes) {
  Scene scene;
  scene.materials = {diffuse(0.5f)};
  scene.lights = {lamp_at({0, -2, 0}, 100)};
  const NearLights near = near_lights(scene);
  const auto lux = [&](glm::vec3 point, glm::vec3 normal, LightKinds kinds) {
    return near.weights(point, normal, kinds).lux;
  };
  EXPECT_NEAR(lux({0, 0, 0}, kUp, LightKinds::hard), 25, 1e-4);
  EXPECT_NEAR(lux({2, 0, 0}, kUp, LightKinds::hard), 100 / 8.0 * std::sqrt(0.5), 1e-4);
  EXPECT_EQ(lux({0, 0, 0}, -kUp, LightKinds::hard), 0);
  EXPECT_EQ(lux({0, 0, 0}, kUp, LightKinds::soft), 0);
  EXPECT_FLOAT_EQ(choice_at(near, {2, 0, 0}, kUp, LightKinds::all).lux[0], lux({2, 0, 0}, kUp, LightKinds::all));
}

// At 10 000 surfaces in a street, every triangle with a corner above the surface has a share: above by more than floats
// of 150 m round to, 1.5e-5 m, times the few sums that lead there.
TEST(NearLights, LeaveOutOnlyWhatIsBehindTheSurface) {
  const NearLights near = near_lights(street(14));
  int behind = 0;
  for (std::uint64_t i = 0; i < 10000; ++i) {
    const auto drawn = [&](std::uint64_t d) { return static_cast<float>(hash(hash(7, i), d) >> 40) * 0x1p-24f; };
    const glm::vec3 point(160 * drawn(0) - 10, -6 * drawn(1), 4 * drawn(2) - 2);
    const glm::vec3 normal = glm::normalize(glm::vec3(drawn(3), drawn(4), drawn(5)) - 0.5f);
    for (std::size_t t = 0; t < near.triangles().size(); ++t) {
      const NearLights::Triangle& light = near.triangles()[t];
      const float highest = glm::dot(normal, light.corner - point) +
                            std::max({0.0f, glm::dot(normal, light.first_edge), glm::dot(normal, light.second_edge)});
      const float share = probability(near, point, normal, LightKinds::soft, t);
      if (highest > 1e-4f) {
        EXPECT_GT(share, 0);
      } else if (share == 0) {
        ++behind;
      }
    }
  }
  EXPECT_GT(behind, 130000);  // of 280 000, half but for those that cut a sphere
}

// However close a lamp is, it may be hidden: of two lamps that are equal on average, the other keeps a quarter.
TEST(NearLights, KeepAQuarterForTheFarLampOfTwo) {
  Scene scene;
  scene.lights = {lamp_at({0, -1e-3f, 0}, 100), lamp_at({30, -1, 0}, 100)};
  const NearLights near = near_lights(scene);
  const NearLights::Choice choice = choice_at(near, glm::vec3(0), kUp, LightKinds::hard);
  float u = 0.999f;
  const NearLights::Picked far = near.pick(choice, 0, u);
  EXPECT_EQ(far.light, 1u);
  EXPECT_NEAR(far.probability, 0.25, 1e-6);
}

// A hundredth of the average light is what a kind that is far weaker counts for, so half of that is its share.
TEST(NearLights, KeepHalfAHundredthForWeakKinds) {
  for (const bool punctual_is_weak : {false, true}) {
    Scene scene = street(1);
    scene.materials[1] = glowing(punctual_is_weak ? 1e9f : 1e-3f);
    scene.lights = {lamp_at({0, -3.5f, 0}, punctual_is_weak ? 1e-3f : 1e9f)};
    const NearLights near = near_lights(scene);
    const float soft =
        probability(near, {0, -2, 0}, kUp, LightKinds::all, 0) + probability(near, {0, -2, 0}, kUp, LightKinds::all, 1);
    EXPECT_NEAR(punctual_is_weak ? 1 - soft : soft, 0.5 * 0.01 / 1.01, 1e-5) << punctual_is_weak;
  }
}

/// Sums over samples of one surface, each of which must state the density that the light it went to reports.
struct Sampled {
  double lux = 0;
  int of_lamps = 0, of_sky = 0, lamps_disagree = 0, sky_disagrees = 0;
};

Sampled sample(const Lights& lights, glm::vec3 point, glm::vec3 normal, LightKinds kinds) {
  alignas(64) int all[kPacket];
  Vec3Packet points, normals;
  for (int i = 0; i < kPacket; ++i) all[i] = -1, points.set(i, point), normals.set(i, normal);
  constexpr int kSamples = 65536;
  Sampled sampled;
  for (int first = 0; first < kSamples; first += kPacket) {
    alignas(64) float numbers[4][kPacket];
    joint_samples(first, hash(1, 2), numbers);
    LightPacket light;
    lights.sample(all, points, normals, numbers[0], numbers[1], light, kinds);
    for (int i = 0; i < kPacket; ++i) {
      const glm::vec3 direction = light.direction.at(i);
      sampled.lux += light.radiance.at(i).g * std::max(glm::dot(normal, direction), 0.0f) / kSamples;
      if (!(light.pdf[i] > 0)) continue;
      const bool of_sky = light.mesh[i] == kNoMesh;
      ++(of_sky ? sampled.of_sky : sampled.of_lamps);
      const float pdf = of_sky ? lights.environment_pdf(point, normal, direction, kinds)
                               : lights.triangle_pdf(point, normal, light.mesh[i], light.triangle[i],
                                                     light.distance_m[i], std::abs(direction.y), kinds);
      const bool disagrees = std::abs(pdf - light.pdf[i]) > 1e-3f * light.pdf[i];
      (of_sky ? sampled.sky_disagrees : sampled.lamps_disagree) += disagrees;
    }
  }
  return sampled;
}

// Sources too weak for numbers are none, whatever is beside them. An empty scene, whose bounds are infinite, has a
// defined average.
TEST(NearLights, LeaveNothingUndefined) {
  Scene scene = street(2);
  scene.environment = {8, 4, std::vector<glm::vec3>(32, glm::vec3(1))};
  for (const float candela : {0.0f, 1e12f}) {
    for (const float nits : {1e-33f, 1e-34f, 1e-35f, 1e-37f, 1e-40f, 1e-42f}) {
      scene.materials[1] = glowing(nits);
      scene.lights = {lamp_at({0, -2, 0}, candela)};
      const Intersector intersector(scene);
      const Lights lights(scene, intersector);
      EXPECT_TRUE(std::isfinite(lights.triangle_pdf({0, -1, 0}, kUp, 1, 0, 2, 1))) << candela << ' ' << nits;
      EXPECT_TRUE(std::isfinite(lights.environment_pdf({0, -1, 0}, kUp, kUp))) << candela << ' ' << nits;
      EXPECT_TRUE(std::isfinite(lights.near_lux())) << candela << ' ' << nits;
      EXPECT_TRUE(std::isfinite(sample(lights, {0, -1, 0}, kUp, LightKinds::all).lux)) << candela << ' ' << nits;
    }
  }
  Scene empty;
  empty.lights = {lamp_at({0, -2, 0}, 100)};
  const Intersector nothing(empty);
  EXPECT_NEAR(NearLights(empty, nothing.bounds()).average_lux(LightKinds::all), 12.5, 1e-3);  // 2 m away
}

// Samples of one surface add up to what arrives there by a sum over fine pieces of the lamps that are above it. The
// variance of one sample, the sum of f^2 / p less 1, is .86 and .35 of the squared mean here, so that 1 / 256 of the
// mean is more than a standard deviation of 65 536 random samples; a net errs by less.
TEST(Lights, SamplesOfAStreetsLampsAddUpToTheirLight) {
  const Scene scene = street(14);
  const Intersector intersector(scene);
  const Lights lights(scene, intersector);
  const glm::vec3 point(12, -2.5f, 0.3f);
  for (const glm::vec3 normal : {kUp, glm::normalize(glm::vec3(-1, -0.4f, 0.1f))}) {
    double expected = 0;
    for (int lamp = 0; lamp < 14; ++lamp) {
      for (int piece = 0; piece < 400; ++piece) {
        const glm::dvec3 at(10.0 * lamp - 0.1 + 0.01 * (piece % 20 + 0.5), -3,
                            -0.1 + 0.01 * (std::floor(piece / 20.0) + 0.5));
        const glm::dvec3 to = at - glm::dvec3(point);
        const double squared = glm::dot(to, to), length = std::sqrt(squared);
        const double cosine = std::max(glm::dot(glm::dvec3(normal), to) / length, 0.0);
        expected += (lamp % 3 == 2 ? 500 : 1000) * (0.04 / 400) * cosine * std::abs(to.y) / length / squared;
      }
    }
    const Sampled sampled = sample(lights, point, normal, LightKinds::all);
    EXPECT_NEAR(sampled.lux, expected, expected / 256);
    EXPECT_EQ(sampled.lamps_disagree, 0);
  }
}

// The same lamps, and another without extent, under a dim and under a bright sky and a sun. Directions on the border of
// two cells of the sky may round into either.
TEST(Lights, DensitiesAreThoseOfSamples) {
  for (const float sky_nits : {0.5f, 5.0f}) {
    Scene scene = street(14);
    scene.environment = {8, 4, std::vector<glm::vec3>(32, glm::vec3(sky_nits))};
    PunctualLight sun;
    sun.kind = PunctualLight::Kind::directional;
    sun.intensity = glm::vec3(10 * sky_nits);
    sun.direction = glm::normalize(glm::vec3(1, 1, 0));
    scene.lights = {sun, lamp_at({20, -2, 1}, 30)};
    const Intersector intersector(scene);
    const Lights lights(scene, intersector);
    const glm::vec3 normal = glm::normalize(glm::vec3(-1, -0.4f, 0.1f));
    for (const LightKinds kinds : {LightKinds::all, LightKinds::soft}) {
      for (const glm::vec3 point : {glm::vec3(11, -2.5f, 0.3f), glm::vec3(65, -0.1f, 4)}) {
        const Sampled sampled = sample(lights, point, normal, kinds);
        EXPECT_GT(sampled.of_lamps, 100);
        EXPECT_GT(sampled.of_sky, 100);
        EXPECT_EQ(sampled.lamps_disagree, 0);
        EXPECT_LT(sampled.sky_disagrees, 10);
      }
    }
  }
}

// Where a lamp is so close that all samples would go to it, it may be hidden: a quarter stays for the sky.
TEST(Lights, KeepSamplesForTheSkyBesideALamp) {
  const auto sky_pdf = [](std::vector<PunctualLight> lamps) {
    Scene scene;
    scene.materials = {diffuse(0.5f)};
    scene.meshes = {make_quad({-5, 0, -5}, {10, 0, 0}, {0, 0, 10}, 0)};
    scene.environment = {8, 4, std::vector<glm::vec3>(32, glm::vec3(100))};
    scene.lights = std::move(lamps);
    const Intersector intersector(scene);
    return Lights(scene, intersector).environment_pdf(glm::vec3(0, -0.01f, 0), kUp, kUp);
  };
  EXPECT_NEAR(sky_pdf({lamp_at({0, -0.02f, 0}, 100)}), 0.25 * sky_pdf({}), 1e-5);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
