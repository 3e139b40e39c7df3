#include "simulator/plan/pilot_errors.h"

#include <algorithm>
#include <cmath>

#include "simulator/plan/error_statistics.h"

namespace dualpixel::simulator {
namespace {

constexpr int kPilotRenders = 4;         ///< at each of kPilotSamples, with seeds of their own
constexpr std::size_t kBouncePilot = 0;  ///< bounces are judged by the renders of these samples
constexpr std::array kBounces = {0, 1, 2, 4, kReferenceBounces};
constexpr double kLeastCorrelation = 0.8;
constexpr double kLostDpPx = 1;
constexpr std::size_t kFewestWindows = 6;
constexpr std::size_t kMostTimesTiles = 4;  ///< of those looked at first

double work(int bounces, int samples) { return (1.0 + bounces) * samples; }

/// At which of kPilotSamples an effect is judged: each pose of an exposure has the least, which are many together.
std::size_t effect_pilot(int poses) { return poses > 1 ? kBouncePilot : kPilotSamples.size() - 1; }

/// Of two pilots with an effect, of which the first is timed; without bounces, which are rarely needed.
double work_of_effect(int poses) { return 3.0 * poses * work(0, kPilotSamples[effect_pilot(poses)]); }

double work_in_all(const Simulation& simulation) {
  double sum = work(kReferenceBounces, kPilotSamples[kBouncePilot]);  // the first one is timed
  for (int samples : kPilotSamples) sum += kPilotRenders * work(kReferenceBounces, samples);
  sum += 2 * work(kReferenceBounces, kPilotSamples.back());  // of which the windows are made
  for (int bounces : kBounces) {
    if (bounces != kReferenceBounces) sum += 3 * work(bounces, kPilotSamples[kBouncePilot]);
  }
  if (simulation.light.light_spacing_px > 0) {
    for (int bounces : {0, kReferenceBounces}) sum += (kPilotRenders + 3) * work(bounces, kPilotSamples[kBouncePilot]);
    sum += 3 * work(0, kPilotSamples[kBouncePilot]);
  }
  for (int samples : kPilotSamples) sum += 3 * work(0, samples);  // without effects
  for (const Effect effect : effects_of(simulation)) {
    Simulation with = without_effects(simulation);
    add(effect, simulation, with);
    sum += work_of_effect(poses_of(with));
  }
  return sum;
}

/// Pilot renders that report how much of all their work is done.
class CountedPilots {
 public:
  CountedPilots(PilotRenders& pilots, const Simulation& file, const ProgressCallback& progress)
      : pilots_(pilots),
        light_spacing_px_(file.light.light_spacing_px),
        work_in_all_(work_in_all(file)),
        progress_(progress) {}

  PilotRender render(const PilotRenders& pilots, const PilotSettings& settings) {
    PilotRender pilot = pilots.render(settings);
    const double done = (settings.timed ? 2 : 1) * pilots.poses() * work(settings.bounces, settings.samples);
    if (settings.first_tile > 0) work_in_all_ += done;  // it was not expected
    done_ += done;
    if (progress_) progress_(std::min(done_ / work_in_all_, 1.0));
    return pilot;
  }

  /// At the scene file's spacing; repeats differ in the noise of light, too, and the first one is timed.
  PilotRender render(int bounces, int samples, int repeat) {
    const bool timed = repeat == 0 && samples == kPilotSamples[0];
    return render(pilots_, {.bounces = bounces,
                            .samples = samples,
                            .light_spacing_px = light_spacing_px_,
                            .repeat = repeat,
                            .light_repeat = repeat,
                            .timed = timed,
                            .new_light = timed});
  }

  PilotRenders& plain() const { return pilots_; }

