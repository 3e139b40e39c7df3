#include "evaluation/methods/disparity_method.h"

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <utility>

#include "capture/error.h"
#include "capture/image/image_io.h"
#include "capture/image/map_file.h"
#include "capture/image/npy.h"
#include "capture/names.h"
#include "evaluation/methods/child_process.h"
#include "pipeline/disparity/tile_disparity.h"

namespace dualpixel::evaluation {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

double own_cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// All {placeholders} replaced by quoted paths in `folder`.
std::string filled_in(std::string command, const std::string& folder) {
  constexpr std::pair<const char*, const char*> kFiles[] = {
      {"{left}", "left.png"}, {"{right}", "right.png"}, {"{left.npy}", "left.npy"},    {"{right.npy}", "right.npy"},
      {"{out}", "out"},       {"{sigma}", "sigma"},     {"{confidence}", "confidence"}};
  for (const auto& [placeholder, file] : kFiles) {
    const std::string path = shell_quoted(folder + "/" + file);
    for (std::size_t at = 0; (at = command.find(placeholder, at)) != std::string::npos; at += path.size()) {
      command.replace(at, std::string(placeholder).size(), path);
    }
  }
  return command;
}

void write_view(const Image& view, float white, const std::string& path) {
  ImageU16 png(view.width, view.height);
  std::transform(view.data.begin(), view.data.end(), png.data.begin(), [&](float signal) {
    return static_cast<std::uint16_t>(std::lround(65535 * std::clamp(signal / white, 0.0f, 1.0f)));
  });
  write_png16(path + ".png", png);
  Image scaled = view;
  for (float& value : scaled.data) value /= white;
  write_npy(path + ".npy", scaled);
}

/// `name` as it was given, or with the ending that what wrote it added or asked for.
Image read_output(const DisparityMethod& method, const std::string& name, const char* channel, const Image& view) {
  constexpr const char* kEndings[] = {"", ".npy", ".pfm", ".exr"};
  const auto* const ending = std::find_if(std::begin(kEndings), std::end(kEndings),
                                          [&](const char* each) { return std::filesystem::exists(name + each); });
  if (ending == std::end(kEndings)) return {};
  const std::string path = name + *ending;
  Image map;
  try {
    map = read_map(path, channel);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: its {}: {}", printable(method.name), channel, error.what()));
  }
  if (map.same_size(view)) return map;
  throw InputError(fmt::format("{}: its {}: {} x {} pixels; the views have {} x {}", printable(method.name), channel,
                               map.width, map.height, view.width, view.height));
}

MethodRun run_program(const DisparityMethod& method, const std::string& command, const Image& left, const Image& right,
                      float white) {
  const ScratchFolder folder;
  write_view(left, white, folder.path() + "/left");
  write_view(right, white, folder.path() + "/right");
  MethodRun run;
  const Clock::time_point start = Clock::now();
  const Ended ended = run_shell(filled_in(command, folder.path()));
  run.wall_s = seconds_since(start);
  run.cpu_s = ended.cpu_s;
  if (ended.peak_rss_mb > 0) run.peak_rss_mb = ended.peak_rss_mb;
  const int status = ended.status;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw InputError(fmt::format("{}: its command ended with {} {}", printable(method.name),
                                 WIFEXITED(status) ? "status" : "signal",
                                 WIFEXITED(status) ? WEXITSTATUS(status) : WTERMSIG(status)));
  }
  run.found.disparity_dp_px = read_output(method, folder.path() + "/out", "disparity_dp_px", left);
  run.found.confidence = read_output(method, folder.path() + "/confidence", "confidence", left);
  run.found.sigma_dp_px = read_output(method, folder.path() + "/sigma", "sigma_dp_px", left);
  if (run.found.disparity_dp_px.empty()) throw InputError(printable(method.name) + ": its command wrote no {out}");
  return run;
}

/// Of "GROUP.OPTION=VALUE,...".
pipeline::MatcherOptions options_of(const pipeline::Matcher& matcher, const std::string& assignments) {
  pipeline::MatcherOptions options;
  for (std::size_t at = 0, end = 0; end != std::string::npos; at = end + 1) {
    end = assignments.find(',', at);
    const std::string assignment = assignments.substr(at, end - at);
    if (assignment.empty()) throw InputError("an option is missing after ':' or ','");
    set_field(pipeline::fields(options), assignment);
    pipeline::require_read_by(&matcher, assignment.substr(0, assignment.find('=')));
  }
  check(options);
  return options;
}

/// "MATCHER" or "MATCHER:GROUP.OPTION=VALUE,...".
DisparityMethod matcher_with_options(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) return method_of(pipeline::matcher_named(text));
  try {
    const pipeline::Matcher& matcher = pipeline::matcher_named(text.substr(0, colon));
    DisparityMethod method = method_of(matcher, options_of(matcher, text.substr(colon + 1)));
    method.name = text;
    return method;
  } catch (const InputError& error) {
    throw InputError(fmt::format("--method {}: {}", printable(text), error.what()));
  }
}

}  // namespace

DisparityMethod method_of(const pipeline::Matcher& matcher, const pipeline::MatcherOptions& options) {
  return {std::string(matcher.name),
          [&matcher, options](const Image& left, const Image& right, const pipeline::ViewSensor& sensor) {
            const Clock::time_point start = Clock::now();
            const double cpu_before = own_cpu_seconds();
            MethodRun run;
            run.found = pipeline::upsample_tiles(matcher.match(left, right, sensor, options), left.width, left.height);
            run.wall_s = seconds_since(start);
            run.cpu_s = own_cpu_seconds() - cpu_before;
            return run;
          }};
}

bool names_matcher(const std::string& text) {
  if (text.find('{') != std::string::npos) return false;  // a command's placeholders
  const std::size_t equals = text.find('=');
  return equals == std::string::npos || text.find(':') < equals;
}

DisparityMethod method_named(const std::string& text) {
  if (names_matcher(text)) return matcher_with_options(text);
  const std::size_t equals = text.find('=');
  DisparityMethod method{text.substr(0, equals), {}};
  const std::string command = text.substr(equals + 1);
  const auto names = [&](const char* placeholder) { return command.find(placeholder) != std::string::npos; };
  const bool views = (names("{left}") || names("{left.npy}")) && (names("{right}") || names("{right.npy}"));
  if (method.name.empty() || !views || !names("{out}")) {
    throw InputError(
        fmt::format("--method {}: must be NAME=COMMAND, with {{left}} or {{left.npy}}, {{right}} or {{right.npy}}, "
                    "and {{out}} (or {{out}}.npy) in the command, or be a matcher, with or without options",
                    printable(text)));
  }
  if (find_named(pipeline::matchers(), method.name)) {
    throw InputError(fmt::format("--method {}: is the name of a matcher: choose another", printable(method.name)));
  }
  method.run = [name = method, command](const Image& left, const Image& right, const pipeline::ViewSensor& sensor) {
    return run_program(name, command, left, right, sensor.white);
  };
  return method;
}

std::vector<DisparityMethod> methods_named(const std::vector<std::string>& texts,
                                           std::vector<DisparityMethod> methods) {
  for (const std::string& text : texts) {
    DisparityMethod method = method_named(text);
    const auto has_its_name = [&](const DisparityMethod& other) { return other.name == method.name; };
    if (std::any_of(methods.begin(), methods.end(), has_its_name)) {
      throw InputError("--method " + printable(text) + ": is there already");
    }
    methods.push_back(std::move(method));
  }
  return methods;
}

}  // namespace dualpixel::evaluation
