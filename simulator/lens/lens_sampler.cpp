#include "simulator/lens/lens_sampler.h"

#include <optional>
#include <type_traits>
#include <utility>

#include "simulator/lens/diffraction.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/lens/models.h"
#include "simulator/lens/prescription/prescription.h"
#include "simulator/lens/split/split_sampler.h"
#include "simulator/sampling/packet.h"
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

/// What all samples of photosite (x, y) share.
PixelFrame pixel_frame(const SensorGrid& sensor, int x, int y) {
  PixelFrame f;
  const glm::dvec2 at_m = sensor.middle_m(x, y);
  const double r = glm::length(at_m);
  f.x_m = static_cast<float>(at_m.x);
  f.y_m = static_cast<float>(at_m.y);
  f.pitch_m = static_cast<float>(sensor.pixel_pitch_m);
  f.radial_x = r > 0 ? static_cast<float>(at_m.x / r) : 0.0f;
  f.radial_y = r > 0 ? static_cast<float>(at_m.y / r) : 1.0f;
  f.radius_m = r;
  return f;
}

}  // namespace

static_assert(LensSampler::kRays == kPacket);

struct LensSampler::Prepared {
  Lens lens;
  SensorGrid sensor;
  SampledThinLens ideal;
  SplitSampler split;
  LensModelSampler model;
  std::optional<Diffraction> diffraction;
};

LensSampler::LensSampler(const Lens& lens, const SensorGrid& sensor)
    : prepared_(std::make_shared<const Prepared>(Prepared{
          lens, sensor, SampledThinLens(lens.thin), SplitSampler(lens.split, lens.thin.rim_slope()),
          sampler_of(lens, sensor), lens.diffraction ? std::optional<Diffraction>(lens.thin) : std::nullopt})) {}

LensSampler::LensSampler(std::shared_ptr<const Prepared> prepared) : prepared_(std::move(prepared)) {}

LensSampler LensSampler::with_split(const SplitPixel& split) const {
  Prepared other = *prepared_;
  other.lens.split = split;
  other.split = SplitSampler(split, other.lens.thin.rim_slope());
  return LensSampler(std::make_shared<const Prepared>(std::move(other)));
}

LensSampler LensSampler::over(const SensorGrid& part) const {
  Prepared other = *prepared_;
  other.sensor = part;
  return LensSampler(std::make_shared<const Prepared>(std::move(other)));
}

const Lens& LensSampler::lens() const { return prepared_->lens; }
const SensorGrid& LensSampler::sensor() const { return prepared_->sensor; }

bool LensSampler::has_color() const {
  return std::visit([](const auto& model) { return model.has_color(); }, prepared_->model);
}

double LensSampler::lux_per_nit() const {
  return std::visit([](const auto& model) { return model.lux_per_nit(); }, prepared_->model);
}

glm::dvec2 LensSampler::chief_slope(double x_m, double y_m) const {
  const glm::dvec2 at(x_m, y_m);
  return at * std::visit([&](const auto& model) { return model.chief_slope_per_m(glm::length(at)); }, prepared_->model);
}

void LensSampler::sample(int x, int y, int color, const float s[4][kRays], LensPacket& out, std::uint32_t draw) const {
  PixelFrame f = pixel_frame(sensor(), x, y);
  f.draw = draw;
  PupilPacket pupil;
  std::visit([&](const auto& model) { model.sample(f, color, s, out, pupil); }, prepared_->model);
  prepared_->split.weigh(f, pupil, out);
}

bool LensSampler::diffracts() const { return prepared_->diffraction.has_value(); }

void LensSampler::bend(int color, const float u[kRays], const float v[kRays], LensPacket& rays) const {
  const Prescription* prescription = prescription_of(lens());
  const bool stated = prescription && prescription->has_color();
  const double wavelength_m = stated ? 1e-9 * prescription->wavelengths_nm[color] : kFilterWavelengths_m[color];
  prepared_->diffraction->bend(wavelength_m, u, v, rays);
}

void LensSampler::sample_ideal(int x, int y, const float s[4][kRays], float aperture_scale, LensPacket& out) const {
  const PixelFrame f = pixel_frame(sensor(), x, y);
  const double step_m = 0.5 * sensor().pixel_pitch_m;
  const glm::dvec2 center = chief_slope(f.x_m, f.y_m);
  const glm::dvec2 across = (chief_slope(f.x_m + step_m, f.y_m) - chief_slope(f.x_m - step_m, f.y_m));
  const glm::dvec2 down = (chief_slope(f.x_m, f.y_m + step_m) - chief_slope(f.x_m, f.y_m - step_m));
  alignas(64) float p[2][kPacket];
  concentric_disc(s[2], s[3], p[0], p[1]);
  const glm::vec2 c(center), a(across), d(down);
  const float radius = prepared_->ideal.radius_m * aperture_scale;
  for (int i = 0; i < kPacket; ++i) {
    const float u = s[0][i] - 0.5f, v = s[1][i] - 0.5f;
    out.origin_x[i] = p[0][i] * radius;
    out.origin_y[i] = p[1][i] * radius;
    out.slope_x[i] = c.x + u * a.x + v * d.x - out.origin_x[i] * prepared_->ideal.inverse_focus;
    out.slope_y[i] = c.y + u * a.y + v * d.y - out.origin_y[i] * prepared_->ideal.inverse_focus;
    out.left[i] = out.right[i] = 0.5f;
  }
}

double lit_share(const LensSampler& lens) {
  constexpr int kPlaces = 64, kPackets = 16;  // along each side; at each place
  constexpr float kLit = 0.01f;
  const SensorGrid& sensor = lens.sensor();
  alignas(64) float s[4][kPacket];
  LensPacket rays;
  int lit = 0;
  for (int i = 0; i < kPlaces * kPlaces; ++i) {
    float light = 0;
    for (int k = 0; k < kPackets; ++k) {
      joint_samples(k * kPacket, 0, s);
      lens.sample((2 * (i % kPlaces) + 1) * sensor.width_px / (2 * kPlaces),
                  (2 * (i / kPlaces) + 1) * sensor.height_px / (2 * kPlaces), 1, s, rays);
      for (int j = 0; j < kPacket; ++j) light += rays.left[j] + rays.right[j];
    }
    lit += light >= kLit * kPackets * kPacket;
  }
  return static_cast<double>(lit) / (kPlaces * kPlaces);
}

}  // namespace dualpixel::simulator
