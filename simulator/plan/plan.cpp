#include "simulator/plan/plan.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "capture/error.h"
#include "capture/timing.h"
#include "simulator/lens/disparity_field.h"
#include "simulator/lens/lens_file.h"
#include "simulator/plan/match_error.h"
#include "simulator/render/camera_rays.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::simulator {
namespace {


constexpr int kPhotositesPerDpPixelX = 2, kPhotositesPerDpPixelY = 4;
constexpr int kPlaceColumns = 24, kPlaceRows = 18;  ///< where lens models are compared
constexpr int kRaysPerPlace = 2048;
constexpr int kTileColumns = 6, kTileRows = 4;
constexpr int kTileWidth = (2 * kWindowDpPx + 2) * kPhotositesPerDpPixelX;  ///< two windows and their neighbours
constexpr int kTileHeight = kWindowDpPx * kPhotositesPerDpPixelY;
constexpr std::array kPilotSamples = {16, 64};  ///< less than a packet of 16 costs as much
constexpr std::array kPilotRenders = {4, 2};    ///< with seeds of their own
constexpr std::size_t kBouncePilot = 0;         ///< ... of which bounces are judged by this one
constexpr std::array kBounces = {0, 1, 2, 4, kReferenceBounces};
constexpr int kMostSamples = 65536;
constexpr double kLeastCorrelation = 0.8;
constexpr double kLostDpPx = 1;
constexpr int kFewestWindows = 6;

double square(double x) { return x * x; }

/// Root of the mean of squares plus three of that mean's standard errors.
double upper_rms(const std::vector<double>& squares) {
  const auto n = static_cast<double>(squares.size());
  double sum = 0, sum2 = 0;
  for (double value : squares) sum += value;
  const double mean = sum / n;
  for (double value : squares) sum2 += square(value - mean);
  return std::sqrt(std::max(mean, 0.0) + 3 * std::sqrt(sum2 / (n * (n - 1))));
}

// Lens models

struct Place {
  int x = 0, y = 0;
  double inverse_depth = 0;  ///< 1/m, along the reference's chief ray
};

glm::dvec2 chief_slope(const LensSampler& lens, const Place& place) {
  const glm::dvec2 at = lens.sensor().middle_m(place.x, place.y);
  return lens.chief_slope(at.x, at.y);
}

/// One place in each cell of a grid over the sensor.
std::vector<Place> stratified_places(const RenderScene& world, const CameraView& camera, std::uint64_t seed) {
  const SensorGrid& sensor = camera.lens.sensor();
  std::vector<Place> places;
  for (int i = 0; i < kPlaceColumns * kPlaceRows; ++i) {
    const std::uint64_t key = hash(seed, i);
    const double u = unit_float(static_cast<std::uint32_t>(key));
    const double v = unit_float(static_cast<std::uint32_t>(key >> 32));
    const auto row = i / kPlaceColumns;
    Place place{static_cast<int>((i % kPlaceColumns + u) / kPlaceColumns * sensor.width_px),
                static_cast<int>((row + v) / kPlaceRows * sensor.height_px)};
    const auto hit = world.intersector.intersect(chief_ray(camera, place.x, place.y));
    if (hit) place.inverse_depth = 1 / static_cast<double>(hit->t);
    places.push_back(place);
  }
  return places;
}

/// Time of a sample through the lens alone, all threads at work.
double sampling_seconds(const LensSampler& lens, const std::vector<Place>& places) {
  constexpr int kSamples = 1024;
  const auto sample_all = [&] {
    tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
      alignas(64) float s[4][kPacket];
      LensPacket packet;
      for (int first = 0; first < kSamples; first += kPacket) {
        joint_samples(first, i, s);
        lens.sample(places[i].x, places[i].y, 1, s, packet);
      }
    });
  };
  sample_all();
  return std::min(seconds(sample_all), seconds(sample_all)) / (static_cast<double>(places.size()) * kSamples);
}

