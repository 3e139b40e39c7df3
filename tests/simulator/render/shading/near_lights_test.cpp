// Which lights samples go to, and that they go there as often as they say.
#include "simulator/render/shading/near_lights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "simulator/render/shading/lights.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/sobol.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

PunctualLight lamp_at(glm::vec3 position, float candela) {
  PunctualLight lamp;
  lamp.position = position;
  lamp.intensity = glm::vec3(candela);
  return lamp;
}

/// A street of `count` lamps, 10 m apart along x and 3 m above the ground y = 0 (up is -y).
Scene street(int count) {
  Scene scene;
  scene.materials = {diffuse(0.5f), glowing(1000)};
  scene.meshes = {make_quad({-5, 0, -5}, {10.0f * count, 0, 0}, {0, 0, 10}, 0)};
  for (int i = 0; i < count; ++i) {
    scene.meshes.push_back(make_quad({10.0f * i - 0.1f, -3, -0.1f}, {0.2f, 0, 0}, {0, 0, 0.2f}, 1));
  }
  return scene;
}

NearLights near_lights(const Scene& scene) { return {scene, glm::vec3(0, -1.5f, 0), 70}; }

/// All lanes of a packet on one surface.
NearLights::Choice choice_at(const NearLights& near, glm::vec3 point, glm::vec3 normal, LightKinds kinds) {
  Vec3Packet points, normals;
  for (int i = 0; i < kPacket; ++i) points.set(i, point), normals.set(i, normal);
  NearLights::Choice choice;
  near.choose(points, normals, kinds, choice);
  return choice;
}

constexpr glm::vec3 kUp(0, -1, 0);

// Every hundred-thousandth of [0, 1) is picked once: a triangle has as many as its probability says, but for two at the
// ends of each stretch; and all together have all.
TEST(NearLights, PicksEachTriangleAsOftenAsItsProbabilitySays) {
  Scene scene = street(40);  // more lamps than groups
  scene.lights = {lamp_at({3, -2, 0}, 500), lamp_at({200, -2, 0}, 2)};
  const NearLights near = near_lights(scene);
  constexpr int kCount = 100000;
  for (const LightKinds kinds : {LightKinds::all, LightKinds::soft}) {
    for (const glm::vec3 point : {glm::vec3(0), glm::vec3(7, -2.9f, 1), glm::vec3(180, 0, 4)}) {
      const glm::vec3 normal = glm::normalize(glm::vec3(0.2f, -1, 0.1f));
      const NearLights::Choice choice = choice_at(near, point, normal, kinds);
      std::map<std::size_t, int> times;
      for (int i = 0; i < kCount; ++i) {
        float u = (i + 0.5f) / kCount;
        ++times[near.pick(choice, 5, kinds, u).light];
        ASSERT_GE(u, 0);
        ASSERT_LT(u, 1);
      }
      int of_triangles = 0;
      double sum = 0;
      for (std::size_t t = 0; t < near.triangles().size(); ++t) {
        const double probability = near.probability(point, normal, kinds, static_cast<int>(t));
        sum += probability;
        of_triangles += times[scene.lights.size() + t];
        EXPECT_NEAR(times[scene.lights.size() + t], probability * kCount, 3) << t;
      }
      EXPECT_NEAR(of_triangles, sum * kCount, 3 + 1e-5 * kCount);
      EXPECT_EQ(of_triangles == kCount, kinds == LightKinds::soft);
    }
  }
}

// One meter below the first of fourteen lamps, 1 / (1 + sum of cos / d^2 of the others) = 99 % of the light is its own.
// It gets half of all samples for that, and a fourteenth of the other half.
TEST(NearLights, PrefersTheOneCloseBy) {
  const Scene scene = street(14);
  const NearLights near = near_lights(scene);
  const auto probability = [&](glm::vec3 point) {
    return near.probability(point, kUp, LightKinds::soft, 0) + near.probability(point, kUp, LightKinds::soft, 1);
  };
  EXPECT_NEAR(probability({0, -2, 0}), 0.5 + 0.5 / 14, 0.02);
  EXPECT_LT(probability({100, 0, 0}), 0.05);
}

// What a lamp throws on the ground below it follows its distance, whichever group it is in.
TEST(NearLights, KnowWhatOneLampThrows) {
  Scene scene;
  scene.materials = {diffuse(0.5f)};
  scene.meshes = {make_quad({-5, 0, -5}, {10, 0, 0}, {0, 0, 10}, 0)};
  scene.lights = {lamp_at({0, -2, 0}, 100)};
  const NearLights near = near_lights(scene);
  EXPECT_NEAR(near.lux({0, 0, 0}, kUp, LightKinds::hard), 25, 1e-4);
  EXPECT_NEAR(near.lux({2, 0, 0}, kUp, LightKinds::hard), 100 / 8.0 * std::sqrt(0.5), 1e-4);
  EXPECT_EQ(near.lux({0, 0, 0}, -kUp, LightKinds::hard), 0);
  EXPECT_EQ(near.lux({0, 0, 0}, kUp, LightKinds::soft), 0);
  EXPECT_EQ(choice_at(near, {2, 0, 0}, kUp, LightKinds::all).lux[0], near.lux({2, 0, 0}, kUp, LightKinds::all));
}

