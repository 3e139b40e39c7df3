#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/files.h"
#include "evaluation/metrics/scoring.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct ScoreOptions {
  std::string capture;
  std::string result;
  bool json = false;
};

/// A score against noisy truth is lower than the picture deserves.
void warn_of_truth_noise(const std::string& capture, const evaluation::Score& score) {
  if (score.truth_noise_db.value_or(0) <= evaluation::kMostTruthNoiseDb) return;
  std::cerr << fmt::format(
      "{}: rendering noise of the true photograph takes {:.2f} dB off the linear PSNR, more than {}: simulate with "
      "more samples, or with --noise-fraction 0.25\n",
      printable(capture), *score.truth_noise_db, evaluation::kMostTruthNoiseDb);
}

void run(const ScoreOptions& options) {
  if (std::filesystem::exists(options.result + "/capture.json") &&
      std::filesystem::exists(options.capture + "/result.json")) {
    throw InputError(fmt::format("{}: is a capture, and {} a result: give the capture first", printable(options.result),
                                 printable(options.capture)));
  }
  const pipeline::StoredResult stored = pipeline::read_result(options.result);
  const Capture capture = read_capture(options.capture, true);
  pipeline::require_own_capture(stored, options.capture, options.result);
  const evaluation::Score score = evaluation::score_result(capture, options.capture, stored, options.result);
  const std::string json =
      evaluation::to_json(score).dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  replace_file(options.result + "/score.json", json);
  warn_of_truth_noise(options.capture, score);
  std::cout << (options.json ? json : evaluation::to_text(score));
}

}  // namespace

void add_score(CLI::App& program) {
  auto options = std::make_shared<ScoreOptions>();
  CLI::App* command = program.add_subcommand("score", "Compare a portrait result with its capture's truth");
  command->add_option("capture", options->capture, "Capture folder, with truth")->required()->type_name("CAPTURE_DIR");
  command->add_option("result", options->result, "Result folder; score.json is written into it")
      ->required()
      ->type_name("RESULT_DIR");
  command->add_flag("--json", options->json, "Print JSON instead of a table");
  add_threads_option(*command);
  command->footer("Example:\n  dualpixel score out/capture out/dp");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