void compare_lenses(std::vector<LensRung>& rungs, const Simulation& simulation, const Scene& scene,
                    const RenderScene& world, std::uint64_t seed) {
  const auto camera_of = [&](const LensRung& rung) {
    Simulation s = simulation;
    s.lens = rung.model.lens;
    return place_camera(s, scene);
  };
  const CameraView reference = camera_of(rungs.back());
  const std::vector<Place> places = stratified_places(world, reference, seed);
  std::vector<DisparityCoefficients> expected(places.size());
  tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
    expected[i] = trace_disparity(reference.lens, places[i].x, places[i].y, kRaysPerPlace);
  });
  rungs.back().seconds_per_sample = sampling_seconds(reference.lens, places);
  const double px_per_slope = reference.lens.lens().thin.image_distance_m() / reference.lens.sensor().pixel_pitch_m;
  for (std::size_t r = 0; r + 1 < rungs.size(); ++r) {
    const LensSampler lens = camera_of(rungs[r]).lens;
    std::vector<double> errors(places.size());
    tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
      const DisparityCoefficients& e = expected[i];
      if (e.left_light == 0 || e.right_light == 0) return;  // nothing to be seen there
      const auto c = trace_disparity(lens, places[i].x, places[i].y, kRaysPerPlace);
      errors[i] = std::abs((c.slope_dp_px_m - e.slope_dp_px_m) * places[i].inverse_depth + c.intercept_dp_px -
                           e.intercept_dp_px);
    });
    std::vector<double> squares;
    double shifts2 = 0;
    for (std::size_t i = 0; i < places.size(); ++i) {
      squares.push_back(square(errors[i]));
      const glm::dvec2 gap = chief_slope(lens, places[i]) - chief_slope(reference.lens, places[i]);
      shifts2 += glm::dot(gap, gap) * square(px_per_slope);
    }
    rungs[r].error_dp_px = upper_rms(squares);
    rungs[r].picture_shift_px = std::sqrt(shifts2 / static_cast<double>(places.size()));
    rungs[r].seconds_per_sample = sampling_seconds(lens, places);
    std::sort(errors.begin(), errors.end());
    rungs[r].error_95_dp_px = errors[errors.size() * 95 / 100];
  }
}

// Pilot renders

/// Cameras that see a part of the sensor each: the principal point moves, nothing else.
std::vector<CameraView> tiles(const Simulation& simulation, const Lens& lens, const Scene& scene, std::uint64_t seed) {
  Simulation posed = simulation;
  posed.lens.model = Lens::Model::thin;  // quick to make ready; only the pose is wanted
  const glm::mat4 pose = place_camera(posed, scene).world_from_camera;
  const SensorGrid sensor = sensor_grid(simulation);
  const int cell_width = sensor.width_px / kTileColumns, cell_height = sensor.height_px / kTileRows;
  std::vector<SensorGrid> grids;
  if (cell_width < kTileWidth || cell_height < kTileHeight) {
    grids.push_back(sensor);
  } else {
    for (int i = 0; i < kTileColumns * kTileRows; ++i) {
      const std::uint64_t key = hash(seed, i);
      const int x = i % kTileColumns * cell_width + static_cast<int>(key % (cell_width - kTileWidth + 1));
      const int y = i / kTileColumns * cell_height + static_cast<int>((key >> 32) % (cell_height - kTileHeight + 1));
      const glm::dvec2 corner(x / kPhotositesPerDpPixelX * kPhotositesPerDpPixelX,
                              y / kPhotositesPerDpPixelY * kPhotositesPerDpPixelY);
      grids.push_back(
          {kTileWidth, kTileHeight, sensor.pixel_pitch_m, sensor.principal_point_px - corner, sensor.dp_downsample_x});
    }
  }
  std::vector<std::optional<CameraView>> ready(grids.size());
  tbb::parallel_for(std::size_t{0}, grids.size(), [&](std::size_t i) {
    ready[i] = CameraView{pose, LensSampler(lens, grids[i])};
  });
  std::vector<CameraView> cameras;
  for (std::optional<CameraView>& camera : ready) cameras.push_back(std::move(*camera));
  return cameras;
}

/// One render of all tiles.
struct Pilot {
  std::vector<DpViews> tiles;
  double seconds_per_sample = 0;
};

class Pilots {
 public:
  Pilots(const Simulation& simulation, const RenderScene& world, std::vector<CameraView> cameras, std::uint64_t seed)
      : simulation_(simulation), world_(world), cameras_(std::move(cameras)), seed_(seed) {}

