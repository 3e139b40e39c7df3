#include "evaluation/chart/cycles_stage.h"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "evaluation/methods/child_process.h"

namespace dualpixel::evaluation {
namespace {

constexpr int kWidth = 96;  // photosites

ChartSection cycles_section(const nlohmann::json& measured) {
  const nlohmann::json& mean = measured.at("mean_nits");
  ChartSection section{
      "Beside Cycles",
      fmt::format(
          "portrait.json, {} photosites wide, by Blender's Cycles and by ours: the same thin lens, focus and "
          "light, direct alone; all materials matte. RMS error, of the mean: the standard deviation between "
          "pictures of {} seeds and, in quadrature, what points of light leave wrong in ours. Time is CPU time "
          "minus that of a render with one sample; ours includes making the points. The two programs' pictures, "
          "ours without points, differ by {:.2f} % on average, and by {:.1f} % in a pixel (RMS, their noise taken "
          "off).",
          kWidth, measured.at("seeds").get<int>(), 100 * measured.at("difference_of_means").get<double>(),
          100 * measured.at("rms_difference").get<double>()),
      "%",
      "CPU s",
      {}};
  for (const auto& [key, name] : {std::pair{"ours", "dualpixel"}, std::pair{"cycles", "Cycles"}}) {
    const double percent = 100 / mean.at(key).get<double>();
    for (const nlohmann::json& row : measured.at(key)) {
      section.points.push_back(
          {fmt::format("{}, {} samples", name, row.at("samples").get<int>()),
           {percent * row.at("rmse_nits").get<double>(), percent * row.at("rmse_standard_error").get<double>()},
           {row.at("cpu_s").get<double>(), row.at("cpu_s_standard_error").get<double>()}});
    }
  }
  section.default_reason = "none: it is a comparison.";
  return section;
}

std::string last_line(const std::string& path) {
  std::ifstream file(path);
  std::string last;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

}  // namespace

bool has_blender() { return run_shell("command -v blender >/dev/null").status == 0; }

ChartPart measure_cycles(const ChartInput& input) {
  if (input.cycles_script.empty()) return {.left_out = {"Cycles: with --cycles tools/compare_cycles.py it is here."}};
  const std::string out = input.scratch + "/cycles";
  const std::string command =
      fmt::format("exec blender --background --factory-startup --python-exit-code 1 --python {} -- {} {} {} {}",
                  shell_quoted(input.cycles_script), shell_quoted(input.program),
                  shell_quoted(input.scenes_folder + "/portrait.json"), shell_quoted(out), kWidth);
  const std::string log = out + ".log";
  if (run_shell(command + " >" + shell_quoted(log) + " 2>&1").status != 0) {
    return {.left_out = {"Cycles: Blender ended with an error: " + last_line(log)}};
  }
  try {
    return {{cycles_section(read_json_file(out + "/cycles.json"))}};
  } catch (const std::exception&) {  // of what the script wrote
    return {.left_out = {"Cycles: the script has not written what is expected of it."}};
  }
}

}  // namespace dualpixel::evaluation
