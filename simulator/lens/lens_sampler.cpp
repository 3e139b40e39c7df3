#include "simulator/lens/lens_sampler.h"

#include <type_traits>

#include "simulator/sampling/sobol.h"

namespace dualpixel::simulator {
namespace {

LensModelSampler sampler_of(const Lens& lens, const SensorGrid& sensor) {
  return std::visit(
      [&](const auto& model) -> LensModelSampler {
        return typename std::decay_t<decltype(model)>::Sampler(model, lens.thin, sensor);
      },
      lens.model);
}

}  // namespace

LensSampler::LensSampler(const Lens& lens, const SensorGrid& sensor)
    : lens_(lens),
      sensor_(sensor),
      ideal_(lens.thin),
      split_(lens.split, lens.thin.rim_slope()),
      model_(sampler_of(lens, sensor)),
      has_color_(std::visit([](const auto& model) { return model.has_color(); }, model_)) {}

PixelFrame LensSampler::frame(int x, int y) const {
  PixelFrame f;
  const glm::dvec2 at_m = sensor_.middle_m(x, y);
  const double r = glm::length(at_m);
  f.x_m = static_cast<float>(at_m.x);
  f.y_m = static_cast<float>(at_m.y);
  f.pitch_m = static_cast<float>(sensor_.pixel_pitch_m);
  f.radial_x = r > 0 ? static_cast<float>(at_m.x / r) : 0.0f;
  f.radial_y = r > 0 ? static_cast<float>(at_m.y / r) : 1.0f;
  f.radius_m = r;
  return f;
}

double LensSampler::lux_per_nit() const {
  return std::visit([](const auto& model) { return model.lux_per_nit(); }, model_);
}

glm::dvec2 LensSampler::chief_slope(double x_m, double y_m) const {
  const glm::dvec2 at(x_m, y_m);
  return at * std::visit([&](const auto& model) { return model.chief_slope_per_m(glm::length(at)); }, model_);
}

void LensSampler::sample(int x, int y, int color, const float s[4][kPacket], LensPacket& out) const {
  const PixelFrame f = frame(x, y);
  PupilPacket pupil;
  std::visit([&](const auto& model) { model.sample(f, color, s, out, pupil); }, model_);
  split_.weigh(f, pupil, out);
}

void LensSampler::sample_ideal(int x, int y, const float s[4][kPacket], float aperture_scale, LensPacket& out) const {
  const PixelFrame f = frame(x, y);
  const double step_m = 0.5 * sensor_.pixel_pitch_m;
  const glm::dvec2 center = chief_slope(f.x_m, f.y_m);
  const glm::dvec2 across = (chief_slope(f.x_m + step_m, f.y_m) - chief_slope(f.x_m - step_m, f.y_m));
  const glm::dvec2 down = (chief_slope(f.x_m, f.y_m + step_m) - chief_slope(f.x_m, f.y_m - step_m));
  alignas(64) float p[2][kPacket];
  concentric_disc(s[2], s[3], p[0], p[1]);
  const glm::vec2 c(center), a(across), d(down);
  const float radius = ideal_.radius_m * aperture_scale;
  for (int i = 0; i < kPacket; ++i) {
    const float u = s[0][i] - 0.5f, v = s[1][i] - 0.5f;
    out.origin_x[i] = p[0][i] * radius;
    out.origin_y[i] = p[1][i] * radius;
    out.slope_x[i] = c.x + u * a.x + v * d.x - out.origin_x[i] * ideal_.inverse_focus;
    out.slope_y[i] = c.y + u * a.y + v * d.y - out.origin_y[i] * ideal_.inverse_focus;
    out.left[i] = out.right[i] = 0.5f;
  }
}

}  // namespace dualpixel::simulator