  Pilot render(int bounces, int samples, int repeat) const {
    Pilot pilot;
    pilot.tiles.resize(cameras_.size());
    double photosites = 0;
    for (const CameraView& camera : cameras_) {
      photosites += static_cast<double>(camera.lens.sensor().width_px) * camera.lens.sensor().height_px;
    }
    const double time_s = seconds([&] {
      tbb::parallel_for(std::size_t{0}, cameras_.size(), [&](std::size_t i) {
        const Views views = render_views(world_, cameras_[i], {samples, bounces, hash(seed_, repeat, i)});
        pilot.tiles[i] =
            expected_dp_views(views, simulation_.sensor, simulation_.exposure, cameras_[i].lens.lux_per_nit());
      });
    });
    pilot.seconds_per_sample = time_s / (photosites * samples);
    return pilot;
  }

 private:
  const Simulation& simulation_;
  const RenderScene& world_;
  std::vector<CameraView> cameras_;
  std::uint64_t seed_;
};

struct TileWindow {
  std::size_t tile = 0;
  MatchWindow window;
};

std::vector<double> shifts(const std::vector<TileWindow>& windows, const Pilot& pilot) {
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

/// From the largest pilot that is not larger, as 1/sqrt: that much sampling does at least. A curve drawn through 16 and
/// 64 samples would promise more at 32.
double error_at(const std::array<double, kPilotSamples.size()>& measured, int samples) {
  std::size_t i = kPilotSamples.size() - 1;
  while (kPilotSamples[i] > samples) --i;
  return measured[i] * std::sqrt(static_cast<double>(kPilotSamples[i]) / samples);
}

struct Measured {
  std::vector<BounceRung> bounces;
  std::array<double, kPilotSamples.size()> noise{};  ///< with the reference's bounces
};

/// Bounces and samples, where enough windows have texture.
std::optional<Measured> measure(const Pilots& pilots, const Simulation& simulation, Plan& plan,
                                const ProgressCallback& progress) {
  const auto work = [](int bounces, int samples) { return (1.0 + bounces) * samples; };
  double work_done = 0, work_in_all = 0;
  for (std::size_t n = 0; n < kPilotSamples.size(); ++n) {
    work_in_all += kPilotRenders[n] * work(kReferenceBounces, kPilotSamples[n]);
  }
  for (int bounces : kBounces) {
    if (bounces != kReferenceBounces) work_in_all += 2 * work(bounces, kPilotSamples[kBouncePilot]);
  }
  const auto render = [&](int bounces, int samples, int repeat) {
    Pilot pilot = pilots.render(bounces, samples, repeat);
    work_done += work(bounces, samples);
    if (progress) progress(work_done / work_in_all);
    return pilot;
  };
  std::array<std::vector<Pilot>, kPilotSamples.size()> full;  // with the reference's bounces
  for (std::size_t n = 0; n < full.size(); ++n) {
    for (int repeat = 0; repeat < kPilotRenders[n]; ++repeat) {
      full[n].push_back(render(kReferenceBounces, kPilotSamples[n], repeat));
    }
  }
  const Exposure exposure = describe_exposure(simulation.sensor, simulation.exposure);
  std::vector<TileWindow> windows;
  const std::vector<Pilot>& best = full.back();
  for (std::size_t t = 0; t < best[0].tiles.size(); ++t) {
    const MatchWindows in_tile =
        match_windows(best[0].tiles[t], best[1].tiles[t], exposure, simulation.burst_frames, plan.tolerance_dp_px);
    plan.windows += in_tile.total;
    for (const MatchWindow& window : in_tile.textured) windows.push_back({t, window});
  }
  plan.windows_textured = static_cast<int>(windows.size());
  if (plan.windows_textured < kFewestWindows) return std::nullopt;

  Measured m;
  for (std::size_t n = 0; n < full.size(); ++n) {
    std::vector<std::vector<double>> all;
    for (const Pilot& pilot : full[n]) all.push_back(shifts(windows, pilot));
    m.noise[n] = noise_error(all);
  }
  const Pilot* reference = full[kBouncePilot].data();  // its first two
  const std::vector<double> full_shifts[2] = {shifts(windows, reference[0]), shifts(windows, reference[1])};
  const double full_noise = noise_error({full_shifts[0], full_shifts[1]});
  for (int bounces : kBounces) {
    BounceRung rung{.bounces = bounces};
    if (bounces == kReferenceBounces) {
      rung.seconds_per_sample = std::min(reference[0].seconds_per_sample, reference[1].seconds_per_sample);
      m.bounces.push_back(rung);
      continue;
    }
    const Pilot cheap[2] = {render(bounces, kPilotSamples[kBouncePilot], 0),
                            render(bounces, kPilotSamples[kBouncePilot], 1)};
    const std::vector<double> cheap_shifts[2] = {shifts(windows, cheap[0]), shifts(windows, cheap[1])};
    rung.seconds_per_sample = std::min(cheap[0].seconds_per_sample, cheap[1].seconds_per_sample);
    std::vector<double> squares;
    for (std::size_t i = 0; i < windows.size(); ++i) {
      const std::size_t t = windows[i].tile;
      const bool lost = windows[i].window.correlation(cheap[0].tiles[t], cheap[1].tiles[t], reference[0].tiles[t],
                                                      reference[1].tiles[t]) < kLeastCorrelation;
      rung.lost_windows += lost;
      squares.push_back(lost ? square(kLostDpPx)
                             : (cheap_shifts[0][i] - full_shifts[0][i]) * (cheap_shifts[1][i] - full_shifts[1][i]));
    }
    rung.error_dp_px = upper_rms(squares);
    rung.noise = full_noise > 0 ? noise_error({cheap_shifts[0], cheap_shifts[1]}) / full_noise : 1;
    m.bounces.push_back(rung);
  }
  return m;
}

/// The least work whose error stays within the tolerance; the reference with the most samples where none does.
void choose(Plan& plan, const std::optional<Measured>& measured, int scene_samples) {
  const auto sample_error = [&](std::size_t b, int samples) {
    return measured ? plan.bounces[b].noise * error_at(measured->noise, samples) : 0.0;
  };
  const auto root_of_squares = [&](std::size_t l, std::size_t b, int samples) {
    return std::sqrt(square(plan.lenses[l].error_dp_px) + square(plan.bounces[b].error_dp_px) +
                     square(sample_error(b, samples)));
  };
  plan.met = false;
  plan.lens = plan.lenses.size() - 1;
  plan.bounce = plan.bounces.size() - 1;
  int chosen_samples = measured ? kMostSamples : scene_samples;
  double least_work = std::numeric_limits<double>::infinity();
  for (std::size_t l = 0; l < plan.lenses.size(); ++l) {
    for (std::size_t b = 0; b < plan.bounces.size(); ++b) {
      int samples = measured ? kPilotSamples[0] : scene_samples;
      while (measured && samples < kMostSamples && !(root_of_squares(l, b, samples) <= plan.tolerance_dp_px))
        samples *= 2;
      const double work = samples * (plan.lenses[l].model.work + plan.bounces[b].bounces);
      if (!(root_of_squares(l, b, samples) <= plan.tolerance_dp_px) || work >= least_work) continue;
      least_work = work;
      plan.met = true;
      plan.lens = l, plan.bounce = b, chosen_samples = samples;
    }
  }
  const int first = measured ? kPilotSamples[0] : chosen_samples,
            last = measured ? std::min(4 * chosen_samples, kMostSamples) : first;
  for (int samples = first; samples <= last; samples *= 2) {
    if (samples == chosen_samples) plan.sample = plan.samples.size();
    plan.samples.push_back({samples, sample_error(plan.bounce, samples)});
  }
}

std::string bounces_name(int bounces) { return fmt::format("{} bounce{}", bounces, bounces == 1 ? "" : "s"); }
std::string samples_name(int samples) { return fmt::format("{} sample{}", samples, samples == 1 ? "" : "s"); }

}  // namespace

