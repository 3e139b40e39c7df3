// The renderer's inner loops by themselves, sixteen samples an iteration, and whole photosites:
// build/release/tests/bench_render_kernels
#include <benchmark/benchmark.h>

#include <cmath>
#include <glm/gtc/constants.hpp>

#include "simulator/lens/lens_file.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/lens/lens_sampler.h"
#include "simulator/render/pixel.h"
#include "simulator/render/render_scene.h"
#include "simulator/render/shading/lights.h"
#include "simulator/render/shading/surface.h"
#include "simulator/sampling/sobol.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

void mirrored(benchmark::State& state) {
  alignas(64) float s[4][kPacket];
  std::uint64_t key = 0;
  for ([[maybe_unused]] auto _ : state) {
    mirrored_samples(0, ++key, s);
    benchmark::DoNotOptimize(s);
  }
  state.SetItemsProcessed(state.iterations() * kPacket);
}
BENCHMARK(mirrored);

void padded(benchmark::State& state) {
  alignas(64) float u[kPacket], v[kPacket];
  std::uint64_t key = 0;
  for ([[maybe_unused]] auto _ : state) {
    padded_samples(0, 31, ++key, 0, u, v);
    benchmark::DoNotOptimize(u);
    benchmark::DoNotOptimize(v);
  }
  state.SetItemsProcessed(state.iterations() * kPacket);
}
BENCHMARK(padded);

void lens(benchmark::State& state, const char* file, bool exact) {
  Lens lens = read_lens_file(std::string(DUALPIXEL_SOURCE_DIR "/lens_models/") + file, 1);
  if (auto* model = std::get_if<PrescriptionModel>(&lens.model)) model->exact_trace = exact;
  const LensSampler sampler(lens, phone_sensor(1344, 1008));
  alignas(64) float s[4][kPacket];
  mirrored_samples(0, 1, s);
  LensPacket rays;
  int pixel = 0;
  for ([[maybe_unused]] auto _ : state) {
    pixel = (pixel + 7919) % (1344 * 1008);
    sampler.sample(pixel % 1344, pixel / 1344, 1, s, rays);
    benchmark::DoNotOptimize(rays);
  }
  state.SetItemsProcessed(state.iterations() * kPacket);
}
BENCHMARK_CAPTURE(lens, thin, "phone_thin_4.4mm_f1.8.json", false);
BENCHMARK_CAPTURE(lens, aberrated, "phone_aberrated_4.4mm_f1.8.json", false);
BENCHMARK_CAPTURE(lens, polynomials, "phone_6p_4.2mm_f1.8.json", false);
BENCHMARK_CAPTURE(lens, traced, "phone_6p_4.2mm_f1.8.json", true);

