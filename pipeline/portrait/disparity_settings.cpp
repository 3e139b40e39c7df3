#include "pipeline/portrait/disparity_settings.h"

#include <fmt/format.h>

#include <algorithm>

#include "capture/error.h"
#include "pipeline/disparity/matchers.h"

namespace dualpixel::pipeline {

std::span<const DisparitySetting> disparity_settings() {
  static const std::vector<DisparitySetting> settings = {
      {"paper, 1/16",
       24,
       1.68,
       "paper",
       {"smooth.divisor=16", "smooth.grid.cell_px=4", "smooth.grid.cell_luma=4", "smooth.solver.lambda=32",
        "smooth.solver.iterations=10"}},
      {"likelihood, 1/32",
       30,
       0.57,
       "likelihood",
       {"smooth.divisor=32", "smooth.grid.cell_px=4", "smooth.grid.cell_luma=4", "smooth.solver.lambda=32"}},
      {"split, 1/16",
       34,
       0.225,
       "split",
       {"smooth.divisor=16", "smooth.grid.cell_px=4", "smooth.solver.robust_rounds=1"}},
      {"split, 1/8", 41, 0.22, "split", {"smooth.divisor=8"}},
  };
  return settings;
}

const DisparitySetting& best_setting(double cpu_ms, double megapixels) {
  const std::span<const DisparitySetting> all = disparity_settings();
  const auto takes = [&](const DisparitySetting& setting) { return setting.cpu_ms_per_megapixel * megapixels; };
  const DisparitySetting* best = nullptr;
  for (const DisparitySetting& setting : all) {
    if (takes(setting) <= cpu_ms) best = &setting;
  }
  if (best) return *best;
  throw InputError(fmt::format("--auto {:g}: the fastest setting takes {:.3g} ms for {:.3g} megapixels; allow that",
                               cpu_ms, takes(all.front()), megapixels));
}

const DisparitySetting& fastest_setting(double error_dp_px) {
  for (const DisparitySetting& setting : disparity_settings()) {
    if (setting.error_dp_px <= error_dp_px) return setting;
  }
  throw InputError(fmt::format("--auto-error {:g}: the least error of any setting is {:g} DP px; allow that",
                               error_dp_px, disparity_settings().back().error_dp_px));
}

PortraitOptions with_setting(PortraitOptions options, const DisparitySetting& setting) {
  PortraitOptions chosen = default_options(setting.matcher);
  for (const std::string_view assignment : setting.assignments) set_field(fields(chosen), std::string(assignment));
  options.matcher = chosen.matcher;
  options.matching = chosen.matching;
  options.tile_upsample = chosen.tile_upsample;
  options.smooth = chosen.smooth;
  return options;
}

void require_not_chosen(std::string_view field) {
  PortraitOptions options;
  OptionFields chosen = fields(options.matching);
  for (const OptionFields& group :
       {grouped("tile_upsample", fields(options.tile_upsample)), grouped("smooth", fields(options.smooth))}) {
    chosen.insert(chosen.end(), group.begin(), group.end());
  }
  if (std::ranges::any_of(chosen, [&](const OptionField& each) { return each.name == field; })) {
    throw InputError(fmt::format("--set {}: is chosen by --auto; leave one of them out", field));
  }
}

std::string command_line(const DisparitySetting& setting) {
  std::string line = fmt::format("--matcher {}", setting.matcher);
  for (const std::string_view assignment : setting.assignments) line += fmt::format(" --set {}", assignment);
  return line;
}

}  // namespace dualpixel::pipeline
