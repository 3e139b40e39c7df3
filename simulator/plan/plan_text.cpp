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
std::string light_samples_name(int samples) { return fmt::format("{} of each point", samples); }
std::string lost(int windows) { return windows > 0 ? fmt::format("; {} windows cannot be matched", windows) : ""; }
std::string samples_name(int samples) { return fmt::format("{} sample{}", samples, samples == 1 ? "" : "s"); }

/// What was chosen but for one step.
PlanChoice chosen_but(const Plan& plan, std::size_t PlanChoice::*kind, std::size_t step) {
  PlanChoice choice = plan.chosen;
  choice.*kind = step;
  return choice;
}

PlanChoice but_effect(const Plan& plan, std::size_t effect, bool simulated) {
  PlanChoice choice = plan.chosen;
  choice.effects[effect] = simulated;
  return choice;
}

/// Of an effect's row: it is, or is left out.
std::string effect_name(Effect effect, bool simulated) {
  return (simulated ? "" : "no ") + std::string(name_of(kEffects, effect));
}

/// ", diffraction, motion blur": those that are simulated.
std::string effects_text(const Plan& plan) {
  std::string text;
  for (std::size_t i = 0; i < plan.effects.size(); ++i) {
    if (plan.chosen.effects[i]) text += ", " + std::string(name_of(kEffects, plan.effects[i].effect));
  }
  return text;
}

/// One sentence.
std::string conclusion(const Plan& plan) {
  const PlanChoice& best = plan.chosen;
  const double spacing_px = plan.lights[best.light].spacing_px;
  const std::string of_points =
      spacing_px > 0 ? fmt::format(" with {} samples each", plan.light_samples[best.light_samples].samples) : "";
  const std::string chosen = fmt::format(
      "{}, {}, {}{}, {}{}", plan.lenses[best.lens].candidate.name, bounces_name(plan.bounces[best.bounce].bounces),
      light_name(spacing_px), of_points, samples_name(plan.samples[best.sample].samples), effects_text(plan));
  const double error = plan.error_dp_px(best), time_s = plan.picture_s(best);
  const std::string views =
      plan.frames > 1 ? fmt::format("the two views of each of {} frames", plan.frames) : "the two views";
  if (!plan.measured) {
    return fmt::format("Not known whether {} DP px are kept: {}: the lens errs by {:.4f} DP px, {:.1f} s for {}.\n",
                       plan.tolerance_dp_px, chosen, error, time_s, views);
  }
  if (!plan.met) {
    return fmt::format(
        "Nothing reaches {} DP px; the cheapest within a tenth of the least error is {}: {:.4f} DP px, {:.1f} s for "
        "{}.\n",
        plan.tolerance_dp_px, chosen, error, time_s, views);
  }
  return fmt::format("Enough for {} DP px: {}: error {:.4f} DP px, {:.1f} s for {}.\n", plan.tolerance_dp_px, chosen,
                     error, time_s, views);
}

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
  const PlanChoice& best = plan.chosen;
  // a step with the others as chosen
  const auto step = [&](ordered_json row, const PlanChoice& choice, bool chosen) {
    row["error_with_the_others_as_chosen_dp_px"] = plan.error_dp_px(choice);
    if (with_times) row["picture_s"] = plan.picture_s(choice);
    row["chosen"] = chosen;
    return row;
  };
  ordered_json lenses = ordered_json::array(), bounces = lenses, lights = lenses, light_samples = lenses,
               effects = lenses, samples = lenses, chosen_effects = lenses;
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
                          chosen_but(plan, &PlanChoice::lens, l), l == best.lens));
  }
  for (std::size_t b = 0; b < plan.bounces.size(); ++b) {
    const BounceStep& r = plan.bounces[b];
    bounces.push_back(
        step({{"max_bounces", r.bounces}, {"error_dp_px", r.error_dp_px}, {"lost_windows", r.lost_windows}},
             chosen_but(plan, &PlanChoice::bounce, b), b == best.bounce));
  }
  for (std::size_t t = 0; t < plan.lights.size(); ++t) {
    const LightStep& r = plan.lights[t];
    lights.push_back(
        step({{"light_spacing_px", r.spacing_px}, {"error_dp_px", r.error_dp_px}, {"lost_windows", r.lost_windows}},
             chosen_but(plan, &PlanChoice::light, t), t == best.light));
  }
  for (std::size_t n = 0; n < plan.light_samples.size(); ++n) {
    const LightSampleStep& r = plan.light_samples[n];
    light_samples.push_back(step({{"light_samples", r.samples}, {"error_dp_px", r.error_dp_px}},
                                 chosen_but(plan, &PlanChoice::light_samples, n), n == best.light_samples));
  }
  for (std::size_t i = 0; i < plan.effects.size(); ++i) {
    const EffectStep& r = plan.effects[i];
    const char* name = name_of(kEffects, r.effect);
    if (best.effects[i]) chosen_effects.push_back(name);
    if (!plan.measured) continue;
    effects.push_back(step({{"without", name}, {"error_dp_px", r.error_dp_px}, {"lost_windows", r.lost_windows}},
                           but_effect(plan, i, false), !best.effects[i]));
  }
  for (std::size_t s = 0; s < plan.samples.size(); ++s) {
    const SampleStep& r = plan.samples[s];
    samples.push_back(step({{"samples_per_pixel", r.samples}, {"error_dp_px", r.error_dp_px}},
                           chosen_but(plan, &PlanChoice::sample, s), s == best.sample));
  }
  ordered_json chosen = {{"lens_model", plan.lenses[best.lens].candidate.name},
                         {"max_bounces", plan.bounces[best.bounce].bounces},
                         {"light_spacing_px", plan.lights[best.light].spacing_px},
                         {"light_samples", plan.light_samples[best.light_samples].samples},
                         {"effects", chosen_effects},
                         {"samples_per_pixel", plan.samples[best.sample].samples},
                         {"error_dp_px", plan.measured ? ordered_json(plan.error_dp_px(best)) : ordered_json()}};
  const Lens& lens = plan.lenses[best.lens].candidate.lens;
  if (std::holds_alternative<Aberrations>(lens.model)) chosen["lens"] = aberrated_lens_json(lens);
  return {{"tolerance_dp_px", plan.tolerance_dp_px},
          {"tolerance_met", plan.measured ? ordered_json(plan.met) : ordered_json()},
          {"seed", plan.seed},
          {"frames", plan.frames},
          {"windows", plan.windows},
          {"windows_textured", plan.windows_textured},
          {"bounces_and_samples_measured", plan.measured},
          {"chosen", chosen},
          {"lens_models", lenses},
          {"bounces", bounces},
          {"light", lights},
          {"light_samples", light_samples},
          {"effects", effects},
          {"samples", samples}};
}

