#include "evaluation/chart/bf16_masks.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/image/image_io.h"
#include "capture/json_fields.h"
#include "evaluation/methods/child_process.h"

namespace dualpixel::evaluation {
namespace {

namespace fs = std::filesystem;

constexpr int kBf16Runs = 3;  // of which the fastest counts, as in f32

std::string pictures_folder(const ChartInput& input) { return input.scratch + "/pictures"; }
std::string masks_folder(const ChartInput& input) { return input.scratch + "/masks"; }

}  // namespace

void keep_for_bf16(const ChartInput& input, int seed, const Image& picture, const Image& true_mask) {
  fs::create_directories(pictures_folder(input));
  fs::create_directories(masks_folder(input));
  const auto file = [&](const std::string& folder, int repeat) {
    return fmt::format("{}/{:02}_{}.exr", folder, seed, repeat);
  };
  write_exr(file(pictures_folder(input), 0), {{"R", &picture, 0}, {"G", &picture, 1}, {"B", &picture, 2}}, false);
  write_exr(file(masks_folder(input), 0), {{"Y", &true_mask}}, false);
  for (int repeat = 1; repeat < kBf16Runs; ++repeat) {
    for (const std::string& folder : {pictures_folder(input), masks_folder(input)}) {
      fs::create_symlink(fs::path(file(folder, 0)).filename(), file(folder, repeat));
    }
  }
}

Bf16Masks try_bf16(const ChartInput& input, int seeds) {
  if (!__builtin_cpu_supports("avx512bw")) return {{}, "The person network in bf16: needs a processor with AVX-512."};
  const std::string out = input.scratch + "/bf16";
  const std::string command =
      fmt::format("exec {} experiment segmentation --bf16 --images {} --masks {} -o {} >/dev/null 2>&1",
                  shell_quoted(input.program), shell_quoted(pictures_folder(input)), shell_quoted(masks_folder(input)),
                  shell_quoted(out));
  if (run_shell(command).status != 0) return {{}, "The person network in bf16: its process ended with an error."};
  const nlohmann::json pictures = read_json_file(out + "/segmentation.json").at("pictures");
  std::vector<Trial> trials;
  for (int seed = 0; seed < seeds; ++seed) {
    Trial& trial = trials.emplace_back(Trial{"face found, bf16"});
    for (int repeat = 0; repeat < kBf16Runs; ++repeat) {
      const nlohmann::json& found = pictures.at(seed * kBf16Runs + repeat);
      trial.error = 100 * (1 - found.at("iou").get<double>());
      const double cpu_ms = found.at("find_cpu_ms").get<double>();
      trial.time = repeat == 0 ? cpu_ms : std::min(trial.time, cpu_ms);
    }
  }
  return {trials, ""};
}

}  // namespace dualpixel::evaluation
