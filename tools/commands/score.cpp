#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/image_io.h"
#include "evaluation/metrics/scoring.h"
#include "pipeline/portrait/zoom.h"
#include "tools/cli/map_options.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct ScoreOptions {
  std::string capture;
  std::string result;
  // files of anybody's making, instead of a result
  MapFiles maps;
  std::string portrait;
  bool json = false;
};

/// A score against noisy truth is lower than the picture deserves.
void warn_of_truth_noise(const std::string& capture, const evaluation::Score& score) {
  if (score.truth_noise_db.value_or(0) <= evaluation::kMostTruthNoiseDb) return;
  const bool limited = *score.truth_noise_db >= evaluation::kTruthNoiseLimitDb;
  std::cerr << fmt::format(
      "{}: rendering noise of the true photograph takes {:.2f} dB{} off the linear PSNR, more than {}: simulate with "
      "more samples, or with --noise-fraction 0.25\n",
      printable(capture), *score.truth_noise_db, limited ? " or more" : "", evaluation::kMostTruthNoiseDb);
}

void print(const ScoreOptions& options, const evaluation::Score& score, const std::string& json) {
  warn_of_truth_noise(options.capture, score);
  std::cout << (options.json ? json : evaluation::to_text(score));
}

std::string json_text(const evaluation::Score& score) {
  return evaluation::to_json(score).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void score_result_folder(const ScoreOptions& options) {
  if (std::filesystem::exists(options.result + "/capture.json") &&
      std::filesystem::exists(options.capture + "/result.json")) {
    throw InputError(fmt::format("{}: is a capture, and {} a result: give the capture first", printable(options.result),
                                 printable(options.capture)));
  }
  const pipeline::StoredResult stored = pipeline::read_result(options.result);
  Capture capture = read_capture(options.capture, true);
  pipeline::require_own_capture(stored, options.capture, options.result);
  if (const auto window = pipeline::window_of(stored, options.result)) {
    capture = pipeline::zoomed(capture, *window, options.result);
  }
  const evaluation::Score score = evaluation::score_result(capture, options.capture, stored, options.result);
  const std::string json = json_text(score);
  replace_file(options.result + "/score.json", json);
  print(options, score, json);
}

/// A picture as the linear signal that the truth has: sRGB-encoded, but for EXR.
Image read_portrait(const std::string& path) {
  Image image = read_image(path);
  if (image.channels < 3)
    throw InputError(fmt::format("{}: {} channels; RGB is needed", printable(path), image.channels));
  Image rgb(image.width, image.height, 3);
  const bool linear = picture_size(path).format == "openexr";
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    for (int c = 0; c < 3; ++c) {
      const float value = image.data[i * image.channels + c];
      rgb.data[3 * i + c] = linear ? value : linear_from_srgb(value);
    }
  }
  return rgb;
}

/// All files that are missing or cannot be read are named in one line.
void score_files(const ScoreOptions& options) {
  std::vector<std::string> problems;
  const auto attempt = [&](const auto& read) {
    try {
      read();
    } catch (const InputError& error) {
      problems.emplace_back(error.what());
    }
  };
  Capture capture;
  evaluation::Estimate estimate;
  attempt([&] { capture = read_capture(options.capture, true); });
  if (!options.portrait.empty()) attempt([&] { estimate.portrait = read_portrait(options.portrait); });
  DisparityMaps maps = read_maps(options.maps, problems);
  estimate.disparity_dp_px = std::move(maps.disparity_dp_px);
  estimate.confidence = std::move(maps.confidence);
  estimate.sigma_dp_px = std::move(maps.sigma_dp_px);
  if (!problems.empty()) throw InputError(fmt::format("{}", fmt::join(problems, "; ")));
  const evaluation::Score score = evaluation::score_estimate(capture, options.capture, estimate);
  print(options, score, json_text(score));
}

void run(const ScoreOptions& options) {
  const bool files = options.maps.any() || !options.portrait.empty();
  if (files == !options.result.empty()) {
    throw InputError("score: give a result folder, or files by --disparity, --confidence, --sigma, --portrait");
  }
  files ? score_files(options) : score_result_folder(options);
}

}  // namespace

void add_score(CLI::App& program) {
  auto options = std::make_shared<ScoreOptions>();
  CLI::App* command =
      program.add_subcommand("score", "Compare a portrait result, or files of any program, with a capture's truth");
  command->add_option("capture", options->capture, "Capture folder, with truth")->required()->type_name("CAPTURE_DIR");
  command->add_option("result", options->result, "Result folder; score.json is written into it")
      ->type_name("RESULT_DIR");
  add_map_options(*command, options->maps, "of the sensor's size or the views'");
  command
      ->add_option("--portrait", options->portrait,
                   "A portrait of the sensor's size: EXR of linear RGB, 1 where the capture clips, or the same "
                   "sRGB-encoded as PNG, TIFF or JPEG")
      ->type_name("FILE");
  command->add_flag("--json", options->json, "Print JSON instead of a table");
  add_threads_option(*command);
  command->footer(
      "Example:\n  dualpixel score out/capture out/dp\n"
      "  dualpixel score out/capture --disparity d.npy --sigma s.npy --portrait p.png");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