double Plan::error_dp_px(std::size_t l, std::size_t b, std::size_t s) const {
  return std::sqrt(square(lenses[l].error_dp_px) + square(bounces[b].error_dp_px) + square(samples[s].error_dp_px));
}

double Plan::picture_s(std::size_t l, std::size_t b, std::size_t s) const {
  return photosites * samples[s].samples *
         (bounces[b].seconds_per_sample + lenses[l].seconds_per_sample - lenses[pilot_lens].seconds_per_sample);
}

Plan plan(const Simulation& simulation, const Scene& scene, double tolerance_dp_px, std::uint64_t seed,
          const ProgressCallback& progress) {
  const SensorGrid sensor = sensor_grid(simulation);
  constexpr int kLeastWidth = (kWindowDpPx + 2) * kPhotositesPerDpPixelX;
  if (sensor.width_px < kLeastWidth || sensor.height_px < kTileHeight) {
    throw InputError(fmt::format("{}: /sensor: {} x {} photosites: a plan needs at least {} x {}, one matcher's window",
                                 printable(simulation.path), sensor.width_px, sensor.height_px, kLeastWidth,
                                 kTileHeight));
  }
  const RenderScene world(scene);
  Plan plan;
  plan.tolerance_dp_px = tolerance_dp_px;
  plan.seed = seed;
  plan.photosites = static_cast<double>(sensor.width_px) * sensor.height_px;
  try {
    for (LensModel& model : lens_ladder(simulation.lens)) plan.lenses.push_back({.model = std::move(model)});
    compare_lenses(plan.lenses, simulation, scene, world, hash(seed, 0));
    plan.pilot_lens = plan.lenses.size() - (plan.lenses.back().model.lens.exact_trace ? 2 : 1);
    const Pilots pilots(simulation, world,
                        tiles(simulation, plan.lenses[plan.pilot_lens].model.lens, scene, hash(seed, 1)),
                        hash(seed, 2));
    const std::optional<Measured> measured = measure(pilots, simulation, plan, progress);
    plan.measured = measured.has_value();
    if (measured) {
      plan.bounces = measured->bounces;
    } else {
      const int bounces = simulation.render.max_bounces;
      plan.bounces = {{.bounces = bounces, .seconds_per_sample = pilots.render(bounces, 16, 0).seconds_per_sample}};
      if (progress) progress(1);
    }
    choose(plan, measured, simulation.render.samples_per_pixel);
  } catch (const std::invalid_argument& error) {
    throw InputError(printable(simulation.path) + ": /lens: " + error.what());
  }
  return plan;
}

