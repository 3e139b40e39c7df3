#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "capture/timing.h"
#include "evaluation/experiments/render_scaling.h"
#include "evaluation/report/report_assets.h"
#include "evaluation/report/report_page.h"
#include "evaluation/report/svg_plot.h"
#include "simulator/lens/sensor_grid.h"
#include "simulator/render/adaptive.h"
#include "simulator/sampling/hash.h"
#include "simulator/simulate.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

using simulator::CameraView;
using simulator::ErrorTarget;
using simulator::LoggedRays;
using simulator::Pilot;
using simulator::RayLog;
using simulator::RenderOptions;
using simulator::SampleMap;
using simulator::Sampling;
using simulator::Simulation;

struct BenchRenderOptions {
  std::vector<std::string> scenes = {"build/release/scenes/portrait.json", "build/release/scenes/slanted_planes.json",
                                     "build/release/scenes/occlusion_edges.json",
                                     "build/release/scenes/calibration_target.json"};
  std::string output;
  int reference_samples = 4096;
  int most_samples = 1024;
  double most_triangles = 1e7;
};

// What is rendered of a scene: patches spread over the frame, in the detail of the full picture.
constexpr int kPatchColumns = 6, kPatchRows = 4, kPatches = kPatchColumns * kPatchRows;
constexpr int kPatchSide = 32;  ///< two tiles of a SampleMap

struct Patches {
  simulator::RenderScene world;
  std::vector<CameraView> cameras;
  ErrorTarget sensor;
  int max_bounces;
};

/// Both halves of the photosites of all patches, in their own filter's colour, nits: left, then right of each.
using Halves = std::vector<double>;

CameraView patch_camera(const Simulation& s, const CameraView& whole, int index) {
  simulator::SensorGrid grid = whole.lens.sensor();
  const auto start = [](int i, int n, int size) {
    return (static_cast<int>((i + 0.5) / n * size) - kPatchSide / 2) & ~1;  // even: the mosaic's colours stay
  };
  grid.principal_point_px -= glm::dvec2(start(index % kPatchColumns, kPatchColumns, grid.width_px),
                                        start(index / kPatchColumns, kPatchRows, grid.height_px));
  grid.width_px = grid.height_px = kPatchSide;
  return {whole.world_from_camera, simulator::LensSampler(s.lens, grid)};
}

