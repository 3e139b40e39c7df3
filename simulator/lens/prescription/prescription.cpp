#include "simulator/lens/prescription/prescription.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "capture/error.h"

namespace dualpixel::simulator {
namespace {

/// A paraxial ray: height y and reduced angle n u.
struct Paraxially {
  double y = 0;
  double nu = 0;
};

/// Curvature at the vertex: an r^2 term bends light too.
double vertex_curvature(const LensSurface& s) {
  double c = s.curvature_per_mm;
  for (const auto& [power, a] : s.terms) {
    if (power == 2) c += 2 * a;
  }
  return c;
}

struct Medium {
  double before, after;
};

std::vector<Medium> media(const Prescription& lens) {
  std::vector<Medium> result;
  double n = 1;
  for (const LensSurface& s : lens.surfaces) {
    const double next = refractive_index(s.after, lens.reference_nm);
    result.push_back({n, next});
    n = next;
  }
  return result;
}

/// From the plane of surface `from` through surfaces from .. to - 1 and their thicknesses; `refract_first` says whether
/// surface `from` itself bends the ray.
Paraxially forward(const Prescription& lens, const std::vector<Medium>& n, Paraxially ray, std::size_t from,
                   std::size_t to, bool refract_first = true) {
  for (std::size_t i = from; i < to; ++i) {
    if (i > from || refract_first) ray.nu -= ray.y * vertex_curvature(lens.surfaces[i]) * (n[i].after - n[i].before);
    if (i + 1 < lens.surfaces.size()) ray.y += ray.nu / n[i].after * lens.surfaces[i].thickness_mm;
  }
  return ray;
}

/// The same lens seen from behind, for rays that run towards the scene.
Prescription reversed(const Prescription& lens) {
  Prescription result = lens;
  const std::size_t count = lens.surfaces.size();
  for (std::size_t i = 0; i < count; ++i) {
    LensSurface& s = result.surfaces[i];
    s = lens.surfaces[count - 1 - i];
    s.curvature_per_mm = -s.curvature_per_mm;
    for (auto& term : s.terms) term.second = -term.second;
    s.thickness_mm = i + 1 < count ? lens.surfaces[count - 2 - i].thickness_mm : 0;
    s.after = i + 1 < count ? lens.surfaces[count - 2 - i].after : Glass{};
  }
  return result;
}

struct Pupil {
  double distance;  ///< behind the last vertex
  double scale;
};

/// The stop as it is seen through the surfaces behind it.
Pupil pupil_behind(const Prescription& lens) {
  const std::vector<Medium> n = media(lens);
  const auto stop = static_cast<std::size_t>(lens.stop_index());
  const std::size_t count = lens.surfaces.size();
  // a point at the stop's center, and one at its rim: linear, so two rays tell all. Light leaves the stop's surface.
  const Paraxially axial = forward(lens, n, {0, 1}, stop, count, false);
  const Paraxially rim = forward(lens, n, {1, 0}, stop, count, false);
  const double distance = axial.nu == 0 ? -std::numeric_limits<double>::infinity() : -axial.y / axial.nu;
  return {distance, rim.y + distance * rim.nu};
}

double vertex_z(const Prescription& lens, std::size_t index) {
  double z = 0;
  for (std::size_t i = 0; i < index; ++i) z += lens.surfaces[i].thickness_mm;
  return z;
}

}  // namespace

int Prescription::stop_index() const {
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (surfaces[i].stop) return static_cast<int>(i);
  }
  return -1;
}

double sag_mm(const LensSurface& s, double r) {
  const double c = s.curvature_per_mm;
  double z = c * r * r / (1 + std::sqrt(1 - (1 + s.conic) * c * c * r * r));
  for (const auto& [power, a] : s.terms) z += a * std::pow(r, power);
  return z;
}

Paraxial paraxial(const Prescription& lens) {
  const std::vector<Medium> n = media(lens);
  const std::size_t count = lens.surfaces.size();
  const Prescription backwards = reversed(lens);
  Paraxial p;
  const Paraxially parallel = forward(lens, n, {1, 0}, 0, count);
  p.focal_length = -1 / parallel.nu;
  p.back_focus = -parallel.y / parallel.nu;
  const Paraxially back = forward(backwards, media(backwards), {1, 0}, 0, count);
  p.front_focus = back.y / back.nu;
  double petzval = 0;
  for (std::size_t i = 0; i < count; ++i) {
    petzval += vertex_curvature(lens.surfaces[i]) * (n[i].after - n[i].before) / (n[i].after * n[i].before);
  }
  p.petzval_radius = -1 / petzval;

  const double stop_diameter = 2 * lens.surfaces[lens.stop_index()].semi_diameter_mm;
  const Pupil exit = pupil_behind(lens);
  const Pupil entrance = pupil_behind(backwards);
  p.exit_pupil_z = vertex_z(lens, count - 1) + exit.distance;
  p.exit_pupil_scale = std::abs(exit.scale);
  p.exit_pupil_diameter = p.exit_pupil_scale * stop_diameter;
  p.entrance_pupil_z = -entrance.distance;
  p.entrance_pupil_scale = std::abs(entrance.scale);
  p.entrance_pupil_diameter = p.entrance_pupil_scale * stop_diameter;
  return p;
}