/// A textured wall under a sky of 64 x 32 and a sun.
Scene wall() {
  Scene scene;
  Texture texture{512, 512};
  for (int i = 0; i < 512 * 512; ++i) {
    const auto gray = static_cast<std::uint8_t>(hash(i));
    texture.rgba.insert(texture.rgba.end(), {gray, gray, gray, 255});
  }
  keep_decoded(texture);
  scene.textures = {texture};
  scene.materials = {diffuse(0.5f)};
  scene.materials[0].base_color_texture.texture = 0;
  scene.meshes = {make_quad({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, 0)};
  scene.environment = {64, 32, std::vector<glm::vec3>(64 * 32)};
  for (int i = 0; i < 64 * 32; ++i) scene.environment.radiance_nits[i] = glm::vec3(static_cast<float>(1000 + i));
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = glm::vec3(50000);
  sun.direction = {0, -0.6f, 0.8f};
  scene.lights = {sun};
  return scene;
}

struct Hits {
  RayPacket rays{};
  alignas(64) int lanes[kPacket];
  Hits() {
    for (int i = 0; i < kPacket; ++i) {
      lanes[i] = -1;
      rays.direction_z[i] = 1;
      rays.far[i] = 1;
      rays.u[i] = 0.02f * static_cast<float>(i);
      rays.v[i] = 0.3f;
    }
  }
};

template <typename Packet>
void shading(benchmark::State& state, void (*shade)(const Scene&, const Mesh&, const int*, const RayPacket&, Packet&)) {
  const Scene scene = wall();
  const Hits hits;
  Packet packet;
  for ([[maybe_unused]] auto _ : state) {
    shade(scene, scene.meshes[0], hits.lanes, hits.rays, packet);
    benchmark::DoNotOptimize(packet);
  }
  state.SetItemsProcessed(state.iterations() * kPacket);
}
BENCHMARK_CAPTURE(shading, base_colors, base_colors_at);
BENCHMARK_CAPTURE(shading, surfaces, surfaces_at);

void light_samples(benchmark::State& state) {
  const Scene scene = wall();
  const Intersector intersector(scene);
  const Lights lights(scene, intersector);
  const Hits hits;
  SurfacePacket surface;
  surfaces_at(scene, scene.meshes[0], hits.lanes, hits.rays, surface);
  alignas(64) float u[kPacket], v[kPacket];
  padded_samples(0, 31, 1, 0, u, v);
  LightPacket out;
  for ([[maybe_unused]] auto _ : state) {
    lights.sample(hits.lanes, surface.position, surface.normal, u, v, out);
    benchmark::DoNotOptimize(out);
  }
  state.SetItemsProcessed(state.iterations() * kPacket);
}
BENCHMARK(light_samples);

/// A ball of 6760 triangles, its texture wrapped around it.
Mesh make_ball(glm::vec3 center, float radius, int material) {
  constexpr int kAround = 65, kDown = 53;
  Mesh mesh;
  mesh.material = material;
  mesh.object_id = 1;
  for (int j = 0; j <= kDown; ++j) {
    for (int i = 0; i <= kAround; ++i) {
      const float u = static_cast<float>(i) / kAround, v = static_cast<float>(j) / kDown;
      const float ring = std::sin(glm::pi<float>() * v), angle = glm::two_pi<float>() * u;
      const glm::vec3 n(ring * std::cos(angle), -std::cos(glm::pi<float>() * v), ring * std::sin(angle));
      mesh.positions.push_back(center + radius * n);
      mesh.normals.push_back(n);
      mesh.uv0.emplace_back(u, v);
      if (i == kAround || j == kDown) continue;
      const unsigned at = static_cast<unsigned>(j * (kAround + 1) + i), below = at + kAround + 1;
      if (j > 0) mesh.triangles.emplace_back(at, at + 1, below + 1);
      if (j < kDown - 1) mesh.triangles.emplace_back(at, below + 1, below);
    }
  }
  return mesh;
}

/// Two textured planes and 15 balls, 101440 triangles, under a disc that shines: the scene on which renderers are
/// compared. A 50 mm f/1.0 lens focused at 3 m, 640 x 480 photosites.
Scene balls() {
  Scene scene = wall();
  scene.environment = {};
  scene.lights = {};
  scene.materials.push_back(glowing(20000));
  scene.meshes = {make_quad({-8, 1, -1}, {16, 0, 0}, {0, 0, 12}, 0), make_quad({-8, -5, 7}, {16, 0, 0}, {0, 6, 0}, 0)};
  for (int i = 0; i < 15; ++i) {
    const int column = i % 5, row = i / 5;
    const float x = 0.55f * static_cast<float>(column - 2);
    const float z = 2 + 0.8f * static_cast<float>(row) + 0.1f * static_cast<float>(column);
    scene.meshes.push_back(make_ball({x, row == 1 ? 0.2f : 0.7f, z}, 0.28f, 0));
  }
  Mesh disc;
  disc.material = 1;
  disc.object_id = 1;
  disc.positions.emplace_back(0, -4, 2);
  constexpr int kRim = 36;
  for (int i = 0; i < kRim; ++i) {
    const float angle = glm::two_pi<float>() * static_cast<float>(i) / kRim;
    disc.positions.emplace_back(std::cos(angle), -4, 2 + std::sin(angle));
    disc.triangles.emplace_back(0, i + 1, (i + 1) % kRim + 1);
  }
  scene.meshes.push_back(disc);
  return scene;
}

/// Direct light: a camera ray and a shadow ray for each of 64 samples of photosites all over the picture.
void balls_in_direct_light(benchmark::State& state) {
  const Scene scene = balls();
  const RenderScene world(scene);
  Lens lens;
  lens.thin = {50e-3, 1.0, 3};
  const CameraView camera{glm::mat4(1), LensSampler(lens, phone_sensor(640, 480, 36e-3 / 640))};
  constexpr int kSamples = 64;
  // tile by tile of 16 x 16, as pictures are rendered; the tiles all over the picture
  constexpr int kColumns = 640 / 16, kTiles = kColumns * (480 / 16);
  int tile = 0, pixel = 0;
  for ([[maybe_unused]] auto _ : state) {
    const int x = tile % kColumns * 16 + pixel % 16, y = tile / kColumns * 16 + pixel / 16;
    benchmark::DoNotOptimize(render_pixel(world, camera, {}, x, y, kSamples, hash(x, y)));
    pixel = (pixel + 1) % 256;
    if (pixel == 0) tile = (tile + 769) % kTiles;
  }
  state.SetItemsProcessed(state.iterations() * kSamples);
}
BENCHMARK(balls_in_direct_light);

}  // namespace
}  // namespace dualpixel::simulator::testing
