#include "scenes/drawn/meter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/drawn/free_view.h"
#include "scenes/procedural/random_stream.h"
#include "simulator/render/truth.h"
#include "simulator/render/views.h"
#include "simulator/simulate.h"

namespace dualpixel::scenes {
namespace {

using nlohmann::json;

constexpr int kDigits = 2;
/// Of scene files' defaults at ISO 100: lux per nit at f/1.8, electrons per lux second over the full well.
constexpr double kSignalPerNitSecond = std::numbers::pi / 4 / (1.8 * 1.8) * 4000 / 6000;
constexpr double kLongest_s = 1.0 / 12, kShortest_s = 1e-6, kHighestIso = 12800;
constexpr double kMost_s = kLongest_s * kHighestIso / 100;  // at ISO 100

/// To so many digits, so that the last bits of a rendering do not show.
double rounded(double value, int digits) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - (digits - 1));
  return std::round(value / unit) * unit;
}

/// The exposure, lux seconds over nits seconds left out: seconds at ISO 100 that give the picture its key, people in it
/// as much as all the rest, less where too much would be white.
double seconds_at_iso_100(const Image& picture, const Image& person_mask, double signal_per_nit_s,
                          const Shooting& shooting) {
  std::vector<double> brightest;
  double logs[2] = {0, 0}, counts[2] = {0, 0};  // of the rest, of people
  for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
    const float* p = &picture.data[3 * i];
    brightest.push_back(std::max({p[0], p[1], p[2], 1e-6f}) * signal_per_nit_s);
    const int part = person_mask.data[i] > 0.5f ? 1 : 0;
    logs[part] += std::log(std::max(0.25 * p[0] + 0.6 * p[1] + 0.15 * p[2], 1e-6) * signal_per_nit_s);
    ++counts[part];
  }
  const double people = counts[1] > 0 && counts[0] > 0 ? 0.5 : counts[1] > 0 ? 1 : 0;
  const double log_mean =
      (1 - people) * logs[0] / std::max(counts[0], 1.0) + people * logs[1] / std::max(counts[1], 1.0);
  const double by_key = shooting.key / std::exp(log_mean);
  const auto clipped = brightest.begin() + static_cast<std::ptrdiff_t>((1 - shooting.most_clipped) *
                                                                       static_cast<double>(brightest.size() - 1));
  std::nth_element(brightest.begin(), clipped, brightest.end());
  return std::min(by_key, 0.95 / *clipped);
}

/// Cameras take the darkest nights with less light than asked for; up to a stop of it nobody is told.
double possible_at_night(double seconds) { return seconds > 2 * kMost_s ? seconds : std::min(seconds, kMost_s); }

/// Depth of a pixel of the middle half of the picture.
double focus_on_something(const Truth& truth, std::uint64_t seed) {
  RandomStream rng(seed, false);
  const int width = truth.depth_m.width, height = truth.depth_m.height;
  for (int attempt = 0; attempt < 64; ++attempt) {
    const int x = width / 4 + rng.below(width / 2), y = height / 4 + rng.below(height / 2);
    const std::size_t i = static_cast<std::size_t>(y) * width + x;
    if (truth.valid.data[i] > 0) return std::clamp<double>(truth.depth_m.data[i], 0.08, 1000);
  }
  return 10;
}

}  // namespace

json small_picture(const json& scene, int width_px) {
  json small = scene;
  const json& sensor = scene.at("sensor");
  const double width_mm = 1e-3 * sensor.at("width_px").get<double>() * sensor.at("pixel_pitch_um").get<double>();
  small["sensor"] = {
      {"width_px", width_px}, {"height_px", width_px / 4 * 3}, {"pixel_pitch_um", 1e3 * width_mm / width_px}};
  small["lens"] = {{"model", "thin"}, {"focal_length_mm", 4.3}, {"f_number", 1.8}};
  small["burst"] = {{"frames", 1}};
  small["render"]["max_bounces"] = std::min(scene.at("render").value("max_bounces", 0), 1);
  small["render"]["light_spacing_px"] = 0;  // points on a million leaves would take longer than the picture
  return small;
}

double signal_per_nit(const json& scene) {
  const json& exposure = scene.at("exposure");
  return kSignalPerNitSecond * exposure.at("time_s").get<double>() * exposure.at("iso").get<double>() / 100;
}

std::string to_text(const MissedExposure& missed) {
  const std::string asked =
      std::isinf(missed.asked_s)
          ? "so much of the picture is black, or white is so low below ISO 100, that no exposure gives the mean "
            "that is asked for"
          : fmt::format("{:.3g} s at ISO 100 are asked for", missed.asked_s);
  return fmt::format("exposure: {}; the limit is {:.3g} s, taken are {:.3g} s", asked, missed.limit_s, missed.taken_s);
}

nlohmann::ordered_json to_json(const MissedExposure& missed) {
  nlohmann::ordered_json json = {{"asked_s", missed.asked_s}, {"limit_s", missed.limit_s}, {"taken_s", missed.taken_s}};
  if (std::isinf(missed.asked_s)) json["asked_s"] = "inf";
  return json;
}

std::optional<MissedExposure> set_exposure(json& scene, double seconds, int digits) {
  const double time_s = seconds <= 1.0 / 60 ? seconds : std::min(std::sqrt(seconds / 60), kLongest_s);
  scene["exposure"]["time_s"] = rounded(std::clamp(time_s, kShortest_s, kLongest_s), digits);
  scene["exposure"]["iso"] =
      std::min(rounded(std::clamp(100 * seconds / time_s, 100.0, kHighestIso), digits), kHighestIso);
  if (seconds >= kShortest_s && seconds <= kMost_s) return {};
  const json& exposure = scene["exposure"];
  return MissedExposure{seconds, std::clamp(seconds, kShortest_s, kMost_s),
                        exposure["time_s"].get<double>() * exposure["iso"].get<double>() / 100};
}

std::vector<std::string> meter(json& scene, const std::string& scene_path, const Shooting& shooting, std::uint64_t seed,
                               double stops) {
  scene["camera"]["focus_distance_m"] = 1.0;
  const simulator::Simulation simulation = simulator::read_simulation(small_picture(scene, 128), scene_path);
  const simulator::Scene loaded = simulator::load_scene(simulation, 0, /*decode_textures=*/false);
  const simulator::RenderScene world(loaded, simulation.light);
  const simulator::CameraView camera = simulator::place_camera(simulation, loaded);
  simulator::RenderOptions options = simulation.render;
  options.samples_per_pixel = 32;
  options.ideal_aperture_scale = 0;
  const Image picture = simulator::undivided(simulator::render_views(world, camera, options));
  const Truth truth = simulator::trace_truth(world, camera);
  const double seconds =
      std::exp2(stops) * seconds_at_iso_100(picture, truth.person_mask, kSignalPerNitSecond, shooting);
  const std::optional<MissedExposure> missed = set_exposure(scene, possible_at_night(seconds), kDigits);
  const double focus_m = shooting.focus_m ? *shooting.focus_m : focus_on_something(truth, seed);
  scene["camera"]["focus_distance_m"] = rounded(focus_m, kDigits);

  std::vector<std::string> faults;
  if (std::string fault = view_fault({world, camera, truth, picture}, shooting); !fault.empty())
    faults.push_back(std::move(fault));
  if (missed) faults.push_back(to_text(*missed));
  return faults;
}

}  // namespace dualpixel::scenes
