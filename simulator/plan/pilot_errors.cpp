#include "simulator/plan/pilot_errors.h"

#include <algorithm>
#include <cmath>

#include "simulator/plan/error_statistics.h"

namespace dualpixel::simulator {
namespace {

constexpr std::array kPilotRenders = {4, 2};  ///< at kPilotSamples, with seeds of their own
constexpr std::size_t kBouncePilot = 0;       ///< bounces are judged by the renders of these samples
constexpr std::array kBounces = {0, 1, 2, 4, kReferenceBounces};
constexpr double kLeastCorrelation = 0.8;
constexpr double kLostDpPx = 1;
constexpr int kFewestWindows = 6;

double work(int bounces, int samples) { return (1.0 + bounces) * samples; }

double work_in_all() {
  double sum = 0;
  for (std::size_t n = 0; n < kPilotSamples.size(); ++n) {
    sum += kPilotRenders[n] * work(kReferenceBounces, kPilotSamples[n]);
  }
  for (int bounces : kBounces) {
    if (bounces != kReferenceBounces) sum += 2 * work(bounces, kPilotSamples[kBouncePilot]);
  }
  return sum;
}

/// Pilot renders that report how much of all their work is done.
class CountedPilots {
 public:
  CountedPilots(const PilotRenders& pilots, const ProgressCallback& progress) : pilots_(pilots), progress_(progress) {}

  PilotRender render(int bounces, int samples, int repeat) {
    PilotRender pilot = pilots_.render(bounces, samples, repeat);
    done_ += work(bounces, samples);
    if (progress_) progress_(done_ / work_in_all());
    return pilot;
  }

 private:
  const PilotRenders& pilots_;
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

/// Error of one of several renders that differ by their seeds alone.
double noise_error(const std::vector<std::vector<double>>& renders) {
  std::vector<double> variances;
  for (std::size_t i = 0; i < renders.front().size(); ++i) {
    double mean = 0, variance = 0;
    for (const std::vector<double>& shift : renders) mean += shift[i] / static_cast<double>(renders.size());
    for (const std::vector<double>& shift : renders) variance += square(shift[i] - mean);
    variances.push_back(variance / static_cast<double>(renders.size() - 1));
  }
  return upper_rms(variances);
}

/// The windows with texture, by two renders of the reference.
std::vector<TileWindow> textured_windows(const std::vector<PilotRender>& best, const Simulation& simulation,
                                         double tolerance_dp_px, int& total) {
  const Exposure exposure = describe_exposure(simulation.sensor, simulation.exposure);
  std::vector<TileWindow> windows;
  for (std::size_t t = 0; t < best[0].tiles.size(); ++t) {
    const MatchWindows in_tile =
        match_windows(best[0].tiles[t], best[1].tiles[t], exposure, simulation.burst_frames, tolerance_dp_px);
    total += in_tile.total;
    for (const MatchWindow& window : in_tile.textured) windows.push_back({t, window});
  }
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
  double seconds_per_sample() const { return std::min(renders[0].seconds_per_sample, renders[1].seconds_per_sample); }
};

/// A window's two pictures correlate too little to be matched.
bool is_lost(const TileWindow& w, const RenderPair& a, const RenderPair& b) {
  return w.window.correlation(a.renders[0].tiles[w.tile], a.renders[1].tiles[w.tile], b.renders[0].tiles[w.tile],
                              b.renders[1].tiles[w.tile]) < kLeastCorrelation;
}

/// The mean product of two pairs' differences is the mean square of what is not noise.
BounceStep compare_bounces(int bounces, const std::vector<TileWindow>& windows, const RenderPair& cheap,
                           const RenderPair& reference) {
  BounceStep step{.bounces = bounces};
  step.seconds_per_sample = cheap.seconds_per_sample();
  std::vector<double> squares;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    const bool lost = is_lost(windows[i], cheap, reference);
    step.lost_windows += lost;
    squares.push_back(lost ? square(kLostDpPx)
                           : (cheap.shifts_dp_px[0][i] - reference.shifts_dp_px[0][i]) *
                                 (cheap.shifts_dp_px[1][i] - reference.shifts_dp_px[1][i]));
  }
  step.error_dp_px = upper_rms(squares);
  step.noise = reference.noise_dp_px > 0 ? cheap.noise_dp_px / reference.noise_dp_px : 1;
  return step;
}

}  // namespace

/// From the largest pilot that is not larger, as 1/sqrt: that much sampling does at least. A curve drawn through 16 and
/// 64 samples would promise more at 32.
double PilotErrors::sample_error(int samples) const {
  std::size_t i = kPilotSamples.size() - 1;
  while (kPilotSamples[i] > samples) --i;
  return noise[i] * std::sqrt(static_cast<double>(kPilotSamples[i]) / samples);
}

PilotErrors measure_pilots(const PilotRenders& pilot_renders, const Simulation& simulation, double tolerance_dp_px,
                           const ProgressCallback& progress) {
  CountedPilots pilots(pilot_renders, progress);
  std::array<std::vector<PilotRender>, kPilotSamples.size()> full;  // with the reference's bounces
  for (std::size_t n = 0; n < full.size(); ++n) {
    for (int repeat = 0; repeat < kPilotRenders[n]; ++repeat) {
      full[n].push_back(pilots.render(kReferenceBounces, kPilotSamples[n], repeat));
    }
  }
  PilotErrors errors;
  const std::vector<TileWindow> windows = textured_windows(full.back(), simulation, tolerance_dp_px, errors.windows);
  errors.windows_textured = static_cast<int>(windows.size());
  if (errors.windows_textured < kFewestWindows) return errors;

  for (std::size_t n = 0; n < full.size(); ++n) {
    std::vector<std::vector<double>> all;
    for (const PilotRender& pilot : full[n]) all.push_back(shifts(windows, pilot));
    errors.noise[n] = noise_error(all);
  }
  const RenderPair reference(windows, full[kBouncePilot].data());  // its first two
  for (int bounces : kBounces) {
    if (bounces == kReferenceBounces) {
      errors.bounces.push_back({.bounces = bounces, .seconds_per_sample = reference.seconds_per_sample()});
      continue;
    }
    const PilotRender cheap[2] = {pilots.render(bounces, kPilotSamples[kBouncePilot], 0),
                                  pilots.render(bounces, kPilotSamples[kBouncePilot], 1)};
    errors.bounces.push_back(compare_bounces(bounces, windows, RenderPair(windows, cheap), reference));
  }
  return errors;
}

}  // namespace dualpixel::simulator