 private:
  PilotRenders& pilots_;
  double light_spacing_px_, work_in_all_;
  const ProgressCallback& progress_;
  double done_ = 0;
};

struct TileWindow {
  std::size_t tile = 0;
  MatchWindow window;
};

std::vector<double> shifts(const std::vector<TileWindow>& windows, const PilotRender& pilot) {
  std::vector<double> result;
  for (const TileWindow& w : windows) result.push_back(w.window.shift_dp_px(pilot.tiles[w.tile]));
  return result;
}

/// Of each window, over several renders that differ by their seeds alone.
std::vector<double> variances_of(const std::vector<std::vector<double>>& renders) {
  std::vector<double> variances;
  for (std::size_t i = 0; i < renders.front().size(); ++i) {
    double mean = 0, variance = 0;
    for (const std::vector<double>& shift : renders) mean += shift[i] / static_cast<double>(renders.size());
    for (const std::vector<double>& shift : renders) variance += square(shift[i] - mean);
    variances.push_back(variance / static_cast<double>(renders.size() - 1));
  }
  return variances;
}

/// Error of one such render.
double noise_error(const std::vector<std::vector<double>>& renders) { return upper_rms(variances_of(renders)); }

/// Windows of the tiles.
struct TileWindows {
  std::vector<TileWindow> textured;
  int total = 0;
};

/// Adds the windows of the tiles from `first_tile` on, by two renders of the reference that serve nothing else: what a
/// window is made of would match it too well.
void add_windows(const Simulation& simulation, double tolerance_dp_px, std::size_t first_tile, CountedPilots& pilots,
                 TileWindows& windows) {
  const auto render = [&](int nth) {
    return pilots.render(pilots.plain(), {.bounces = kReferenceBounces,
                                          .samples = kPilotSamples.back(),
                                          .light_spacing_px = simulation.light.light_spacing_px,
                                          .repeat = kPilotRenders + nth,
                                          .light_repeat = kPilotRenders + nth,
                                          .first_tile = first_tile});
  };
  const PilotRender best[2] = {render(0), render(1)};
  const Exposure exposure = describe_exposure(simulation.sensor, simulation.exposure);
  for (std::size_t t = first_tile; t < best[0].tiles.size(); ++t) {
    const MatchWindows in_tile =
        match_windows(best[0].tiles[t], best[1].tiles[t], exposure, simulation.burst_frames, tolerance_dp_px);
    windows.total += in_tile.total;
    for (const MatchWindow& window : in_tile.textured) windows.textured.push_back({t, window});
  }
}

/// Leaves out the tiles without a textured window, but for the first ones, so that time is still nearly that of the
/// whole frame.
void keep_textured_tiles(std::size_t first_ones, PilotRenders& pilots, std::vector<TileWindow>& windows) {
  std::vector<bool> wanted(pilots.tiles(), false);
  std::fill_n(wanted.begin(), first_ones, true);
  for (const TileWindow& w : windows) wanted[w.tile] = true;
  for (TileWindow& w : windows) {
    w.tile = std::count(wanted.begin(), wanted.begin() + static_cast<std::ptrdiff_t>(w.tile), true);
  }
  pilots.keep_tiles(wanted);
}

/// Of the tiles; where few windows have texture, of up to kMostTimesTiles times as many.
TileWindows find_windows(const Simulation& simulation, double tolerance_dp_px, CountedPilots& pilots) {
  PilotRenders& plain = pilots.plain();
  const std::size_t first_ones = plain.tiles();
  std::size_t looked_at = 0;
  TileWindows windows;
  do {
    add_windows(simulation, tolerance_dp_px, looked_at, pilots, windows);
    looked_at = plain.tiles();
  } while (windows.textured.size() < kFewestWindows && looked_at < kMostTimesTiles * first_ones && plain.add_tiles());
  if (looked_at > first_ones) keep_textured_tiles(first_ones, plain, windows.textured);
  return windows;
}

/// Two renders with independent noise, and the shifts that they show.
struct RenderPair {
  const PilotRender* renders;
  std::array<std::vector<double>, 2> shifts_dp_px;
  double noise_dp_px;

