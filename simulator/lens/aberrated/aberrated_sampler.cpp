#include "simulator/lens/aberrated/aberrated_sampler.h"

#include <algorithm>
#include <cmath>

#include "simulator/sampling/sobol.h"

namespace dualpixel::simulator {

AberratedSampler::AberratedSampler(const Aberrations& aberrations, const ThinLens& thin, const SensorGrid&)
    : aberrations_(aberrations),
      thin_(thin),
      sampled_(thin),
      field_radius_m_(field_radius_m(aberrations.image_radius_mm, thin)) {}

AberratedSampler::Local AberratedSampler::local_at(const PixelFrame& f, int color) const {
  const Aberrations& a = aberrations_;
  const double field = f.radius_m / field_radius_m_;
  const auto field2 = static_cast<float>(field * field);
  Local at;
  at.h = std::sqrt(field2);
  at.per_m = 1 / sampled_.image_distance_m;
  at.rim = sampled_.radius_m * at.per_m;
  const double h2 = std::min(field2, 1.0f);  // beyond the image circle aberrations stay what they are at its edge
  const double color_um = color == 0 ? a.longitudinal_color_um[0] : color == 2 ? a.longitudinal_color_um[1] : 0;
  const double color_size = 1 + (color == 0 ? a.lateral_color[0] : color == 2 ? a.lateral_color[1] : 0);
  const double diopters = 1 / thin_.focus_distance_m;
  const double focus_um = a.focus_um + a.focus_um_per_diopter * diopters + color_um;
  const double tangential_um = a.tangential_focus_um(h2) + a.tangential_focus_um_per_diopter(h2) * diopters;
  const double sagittal_um = a.sagittal_focus_um(h2) + a.sagittal_focus_um_per_diopter(h2) * diopters;
  at.defocus_t = static_cast<float>(-1e-6 * (focus_um + tangential_um) * at.rim);
  at.defocus_s = static_cast<float>(-1e-6 * (focus_um + sagittal_um) * at.rim);
  double coma_um = 0;
  for (auto c = a.coma_um.rbegin(); c != a.coma_um.rend(); ++c) coma_um = coma_um * h2 + *c;
  at.coma = static_cast<float>(1e-6 * coma_um * std::sqrt(h2));
  at.pupil_t = static_cast<float>(1 + a.tangential_pupil(h2));
  at.pupil_s = static_cast<float>(1 + a.sagittal_pupil(h2));
  at.exit_pupil = 1 + a.exit_pupil_growth(h2);
  // the ideal picture's position, and how it changes within the photosite
  const double stretch = 1 / ((1 + a.distortion(field2)) * color_size);
  const double step = 1e-3;
  const double ahead = (at.h + step) / (1 + a.distortion((at.h + step) * (at.h + step)));
  const double behind = (at.h - step) / (1 + a.distortion((at.h - step) * (at.h - step)));
  at.stretch_radial = static_cast<float>((ahead - behind) / (2 * step) / color_size);
  at.stretch_around = static_cast<float>(stretch);
  return at;
}

/// Moves positions that are spread evenly over the whole pupil into what the rims leave of it, and says how much of the
/// pupil each stands for. So no samples are lost, whose number would differ from photosite to photosite: noise that
/// both views share. A rim that hides the pupil's middle is left to weigh().
void AberratedSampler::draw_in(const Local& at, CutPupil& p) const {
  std::fill_n(p.area, kPacket, 1.0f);
  if (aberrations_.rims.empty()) return;
  constexpr float kNone = 1e-20f;  // in the middle
  alignas(64) float cosine[kPacket], sine[kPacket], reach[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const float radius = std::sqrt(p.along[i] * p.along[i] + p.across[i] * p.across[i]) + kNone;
    cosine[i] = p.along[i] / radius, sine[i] = p.across[i] / radius;
    reach[i] = 1;
  }
  for (const Aberrations::Rim& rim : aberrations_.rims) {
    const auto shift = static_cast<float>(rim.shift * at.h), radius = static_cast<float>(rim.radius);
    if (std::abs(shift) >= radius) continue;
    for (int i = 0; i < kPacket; ++i) {
      const float aside = shift * sine[i];
      reach[i] = std::min(reach[i], shift * cosine[i] + std::sqrt(radius * radius - aside * aside));
    }
  }
  for (int i = 0; i < kPacket; ++i) {
    p.x[i] *= reach[i], p.y[i] *= reach[i], p.along[i] *= reach[i], p.across[i] *= reach[i];
    p.area[i] = reach[i] * reach[i];
  }
}

/// Falloff, and the rims that cut the pupil.
void AberratedSampler::weigh(const PixelFrame& f, const Local& at, const CutPupil& p, float weight[kPacket]) const {
  const Aberrations& a = aberrations_;
  // etendue: light from the pupil's area and the scene's solid angle that one photosite sees
  const float chief = static_cast<float>(f.radius_m) * at.stretch_around * at.per_m;
  const float cos2 = 1 / (1 + chief * chief);
  const float cos4 = cos2 * cos2 * at.pupil_t * at.pupil_s * at.stretch_radial * at.stretch_around;
  for (int i = 0; i < kPacket; ++i) {
    weight[i] = a.falloff == Aberrations::Falloff::cos4 ? cos4 : 1.0f;
    if (a.falloff == Aberrations::Falloff::disc) {
      const float tx = f.x_m * at.per_m + p.x[i] * at.rim, ty = f.y_m * at.per_m + p.y[i] * at.rim;
      const float c2 = 1 / (1 + tx * tx + ty * ty);
      weight[i] = c2 * c2;
    }
    weight[i] *= p.area[i];
  }
  for (const Aberrations::Rim& rim_disc : a.rims) {
    const auto shift = static_cast<float>(rim_disc.shift * at.h);
    constexpr float kRounding = 1.00001f;  // of positions at the rim
    const auto radius2 = kRounding * static_cast<float>(rim_disc.radius * rim_disc.radius);
    for (int i = 0; i < kPacket; ++i) {
      const float d = p.along[i] - shift;
      weight[i] = d * d + p.across[i] * p.across[i] <= radius2 ? weight[i] : 0.0f;
    }
  }
}

void AberratedSampler::sample(const PixelFrame& f, int color, const float s[4][kPacket], LensPacket& out,
                              PupilPacket& pupil) const {
  const Aberrations& a = aberrations_;
  const Local at = local_at(f, color);
  const float rx = f.radial_x, ry = f.radial_y;
  CutPupil p;
  concentric_disc(s[2], s[3], p.x, p.y);
  for (int i = 0; i < kPacket; ++i) {
    p.along[i] = p.x[i] * rx + p.y[i] * ry;
    p.across[i] = -p.x[i] * ry + p.y[i] * rx;
  }
  draw_in(at, p);
  const auto radius_m = static_cast<float>(f.radius_m);
  for (int i = 0; i < kPacket; ++i) {
    const float along = p.along[i], across = p.across[i];
    const float dx = (s[0][i] - 0.5f) * f.pitch_m, dy = (s[1][i] - 0.5f) * f.pitch_m;
    const float image_r = radius_m * at.stretch_around + at.stretch_radial * (dx * rx + dy * ry);
    const float image_a = at.stretch_around * (-dx * ry + dy * rx);
    const float rho2 = along * along + across * across;
    float spherical = 0;
    for (auto c = a.spherical_um.rbegin(); c != a.spherical_um.rend(); ++c) {
      spherical = (spherical + 1e-6f * static_cast<float>(*c)) * rho2;
    }
    const float origin_r = along * at.pupil_t * sampled_.radius_m;
    const float origin_a = across * at.pupil_s * sampled_.radius_m;
    const float coma_r = rho2 + 2 * along * along, coma_a = 2 * along * across;
    const float to_r = image_r - along * (at.defocus_t + spherical) - at.coma * coma_r;
    const float to_a = image_a - across * (at.defocus_s + spherical) - at.coma * coma_a;
    const float slope_r = to_r * at.per_m - origin_r * sampled_.inverse_focus;
    const float slope_a = to_a * at.per_m - origin_a * sampled_.inverse_focus;
    out.origin_x[i] = origin_r * rx - origin_a * ry;
    out.origin_y[i] = origin_r * ry + origin_a * rx;
    out.slope_x[i] = slope_r * rx - slope_a * ry;
    out.slope_y[i] = slope_r * ry + slope_a * rx;
    pupil.p[i] = p.x[i];
    pupil.t[i] = p.x[i] * at.rim;
  }
  weigh(f, at, p, pupil.weight);

  const double moved_m = sampled_.image_distance_m - thin_.focal_length_m;
  const double exit_pupil_m = a.exit_pupil_mm > 0 ? 1e-3 * a.exit_pupil_mm + moved_m : sampled_.image_distance_m;
  pupil.chief_slope = static_cast<float>(f.x_m / (exit_pupil_m * at.exit_pupil));
  const double scale = 1 / field_radius_m_;
  pupil.split_offset = static_cast<float>(a.split_offset(f.x_m * scale, f.y_m * scale));
  pupil.left_gain = static_cast<float>(std::clamp(a.left_gain(f.x_m * scale, f.y_m * scale), 0.0, 1.0));
  pupil.right_gain = static_cast<float>(std::clamp(a.right_gain(f.x_m * scale, f.y_m * scale), 0.0, 1.0));
}

double AberratedSampler::chief_slope_per_m(double radius_m) const {
  const double h = radius_m / field_radius_m_;
  const double ideal = 1 / (1 + aberrations_.distortion(h * h));
  return ideal / thin_.image_distance_m();
}

}  // namespace dualpixel::simulator
