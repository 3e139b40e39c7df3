#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "capture/files.h"
#include "capture/image/image_io.h"
#include "evaluation/experiments/scene_experiment.h"
#include "scenes/kinds/kinds.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

void run(const evaluation::SceneExperimentOptions& options, const std::string& folder) {
  scenes::scene_kind(options.kind);  // refuses others before anything is written
  NewFolder out(folder, "scenes.json");
  Progress bar(options.kind);
  const std::string scratch = out.path() + "/scratch";
  std::filesystem::create_directory(scratch);
  const evaluation::SceneExperiment measured =
      evaluation::measure_scenes(options, scratch, [&](double fraction) { bar(fraction); });
  std::filesystem::remove_all(scratch);
  int failed = 0;
  for (const evaluation::DrawnSceneResult& scene : measured.scenes) {
    failed += !scene.faults.empty();
    for (const std::string& fault : scene.faults)
      std::cerr << fmt::format("{}, seed {}: {}\n", options.kind, scene.seed, fault);
  }
  const auto was_rendered = [](const evaluation::DrawnSceneResult& scene) { return scene.rendered; };
  if (std::none_of(measured.scenes.begin(), measured.scenes.end(), was_rendered)) {
    throw std::runtime_error(fmt::format("{}: none of {} scenes was rendered", options.kind, options.count));
  }
  write_png8(out.path() + "/sheet.png", measured.sheet);
  write_file(out.path() + "/scenes.json", to_json(measured, options).dump(2) + "\n");
  out.commit();
  std::cout << fmt::format("{} of {} scenes without a warning\n", options.count - failed, options.count);
}

}  // namespace

void add_experiment_scenes(CLI::App& experiment) {
  auto options = std::make_shared<evaluation::SceneExperimentOptions>();
  auto folder = std::make_shared<std::string>();
  CLI::App* command = experiment.add_subcommand(
      "scenes", "Draw, load and render many seeds of a kind of scene: a contact sheet, failures, cost, statistics");
  command->add_option("kind", options->kind, "A kind of scene, as `dualpixel scene --options` lists them")
      ->required()
      ->type_name("KIND");
  command->add_option("--count", options->count, "Seeds; the sheet shows the first 36")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--first", options->first_seed, "The first of them")->check(any_seed())->capture_default_str();
  command->add_option("--width", options->width_px, "Of the pictures, photosites: a multiple of 16")
      ->check(CLI::Range(64, 2048))
      ->check([](const std::string& text) {
        return text.size() < 6 && std::atoi(text.c_str()) % 16 == 0 ? "" : "must be a multiple of 16";
      })
      ->capture_default_str();
  command
      ->add_option("--samples", options->samples_per_pixel,
                   "Of each photosite: a multiple of 4; of each point of light no more than this or 64")
      ->check(CLI::Range(4, 4096))
      ->check([](const std::string& text) {
        return text.size() < 6 && std::atoi(text.c_str()) % 4 == 0 ? "" : "must be a multiple of 4";
      })
      ->capture_default_str();
  command->add_option("-o,--output", *folder, "Folder to write scenes.json and sheet.png into")
      ->required()
      ->type_name("DIR");
  add_threads_option(*command);
  command->footer("Example:\n  dualpixel experiment scenes still_life --count 36 -o out/still_lifes");
  command->callback([options, folder] { run(*options, *folder); });
}

}  // namespace dualpixel::tools