  RenderPair(const std::vector<TileWindow>& windows, const PilotRender* pair)
      : renders(pair),
        shifts_dp_px{shifts(windows, pair[0]), shifts(windows, pair[1])},
        noise_dp_px(noise_error({shifts_dp_px[0], shifts_dp_px[1]})) {}
};

/// A window's two pictures correlate too little to be matched.
bool is_lost(const TileWindow& w, const RenderPair& a, const RenderPair& b) {
  return w.window.correlation(a.renders[0].tiles[w.tile], a.renders[1].tiles[w.tile], b.renders[0].tiles[w.tile],
                              b.renders[1].tiles[w.tile]) < kLeastCorrelation;
}

struct Difference {
  double error_dp_px = 0;
  int lost_windows = 0;
};

/// The mean product of two pairs' differences is the mean square of what is not noise.
Difference compare(const std::vector<TileWindow>& windows, const RenderPair& cheap, const RenderPair& reference) {
  Difference difference;
  std::vector<double> squares;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const bool lost = is_lost(windows[i], cheap, reference);
    difference.lost_windows += lost;
    squares.push_back(lost ? square(kLostDpPx)
                           : (cheap.shifts_dp_px[0][i] - reference.shifts_dp_px[0][i]) *
                                 (cheap.shifts_dp_px[1][i] - reference.shifts_dp_px[1][i]));
  }
  difference.error_dp_px = upper_rms(squares);
  return difference;
}

/// Noise is not taken to be less with fewer bounces: two renders cannot tell by how much.
BounceStep compare_bounces(int bounces, const std::vector<TileWindow>& windows, const RenderPair& cheap,
                           const RenderPair& reference) {
  const auto [error_dp_px, lost_windows] = compare(windows, cheap, reference);
  return {.bounces = bounces,
          .error_dp_px = error_dp_px,
          .lost_windows = lost_windows,
          .noise = reference.noise_dp_px > 0 ? std::max(cheap.noise_dp_px / reference.noise_dp_px, 1.0) : 1,
          .seconds_per_sample = cheap.renders[0].seconds_per_sample,
          .light_seconds = cheap.renders[0].light_seconds};
}

/// The scene file's spacing, twice that and half. Interpolation errs with the square of the spacing, so that the
/// difference of the first two is three quarters of the coarse one's error, and three times the other's. Half is not
/// rendered: it errs by a quarter, and takes as many times longer as the coarse one is faster, with at most four times
/// as many points. A quarter as many points have twice the noise in a window; of closer ones it is not taken to be
/// less, as those at vertices stay where they are.
std::vector<LightStep> compare_lights(const std::vector<TileWindow>& windows, int bounces, double spacing_px,
                                      const RenderPair& as_asked, CountedPilots& pilots) {
  const double coarse_px = std::min(2 * spacing_px, 1000.0);
  const auto render = [&](int repeat) {
    return pilots.render(pilots.plain(), {.bounces = bounces,
                                          .samples = kPilotSamples[kBouncePilot],
                                          .light_spacing_px = coarse_px,
                                          .repeat = repeat,
                                          .light_repeat = repeat,
                                          .timed = repeat == 0,
                                          .new_light = repeat == 0});
  };
  const PilotRender renders[2] = {render(0), render(1)};
  const RenderPair coarse(windows, renders);
  const auto [difference_dp_px, lost_windows] = compare(windows, coarse, as_asked);
  const double coarse_s = renders[0].light_seconds, as_asked_s = as_asked.renders[0].light_seconds;
  const double making = as_asked_s > 0 ? std::clamp(coarse_s / as_asked_s, 0.25, 1.0) : 1;
  return {{.spacing_px = coarse_px,
           .error_dp_px = 4.0 / 3 * difference_dp_px,
           .lost_windows = lost_windows,
           .noise = coarse_px / spacing_px,
           .making = making},
          {.spacing_px = spacing_px, .error_dp_px = difference_dp_px / 3},
          {.spacing_px = spacing_px / 2, .error_dp_px = difference_dp_px / 12, .making = 1 / making}};
}

/// By renders that differ in nothing but light at points.
std::vector<double> light_variances(const std::vector<TileWindow>& windows, int bounces, double spacing_px,
                                    CountedPilots& pilots) {
  std::vector<std::vector<double>> all;
  for (int light_repeat = 0; light_repeat < kPilotRenders; ++light_repeat) {
    all.push_back(shifts(windows, pilots.render(pilots.plain(), {.bounces = bounces,
                                                                 .samples = kPilotSamples[kBouncePilot],
                                                                 .light_spacing_px = spacing_px,
                                                                 .light_repeat = light_repeat})));
  }
  return variances_of(all);
}

/// What light at points does with so many bounces.
struct LightErrors {
  std::vector<LightStep> steps;
  std::vector<double> variances;  ///< of each window
};

LightErrors measure_light(const std::vector<TileWindow>& windows, int bounces, double spacing_px,
                          const RenderPair& as_asked, CountedPilots& pilots) {
  return {compare_lights(windows, bounces, spacing_px, as_asked, pilots),
          light_variances(windows, bounces, spacing_px, pilots)};
}

/// The worse of each.
void take_worse(const std::vector<LightStep>& other, std::vector<LightStep>& steps) {
  for (std::size_t i = 0; i < steps.size(); ++i) {
    steps[i].error_dp_px = std::max(steps[i].error_dp_px, other[i].error_dp_px);
    steps[i].lost_windows = std::max(steps[i].lost_windows, other[i].lost_windows);
    steps[i].making = std::max(steps[i].making, other[i].making);
  }
}

/// More samples of each point: independent ones have that much less noise at least.
std::vector<LightSampleStep> light_sample_steps(const LightCacheOptions& light, double noise_dp_px) {
  constexpr int kMostLightSamples = 65536 / 4;  // reflected light has four times as many paths at its points
  std::vector<LightSampleStep> steps = {{light.light_samples, noise_dp_px}};
  for (const int times : {4, 16}) {
    if (times * light.light_samples > kMostLightSamples || light.light_spacing_px == 0) break;
    steps.push_back(
        {times * light.light_samples, noise_dp_px / std::sqrt(static_cast<double>(times)), static_cast<double>(times)});
  }
  return steps;
}

/// Two renders that differ by their seeds alone, the first one timed.
std::array<PilotRender, 2> render_pair(const PilotRenders& pilots, int bounces, int samples, double light_spacing_px,
                                       CountedPilots& counted) {
  const auto render = [&](int repeat) {
    return counted.render(pilots, {bounces, samples, light_spacing_px, repeat, repeat, repeat == 0});
  };
  return {render(0), render(1)};
}

/// Each effect against none of them, with so many bounces. Of the poses of an exposure each has as many samples as the
/// picture without it, so that noise is no part of the difference.
std::vector<EffectStep> compare_effects(const Simulation& file, const std::vector<TileWindow>& windows, int bounces,
                                        CountedPilots& pilots) {
  constexpr double kLeastAdded = 0.1;  // of a sample's time: less is the clock's scatter
  const double spacing_px = file.light.light_spacing_px;
  const auto without = [&](std::size_t pilot) {
    return render_pair(pilots.plain(), bounces, kPilotSamples[pilot], spacing_px, pilots);
  };
  const std::array<std::array<PilotRender, 2>, kPilotSamples.size()> plain = {without(0), without(1)};
  std::vector<EffectStep> steps;
  for (const Effect effect : effects_of(file)) {
    Simulation with = pilots.plain().simulation();
    add(effect, file, with);
    const PilotRenders with_effect = pilots.plain().of(with);
    const std::size_t pilot = effect_pilot(with_effect.poses());
    const std::array renders = render_pair(with_effect, bounces, kPilotSamples[pilot], spacing_px, pilots);
    const auto [error_dp_px, lost_windows] =
        compare(windows, RenderPair(windows, renders.data()), RenderPair(windows, plain[pilot].data()));
    const double plain_s = plain[pilot][0].seconds_per_sample, added_s = renders[0].seconds_per_sample - plain_s;
    steps.push_back({.effect = effect,
                     .error_dp_px = error_dp_px,
                     .lost_windows = lost_windows,
                     .seconds_per_sample = added_s > kLeastAdded * plain_s ? added_s : 0,
                     .least_samples = with_effect.poses() > 1 ? 2 * with_effect.poses() : 1});
  }
  return steps;
}

/// The fewest bounces with which every window can be matched: in the dark of too few, no effect would show.
int fewest_bounces(const std::vector<BounceStep>& steps) {
  return std::find_if(steps.begin(), steps.end(), [](const BounceStep& step) { return step.lost_windows == 0; })
      ->bounces;
}

}  // namespace

