#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/files.h"
#include "capture/folder/capture_json.h"
#include "evaluation/report/report_sections.h"
#include "pipeline/portrait/result_io.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct ReportOptions {
  std::vector<std::string> results;
  std::string output;
  std::string capture;
};

/// The capture that a result says it was made from.
std::string capture_of(const pipeline::StoredResult& stored, const std::string& result_path) {
  const auto named = stored.json["provenance"].find("capture");
  if (named == stored.json["provenance"].end() || !named->is_string()) {
    throw InputError(printable(result_path) +
                     "/result.json: /provenance/capture: does not name the capture (a plain pair has none); give "
                     "--capture where there is one of the same picture");
  }
  std::string path = named->get<std::string>();
  if (!std::filesystem::exists(path)) {
    throw InputError(fmt::format("{}/result.json: /provenance/capture: {}: no such folder; give --capture",
                                 printable(result_path), printable(path)));
  }
  return path;
}

void run(const ReportOptions& options) {
  std::vector<evaluation::CaptureSection> sections;
  Capture capture;
  for (const std::string& path : options.results) {
    const pipeline::StoredResult stored = pipeline::read_result(path);
    const std::string capture_path = options.capture.empty() ? capture_of(stored, path) : options.capture;
    pipeline::require_own_capture(stored, capture_path, path);
    if (sections.empty() || sections.back().name != capture_path) {
      capture = read_capture(capture_path, true);
      sections.push_back(evaluation::make_capture_section(capture, capture_path));
    }
    if (stored.result.input.width != capture.camera.width_px ||
        stored.result.input.height != capture.camera.height_px) {
      throw InputError(fmt::format("{}: {} x {} pixels; the capture {} has {} x {}", printable(path),
                                   stored.result.input.width, stored.result.input.height, printable(capture_path),
                                   capture.camera.width_px, capture.camera.height_px));
    }
    sections.back().results.push_back(evaluation::make_result_section(capture, capture_path, stored, path));
  }
  replace_file(options.output, evaluation::report_page(sections));
}

}  // namespace

void add_report(CLI::App& program) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* command = program.add_subcommand("report", "Write one HTML page about portrait results");
  command->add_option("results", options->results, "Result folders")->required()->type_name("RESULT_DIR");
  command->add_option("-o,--output", options->output, "Page to write")->required()->type_name("REPORT.html");
  command->add_option("--capture", options->capture, "Capture folder; by default the one that each result names")
      ->type_name("CAPTURE_DIR");
  add_threads_option(*command);
  command->footer("Example:\n  dualpixel report out/dp out/dp+seg -o out/report.html");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