Simulation planned(Simulation simulation, const Plan& plan) {
  simulation.lens = plan.lenses[plan.lens].model.lens;
  if (!plan.measured) return simulation;
  simulation.render.max_bounces = plan.bounces[plan.bounce].bounces;
  simulation.render.samples_per_pixel = plan.samples[plan.sample].samples;
  simulation.noise_fraction.reset();
  simulation.render_error.reset();
  simulation.time_budget_s.reset();
  return simulation;
}

nlohmann::ordered_json plan_json(const Plan& plan, bool with_times) {
  using nlohmann::ordered_json;
  // each rung with the other two as chosen
  const auto rung = [&](ordered_json row, std::size_t l, std::size_t b, std::size_t s, bool chosen) {
    row["error_with_the_others_as_chosen_dp_px"] = plan.error_dp_px(l, b, s);
    if (with_times) row["picture_s"] = plan.picture_s(l, b, s);
    row["chosen"] = chosen;
    return row;
  };
  ordered_json lenses = ordered_json::array(), bounces = lenses, samples = lenses;
  for (std::size_t l = 0; l < plan.lenses.size(); ++l) {
    const LensRung& r = plan.lenses[l];
    lenses.push_back(rung({{"model", r.model.name},
                           {"error_dp_px", r.error_dp_px},
                           {"error_95th_percentile_dp_px", r.error_95_dp_px},
                           {"picture_shift_px", r.picture_shift_px}},
                          l, plan.bounce, plan.sample, l == plan.lens));
  }
  for (std::size_t b = 0; b < plan.bounces.size(); ++b) {
    const BounceRung& r = plan.bounces[b];
    bounces.push_back(
        rung({{"max_bounces", r.bounces}, {"error_dp_px", r.error_dp_px}, {"lost_windows", r.lost_windows}}, plan.lens,
             b, plan.sample, b == plan.bounce));
  }
  for (std::size_t s = 0; s < plan.samples.size(); ++s) {
    const SampleRung& r = plan.samples[s];
    samples.push_back(rung({{"samples_per_pixel", r.samples}, {"error_dp_px", r.error_dp_px}}, plan.lens, plan.bounce,
                           s, s == plan.sample));
  }
  ordered_json chosen = {{"lens_model", plan.lenses[plan.lens].model.name},
                         {"max_bounces", plan.bounces[plan.bounce].bounces},
                         {"samples_per_pixel", plan.samples[plan.sample].samples},
                         {"error_dp_px", plan.error_dp_px(plan.lens, plan.bounce, plan.sample)}};
  const Lens& lens = plan.lenses[plan.lens].model.lens;
  if (lens.model == Lens::Model::aberrated) chosen["lens"] = aberrated_lens_json(lens);
  return {{"tolerance_dp_px", plan.tolerance_dp_px},
          {"tolerance_met", plan.met},
          {"seed", plan.seed},
          {"windows", plan.windows},
          {"windows_textured", plan.windows_textured},
          {"bounces_and_samples_measured", plan.measured},
          {"chosen", chosen},
          {"lens_models", lenses},
          {"bounces", bounces},
          {"samples", samples}};
}