Halves render(const Patches& patches, Sampling sampling, std::uint64_t seed, const std::vector<SampleMap>& maps) {
  Halves halves(std::size_t{kPatches} * kPatchSide * kPatchSide * 2);
  tbb::parallel_for(0, kPatches, [&](int p) {
    const RenderOptions options{0, patches.max_bounces, simulator::hash(seed, p), {}, sampling};
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

/// RMS over the patches, each photosite's over its sensor noise (of one half; of both for their difference).
struct Error {
  double left = 0, right = 0, difference = 0;
  double halves() const { return std::sqrt(0.5 * (left * left + right * right)); }
};

/// What `reference` makes of its own error is taken off: it is the mean of two renders, `apart` their difference.
Error error_of(const Patches& patches, const Halves& halves, const Halves& reference, const Halves& apart) {
  double left = 0, right = 0, difference = 0;
  const std::size_t count = halves.size() / 2;
  for (std::size_t i = 0; i < count; ++i) {
    const int c = simulator::cfa_color(static_cast<int>(i) % kPatchSide, static_cast<int>(i) / kPatchSide % kPatchSide);
    const double nits = 0.5 * (reference[2 * i] + reference[2 * i + 1]);
    const double noise2 = patches.sensor.per_nit[c] * nits + patches.sensor.constant[c];
    const double l = halves[2 * i] - reference[2 * i], r = halves[2 * i + 1] - reference[2 * i + 1];
    const double own_l = 0.5 * apart[2 * i], own_r = 0.5 * apart[2 * i + 1];
    left += (l * l - own_l * own_l) / noise2;
    right += (r * r - own_r * own_r) / noise2;
    difference += ((l - r) * (l - r) - (own_l - own_r) * (own_l - own_r)) / (2 * noise2);
  }
  const auto rms = [&](double sum) { return std::sqrt(std::max(sum, 0.0) / static_cast<double>(count)); };
  return {rms(left), rms(right), rms(difference)};
}

/// One map for each patch, from a pilot over all of them; its time is the caller's to count.
std::vector<SampleMap> adapt(const Patches& patches, double error, std::uint64_t seed) {
  ErrorTarget target = patches.sensor;
  for (int c = 0; c < 3; ++c) target.per_nit[c] *= error * error, target.constant[c] *= error * error;
  std::vector<Pilot> pilots(kPatches);
  tbb::parallel_for(0, kPatches, [&](int p) {
    const RenderOptions options{0, patches.max_bounces, simulator::hash(seed, p), {}, Sampling::mirrored};
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

/// Time at which the line through `rows` comes down to `error`, straight between them on log axes; 0: never.
double time_to(const nlohmann::ordered_json& rows, double error) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double e0 = rows[i - 1]["error"], e1 = rows[i]["error"], t0 = rows[i - 1]["time_s"], t1 = rows[i]["time_s"];
    if (e1 > error || !(e0 > error)) continue;
    return t0 * std::pow(t1 / t0, std::log(e0 / error) / std::log(e0 / e1));
  }
  return 0;
}

nlohmann::ordered_json row(double samples, double time_s, const Error& e) {
  return {{"samples", samples}, {"time_s", time_s}, {"error", e.halves()},
          {"left", e.left},     {"right", e.right}, {"left_minus_right", e.difference}};
}

/// The renderer and Embree alone on one thread, on the same rays, turn by turn.
nlohmann::ordered_json against_embree(const Patches& patches) {
  constexpr int kEvery = 4, kSamples = 64;
  const auto render_some = [&](RayLog* log) {
    for (int p = 0; p < kPatches; p += kEvery) {
      for (int i = 0; i < kPatchSide * kPatchSide; ++i) {
        simulator::render_pixel(patches.world, patches.cameras[p], {patches.max_bounces, {}, Sampling::mirrored, log},
                                i % kPatchSide, i / kPatchSide, kSamples, simulator::hash(7, p, i));
      }
    }
  };
  RayLog log;
  render_some(&log);
  constexpr int kRendered = kPatches / kEvery;
  const double samples = static_cast<double>(kSamples) * kPatchSide * kPatchSide * kRendered;
  double rays = 0;
  for (const LoggedRays& packet : log) rays -= std::accumulate(packet.active, packet.active + simulator::kPacket, 0);
  constexpr int kWidths[] = {1, 8, 16};
  double render_s = 1e30, replay_s[3] = {1e30, 1e30, 1e30};
  for (int repeat = 0; repeat < 5; ++repeat) {
    render_s = std::min(render_s, cpu_seconds([&] { render_some(nullptr); }));
    for (int w = 0; w < 3; ++w) {
      replay_s[w] =
          std::min(replay_s[w], cpu_seconds([&] { simulator::replay(patches.world.intersector, log, kWidths[w]); }));
    }
  }
  nlohmann::ordered_json widths = nlohmann::ordered_json::object();
  for (int w = 0; w < 3; ++w) widths[std::to_string(kWidths[w])] = samples / replay_s[w];
  return {{"rays_per_sample", rays / samples},
          {"samples_per_core_s", samples / render_s},
          {"embree_samples_per_core_s_by_packet", widths},
          {"share_of_embree", *std::min_element(replay_s, replay_s + 3) / render_s}};
}

/// Both views over a single one that no pixel is split for: the ideal lens, of which render_pixel keeps one sum. The
/// scene's own lens is taken for a thin one, so that the split alone tells the two apart.
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

/// At the errors of independent samples, the time that mirrored pairs take for the same. Beyond the last row, where
/// pairs reach on, the variance of independent samples goes on as 1 / time, which is exact for them.
nlohmann::ordered_json time_saved_over_random(const nlohmann::ordered_json& random,
                                              const nlohmann::ordered_json& pairs) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  const double last_error = random.back()["error"], last_s = random.back()["time_s"];
  const double least = pairs.back()["error"];
  for (double error = random.front()["error"]; error >= least; error /= std::sqrt(2)) {
    const bool drawn_on = error < last_error;
    const double random_s = drawn_on ? last_s * (last_error / error) * (last_error / error) : time_to(random, error);
    const double ours_s = time_to(pairs, error);
    if (ours_s > 0 && random_s > 0) {
      rows.push_back({{"error", error}, {"ratio", random_s / ours_s}, {"random_drawn_on", drawn_on}});
    }
  }
  return rows;
}

nlohmann::ordered_json bench_scene(const std::string& path, const BenchRenderOptions& options, Progress& progress) {
  const Simulation s = simulator::read_simulation(read_json_file(path), path);
  const simulator::Scene scene = simulator::load_scene(s);
  const CameraView whole = simulator::place_camera(s, scene);
  Patches patches{
      simulator::RenderScene(scene), {}, simulator::sensor_noise(s, whole.lens.lux_per_nit()), s.render.max_bounces};
  for (int p = 0; p < kPatches; ++p) patches.cameras.push_back(patch_camera(s, whole, p));

  nlohmann::ordered_json result{{"scene", path},
                                {"against_embree", against_embree(patches)},
                                {"pair_over_undivided", pair_over_undivided(patches)}};
  const Halves a = render(patches, Sampling::mirrored, 1, uniform(options.reference_samples));
  progress(0.3);
  const Halves b = render(patches, Sampling::mirrored, 2, uniform(options.reference_samples));
  progress(0.6);
  Halves reference(a.size()), apart(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) reference[i] = 0.5 * (a[i] + b[i]), apart[i] = a[i] - b[i];

  constexpr std::pair<const char*, Sampling> kSamplings[] = {{"random", Sampling::random},
                                                             {"padded", Sampling::padded},
                                                             {"joint", Sampling::joint},
                                                             {"mirrored pairs", Sampling::mirrored}};
  nlohmann::ordered_json lines = nlohmann::ordered_json::object();
  for (int samples = 16; samples <= options.most_samples; samples *= 2) {
    for (const auto& sampling : kSamplings) {
      Halves halves;
      const double time_s = cpu_seconds([&] { halves = render(patches, sampling.second, 3, uniform(samples)); });
      lines[sampling.first].push_back(row(samples, time_s, error_of(patches, halves, reference, apart)));
    }
    progress(0.6 + 0.3 * samples / options.most_samples);
  }
  // Errors that uniform sampling reaches, so that the two lines can be compared.
  const nlohmann::ordered_json uniform_rows = lines["mirrored pairs"];
  for (std::size_t i = 1; i < uniform_rows.size(); ++i) {
    Halves halves;
    std::vector<SampleMap> maps;
    const double time_s = cpu_seconds([&] {
      maps = adapt(patches, uniform_rows[i]["error"], 4);
      halves = render(patches, Sampling::mirrored, 5, maps);
    });
    double samples = 0;
    for (const SampleMap& map : maps) samples += map.total_samples();
    const Error error = error_of(patches, halves, reference, apart);
    auto& rows = lines["adaptive"];
    rows.push_back(row(samples / (double{kPatches} * kPatchSide * kPatchSide), time_s, error));
    rows.back()["error_asked_for"] = uniform_rows[i]["error"];
    progress(0.9 + 0.1 * static_cast<double>(i + 1) / static_cast<double>(uniform_rows.size()));
  }
  // Embree alone: the errors of mirrored pairs, in the time that their rays take by themselves.
  nlohmann::ordered_json floor = uniform_rows;
  for (auto& r : floor) {
    r["time_s"] = r["time_s"].get<double>() * result["against_embree"]["share_of_embree"].get<double>();
  }
  lines["Embree alone"] = floor;
  result["time_saved_over_random"] = time_saved_over_random(lines["random"], uniform_rows);
  result["lines"] = lines;
  progress(1);
  return result;
}

/// Of all rows that are not Embree's alone: those that nothing else beats in both time and error.
evaluation::Series pareto_front(const nlohmann::ordered_json& lines) {
  std::vector<std::pair<double, double>> all;
  for (const auto& [name, rows] : lines.items()) {
    if (name == "Embree alone") continue;
    for (const auto& r : rows) all.emplace_back(r["time_s"], r["error"]);
  }
  std::sort(all.begin(), all.end());
  evaluation::Series front{"Pareto front", {}, false, true};
  for (const auto& point : all) {
    if (front.points.empty() || point.second < front.points.back().second) front.points.push_back(point);
  }
  return front;
}

evaluation::Plot saved_plot(const nlohmann::ordered_json& saved) {
  evaluation::Plot plot;
  plot.title = "Time of independent samples over that of mirrored pairs";
  plot.x_label = "error over the sensor's noise";
  plot.y_label = "ratio";
  plot.log_x = true;
  evaluation::Series measured{"measured", {}, false, false},
      drawn_on{"independent samples drawn on as 1/N", {}, true, false};
  for (const auto& row : saved) {
    const std::pair<double, double> point{row["error"], row["ratio"]};
    const bool beyond = row["random_drawn_on"].get<bool>();
    if (!beyond) measured.points.push_back(point);
    if (beyond && drawn_on.points.empty() && !measured.points.empty()) {
      drawn_on.points.push_back(measured.points.back());
    }
    if (beyond) drawn_on.points.push_back(point);
  }
  plot.series = {measured, drawn_on};
  return plot;
}

std::string to_page(const nlohmann::ordered_json& results, const nlohmann::ordered_json& scaling) {
  std::string body =
      "<h1>Rendering: error against time</h1><p>Error: RMS of both views' photosites against a converged reference, "
      "over the noise that the scene's sensor adds to them; of 24 patches spread over the frame. Time: CPU time of all "
      "cores.</p>";
  for (const auto& result : results) {
    const auto& embree = result["against_embree"];
    body += fmt::format(
        "<h2>{}</h2><p>{:.1f} M samples a core-second with {:.2f} rays each; Embree alone, on the same rays, {:.1f} M "
        "in packets of 16, {:.1f} M of 8, {:.1f} M one by one: {:.0f} % of the time is Embree's.</p><div "
        "class=\"plots\">",
        evaluation::escape_html(printable(result["scene"].get<std::string>())),
        embree["samples_per_core_s"].get<double>() / 1e6, embree["rays_per_sample"].get<double>(),
        embree["embree_samples_per_core_s_by_packet"]["16"].get<double>() / 1e6,
        embree["embree_samples_per_core_s_by_packet"]["8"].get<double>() / 1e6,
        embree["embree_samples_per_core_s_by_packet"]["1"].get<double>() / 1e6,
        100 * embree["share_of_embree"].get<double>());
    body.insert(body.rfind("</p>"), fmt::format(" Both views take {:.3f} times as long as a single undivided one.",
                                                result["pair_over_undivided"].get<double>()));
    for (const auto& [title, key] : {std::pair{"Left and right", "error"}, {"Left minus right", "left_minus_right"}}) {
      evaluation::Plot plot;
      plot.title = title;
      plot.x_label = "CPU time, s";
      plot.y_label = "error over the sensor's noise";
      plot.log_x = plot.log_y = true;
      for (const auto& [name, rows] : result["lines"].items()) {
        evaluation::Series line{name, {}, name == "Embree alone", false};
        for (const auto& r : rows) line.points.emplace_back(r["time_s"], r[key]);
        plot.series.push_back(line);
      }
      if (std::string(key) == "error") plot.series.push_back(pareto_front(result["lines"]));
      body += evaluation::svg_plot(plot);
    }
    body += evaluation::svg_plot(saved_plot(result["time_saved_over_random"])) + "</div>";
  }
  body += evaluation::scaling_section(scaling);
  return evaluation::html_page("Rendering: error against time",
                               std::string(evaluation::kReportStyle) + evaluation::kPlotStyle, body);
}

void run(const BenchRenderOptions& options) {
  NewFolder folder(options.output, "render.json");  // what cannot be written is refused first
  nlohmann::ordered_json results = nlohmann::ordered_json::array();
  for (const std::string& scene : options.scenes) {
    Progress progress(scene);
    results.push_back(bench_scene(scene, options, progress));
  }
  Progress growth("growth");
  const nlohmann::ordered_json scaling =
      evaluation::measure_scaling(options.most_triangles, [&](double fraction) { growth(fraction); });
  write_file(folder.path() + "/render.html", to_page(results, scaling));
  write_file(folder.path() + "/render.json",
             nlohmann::ordered_json{{"scenes", results}, {"growth", scaling}}.dump(2) + "\n");
  folder.commit();
}

}  // namespace

void add_bench_render(CLI::App& bench) {
  auto options = std::make_shared<BenchRenderOptions>();
  CLI::App* command = bench.add_subcommand("render", "Chart the renderer's error against its time, and Embree's floor");
  command->add_option("scene", options->scenes, "Scene JSON files (default: the shipped ones)")
      ->type_name("SCENE.json");
  command->add_option("-o,--output", options->output, "Folder for render.json and render.html")
      ->type_name("DIR")
      ->required();
  command->add_option("--reference-samples", options->reference_samples, "Of each of the reference's two renders")
      ->check(CLI::Range(16, 65536))
      ->capture_default_str();
  command->add_option("--most-samples", options->most_samples, "Of the charted renders")
      ->check(CLI::Range(32, 65536))
      ->capture_default_str();
  command->add_option("--most-triangles", options->most_triangles, "Of the chart of growth")
      ->check(CLI::Range(1e4, 1e8))
      ->capture_default_str();
  command->footer("Example:\n  dualpixel bench render build/release/scenes/portrait.json -o bench");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
