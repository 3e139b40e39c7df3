#include "evaluation/chart/cycles_stage.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/json_fields.h"
#include "evaluation/methods/child_process.h"

namespace dualpixel::evaluation {

bool can_measure_cycles() {
  return std::filesystem::exists(kCyclesScript) && run_shell("command -v blender >/dev/null").status == 0;
}

ChartPart measure_cycles(const ChartInput& input) {
  constexpr int kWidth = 96;  // photosites
  if (input.program.empty() || !can_measure_cycles()) return {};
  const std::string out = input.scratch + "/cycles";
  const std::string command = fmt::format(
      "exec blender --background --python-exit-code 1 --python {} -- {} {} {} {} >/dev/null 2>&1", kCyclesScript,
      shell_quoted(input.program), shell_quoted(input.scenes_folder + "/portrait.json"), shell_quoted(out), kWidth);
  if (run_shell(command).status != 0) return {};
  const nlohmann::json measured = read_json_file(out + "/cycles.json");
  const nlohmann::json& mean = measured.at("mean_nits");
  ChartSection section{"Beside Cycles",
                       fmt::format("portrait.json, {} photosites wide, by Blender's Cycles and by ours: the same thin "
                                   "lens, focus and light, direct alone; all materials matte; one seed. RMS error "
                                   "against a program's own reference of 2048 samples, of its mean. The means of the "
                                   "two references differ by {:.2f} %.",
                                   kWidth, 100 * measured.at("difference_of_means").get<double>()),
                       "%",
                       "CPU s",
                       {}};
  for (const auto& [key, name] : {std::pair{"ours", "dualpixel"}, std::pair{"cycles", "Cycles"}}) {
    for (const nlohmann::json& row : measured.at(key)) {
      const double error = row.at("rmse_nits").get<double>() / mean.at(key).get<double>();
      section.points.push_back({fmt::format("{}, {} samples", name, row.at("samples").get<int>()),
                                {100 * error},
                                {row.at("cpu_s").get<double>()}});
    }
  }
  section.default_reason = "none: it is a comparison.";
  return {{section}};
}

}  // namespace dualpixel::evaluation
