// How many samples a picture needs, and how the views share its noise.
#include "simulator/render/adaptive.h"
#include "simulator/sampling/mosaic.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <bit>
#include <cmath>

#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

/// Noise to share samples out for: light is sampled by every path.
constexpr LightCacheOptions kSampledLight{.light_spacing_px = 0};

/// A gray wall that a bar in front of it shades from an uneven sky; half of the picture is smooth, half is not.
Scene barred_wall() {
  Scene scene;
  scene.materials = {diffuse(0.7f)};
  scene.meshes = {make_quad({-1, -1, 1.5f}, {2, 0, 0}, {0, 2, 0}, 0),
                  make_quad({0, -0.5f, 1.45f}, {0.5f, 0, 0}, {0, 0.5f, 0}, 0)};
  scene.environment = {4,
                       2,
                       {glm::vec3(100), glm::vec3(900), glm::vec3(300), glm::vec3(200), glm::vec3(50), glm::vec3(80),
                        glm::vec3(20), glm::vec3(10)}};
  return scene;
}

constexpr int kWidth = 96, kHeight = 64;

// Light noise that lies at the same pixel in both views pulls their disparity to 0: the views' errors must go together
// no more than those of independent samples do.
TEST(Views, DoNotShareTheirNoise) {
  Scene scene = barred_wall();
  scene.meshes.pop_back();
  constexpr int kSide = 48;
  const RenderScene world(scene, kSampledLight);
  const CameraView camera = phone_camera(0.8, kSide, kSide);
  const Views a = render_views(world, camera, {16, 0, 3}), b = render_views(world, camera, {16, 0, 4});
  double left2 = 0, right2 = 0, both = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const double left = a.left.data[3 * i] - b.left.data[3 * i], right = a.right.data[3 * i] - b.right.data[3 * i];
    left2 += left * left;
    right2 += right * right;
    both += left * right;
  }
  // of independent samples, shared out by the ramp 1/2 +- p/(2k): (1/4 - 1/(16 k^2)) / (1/4 + 1/(16 k^2))
  const double k = 1.19, share = 1 / (16 * k * k);
  EXPECT_LT(both / std::sqrt(left2 * right2), (0.25 - share) / (0.25 + share));
}

/// RMS of the error between two renders with one map over the allowed error: what a picture got for what it asked.
double realised(const RenderScene& world, const CameraView& camera, const ErrorTarget& target, const SampleMap& map) {
  const Views a = render_views(world, camera, {0, 0, 101}, map), b = render_views(world, camera, {0, 0, 102}, map);
  double sum = 0;
  for (int y = 0; y < map.height_px; ++y) {
    for (int x = 0; x < map.width_px; ++x) {
      const int c = cfa_color(x, y);
      for (const auto& [one, other] :
           {std::pair{a.left.at(x, y, c), b.left.at(x, y, c)}, {a.right.at(x, y, c), b.right.at(x, y, c)}}) {
        sum += 0.5 * std::pow(one - other, 2) / (target.per_nit[c] * 0.5 * (one + other) + target.constant[c]);
      }
    }
  }
  return std::sqrt(sum / (2.0 * map.width_px * map.height_px));
}

/// What adaptive sampling promises of the realised error: 16 probes of a tile, each the difference of two renders,
/// leave 18 % of its error unsure, 24 tiles of the picture 4 %; the rest is room for drawing on the curve's last slope.
constexpr double kOfItsTarget = 0.2;

TEST(SlowAdaptive, RealisesTheErrorThatItWasAskedFor) {
  const Scene scene = barred_wall();
  const RenderScene world(scene, kSampledLight);
  const CameraView camera = phone_camera(0.8, kWidth, kHeight);
  for (double allowed : {0.01, 0.003}) {  // nits^2 for each nit: of some 100 nits, 1 % and 0.5 %
    const ErrorTarget target{{allowed, allowed, allowed}, {1e-6, 1e-6, 1e-6}};
    const Pilot pilot = probe_tiles(world, camera, {0, 0, 9}, target);
    const SampleMap map = share_samples(pilot, 1);
    EXPECT_GT(map.total_samples(), 40.0 * kWidth * kHeight) << "the fewest samples were enough";
    const double ratio = realised(world, camera, target, map);
    EXPECT_NEAR(ratio, 1, kOfItsTarget) << allowed;
    for (std::uint32_t samples : map.samples) EXPECT_TRUE(std::has_single_bit(samples)) << samples;
    EXPECT_LT(pilot.samples, 0.5 * map.total_samples());
  }
}

// Where the fewest samples are more than enough, the error that is stated is theirs, not that of the goal. The probes
// end at half as many, from which variance is taken to halve; a net's may fall to a quarter.
TEST(Adaptive, StatesTheErrorOfTheFewestSamples) {
  const Scene scene = barred_wall();
  const RenderScene world(scene, kSampledLight);
  const CameraView camera = phone_camera(0.8, kWidth, kHeight);
  for (double allowed : {10.0, 1000.0}) {
    const ErrorTarget target{{allowed, allowed, allowed}, {1e-6, 1e-6, 1e-6}};
    const SampleMap map = share_samples(probe_tiles(world, camera, {0, 0, 9}, target), 1);
    EXPECT_EQ(map.total_samples(), 16.0 * kWidth * kHeight);
    double squares = 0;
    for (const float ratio : map.error_ratio) squares += ratio * ratio / static_cast<double>(map.error_ratio.size());
    const double over_stated = std::sqrt(squares) / realised(world, camera, target, map);
    EXPECT_GT(over_stated, 1 - kOfItsTarget) << allowed;
    EXPECT_LT(over_stated, std::sqrt(2) * (1 + kOfItsTarget)) << allowed;
  }
}