std::string plan_text(const Plan& plan) {
  std::string text;
  const auto heading = [&](const char* name) {
    text += fmt::format("{}{:<18}{:>14}{:>14}{:>14}{:>12}\n", text.empty() ? "" : "\n", name, "error, DP px",
                        "in all, DP px", "picture, s", "saves, s");
  };
  const double chosen_s = plan.picture_s(plan.lens, plan.bounce, plan.sample);
  const auto row = [&](const std::string& name, double error, std::size_t l, std::size_t b, std::size_t s, bool chosen,
                       const std::string& note) {
    const double all = plan.error_dp_px(l, b, s);
    const double time_s = plan.picture_s(l, b, s);
    const char* verdict = chosen ? "chosen" : all > plan.tolerance_dp_px ? "over the tolerance" : "more work";
    text += fmt::format("{:<18}{:>14.4f}{:>14.4f}{:>14.2f}{:>12.2f}  {}{}\n", name, error, all, time_s,
                        chosen_s - time_s, verdict, note);
  };
  heading("lens model");
  for (std::size_t l = 0; l < plan.lenses.size(); ++l) {
    const LensRung& r = plan.lenses[l];
    row(r.model.name, r.error_dp_px, l, plan.bounce, plan.sample, l == plan.lens,
        fmt::format("; 95 % within {:.4f}; draws the picture {:.2f} px elsewhere", r.error_95_dp_px,
                    r.picture_shift_px));
  }
  heading("bounces");
  for (std::size_t b = 0; b < plan.bounces.size(); ++b) {
    const BounceRung& r = plan.bounces[b];
    row(bounces_name(r.bounces), r.error_dp_px, plan.lens, b, plan.sample, b == plan.bounce,
        r.lost_windows > 0 ? fmt::format("; {} windows show other things", r.lost_windows) : "");
  }
  heading("samples");
  for (std::size_t s = 0; s < plan.samples.size(); ++s) {
    const SampleRung& r = plan.samples[s];
    row(samples_name(r.samples), r.error_dp_px, plan.lens, plan.bounce, s, s == plan.sample, "");
  }
  text +=
      "\nEach row with the other two as chosen. Lens models: disparity traced at 432 places, at the depth that the "
      "scene has there.\n";
  text += plan.measured
              ? fmt::format(
                    "Bounces and samples: pilot renders, as a matcher sees them in the {} of {} windows whose "
                    "texture stands out of the sensor's noise.\n",
                    plan.windows_textured, plan.windows)
              : fmt::format(
                    "Bounces and samples were not measured and are the scene file's: just {} of {} windows have "
                    "texture that stands out of the sensor's noise.\n",
                    plan.windows_textured, plan.windows);
  const auto chosen =
      fmt::format("{}, {}, {}", plan.lenses[plan.lens].model.name, bounces_name(plan.bounces[plan.bounce].bounces),
                  samples_name(plan.samples[plan.sample].samples));
  const double error = plan.error_dp_px(plan.lens, plan.bounce, plan.sample);
  text += plan.met ? fmt::format("Enough for {} DP px: {}: error {:.4f} DP px, {:.1f} s for the two views.\n",
                                 plan.tolerance_dp_px, chosen, error, chosen_s)
                   : fmt::format("Nothing reaches {} DP px; the best is {}: error {:.4f} DP px, {:.1f} s.\n",
                                 plan.tolerance_dp_px, chosen, error, chosen_s);
  return text;
}

}  // namespace dualpixel::simulator