// A light that may be seen has a share: of 10 000 surfaces in a street, each lamp any corner of which lies above one.
TEST(NearLights, LeaveOutOnlyWhatIsBehindTheSurface) {
  const Scene scene = street(14);
  const NearLights near = near_lights(scene);
  int behind = 0;
  for (int i = 0; i < 10000; i += kPacket) {
    alignas(64) float at[4][kPacket], facing[4][kPacket];
    joint_samples(i, hash(1, 0), at);
    joint_samples(i, hash(2, 0), facing);
    for (int k = 0; k < kPacket; ++k) {
      const glm::vec3 point(160 * at[0][k] - 10, -6 * at[1][k], 4 * at[2][k] - 2);
      const glm::vec3 normal = glm::normalize(glm::vec3(facing[0][k] - 0.5f, facing[1][k] - 0.5f, facing[2][k] - 0.5f));
      for (std::size_t t = 0; t < near.triangles().size(); ++t) {
        const NearLights::Triangle& light = near.triangles()[t];
        const glm::vec3 corner = light.corner - point;
        const float highest = glm::dot(normal, corner) +
                              std::max({0.0f, glm::dot(normal, light.first_edge), glm::dot(normal, light.second_edge)});
        const float probability = near.probability(point, normal, LightKinds::soft, static_cast<int>(t));
        if (highest > 1e-4f) {
          EXPECT_GT(probability, 0);
        } else if (probability == 0) {
          ++behind;
        }
      }
    }
  }
  EXPECT_GT(behind, 100000);  // of 280 000, nearly half
}

// However close a lamp is, it may be hidden: the others keep half of what they would have by average light.
TEST(NearLights, LeaveHalfOfTheSamplesToLampsFarAway) {
  Scene scene;
  scene.lights = {lamp_at({0, -1e-3f, 0}, 100), lamp_at({30, -1, 0}, 100)};
  const NearLights near = near_lights(scene);
  const NearLights::Choice choice = choice_at(near, glm::vec3(0), kUp, LightKinds::hard);
  float u = 0.999f;
  const NearLights::Picked far = near.pick(choice, 0, LightKinds::hard, u);
  EXPECT_EQ(far.light, 1u);
  EXPECT_NEAR(far.probability, 0.25, 0.01);
}

/// Mean of what samples of all lights throw on a surface. Each states the density that the light it went to reports.
double sampled_lux(const Lights& lights, glm::vec3 point, glm::vec3 normal) {
  alignas(64) int all[kPacket];
  Vec3Packet points, normals;
  for (int i = 0; i < kPacket; ++i) all[i] = -1, points.set(i, point), normals.set(i, normal);
  constexpr int kSamples = 65536;
  double sum = 0;
  for (int first = 0; first < kSamples; first += kPacket) {
    alignas(64) float numbers[4][kPacket];
    joint_samples(first, 7, numbers);
    LightPacket light;
    lights.sample(all, points, normals, numbers[0], numbers[1], light);
    for (int i = 0; i < kPacket; ++i) {
      const glm::vec3 direction = light.direction.at(i);
      sum += light.radiance.at(i).g * std::max(glm::dot(normal, direction), 0.0f) / kSamples;
      if (!(light.pdf[i] > 0) || light.mesh[i] == kNoMesh) continue;
      const float pdf = lights.triangle_pdf(point, normal, light.mesh[i], light.triangle[i], light.distance_m[i],
                                            std::abs(direction.y));
      EXPECT_NEAR(pdf, light.pdf[i], 1e-4f * light.pdf[i]);
    }
  }
  return sum;
}

// Under lamps that all throw something, samples of one point add up to what arrives by a sum over fine pieces of the
// lamps; 65 536 samples of a net, whose error is below that of as many random ones: .4 % here.
TEST(Lights, SamplesOfAStreetsLampsAddUpToTheirLight) {
  const Scene scene = street(14);
  const Intersector intersector(scene);
  const Lights lights(scene, intersector);
  const glm::vec3 point(12, -2.5f, 0.3f);
  const glm::vec3 normal = glm::normalize(glm::vec3(-1, -0.4f, 0.1f));
  double expected = 0;
  for (int lamp = 0; lamp < 14; ++lamp) {
    for (int piece = 0; piece < 400; ++piece) {
      const glm::dvec3 at(10.0 * lamp - 0.1 + 0.2 * (piece % 20 + 0.5) / 20, -3, -0.1 + 0.2 * (piece / 20 + 0.5) / 20);
      const glm::dvec3 to = at - glm::dvec3(point);
      const double squared = glm::dot(to, to), length = std::sqrt(squared);
      const double cosine = std::max(glm::dot(glm::dvec3(normal), to) / length, 0.0);
      expected += 1000 * (0.04 / 400) * cosine * std::abs(to.y) / length / squared;
    }
  }
  EXPECT_NEAR(sampled_lux(lights, point, normal), expected, 0.004 * expected);
}

// The same lamps under a dim and under a bright sky and a sun.
TEST(Lights, DensitiesAreThoseOfSamples) {
  for (const float sky_nits : {0.5f, 100.0f}) {
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
    for (const glm::vec3 point : {glm::vec3(11, -2.5f, 0.3f), glm::vec3(65, -0.1f, 4)}) {
      EXPECT_GT(sampled_lux(lights, point, normal), 0);
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