/// From the largest pilot that is not larger, as 1/sqrt: that much sampling does at least. A curve drawn through 16 and
/// 64 samples would promise more at 32.
double PilotErrors::sample_error(int samples) const {
  std::size_t i = kPilotSamples.size() - 1;
  while (kPilotSamples[i] > samples) --i;
  return std::sqrt(std::max(square(noise[i]) - light_variance, 0.0) * kPilotSamples[i] / samples);
}

PilotErrors measure_pilots(PilotRenders& pilot_renders, const Simulation& simulation, double tolerance_dp_px,
                           const ProgressCallback& progress) {
  const double spacing_px = simulation.light.light_spacing_px;
  CountedPilots pilots(pilot_renders, simulation, progress);
  PilotErrors errors;
  const TileWindows found = find_windows(simulation, tolerance_dp_px, pilots);
  const std::vector<TileWindow>& windows = found.textured;
  errors.windows = found.total;
  errors.windows_textured = static_cast<int>(windows.size());
  if (windows.size() < kFewestWindows) return errors;

  std::array<std::vector<PilotRender>, kPilotSamples.size()> full;  // with the reference's bounces
  for (std::size_t n = 0; n < full.size(); ++n) {
    for (int repeat = 0; repeat < kPilotRenders; ++repeat) {
      full[n].push_back(pilots.render(kReferenceBounces, kPilotSamples[n], repeat));
    }
  }
  for (std::size_t n = 0; n < full.size(); ++n) {
    std::vector<std::vector<double>> all;
    for (const PilotRender& pilot : full[n]) all.push_back(shifts(windows, pilot));
    errors.noise[n] = noise_error(all);
  }
  const RenderPair reference(windows, full[kBouncePilot].data());  // its first two
  for (int bounces : kBounces) {
    if (bounces == kReferenceBounces) {
      errors.bounces.push_back({.bounces = bounces,
                                .seconds_per_sample = reference.renders[0].seconds_per_sample,
                                .light_seconds = reference.renders[0].light_seconds});
      continue;
    }
    const PilotRender cheap[2] = {pilots.render(bounces, kPilotSamples[kBouncePilot], 0),
                                  pilots.render(bounces, kPilotSamples[kBouncePilot], 1)};
    errors.bounces.push_back(compare_bounces(bounces, windows, RenderPair(windows, cheap), reference));
  }
  double light_noise = 0;
  errors.lights = {{}};
  if (spacing_px > 0) {
    const LightErrors all_bounces = measure_light(windows, kReferenceBounces, spacing_px, reference, pilots);
    errors.lights = all_bounces.steps;
    light_noise = upper_rms(all_bounces.variances);
    errors.light_variance = mean(all_bounces.variances);
    if (errors.bounces[0].lost_windows == 0) {  // then small triangles have points, too
      const PilotRender direct[2] = {pilots.render(0, kPilotSamples[kBouncePilot], 0),
                                     pilots.render(0, kPilotSamples[kBouncePilot], 1)};
      const LightErrors direct_light = measure_light(windows, 0, spacing_px, RenderPair(windows, direct), pilots);
      take_worse(direct_light.steps, errors.lights);
      light_noise = std::max(light_noise, upper_rms(direct_light.variances));
    }
  }
  errors.light_samples = light_sample_steps(simulation.light, light_noise);
  errors.effects = compare_effects(simulation, windows, fewest_bounces(errors.bounces), pilots);
  return errors;
}

}  // namespace dualpixel::simulator
