#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/files.h"
#include "capture/folder/capture_json.h"
#include "evaluation/report/page.h"
#include "evaluation/report/report_sections.h"
#include "pipeline/portrait/photograph.h"
#include "pipeline/portrait/plain_pair.h"
#include "pipeline/portrait/result_io.h"
#include "pipeline/portrait/zoom.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct ReportOptions {
  std::vector<std::string> results;
  std::string output;
  std::string capture;
};

/// What a result was made from: a capture's folder, a plain pair, or a photograph; and of which part of it.
struct Source {
  std::string name;  ///< a path
  std::optional<pipeline::PlainPair> pair;
  bool photograph = false;
  std::optional<pipeline::Window> window;

  bool folder() const { return !pair && !photograph; }
};

/// The text of a field of the result's provenance, if it is one.
std::optional<std::string> provenance_text(const pipeline::StoredResult& stored, const char* field) {
  const auto found = stored.json["provenance"].find(field);
  if (found == stored.json["provenance"].end() || !found->is_string()) return {};
  return found->get<std::string>();
}

void require_own_picture(const pipeline::StoredResult& stored, const std::string& path, const char* hash,
                         const std::string& result_path) {
  if (const auto was = provenance_text(stored, hash); !was || *was == file_hash(path)) return;
  throw InputError(printable(path) + ": was changed since " + printable(result_path) +
                   " was made of it; run the portrait again");
}

/// What the result says that it was made from, or `capture` where one is given.
Source whole_source_of(const pipeline::StoredResult& stored, const std::string& capture,
                       const std::string& result_path) {
  if (!capture.empty()) return {capture, {}};
  const auto refuse = [&](const std::string& what) {
    throw InputError(printable(result_path) + "/result.json: /provenance/" + what);
  };
  if (auto path = provenance_text(stored, "capture")) {
    if (!std::filesystem::exists(*path)) refuse("capture: " + printable(*path) + ": no such folder; give --capture");
    return {*path, {}};
  }
  if (auto path = provenance_text(stored, "picture")) {
    if (!std::filesystem::exists(*path)) refuse("picture: " + printable(*path) + ": no such file");
    require_own_picture(stored, *path, "picture_hash", result_path);
    return {*path, {}, true};
  }
  const auto left = provenance_text(stored, "left"), right = provenance_text(stored, "right");
  if (!left || !right) {
    refuse("capture: does not name the capture, nor /provenance/left and right a plain pair; give --capture");
  }
  for (const std::string& view : {*left, *right}) {
    if (!std::filesystem::exists(view)) refuse("left, right: " + printable(view) + ": no such file");
  }
  require_own_picture(stored, *left, "left_hash", result_path);
  require_own_picture(stored, *right, "right_hash", result_path);
  pipeline::PlainPair pair{*left, *right, provenance_text(stored, "metadata").value_or(""),
                           provenance_text(stored, "split") == "vertical"};
  return {*left + " + " + std::filesystem::path(*right).filename().string(), pair};
}

Source source_of(const pipeline::StoredResult& stored, const std::string& capture, const std::string& result_path) {
  Source source = whole_source_of(stored, capture, result_path);
  source.window = pipeline::window_of(stored, result_path);
  return source;
}

Capture read_whole(const Source& source) {
  if (source.photograph) return pipeline::read_photograph(source.name).capture;
  if (source.folder()) return read_capture(source.name, true);
  return pipeline::upright(pipeline::read_plain_pair(*source.pair), source.pair->vertical_split);
}

Capture read_source(const Source& source, const std::string& result_path) {
  Capture capture = read_whole(source);
  return source.window ? pipeline::zoomed(capture, *source.window, result_path) : capture;
}

void run(const ReportOptions& options) {
  evaluation::require_page_path(options.output);
  const std::string page_folder = std::filesystem::absolute(options.output).parent_path().string();
  std::vector<evaluation::CaptureSection> sections;
  std::string latest;
  Capture capture;
  for (const std::string& path : options.results) {
    const pipeline::StoredResult stored = pipeline::read_result(path);
    const Source source = source_of(stored, options.capture, path);
    if (source.folder()) pipeline::require_own_capture(stored, source.name, path);
    const std::string shown = source.name + (source.window ? " (zoomed)" : "");
    if (sections.empty() || latest != shown) {
      capture = read_source(source, path);
      sections.push_back(evaluation::make_capture_section(capture, source.name, page_folder));
      latest = shown;
    }
    if (stored.result.input.width != capture.camera.width_px ||
        stored.result.input.height != capture.camera.height_px) {
      throw InputError(fmt::format("{}: {} x {} pixels; the capture {} has {} x {}", printable(path),
                                   stored.result.input.width, stored.result.input.height, printable(source.name),
                                   capture.camera.width_px, capture.camera.height_px));
    }
    evaluation::add_result(sections.back(), capture, source.name, stored, path, page_folder);
  }
  evaluation::write_page(options.output, evaluation::report_page(sections));
}

}  // namespace

void add_report(CLI::App& program) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* command = program.add_subcommand("report", "Write one HTML page about portrait results");
  command->add_option("results", options->results, "Result folders")->required()->type_name("RESULT_DIR");
  command->add_option("-o,--output", options->output, "Page to write")->required()->type_name("REPORT.html");
  command->add_option("--capture", options->capture, "Capture folder; by default what each result was made from")
      ->type_name("CAPTURE_DIR");
  add_threads_option(*command);
  command->footer("Example:\n  dualpixel report out/dp out/dp+seg -o out/report.html");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
