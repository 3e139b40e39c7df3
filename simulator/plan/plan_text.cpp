#include "simulator/plan/plan_text.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "simulator/lens/aberrated/aberrated_json.h"

namespace dualpixel::simulator {
namespace {

std::string bounces_name(int bounces) { return fmt::format("{} bounce{}", bounces, bounces == 1 ? "" : "s"); }
std::string light_name(double spacing_px) {
  return spacing_px > 0 ? fmt::format("points every {} px", spacing_px) : "light sampled";
}
std::string lost(int windows) { return windows > 0 ? fmt::format("; {} windows cannot be matched", windows) : ""; }
std::string samples_name(int samples) { return fmt::format("{} sample{}", samples, samples == 1 ? "" : "s"); }

std::string differences_text(const Plan& plan) {
  std::string text = fmt::format("\n{:<18}{:>14}{:>16}{:>12}{:>12}{:>18}\n", "beside disparity", "picture, px",
                                 "red - blue, px", "blur, px", "light, %", "left's share, %");
  for (std::size_t l = 0; l + 1 < plan.lenses.size(); ++l) {
    const LensDifferences& d = plan.lenses[l].differences;
    const auto cell = [](double value, int decimals) {
      return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : std::string("–");
    };
    text += fmt::format("{:<18}{:>14}{:>16}{:>12}{:>12}{:>18}\n", plan.lenses[l].candidate.name,
                        cell(d.picture_shift_px, 2), cell(d.color_shift_px, 3), cell(d.blur_px, 3),
                        cell(100 * d.light, 2), cell(100 * d.left_share, 2));
  }
  return text;
}

}  // namespace

nlohmann::ordered_json plan_json(const Plan& plan, bool with_times) {
  using nlohmann::ordered_json;
  // each step with the others as chosen
  const auto step = [&](ordered_json row, std::size_t l, std::size_t b, std::size_t t, std::size_t s, bool chosen) {
    row["error_with_the_others_as_chosen_dp_px"] = plan.error_dp_px(l, b, t, s);
    if (with_times) row["picture_s"] = plan.picture_s(l, b, t, s);
    row["chosen"] = chosen;
    return row;
  };
  ordered_json lenses = ordered_json::array(), bounces = lenses, lights = lenses, samples = lenses;
  for (std::size_t l = 0; l < plan.lenses.size(); ++l) {
    const LensStep& r = plan.lenses[l];
    lenses.push_back(step({{"model", r.candidate.name},
                           {"error_dp_px", r.error_dp_px},
                           {"error_95th_percentile_dp_px", r.error_95_dp_px},
                           {"picture_shift_px", r.differences.picture_shift_px},
                           {"color_shift_px", r.differences.color_shift_px},
                           {"blur_difference_px", r.differences.blur_px},
                           {"light_difference", r.differences.light},
                           {"left_share_difference", r.differences.left_share}},
                          l, plan.bounce, plan.light, plan.sample, l == plan.lens));
  }
  for (std::size_t b = 0; b < plan.bounces.size(); ++b) {
    const BounceStep& r = plan.bounces[b];
    bounces.push_back(
        step({{"max_bounces", r.bounces}, {"error_dp_px", r.error_dp_px}, {"lost_windows", r.lost_windows}}, plan.lens,
             b, plan.light, plan.sample, b == plan.bounce));
  }
  for (std::size_t t = 0; t < plan.lights.size(); ++t) {
    const LightStep& r = plan.lights[t];
    lights.push_back(
        step({{"light_spacing_px", r.spacing_px}, {"error_dp_px", r.error_dp_px}, {"lost_windows", r.lost_windows}},
             plan.lens, plan.bounce, t, plan.sample, t == plan.light));
  }
  for (std::size_t s = 0; s < plan.samples.size(); ++s) {
    const SampleStep& r = plan.samples[s];
    samples.push_back(step({{"samples_per_pixel", r.samples}, {"error_dp_px", r.error_dp_px}}, plan.lens, plan.bounce,
                           plan.light, s, s == plan.sample));
  }
  ordered_json chosen = {{"lens_model", plan.lenses[plan.lens].candidate.name},
                         {"max_bounces", plan.bounces[plan.bounce].bounces},
                         {"light_spacing_px", plan.lights[plan.light].spacing_px},
                         {"samples_per_pixel", plan.samples[plan.sample].samples},
                         {"error_dp_px", plan.error_dp_px()}};
  const Lens& lens = plan.lenses[plan.lens].candidate.lens;
  if (std::holds_alternative<Aberrations>(lens.model)) chosen["lens"] = aberrated_lens_json(lens);
  return {{"tolerance_dp_px", plan.tolerance_dp_px},
          {"tolerance_met", plan.met},
          {"seed", plan.seed},
          {"windows", plan.windows},
          {"windows_textured", plan.windows_textured},
          {"bounces_and_samples_measured", plan.measured},
          {"chosen", chosen},
          {"lens_models", lenses},
          {"bounces", bounces},
          {"light", lights},
          {"samples", samples}};
}

std::string plan_text(const Plan& plan) {
  std::string text;
  const auto heading = [&](const char* name) {
    text += fmt::format("{}{:<18}{:>14}{:>14}{:>14}{:>12}\n", text.empty() ? "" : "\n", name, "error, DP px",
                        "in all, DP px", "picture, s", "saves, s");
  };
  const double chosen_s = plan.picture_s(plan.lens, plan.bounce, plan.light, plan.sample);
  const auto row = [&](const std::string& name, double error, std::size_t l, std::size_t b, std::size_t t,
                       std::size_t s, bool chosen, const std::string& note) {
    const double all = plan.error_dp_px(l, b, t, s);
    const double time_s = plan.picture_s(l, b, t, s);
    const char* verdict = chosen ? "chosen" : all > plan.tolerance_dp_px ? "over the tolerance" : "more work";
    text += fmt::format("{:<18}{:>14.4f}{:>14.4f}{:>14.2f}{:>12.2f}  {}{}\n", name, error, all, time_s,
                        chosen_s - time_s, verdict, note);
  };
  heading("lens model");
  for (std::size_t l = 0; l < plan.lenses.size(); ++l) {
    const LensStep& r = plan.lenses[l];
    row(r.candidate.name, r.error_dp_px, l, plan.bounce, plan.light, plan.sample, l == plan.lens,
        fmt::format("; 95 % within {:.4f}", r.error_95_dp_px));
  }
  if (plan.lenses.size() > 1) text += differences_text(plan);
  heading("bounces");
  for (std::size_t b = 0; b < plan.bounces.size(); ++b) {
    const BounceStep& r = plan.bounces[b];
    row(bounces_name(r.bounces), r.error_dp_px, plan.lens, b, plan.light, plan.sample, b == plan.bounce,
        lost(r.lost_windows));
  }
  heading("light");
  for (std::size_t t = 0; t < plan.lights.size(); ++t) {
    const LightStep& r = plan.lights[t];
    row(light_name(r.spacing_px), r.error_dp_px, plan.lens, plan.bounce, t, plan.sample, t == plan.light,
        lost(r.lost_windows));
  }
  heading("samples");
  for (std::size_t s = 0; s < plan.samples.size(); ++s) {
    const SampleStep& r = plan.samples[s];
    row(samples_name(r.samples), r.error_dp_px, plan.lens, plan.bounce, plan.light, s, s == plan.sample, "");
  }
  text +=
      "\nEach row with the others as chosen. Lens models: disparity traced at 432 field points, at the depth that "
      "the scene has there; beside it what else they change, RMS over those of the points where it can be told "
      "(colors: where "
      "the pupil is nearly whole), which does not count.\n";
  text += plan.measured
              ? fmt::format(
                    "Bounces, light and samples: pilot renders, as a matcher sees them in the {} of {} windows whose "
                    "texture stands out of the sensor's noise.\n",
                    plan.windows_textured, plan.windows)
              : fmt::format(
                    "Bounces, light and samples were not measured and are the scene file's: just {} of {} windows have "
                    "texture that stands out of the sensor's noise.\n",
                    plan.windows_textured, plan.windows);
  const auto chosen = fmt::format(
      "{}, {}, {}, {}", plan.lenses[plan.lens].candidate.name, bounces_name(plan.bounces[plan.bounce].bounces),
      light_name(plan.lights[plan.light].spacing_px), samples_name(plan.samples[plan.sample].samples));
  const double error = plan.error_dp_px();
  text += plan.met ? fmt::format("Enough for {} DP px: {}: error {:.4f} DP px, {:.1f} s for the two views.\n",
                                 plan.tolerance_dp_px, chosen, error, chosen_s)
                   : fmt::format(
                         "Nothing reaches {} DP px; the cheapest within a tenth of the least error is {}: {:.4f} DP "
                         "px, {:.1f} s.\n",
                         plan.tolerance_dp_px, chosen, error, chosen_s);
  return text;
}

}  // namespace dualpixel::simulator