std::string plan_text(const Plan& plan) {
  std::string text;
  const auto heading = [&](const char* name) {
    text += fmt::format("{}{:<18}{:>14}{:>14}{:>14}{:>12}\n", text.empty() ? "" : "\n", name, "error, DP px",
                        "in all, DP px", "picture, s", "saves, s");
  };
  const PlanChoice& best = plan.chosen;
  const double chosen_s = plan.picture_s(best);
  const auto row = [&](const std::string& name, double error, const PlanChoice& choice, bool chosen,
                       const std::string& note) {
    const double all = plan.error_dp_px(choice);
    const double time_s = plan.picture_s(choice);
    const char* verdict = chosen                       ? "chosen"
                          : all > plan.tolerance_dp_px ? "over the tolerance"
                          : time_s < 1.02 * chosen_s   ? "as much work"
                                                       : "more work";
    text += fmt::format("{:<18}{:>14.4f}{:>14.4f}{:>14.2f}{:>12.2f}  {}{}\n", name, error, all, time_s,
                        chosen_s - time_s, verdict, note);
  };
  heading("lens model");
  for (std::size_t l = 0; l < plan.lenses.size(); ++l) {
    const LensStep& r = plan.lenses[l];
    row(r.candidate.name, r.error_dp_px, chosen_but(plan, &PlanChoice::lens, l), l == best.lens,
        fmt::format("; 95 % within {:.4f}", r.error_95_dp_px));
  }
  if (plan.lenses.size() > 1) text += differences_text(plan);
  heading("bounces");
  for (std::size_t b = 0; b < plan.bounces.size(); ++b) {
    const BounceStep& r = plan.bounces[b];
    row(bounces_name(r.bounces), r.error_dp_px, chosen_but(plan, &PlanChoice::bounce, b), b == best.bounce,
        lost(r.lost_windows));
  }
  heading("light");
  for (std::size_t t = 0; t < plan.lights.size(); ++t) {
    const LightStep& r = plan.lights[t];
    row(light_name(r.spacing_px), r.error_dp_px, chosen_but(plan, &PlanChoice::light, t), t == best.light,
        lost(r.lost_windows));
  }
  if (plan.lights[best.light].spacing_px > 0) heading("light samples");
  for (std::size_t n = 0; plan.lights[best.light].spacing_px > 0 && n < plan.light_samples.size(); ++n) {
    const LightSampleStep& r = plan.light_samples[n];
    row(light_samples_name(r.samples), r.error_dp_px, chosen_but(plan, &PlanChoice::light_samples, n),
        n == best.light_samples, "");
  }
  const std::size_t effects = plan.measured ? plan.effects.size() : 0;
  if (effects > 0) heading("effects");
  for (std::size_t i = 0; i < effects; ++i) {
    const EffectStep& r = plan.effects[i];
    for (const bool simulated : {false, true}) {
      if (simulated && !knows(plan.lenses[best.lens].candidate.lens, r.effect)) continue;
      row(effect_name(r.effect, simulated), simulated ? 0 : r.error_dp_px, but_effect(plan, i, simulated),
          simulated == best.effects[i], simulated ? "" : lost(r.lost_windows));
    }
  }
  heading("samples");
  for (std::size_t s = 0; s < plan.samples.size(); ++s) {
    const SampleStep& r = plan.samples[s];
    row(samples_name(r.samples), r.error_dp_px, chosen_but(plan, &PlanChoice::sample, s), s == best.sample, "");
  }
  text +=
      "\nErrors are against a simulation with everything on, not against truth; each row with the others as chosen. "
      "Lens models: disparity traced at 432 field points, at the depth that the "
      "scene has there; beside it what else they change, RMS over those of the points where it can be told (colors: "
      "where the pupil is nearly whole), which does not count.\n";
  const std::string texture = fmt::format("{} of {} windows", plan.windows_textured, plan.windows);
  text += plan.measured ? "Bounces, light, effects and samples: pilot renders, as a matcher sees them in the " +
                              texture + " whose texture stands out of the sensor's noise.\n"
                        : "Bounces, light, effects and samples were not measured and are the scene file's: just " +
                              texture + " have texture that stands out of the sensor's noise.\n";
  return text + conclusion(plan);
}

}  // namespace dualpixel::simulator
