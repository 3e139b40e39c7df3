#include "evaluation/benchmarks/render_benchmark.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "capture/json_fields.h"
#include "capture/timing.h"
#include "simulator/render/adaptive.h"
#include "simulator/render/render_error.h"
#include "simulator/sampling/hash.h"
#include "simulator/sampling/mosaic.h"
#include "simulator/sensor_noise.h"
#include "simulator/simulate.h"

namespace dualpixel::evaluation {
namespace {

using simulator::CameraView;
using simulator::ErrorTarget;
using simulator::LightCache;
using simulator::LightCacheOptions;
using simulator::LoggedRays;
using simulator::Pilot;
using simulator::RayLog;
using simulator::RenderOptions;
using simulator::SampleMap;
using simulator::Sampling;
using simulator::Simulation;

// What is rendered of a scene: patches spread over the frame, in the detail of the full picture.
constexpr int kPatchColumns = 6, kPatchRows = 4, kPatches = kPatchColumns * kPatchRows;
constexpr int kPatchSide = 32;  ///< two tiles of a SampleMap

struct Patches {
  simulator::RenderScene world;  ///< all light sampled, but while the light cache is measured
  std::vector<CameraView> cameras;
  ErrorTarget sensor;
  int max_bounces = 0;
  std::uint64_t first_seed = 0;  ///< what is rendered has seeds from here on
};

/// Both halves of the photosites of all patches, in their own filter's color, nits: left, then right of each.
using Halves = std::vector<double>;

CameraView patch_camera(const Simulation& s, const CameraView& whole, int index) {
  simulator::SensorGrid grid = whole.lens.sensor();
  const auto start = [](int i, int n, int size) {
    return (static_cast<int>((i + 0.5) / n * size) - kPatchSide / 2) & ~1;  // even: the mosaic's colors stay
  };
  grid.principal_point_px -= glm::dvec2(start(index % kPatchColumns, kPatchColumns, grid.width_px),
                                        start(index / kPatchColumns, kPatchRows, grid.height_px));
  grid.width_px = grid.height_px = kPatchSide;
  return {whole.world_from_camera, simulator::LensSampler(s.lens, grid)};
}

Halves render(const Patches& patches, Sampling sampling, std::uint64_t seed, const std::vector<SampleMap>& maps) {
  Halves halves(std::size_t{kPatches} * kPatchSide * kPatchSide * 2);
  tbb::parallel_for(0, kPatches, [&](int p) {
    const RenderOptions options{0, patches.max_bounces, simulator::hash(patches.first_seed + seed, p), {}, sampling};
    const simulator::Views views = simulator::render_views(patches.world, patches.cameras[p], options, maps[p]);
    double* out = &halves[static_cast<std::size_t>(p) * kPatchSide * kPatchSide * 2];
    for (int y = 0; y < kPatchSide; ++y) {
      for (int x = 0; x < kPatchSide; ++x) {
        *out++ = views.left.at(x, y, simulator::cfa_color(x, y));
        *out++ = views.right.at(x, y, simulator::cfa_color(x, y));
      }
    }
  });
  return halves;
}

std::vector<SampleMap> uniform(int samples) {
  return std::vector<SampleMap>(kPatches, simulator::uniform_map(kPatchSide, kPatchSide, samples));
}

/// RMS over all patches, each photosite over its sensor noise (of one half; of both for their difference).
struct Error {
  double left = 0, right = 0, difference = 0;
  double halves() const { return std::sqrt(0.5 * (left * left + right * right)); }
};

/// The reference's own error is subtracted: `reference` is the mean of two renders, `apart` their difference.
Error error_of(const Patches& patches, const Halves& halves, const Halves& reference, const Halves& apart) {
  double left = 0, right = 0, difference = 0;
  const std::size_t count = halves.size() / 2;
  for (std::size_t i = 0; i < count; ++i) {
    const int c = simulator::cfa_color(static_cast<int>(i) % kPatchSide, static_cast<int>(i) / kPatchSide % kPatchSide);
    const double nits = 0.5 * (reference[2 * i] + reference[2 * i + 1]);
    const double noise2 = patches.sensor.at(c, nits);
    const double l = halves[2 * i] - reference[2 * i], r = halves[2 * i + 1] - reference[2 * i + 1];
    const double own_l = 0.5 * apart[2 * i], own_r = 0.5 * apart[2 * i + 1];
    left += (l * l - own_l * own_l) / noise2;
    right += (r * r - own_r * own_r) / noise2;
    difference += ((l - r) * (l - r) - (own_l - own_r) * (own_l - own_r)) / (2 * noise2);
  }
  const auto rms = [&](double sum) { return std::sqrt(std::max(sum, 0.0) / static_cast<double>(count)); };
  return {rms(left), rms(right), rms(difference)};
}

/// One map for each patch, from a pilot over all of them.
std::vector<SampleMap> adapt(const Patches& patches, double error, std::uint64_t seed) {
  ErrorTarget target = patches.sensor;
  for (int c = 0; c < 3; ++c) target.per_nit[c] *= error * error, target.constant[c] *= error * error;
  std::vector<Pilot> pilots(kPatches);
  tbb::parallel_for(0, kPatches, [&](int p) {
    const std::uint64_t patch_seed = simulator::hash(patches.first_seed + seed, p);
    const RenderOptions options{0, patches.max_bounces, patch_seed, {}, Sampling::mirrored};
    pilots[p] = simulator::probe_tiles(patches.world, patches.cameras[p], options, target);
  });
  Pilot all;
  all.grid = simulator::uniform_map(kPatchSide, kPatchSide * kPatches, 1);  // patch below patch
  for (const Pilot& pilot : pilots) {
    all.needed.insert(all.needed.end(), pilot.needed.begin(), pilot.needed.end());
    all.slope.insert(all.slope.end(), pilot.slope.begin(), pilot.slope.end());
  }
  const SampleMap shared = simulator::share_samples(all, 1);
  std::vector<SampleMap> maps = uniform(1);
  for (int p = 0; p < kPatches; ++p) {
    const auto tiles = static_cast<std::ptrdiff_t>(maps[p].samples.size());
    std::copy_n(shared.samples.begin() + p * tiles, tiles, maps[p].samples.begin());
  }
  return maps;
}

/// The renderer and Embree alone on one thread, on the same rays, taking turns.
EmbreeShare against_embree(const Patches& patches) {
  constexpr int kEvery = 4, kSamples = 64;
  const auto render_some = [&](RayLog* log) {
    for (int p = 0; p < kPatches; p += kEvery) {
      for (int i = 0; i < kPatchSide * kPatchSide; ++i) {
        simulator::render_pixel(patches.world, patches.cameras[p],
                                {patches.max_bounces, {}, Sampling::mirrored, {}, log}, i % kPatchSide, i / kPatchSide,
                                kSamples, simulator::hash(7, p, i));
      }
    }
  };
  RayLog log;
  render_some(&log);
  constexpr int kRendered = kPatches / kEvery;
  const double samples = static_cast<double>(kSamples) * kPatchSide * kPatchSide * kRendered;
  double rays = 0;
  for (const LoggedRays& packet : log) rays -= std::accumulate(packet.active, packet.active + simulator::kPacket, 0);
  double render_s = 1e30, replay_s[3] = {1e30, 1e30, 1e30};
  for (int repeat = 0; repeat < 5; ++repeat) {
    render_s = std::min(render_s, cpu_seconds([&] { render_some(nullptr); }));
    for (int w = 0; w < 3; ++w) {
      const int width = EmbreeShare::kPacketWidths[w];
      replay_s[w] =
          std::min(replay_s[w], cpu_seconds([&] { simulator::replay(patches.world.intersector, log, width); }));
    }
  }
  EmbreeShare share;
  share.rays_per_sample = rays / samples;
  share.samples_per_core_s = samples / render_s;
  for (int w = 0; w < 3; ++w) share.embree_samples_per_core_s[w] = samples / replay_s[w];
  share.share_of_embree = *std::min_element(replay_s, replay_s + 3) / render_s;
  return share;
}

/// Time of both views over that of a single one without a split pixel: the ideal lens, for which render_pixel keeps one
/// sum. The scene's lens is replaced by a thin one in both, so that the split alone makes the difference.
double pair_over_undivided(const Patches& patches) {
  constexpr int kEvery = 6, kSamples = 64;
  std::vector<CameraView> thin;
  for (int p = 0; p < kPatches; p += kEvery) {
    simulator::Lens lens = patches.cameras[p].lens.lens();
    lens.model = simulator::ThinModel{};
    thin.push_back({patches.cameras[p].world_from_camera, {lens, patches.cameras[p].lens.sensor()}});
  }
  const auto render_all = [&](std::optional<double> ideal) {
    for (const CameraView& camera : thin) {
      for (int i = 0; i < kPatchSide * kPatchSide; ++i) {
        simulator::render_pixel(patches.world, camera, {patches.max_bounces, ideal}, i % kPatchSide, i / kPatchSide,
                                kSamples, simulator::hash(7, i));
      }
    }
  };
  double pair_s = 1e30, undivided_s = 1e30;
  for (int repeat = 0; repeat < 15; ++repeat) {
    pair_s = std::min(pair_s, cpu_seconds([&] { render_all({}); }));
    undivided_s = std::min(undivided_s, cpu_seconds([&] { render_all(1.0); }));
  }
  return pair_s / undivided_s;
}

RenderRun run_of(double samples, double time_s, const Error& e) {
  return {samples, time_s, e.halves(), e.left, e.right, e.difference, {}};
}

/// Time at which the curve comes down to `error`, interpolated on log axes; 0: never.
double time_to(const std::vector<RenderRun>& runs, double error) {
  for (std::size_t i = 1; i < runs.size(); ++i) {
    const double e0 = runs[i - 1].error, e1 = runs[i].error, t0 = runs[i - 1].time_s, t1 = runs[i].time_s;
    if (e1 > error || !(e0 > error)) continue;
    return t0 * std::pow(t1 / t0, std::log(e0 / error) / std::log(e0 / e1));
  }
  return 0;
}

/// At the errors of independent samples, the time that mirrored pairs take for the same. Below the last measured error,
/// which pairs still reach, the variance of independent samples is extrapolated as 1 / time, which is exact for them.
std::vector<TimeSaved> time_saved_over_random(const std::vector<RenderRun>& random,
                                              const std::vector<RenderRun>& pairs) {
  std::vector<TimeSaved> rows;
  const double last_error = random.back().error, last_s = random.back().time_s;
  const double least = pairs.back().error;
  for (double error = random.front().error; error >= least; error /= std::sqrt(2)) {
    const bool extrapolated = error < last_error;
    const double random_s =
        extrapolated ? last_s * (last_error / error) * (last_error / error) : time_to(random, error);
    const double ours_s = time_to(pairs, error);
    if (ours_s > 0 && random_s > 0) rows.push_back({error, random_s / ours_s, extrapolated});
  }
  return rows;
}

/// A converged picture: the mean of two renders, and their difference.
struct Reference {
  Halves mean, apart;
};

Reference render_reference(const Patches& patches, int samples, const std::function<void(double)>& progress) {
  const Halves a = render(patches, Sampling::mirrored, 1, uniform(samples));
  progress(0.3);
  const Halves b = render(patches, Sampling::mirrored, 2, uniform(samples));
  progress(0.6);
  Reference reference{Halves(a.size()), Halves(a.size())};
  for (std::size_t i = 0; i < a.size(); ++i) reference.mean[i] = 0.5 * (a[i] + b[i]), reference.apart[i] = a[i] - b[i];
  return reference;
}

/// The four ways of spreading uniform sample counts, taking turns.
std::vector<RenderCurve> measure_uniform(const Patches& patches, const Reference& reference, int most_samples,
                                         const std::function<void(double)>& progress) {
  constexpr std::pair<const char*, Sampling> kSamplings[] = {{"random", Sampling::random},
                                                             {"padded", Sampling::padded},
                                                             {"joint", Sampling::joint},
                                                             {"mirrored pairs", Sampling::mirrored}};
  std::vector<RenderCurve> curves;
  for (const auto& sampling : kSamplings) curves.push_back({sampling.first, {}});
  for (int samples = 16; samples <= most_samples; samples *= 2) {
    for (std::size_t i = 0; i < curves.size(); ++i) {
      Halves halves;
      const double time_s = cpu_seconds([&] { halves = render(patches, kSamplings[i].second, 3, uniform(samples)); });
      curves[i].runs.push_back(run_of(samples, time_s, error_of(patches, halves, reference.mean, reference.apart)));
    }
    progress(0.6 + 0.3 * samples / most_samples);
  }
  return curves;
}

/// As many light samples as camera samples a photosite, or those that the options have.
enum class LightSamples { as_camera, given };

/// Points of light take part of the time: they are computed anew for each run.
RenderCurve measure_light_cache(const std::string& name, LightCacheOptions light, Patches& patches,
                                const Reference& reference, int most_samples,
                                LightSamples count = LightSamples::as_camera) {
  RenderCurve curve{name, {}};
  for (int samples = 16; samples <= most_samples; samples *= 2) {
    if (count == LightSamples::as_camera) light.light_samples = samples;
    if (light.light_spacing_px > 0) patches.world.light_cache = std::make_unique<LightCache>(light);
    Halves halves;
    const double time_s = cpu_seconds([&] { halves = render(patches, Sampling::mirrored, 3, uniform(samples)); });
    curve.runs.push_back(run_of(samples, time_s, error_of(patches, halves, reference.mean, reference.apart)));
  }
  patches.world.light_cache.reset();
  return curve;
}

/// Adaptive sampling, asked for errors that uniform sampling reaches, so that the two curves can be compared.
RenderCurve measure_adaptive(const Patches& patches, const Reference& reference,
                             const std::vector<RenderRun>& uniform_runs, const std::function<void(double)>& progress) {
  RenderCurve curve{"adaptive", {}};
  for (std::size_t i = 1; i < uniform_runs.size(); ++i) {
    Halves halves;
    std::vector<SampleMap> maps;
    const double time_s = cpu_seconds([&] {
      maps = adapt(patches, uniform_runs[i].error, 4);
      halves = render(patches, Sampling::mirrored, 5, maps);
    });
    double samples = 0;
    for (const SampleMap& map : maps) samples += map.total_samples();
    curve.runs.push_back(run_of(samples / (double{kPatches} * kPatchSide * kPatchSide), time_s,
                                error_of(patches, halves, reference.mean, reference.apart)));
    curve.runs.back().target = {uniform_runs[i].error, uniform_runs[i].samples};
    progress(0.9 + 0.1 * static_cast<double>(i + 1) / static_cast<double>(uniform_runs.size()));
  }
  return curve;
}

/// Light samples for half of the square error that is allowed, extrapolated from few. Returns the share of it that they
/// leave to camera samples.
double fit_light_cache(Patches& patches, double error) {
  constexpr int kPilotSamples = 16, kPilotPatches = 4;  // 256 photosites, a hundredth of them all
  double light = 0;
  for (int p = 0; p < kPilotPatches; ++p) {
    const CameraView& camera = patches.cameras[p * (kPatches / kPilotPatches + 1)];
    patches.world.light_cache = std::make_unique<LightCache>(LightCacheOptions{.light_samples = kPilotSamples});
    const RenderOptions options{kPilotSamples, patches.max_bounces, patches.first_seed + 6};
    light +=
        simulator::estimate_error(patches.world, camera, options, patches.sensor, kPilotSamples).light / kPilotPatches;
  }
  const int samples = simulator::light_samples_for(0.5 * error * error, light, kPilotSamples);
  patches.world.light_cache = std::make_unique<LightCache>(LightCacheOptions{.light_samples = samples});
  return 1 - simulator::light_error(light, kPilotSamples, samples) / (error * error);
}

/// The default renderer with adaptive sampling, asked for the same errors.
RenderCurve measure_adaptive_with_cache(Patches& patches, const Reference& reference,
                                        const std::vector<RenderRun>& uniform_runs) {
  RenderCurve curve{"light cache, adaptive", {}};
  for (const RenderRun& run : uniform_runs) {
    patches.world.light_cache.reset();
    patches.world.spare_light.clear();  // points that are there already would take no time
    Halves halves;
    std::vector<SampleMap> maps;
    const double time_s = cpu_seconds([&] {
      const double left = std::max(fit_light_cache(patches, run.error), 0.25);
      maps = adapt(patches, run.error * std::sqrt(left), 4);
      halves = render(patches, Sampling::mirrored, 5, maps);
    });
    double samples = 0;
    for (const SampleMap& map : maps) samples += map.total_samples();
    curve.runs.push_back(run_of(samples / (double{kPatches} * kPatchSide * kPatchSide), time_s,
                                error_of(patches, halves, reference.mean, reference.apart)));
    curve.runs.back().target = {run.error, run.samples};
  }
  patches.world.light_cache.reset();
  patches.world.spare_light.clear();
  return curve;
}

/// Of points so far apart, with what rendering the patches takes besides; sample counts do not change it.
double memory_of_points(const LightCacheOptions& light, Patches& patches) {
  constexpr int kSamples = 1;
  const double memory_mb = peak_mb([&] {
    if (light.light_spacing_px > 0) patches.world.light_cache = std::make_unique<LightCache>(light);
    render(patches, Sampling::mirrored, 3, uniform(kSamples));
  });
  patches.world.light_cache.reset();
  return memory_mb;
}

nlohmann::ordered_json to_json(const EmbreeShare& share) {
  nlohmann::ordered_json widths = nlohmann::ordered_json::object();
  for (int w = 0; w < 3; ++w)
    widths[std::to_string(EmbreeShare::kPacketWidths[w])] = share.embree_samples_per_core_s[w];
  return {{"rays_per_sample", share.rays_per_sample},
          {"samples_per_core_s", share.samples_per_core_s},
          {"embree_samples_per_core_s_by_packet", widths},
          {"share_of_embree", share.share_of_embree}};
}

nlohmann::ordered_json to_json(const RenderRun& run) {
  nlohmann::ordered_json json = {{"samples", run.samples}, {"time_s", run.time_s},
                                 {"error", run.error},     {"left", run.left},
                                 {"right", run.right},     {"left_minus_right", run.left_minus_right}};
  if (run.target) json["requested_error"] = run.target->error;
  return json;
}

/// A loaded scene, and patches of it, which refer to it: not to be copied.
struct PatchedScene {
  PatchedScene(const Simulation& s, std::uint64_t seed)
      : scene(simulator::load_scene(s)), patches{simulator::RenderScene(scene, {.light_spacing_px = 0}), {}, {}} {
    constexpr std::uint64_t kSeedsOfOne = 16;
    patches.first_seed = kSeedsOfOne * seed;
    const CameraView whole = simulator::place_camera(s, scene);
    patches.sensor = simulator::sensor_noise(s, whole.lens.lux_per_nit());
    patches.max_bounces = s.render.max_bounces;
    for (int p = 0; p < kPatches; ++p) patches.cameras.push_back(patch_camera(s, whole, p));
  }
  PatchedScene(const std::string& scene_file, std::uint64_t seed)
      : PatchedScene(simulator::read_simulation(read_json_file(scene_file), scene_file), seed) {}