double paraxial_image_distance(const Prescription& lens, double object_z) {
  const std::vector<Medium> n = media(lens);
  const Paraxially start = std::isinf(object_z) ? Paraxially{1, 0} : Paraxially{-object_z, 1};
  const Paraxially end = forward(lens, n, start, 0, lens.surfaces.size());
  return -end.y / end.nu;
}

std::optional<std::string> check_f_number(const Prescription& lens, double f_number) {
  const double open = paraxial(lens).f_number();
  if (f_number >= open * (1 - 1e-6)) return std::nullopt;
  return fmt::format("{}: the lens opens to f/{:.4g} only", f_number, open);
}

Prescription stopped_down(Prescription lens, double f_number) {
  if (const auto why = check_f_number(lens, f_number)) throw InputError("f_number: " + *why);
  const Paraxial p = paraxial(lens);
  lens.surfaces[lens.stop_index()].semi_diameter_mm = p.focal_length / (2 * f_number * p.entrance_pupil_scale);
  return lens;
}

Prescription focused(Prescription lens, double focus_distance_mm) {
  const auto gap = lens.focus_gap < 0 ? lens.surfaces.size() - 1 : static_cast<std::size_t>(lens.focus_gap);
  double& thickness = lens.surfaces[gap].thickness_mm;
  thickness -= lens.focus_shift_mm;
  lens.focus_shift_mm = 0;
  if (std::isinf(focus_distance_mm)) return lens;
  const double at_infinity = thickness;
  const double miss_at_infinity =
      lens.surfaces.back().thickness_mm - paraxial_image_distance(lens, -std::numeric_limits<double>::infinity());
  // how far behind the wanted position the image falls
  const auto miss = [&](double shift) {
    thickness = at_infinity + shift;
    const double object_z = paraxial(lens).entrance_pupil_z - focus_distance_mm;
    return paraxial_image_distance(lens, object_z) + miss_at_infinity - lens.surfaces.back().thickness_mm;
  };
  double a = 0, miss_a = miss(a);
  double b = miss_a, miss_b = miss(b);  // a whole lens that moves by the miss is nearly right
  for (int i = 0; i < 60 && std::abs(miss_b) > 1e-13 * focus_distance_mm && miss_b != miss_a; ++i) {
    const double next = b - miss_b * (b - a) / (miss_b - miss_a);
    a = b;
    miss_a = miss_b;
    b = next;
    miss_b = miss(b);
  }
  const double room = lens.surfaces.size() * 1e-6 + (gap + 1 == lens.surfaces.size() ? 1e9 : at_infinity);
  if (!(std::abs(miss_b) < 1e-9 * focus_distance_mm) || !(at_infinity + b > 0) || !(std::abs(b) < 20 * room)) {
    throw InputError(fmt::format("focus_distance_m: {:.6g}: must be one that surface {}'s gap can be set for",
                                 1e-3 * focus_distance_mm, gap));
  }
  lens.focus_shift_mm = b;
  return lens;
}

std::vector<std::string> overlaps(const Prescription& lens) {
  std::vector<std::string> result;
  for (std::size_t i = 0; i + 1 < lens.surfaces.size(); ++i) {
    const LensSurface& a = lens.surfaces[i];
    const LensSurface& b = lens.surfaces[i + 1];
    if (a.stop || b.stop) continue;  // a stop is a hole: glass may reach through it
    const double r_max = std::min(a.semi_diameter_mm, b.semi_diameter_mm);
    for (int k = 0; k <= 64; ++k) {
      const double r = r_max * k / 64;
      const double gap = a.thickness_mm + sag_mm(b, r) - sag_mm(a, r);
      if (gap < 0) {
        result.push_back(fmt::format("surfaces {} and {} cross by {:.4g} mm at radius {:.4g} mm", i, i + 1, -gap, r));
        break;
      }
    }
  }
  return result;
}

}  // namespace dualpixel::simulator
