#include <fmt/format.h>
#include <tbb/global_control.h>

#include <cstring>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/json_fields.h"
#include "pipeline/portrait.h"
#include "simulator/sampling/hash.h"
#include "simulator/simulate.h"
#include "tools/commands.h"
#include "tools/timing.h"

namespace dualpixel::tools {
namespace {

struct BenchOptions {
  std::string scene = "scenes/portrait.json";
  bool json = false;
};

/// The renderer at 1344 x 1008, 64 samples, and Embree alone on some of the same rays: one thread each, turn by turn,
/// so that a busy machine slows both.
nlohmann::json bench_render(const simulator::Simulation& s, const simulator::Scene& scene) {
  const simulator::RenderScene world(scene);
  simulator::SensorGrid sensor = simulator::sensor_grid(s);
  sensor = {1344, 1008, sensor.pixel_pitch_m * sensor.width_px / 1344.0, {672, 504}};
  const simulator::CameraView camera{simulator::place_camera(s, scene).world_from_camera, {s.lens, sensor}};
  constexpr int kSamples = 64, kTilesApart = 12, kTile = 16;
  const auto render_tiles = [&](simulator::RayLog* log) {
    int photosites = 0;
    for (int tile_y = 0; tile_y < sensor.height_px; tile_y += kTilesApart * kTile) {
      for (int tile_x = 0; tile_x < sensor.width_px; tile_x += kTilesApart * kTile) {
        for (int i = 0; i < kTile * kTile; ++i, ++photosites) {
          const int x = tile_x + i % kTile, y = tile_y + i / kTile;
          render_pixel(world, camera, {s.render.max_bounces, {}, simulator::Sampling::mirrored, log}, x, y, kSamples,
                       simulator::hash(1, static_cast<std::uint64_t>(y) << 32 | static_cast<unsigned>(x)));
        }
      }
    }
    return photosites;
  };
  simulator::RayLog log;
  const double samples = 1.0 * kSamples * render_tiles(&log);

  double ours_s = 1e30, embree_s = 1e30;
  for (int repeat = 0; repeat < 10; ++repeat) {
    ours_s = std::min(ours_s, seconds([&] { render_tiles(nullptr); }));
    embree_s = std::min(embree_s, seconds([&] { replay(world.intersector, log, simulator::kPacket); }));
  }
  return {{"samples_per_core_s", samples / ours_s},
          {"embree_samples_per_core_s", samples / embree_s},
          {"share_of_embree", embree_s / ours_s}};
}

/// The pipeline on a capture of this scene, all cores, against copying its nine frames in memory once.
nlohmann::json bench_pipeline(simulator::Simulation s, const simulator::Scene& scene) {
  s.render.samples_per_pixel = s.photograph_samples_per_pixel = s.all_in_focus_samples_per_pixel = 1;
  Capture capture = simulator::simulate(s, scene);
  capture.truth.reset();
  double best_s = 1e30;
  nlohmann::json stages;
  for (int repeat = 0; repeat < 3; ++repeat) {
    pipeline::PortraitResult result;
    const double time_s = seconds([&] { result = pipeline::run_portrait(capture, {}); });
    if (time_s >= best_s) continue;
    best_s = time_s;
    stages = nlohmann::json::object();
    for (const pipeline::StageTime& stage : result.stages) stages[stage.name] = stage.ms;
  }
  std::vector<ImageU16> copies(capture.frames.size());
  for (std::size_t i = 0; i < copies.size(); ++i) copies[i] = capture.frames[i].mosaic;  // touch the pages
  const double copy_s = seconds([&] {
    for (std::size_t i = 0; i < copies.size(); ++i) {
      std::memcpy(copies[i].data.data(), capture.frames[i].mosaic.data.data(), copies[i].data.size() * 2);
    }
  });
  return {{"dp_ms", best_s * 1e3},
          {"burst_copy_ms", copy_s * 1e3},
          {"ratio_to_copy", best_s / copy_s},
          {"stages_ms", stages}};
}

void run(const BenchOptions& options) {
  const simulator::Simulation s = simulator::read_simulation(read_json_file(options.scene), options.scene);
  const simulator::Scene scene = simulator::load_scene(s);
  const nlohmann::json render = bench_render(s, scene);
  const nlohmann::json pipeline = bench_pipeline(s, scene);
  if (options.json) {
    std::cout << nlohmann::json{{"render", render}, {"pipeline", pipeline}}.dump(2) << '\n';
    return;
  }
  std::cout << fmt::format(
      "render    {:6.2f} M camera samples/s for each core; Embree alone {:6.2f} M; ratio {:.2f}\n"
      "pipeline  {:6.0f} ms (dp); copying the burst {:6.1f} ms; ratio {:.0f}\n",
      render["samples_per_core_s"].get<double>() / 1e6, render["embree_samples_per_core_s"].get<double>() / 1e6,
      render["share_of_embree"].get<double>(), pipeline["dp_ms"].get<double>(), pipeline["burst_copy_ms"].get<double>(),
      pipeline["ratio_to_copy"].get<double>());
  for (const auto& [name, ms] : pipeline["stages_ms"].items()) {
    std::cout << fmt::format("  {:<12}{:8.0f} ms\n", name, ms.get<double>());
  }
}

}  // namespace

void add_bench(CLI::App& program) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* command =
      program.add_subcommand("bench", "Time the renderer against Embree alone, the pipeline against a copy");
  command->add_option("scene", options->scene, "Scene JSON file (default: scenes/portrait.json)")
      ->type_name("SCENE.json");
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(
      "Example:\n  dualpixel bench scenes/portrait.json\n  dualpixel bench lens lens_models/phone_6p_4.2mm_f1.8.json");
  add_bench_lens(*command);
  add_bench_disparity(*command);
  add_bench_edges(*command);
  add_bench_render(*command);
  command->callback([options, command] {
    if (command->get_subcommands().empty()) run(*options);
  });
}

}  // namespace dualpixel::tools
