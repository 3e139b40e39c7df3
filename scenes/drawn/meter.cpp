#include "scenes/drawn/meter.h"

#include <algorithm>
#include <cmath>

#include "scenes/procedural/random_stream.h"
#include "simulator/render/truth.h"
#include "simulator/render/views.h"
#include "simulator/simulate.h"

namespace dualpixel::scenes {
namespace {

using nlohmann::json;

constexpr int kDigits = 2;

/// To so many digits, so that the last bits of a rendering do not show.
double rounded(double value, int digits) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - (digits - 1));
  return std::round(value / unit) * unit;
}

/// A small sensor of the same field of view behind a thin lens, which is prepared at once.
json small_picture(const json& scene) {
  constexpr int kWidth = 128, kHeight = 96;
  json small = scene;
  const json& sensor = scene.at("sensor");
  const double width_mm = 1e-3 * sensor.at("width_px").get<double>() * sensor.at("pixel_pitch_um").get<double>();
  small["sensor"] = {{"width_px", kWidth}, {"height_px", kHeight}, {"pixel_pitch_um", 1e3 * width_mm / kWidth}};
  small["lens"] = {{"model", "thin"}, {"focal_length_mm", 4.3}, {"f_number", 1.8}};
  small["burst"] = {{"frames", 1}};
  small["render"]["max_bounces"] = std::min(scene.at("render").value("max_bounces", 0), 1);
  small["render"]["light_spacing_px"] = 0;  // points on a million leaves would take longer than the picture
  return small;
}

/// The exposure, lux seconds over nits seconds left out: seconds at ISO 100 that give the picture its key, less where
/// too much would be white.
double seconds_at_iso_100(const Image& picture, double signal_per_nit_s, const Shooting& shooting) {
  std::vector<double> brightest;
  double logs = 0;
  for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
    const float* p = &picture.data[3 * i];
    brightest.push_back(std::max({p[0], p[1], p[2], 1e-6f}) * signal_per_nit_s);
    logs += std::log(std::max(0.25 * p[0] + 0.6 * p[1] + 0.15 * p[2], 1e-6) * signal_per_nit_s);
  }
  const double by_key = shooting.key / std::exp(logs / static_cast<double>(picture.pixel_count()));
  const auto clipped = brightest.begin() + static_cast<std::ptrdiff_t>((1 - shooting.most_clipped) *
                                                                       static_cast<double>(brightest.size() - 1));
  std::nth_element(brightest.begin(), clipped, brightest.end());
  return std::min(by_key, 0.95 / *clipped);
}

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

void set_exposure(json& scene, double seconds, int digits) {
  const double time_s = seconds <= 1.0 / 60 ? seconds : std::min(std::sqrt(seconds / 60), 1.0 / 12);
  scene["exposure"]["time_s"] = rounded(std::clamp(time_s, 1e-6, 1.0 / 12), digits);
  scene["exposure"]["iso"] = rounded(std::clamp(100 * seconds / time_s, 100.0, 12800.0), digits);
}

void meter(json& scene, const std::string& scene_path, const Shooting& shooting, std::uint64_t seed, double stops) {
  constexpr double kFullWell_e = 6000, kElectrons = 4000, kDiaphragm = 1.8;  // of scene files' defaults; signal 1
  constexpr double kPi = 3.141592653589793;
  scene["camera"]["focus_distance_m"] = 1.0;
  const simulator::Simulation simulation = simulator::read_simulation(small_picture(scene), scene_path);
  const simulator::Scene loaded = simulator::load_scene(simulation);
  const simulator::RenderScene world(loaded, simulation.light);
  const simulator::CameraView camera = simulator::place_camera(simulation, loaded);
  simulator::RenderOptions options = simulation.render;
  options.samples_per_pixel = 32;
  options.ideal_aperture_scale = 0;
  const Image picture = simulator::undivided(simulator::render_views(world, camera, options));
  const double lux_per_nit = kPi / 4 / (kDiaphragm * kDiaphragm);
  const double seconds = seconds_at_iso_100(picture, lux_per_nit * kElectrons / kFullWell_e, shooting);
  set_exposure(scene, std::exp2(stops) * seconds, kDigits);
  const double focus_m =
      shooting.focus_m ? *shooting.focus_m : focus_on_something(simulator::trace_truth(world, camera), seed);
  scene["camera"]["focus_distance_m"] = rounded(focus_m, kDigits);
}

}  // namespace dualpixel::scenes