// As many samples as can be paid for, shared out as for an error: the error that comes with them costs as much.
TEST(Adaptive, SpendsABudget) {
  const Scene scene = barred_wall();
  const RenderScene world(scene, kSampledLight);
  const CameraView camera = phone_camera(0.8, kWidth, kHeight);
  const ErrorTarget target{{0.003, 0.003, 0.003}, {1e-6, 1e-6, 1e-6}};
  const Pilot pilot = probe_tiles(world, camera, {0, 0, 9}, target);
  const SampleMap wanted = share_samples(pilot, 1);
  const SampleMap map = share_budget(pilot, [&] { return wanted.total_samples(); });
  EXPECT_LE(map.total_samples(), wanted.total_samples());
  EXPECT_GT(map.total_samples(), (1 - 2.0 / 24) * wanted.total_samples());  // counts double: one tile of 24 is the step
  double sum = 0;
  for (float ratio : map.error_ratio) sum += ratio * ratio / static_cast<float>(map.error_ratio.size());
  EXPECT_NEAR(sum, 1, 3.0 / 24);  // likewise: halving one tile's samples costs up to 3 times its share of the squares
  const double photosites = kWidth * kHeight;
  EXPECT_EQ(share_budget(pilot, [] { return 0.0; }, {8, 64}).total_samples(), 8 * photosites);
  EXPECT_EQ(share_budget(pilot, [] { return 1e12; }, {8, 64}).total_samples(), 64 * photosites);
}

// The mean of 64 renders, each with a pilot of its own, against that of 64 with one count for all: were the count to
// depend on the samples that it counts, dark tiles would stop early.
TEST(SlowAdaptive, StoppingDoesNotBias) {
  const Scene scene = barred_wall();
  const RenderScene world(scene, kSampledLight);
  constexpr int kSide = 32, kRenders = 64, kPhotosites = kSide * kSide;
  const CameraView camera = phone_camera(0.8, kSide, kSide);
  const ErrorTarget target{{0.03, 0.03, 0.03}, {1e-6, 1e-6, 1e-6}};
  std::vector<double> sum[2], sum2[2];
  for (int kind : {0, 1}) {
    sum[kind].resize(kPhotosites);
    sum2[kind].resize(kPhotosites);
    for (std::uint64_t seed = 1000; seed < 1000 + kRenders; ++seed) {
      const SampleMap map = kind == 0 ? share_samples(probe_tiles(world, camera, {0, 0, seed}, target), 1)
                                      : uniform_map(kSide, kSide, 64);
      const Views views = render_views(world, camera, {0, 0, seed + 5000 * kind}, map);
      for (int i = 0; i < kPhotosites; ++i) {
        const double value = views.left.data[3 * i + 1];
        sum[kind][i] += value;
        sum2[kind][i] += value * value;
      }
    }
  }
  double z = 0, z2 = 0;
  for (int i = 0; i < kPhotosites; ++i) {
    double difference = 0, variance = 1e-12;
    for (int kind : {0, 1}) {
      const double mean = sum[kind][i] / kRenders;
      difference += kind == 0 ? mean : -mean;
      variance += (sum2[kind][i] / kRenders - mean * mean) / (kRenders - 1);
    }
    z += difference / std::sqrt(variance);
    z2 += difference * difference / variance;
  }
  // Student's t with some 63 degrees of freedom: variance 63/61, and 2.2 that of its square
  EXPECT_LT(std::abs(z), 3 * std::sqrt(kPhotosites * 63 / 61.0));
  EXPECT_NEAR(z2 / kPhotosites, 63 / 61.0, 3 * std::sqrt(2.2 / kPhotosites));
}

TEST(Adaptive, IsTheSameForAnyNumberOfThreads) {
  const Scene scene = barred_wall();
  const RenderScene world(scene, kSampledLight);
  const CameraView camera = phone_camera(0.8, kWidth, kHeight);
  const ErrorTarget target{{0.03, 0.03, 0.03}, {1e-6, 1e-6, 1e-6}};
  std::vector<std::uint32_t> samples;
  for (int threads : {1, 3}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const SampleMap map = share_samples(probe_tiles(world, camera, {0, 0, 9}, target), 1);
    if (samples.empty()) samples = map.samples;
    EXPECT_EQ(samples, map.samples);
  }
}

// Few samples of a coat or of a thin shadow may take more light away than there is: no variance is negative for that.
TEST(Adaptive, NegativeLightAllowsWhatDarknessDoes) {
  const ErrorTarget target{{3, 4, 5}, {0.1, 0.2, 0.3}};
  EXPECT_EQ(target.at(1, 2), 8.2);
  EXPECT_EQ(target.at(1, -26), 0.2);
}

TEST(Adaptive, DarknessAndImpossibleTargetsEnd) {
  Scene scene = barred_wall();
  const CameraView camera = phone_camera(0.8, 32, 16);
  const Pilot greedy = probe_tiles(RenderScene(scene), camera, {0, 0, 9}, {{0, 0, 0}, {1e-12, 1e-12, 1e-12}}, 64);
  for (std::uint32_t n : share_samples(greedy, 1, {32, 64}).samples) EXPECT_EQ(n, 64u);
  scene.environment = {};
  const Pilot dark = probe_tiles(RenderScene(scene), camera, {0, 0, 9}, {{0, 0, 0}, {1e-12, 1e-12, 1e-12}});
  for (std::uint32_t n : share_samples(dark, 1).samples) EXPECT_EQ(n, SampleLimits{}.fewest);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
