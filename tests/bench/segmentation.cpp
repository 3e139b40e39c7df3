#include <benchmark/benchmark.h>

#include <random>

#include "pipeline/segmentation/network.h"
#include "pipeline/segmentation/person_mask.h"

/// What finding people costs, on one core: the network's 256 x 256, and faces at 1x and at 1x and 2x of 640 px.
namespace dualpixel::pipeline {
namespace {

Image noise(int width, int height) {
  std::mt19937 random(1);
  Image picture(width, height, 3);
  for (float& value : picture.data) value = static_cast<float>(random() % 1000) / 1000;
  return picture;
}

void person_network(benchmark::State& state) {
  PersonNetwork network(read_weights(DUALPIXEL_SOURCE_DIR "/pipeline/segmentation/weights/person.safetensors"));
  const Image input = network_input(noise(256, 192), {100, 50, 40, 40});
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(network(input));
}
BENCHMARK(person_network)->Unit(benchmark::kMillisecond);

/// By itself (--benchmark_filter=bf16): a process that has run f32 cannot.
void person_network_bf16(benchmark::State& state) try {
  PersonNetwork network(built_in_weights(), 1, Precision::bf16);
  const Image input = network_input(noise(256, 192), {100, 50, 40, 40});
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(network(input));
} catch (const std::exception& error) {
  state.SkipWithError(error.what());
}
BENCHMARK(person_network_bf16)->Unit(benchmark::kMillisecond);

void network_input_of_12_megapixels(benchmark::State& state) {
  const Image picture = noise(4000, 3000);
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(network_input(picture, {1000, 500, 400, 400}));
}
BENCHMARK(network_input_of_12_megapixels)->Unit(benchmark::kMillisecond);

void faces(benchmark::State& state) {
  const Image picture = noise(640, 480);
  find_faces(picture);  // sets the network up
  for ([[maybe_unused]] auto _ : state) benchmark::DoNotOptimize(find_faces(picture));
}
BENCHMARK(faces)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dualpixel::pipeline