  PatchedScene(const PatchedScene&) = delete;
  PatchedScene& operator=(const PatchedScene&) = delete;

  simulator::Scene scene;
  Patches patches;
};

}  // namespace

std::vector<RenderCurve> measure_light_points(const std::string& scene_file, const RenderBenchmarkOptions& options,
                                              const std::vector<double>& spacings_px) {
  PatchedScene made(scene_file, options.seed);
  const Reference reference = render_reference(made.patches, options.reference_samples, [](double) {});
  std::vector<RenderCurve> curves;
  for (const double spacing : spacings_px) {
    const std::string name = spacing > 0 ? fmt::format("points {:g} px apart", spacing) : "light of every sample";
    const LightCacheOptions light{.light_spacing_px = spacing};
    curves.push_back(measure_light_cache(name, light, made.patches, reference, options.most_samples));
    curves.back().memory_mb = memory_of_points(light, made.patches);
  }
  const std::string name = fmt::format("as by default, {} light samples", LightCacheOptions{}.light_samples);
  curves.push_back(measure_light_cache(name, {}, made.patches, reference, options.most_samples, LightSamples::given));
  curves.back().memory_mb = memory_of_points({}, made.patches);
  return curves;
}

SceneRenderBenchmark measure_rendering(const std::string& scene_file, const RenderBenchmarkOptions& options,
                                       const std::function<void(double)>& progress) {
  PatchedScene made(scene_file, options.seed);
  Patches& patches = made.patches;
  SceneRenderBenchmark result;
  result.scene = scene_file;
  result.embree = against_embree(patches);
  result.pair_over_undivided = pair_over_undivided(patches);
  const Reference reference = render_reference(patches, options.reference_samples, progress);
  result.curves = measure_uniform(patches, reference, options.most_samples, progress);
  const std::vector<RenderRun> random = result.curves.front().runs, pairs = result.curves.back().runs;
  result.curves.push_back(measure_adaptive(patches, reference, pairs, progress));
  result.curves.push_back(measure_light_cache("light cache", {}, patches, reference, options.most_samples));
  result.curves.push_back(measure_adaptive_with_cache(patches, reference, pairs));
  RenderCurve& floor = result.curves.emplace_back(RenderCurve{"Embree alone", pairs});
  for (RenderRun& run : floor.runs) run.time_s *= result.embree.share_of_embree;
  result.time_saved = time_saved_over_random(random, pairs);
  progress(1);
  return result;
}

nlohmann::ordered_json to_json(const SceneRenderBenchmark& benchmark) {
  nlohmann::ordered_json saved = nlohmann::ordered_json::array(), lines = nlohmann::ordered_json::object();
  for (const TimeSaved& row : benchmark.time_saved) {
    saved.push_back({{"error", row.error}, {"ratio", row.ratio}, {"random_extrapolated", row.extrapolated}});
  }
  for (const RenderCurve& curve : benchmark.curves) {
    for (const RenderRun& run : curve.runs) lines[curve.name].push_back(to_json(run));
  }
  return {{"scene", benchmark.scene},
          {"against_embree", to_json(benchmark.embree)},
          {"pair_over_undivided", benchmark.pair_over_undivided},
          {"time_saved_over_random", saved},
          {"lines", lines}};
}

}  // namespace dualpixel::evaluation
