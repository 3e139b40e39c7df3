#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/image_io.h"
#include "evaluation/comparison/compare_methods.h"
#include "evaluation/comparison/comparison_scenes.h"
#include "evaluation/comparison/comparison_table.h"
#include "pipeline/segmentation/network.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

namespace fs = std::filesystem;

struct MethodsCommand {
  std::string folder;
  int scenes = 0;
  bool json = false;
};

/// The scene's capture: kept in `folder`/captures, or made now.
Capture capture_of(const evaluation::ComparisonScene& scene, const std::string& folder) {
  const std::string path = folder + "/captures/" + scene.name;
  if (fs::exists(path)) return read_capture(path, true);
  Capture capture;
  {
    const NewFolder scratch(path + ".scene", "scene.json");  // goes when the capture is there
    capture = evaluation::simulate_comparison_scene(scene, scratch.path());
  }
  write_capture(capture, path);
  return capture;
}

std::string picture_file(const std::string& folder, std::size_t method) {
  return fmt::format("{}/method_{}.png", folder, method + 1);
}

/// Makes what `folder` of results is to hold of one scene.
void compare(const evaluation::ComparisonScene& scene, const Capture& capture, pipeline::PersonNetwork& network,
             const std::string& folder) {
  const evaluation::ComparedPictures result = evaluation::compare_methods(capture, scene.name, network);
  NewFolder out(folder, "figures.json");
  write_png8(out.path() + "/photograph.png", result.photograph_srgb);
  for (std::size_t i = 0; i < result.pictures_srgb.size(); ++i) {
    write_png8(picture_file(out.path(), i), result.pictures_srgb[i]);
  }
  write_file(out.path() + "/figures.json", to_json(result.figures).dump(2) + "\n");
  out.commit();
}

Image read_rgb(const std::string& path) {
  Image picture = read_image(path);
  if (picture.channels != 3) throw InputError(printable(path) + ": must be RGB; remove the folder to make it anew");
  return picture;
}

void check_names(const evaluation::SceneComparison& figures, const std::string& scene, const std::string& file) {
  const auto check = [&](const std::string& field, const std::string& found, const std::string& name) {
    if (found == name) return;
    throw InputError(fmt::format("{}: {}: {}: must be {}; remove the folder to make it anew", printable(file), field,
                                 printable(found), name));
  };
  check("/scene", figures.scene, scene);
  const std::vector<std::string> names = evaluation::compared_names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    check(fmt::format("/methods/{}/method", i), figures.methods[i].method, names[i]);
  }
}

evaluation::ComparedPictures read_compared(const std::string& folder, const std::string& scene) {
  evaluation::ComparedPictures result;
  result.figures = evaluation::read_scene_comparison(folder + "/figures.json");
  check_names(result.figures, scene, folder + "/figures.json");
  result.photograph_srgb = read_rgb(folder + "/photograph.png");
  const Image& photograph = result.photograph_srgb;
  for (const evaluation::Crop& crop : result.figures.crops) {
    if (crop.x + crop.side > photograph.width || crop.y + crop.side > photograph.height) {
      throw InputError(fmt::format("{}/figures.json: /crops: [{}, {}] and {} px: must lie in the photograph, {} x {}",
                                   printable(folder), crop.x, crop.y, crop.side, photograph.width, photograph.height));
    }
  }
  for (std::size_t i = 0; i < result.figures.methods.size(); ++i) {
    result.pictures_srgb.push_back(read_rgb(picture_file(folder, i)));
    if (!result.pictures_srgb.back().same_size(photograph)) {
      throw InputError(fmt::format("{}: must be of the photograph's size, {} x {}; remove the folder to make it anew",
                                   printable(picture_file(folder, i)), photograph.width, photograph.height));
    }
  }
  return result;
}

/// Refuses a folder with files of others, and marks an empty one as ours.
void claim(const std::string& folder) {
  const std::string marker = folder + "/methods.json";
  std::error_code error;
  if (fs::exists(folder, error) && !holds_nothing(folder) && !fs::exists(marker, error)) {
    throw InputError(fmt::format("{}: holds other files: needs an empty folder, or one of this command to go on with",
                                 printable(folder)));
  }
  require_writable(marker);
  if (!fs::exists(marker, error)) replace_file(marker, "{}\n");
}

void run(const MethodsCommand& command) {
  pipeline::PersonNetwork network;
  claim(command.folder);
  Progress bar("methods");
  std::vector<evaluation::SceneComparison> figures;
  std::string sections;
  for (const evaluation::ComparisonScene& scene : evaluation::comparison_scenes().first(command.scenes)) {
    const std::string folder = command.folder + "/results/" + scene.name;
    if (!fs::exists(folder)) compare(scene, capture_of(scene, command.folder), network, folder);
    const evaluation::ComparedPictures compared =
        read_compared(folder, scene.name);  // the same page, made now or before
    sections += scene_section(compared);
    figures.push_back(compared.figures);
    bar(static_cast<double>(figures.size()) / command.scenes);
  }
  const std::vector<evaluation::ComparedGroup> groups = evaluation::compare_scenes(figures);
  const std::string json = to_json(groups, figures).dump(2) + "\n";
  replace_file(command.folder + "/methods.html", to_page(groups, sections));
  replace_file(command.folder + "/methods.json", json);
  print_written(command.folder + "/methods.html");
  std::cout << (command.json ? json : to_text(groups));
}

}  // namespace

void add_experiment_methods(CLI::App& experiment) {
  auto command = std::make_shared<MethodsCommand>();
  const auto most = static_cast<int>(evaluation::comparison_scenes().size());
  command->scenes = most;
  CLI::App* sub = experiment.add_subcommand(
      "methods", "Five methods of synthetic defocus over drawn scenes, against true photographs: the paper's Table 3");
  sub->add_option("-o,--output", command->folder,
                  "Folder for methods.json and methods.html; captures and results are kept there, scene by scene, and "
                  "the same command goes on where it was ended")
      ->required()
      ->type_name("DIR");
  sub->add_option("--scenes", command->scenes, "The first so many; kinds alternate")
      ->check(CLI::Range(1, most))
      ->capture_default_str();
  sub->add_flag("--json", command->json, "Print methods.json in place of tables");
  add_threads_option(*sub);
  sub->footer("Example:\n  dualpixel experiment methods -o out/methods");
  sub->callback([command] { run(*command); });
}

}  // namespace dualpixel::tools
