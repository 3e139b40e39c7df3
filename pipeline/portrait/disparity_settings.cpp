#include "pipeline/portrait/disparity_settings.h"

#include <fmt/format.h>

#include <cmath>

#include "capture/error.h"
#include "pipeline/disparity/match_pixels.h"

namespace dualpixel::pipeline {

std::span<const DisparitySetting> disparity_settings() {
  static const std::vector<DisparitySetting> settings = {
      {"paper, 1/16",
       0,
       24,
       23,
       1.7,
       "paper",
       {"smooth.divisor=16", "smooth.grid.cell_px=4", "smooth.grid.cell_luma=4", "smooth.solver.lambda=32",
        "smooth.solver.iterations=10"}},
      {"likelihood, 1/32",
       0,
       81,
       21,
       0.75,
       "likelihood",
       {"smooth.divisor=32", "smooth.grid.cell_px=4", "smooth.grid.cell_luma=4", "smooth.solver.lambda=32"}},
      {"split, 1/16",
       7,
       84,
       23,
       0.25,
       "split",
       {"smooth.divisor=16", "smooth.grid.cell_px=4", "smooth.solver.robust_rounds=1"}},
      {"split, 1/4", 7, 84, 54, 0.245, "split", {}},
  };
  return settings;
}

Megapixels megapixels_of(const Capture& capture) {
  const Camera& camera = capture.camera;
  const double view = 1e-6 * camera.dp_width() * camera.dp_height();
  return {1e-6 * camera.width_px * camera.height_px, is_dense_mosaic(capture) ? view / 4 : view};
}

double cpu_ms(const DisparitySetting& setting, const Megapixels& size) {
  return setting.fixed_ms + setting.matching_ms * size.view + setting.smoothing_ms * size.picture;
}

const DisparitySetting& best_setting(double most_cpu_ms, const Megapixels& size) {
  const std::span<const DisparitySetting> all = disparity_settings();
  const DisparitySetting* best = nullptr;
  for (const DisparitySetting& setting : all) {
    if (cpu_ms(setting, size) <= most_cpu_ms) best = &setting;
  }
  if (best) return *best;
  const double least = std::ceil(10 * cpu_ms(all.front(), size)) / 10;
  throw InputError(fmt::format("--auto {:g}: must be at least {:.1f}, ms of the fastest setting for {:.3g} megapixels",
                               most_cpu_ms, least, size.picture));
}

const DisparitySetting& fastest_setting(double error_dp_px) {
  for (const DisparitySetting& setting : disparity_settings()) {
    if (setting.error_dp_px <= error_dp_px) return setting;
  }
  throw InputError(fmt::format("--auto-error {:g}: must be at least {:g}, DP px of the most accurate setting on offer",
                               error_dp_px, disparity_settings().back().error_dp_px));
}

PortraitOptions with_setting(PortraitOptions options, const DisparitySetting& setting) {
  options.matcher = setting.matcher;
  options.smooth = default_options(setting.matcher).smooth;
  for (const std::string_view assignment : setting.assignments) set_field(fields(options), std::string(assignment));
  return options;
}

void require_not_chosen(std::string_view assignment) {
  if (!assignment.starts_with("smooth.")) return;
  throw InputError(
      fmt::format("{}: smoothing is chosen by --auto and --auto-error; leave one of them out", assignment));
}

std::string command_line(const DisparitySetting& setting) {
  std::string line = fmt::format("--matcher {}", setting.matcher);
  for (const std::string_view assignment : setting.assignments) line += fmt::format(" --set {}", assignment);
  return line;
}

}  // namespace dualpixel::pipeline
