#include "evaluation/report/lens_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "capture/error.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/report_images.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/lens/lens_sampler.h"
#include "simulator/lens/prescription/prescription.h"
#include "simulator/lens/prescription/pupil_bounds.h"
#include "simulator/lens/prescription/ray_trace.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::evaluation {
namespace {

using simulator::kPacket;
using simulator::Lens;
using simulator::LensPacket;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Points that sample the field.
struct FieldPoint {
  const char* name;
  double x, y;  ///< in half widths and half heights
};
constexpr FieldPoint kFieldPoints[] = {{"left edge", -0.95, 0}, {"center", 0, 0},  {"half way right", 0.5, 0},
                                       {"right edge", 0.95, 0}, {"top", 0, -0.95}, {"corner", 0.95, -0.95}};

struct Pixel {
  int x, y;
};
Pixel pixel_at(const simulator::SensorGrid& sensor, const FieldPoint& point) {
  return {static_cast<int>(0.5 * (1 + point.x) * (sensor.width_px - 1)),
          static_cast<int>(0.5 * (1 + point.y) * (sensor.height_px - 1))};
}

/// Calls visit(origin x, origin y, slope x, slope y, left, right) for rays that reach the middle of a photosite.
template <typename Visit>
void each_ray(const simulator::LensSampler& sampler, Pixel pixel, int count, const Visit& visit) {
  alignas(64) float s[4][kPacket];
  LensPacket packet;
  for (int first = 0; first < count; first += kPacket) {
    simulator::joint_samples(first, 0, s);
    std::fill(&s[0][0], &s[2][0], 0.5f);
    sampler.sample(pixel.x, pixel.y, 1, s, packet);
    for (int i = 0; i < kPacket; ++i) {
      if (packet.left[i] + packet.right[i] == 0) continue;
      visit(packet.origin_x[i], packet.origin_y[i], packet.slope_x[i], packet.slope_y[i], packet.left[i],
            packet.right[i]);
    }
  }
}

/// The entrance pupil as a photosite sees it: dots, colored by the view that most of the light goes to.
Plot pupil_plot(const simulator::LensSampler& sampler, const FieldPoint& point) {
  Plot plot;
  plot.title = fmt::format("Pupil, {}", point.name);
  plot.x_label = "x, pupil radii";
  plot.y_label = "y, pupil radii, upward";
  plot.equal_scale = true;
  plot.series = {{"left view", {}, false, true}, {"right view", {}, false, true}};
  const double radius = 0.5 * sampler.lens().thin.pupil_diameter_m();
  const Pixel pixel = pixel_at(sampler.sensor(), point);
  constexpr int kRays = 1024;
  float most = 0;
  each_ray(sampler, pixel, kRays,
           [&](float, float, float, float, float left, float right) { most = std::max(most, left + right); });
  float light = 0;  // a dot for every 2 `most` of it: rays are denser where rims cut the pupil, and weigh less
  each_ray(sampler, pixel, kRays, [&](float x, float y, float, float, float left, float right) {
    light += left + right;
    if (light < 2 * most) return;
    light -= 2 * most;
    plot.series[left > right ? 0 : 1].points.emplace_back(x / radius, -y / radius);
  });
  return plot;
}

/// What each view sees of a point that is out of focus: a histogram of where its rays would land.
std::string kernels(const simulator::LensSampler& sampler, const FieldPoint& point, double inverse_depth,
                    const std::string& name) {
  constexpr int kSide = 64;
  const simulator::SensorGrid& sensor = sampler.sensor();
  const Pixel pixel = pixel_at(sensor, point);
  const double px_per_slope = sampler.lens().thin.image_distance_m() / sensor.pixel_pitch_m;
  double mean_x = 0, mean_y = 0, light = 0, reach = 0;
  const auto miss = [&](float o, float m) { return -(o * inverse_depth + m) * px_per_slope; };
  each_ray(sampler, pixel, 4096, [&](float x, float y, float sx, float sy, float left, float right) {
    mean_x += (left + right) * miss(x, sx);
    mean_y += (left + right) * miss(y, sy);
    light += left + right;
  });
  if (light == 0) return "";
  mean_x /= light;
  mean_y /= light;
  each_ray(sampler, pixel, 4096, [&](float x, float y, float sx, float sy, float, float) {
    reach = std::max({reach, std::abs(miss(x, sx) - mean_x), std::abs(miss(y, sy) - mean_y)});
  });
  reach = std::max(1.05 * reach, 0.5);
  Image view[2] = {Image(kSide, kSide), Image(kSide, kSide)};
  each_ray(sampler, pixel, 65536, [&](float x, float y, float sx, float sy, float left, float right) {
    const int u = static_cast<int>((miss(x, sx) - mean_x + reach) / (2 * reach) * kSide);
    const int v = static_cast<int>((miss(y, sy) - mean_y + reach) / (2 * reach) * kSide);
    if (u < 0 || v < 0 || u >= kSide || v >= kSide) return;
    view[0].at(u, v) += left;
    view[1].at(u, v) += right;
  });
  const float most = std::max(percentile(view[0], 0.998), percentile(view[1], 0.998));
  std::string html = "<figure class=\"kernel\"><div>";
  for (const Image& image : view) {
    const char* side = &image == view ? "left view" : "right view";
    const Image large = [&] {
      Image result(4 * kSide, 4 * kSide);
      for (int y = 0; y < result.height; ++y) {
        for (int x = 0; x < result.width; ++x) result.at(x, y) = image.at(x / 4, y / 4);
      }
      return result;
    }();
    html +=
        fmt::format("<img src=\"{}\" alt=\"{}\">", jpeg_data_uri(gray_levels(large, std::max(most, 1e-6f)), 92), side);
  }
  return html +
         fmt::format(
             "</div><figcaption><b>{}, {}</b> left and right view, {:.1f} photosites wide</figcaption></figure>\n",
             point.name, name, 2 * reach);
}

/// The lens cut open, with rays from three fields.
Plot cross_section(const simulator::Prescription& lens) {
  Plot plot;
  plot.title = "Cross-section";
  plot.x_label = "z, mm from the first vertex";
  plot.y_label = "mm";
  plot.equal_scale = plot.wide = true;
  Series glass{"surfaces", {}, false, false}, stop{"stop", {}, false, false};
  double z = 0, sensor_z = 0;
  for (const simulator::LensSurface& s : lens.surfaces) sensor_z += s.thickness_mm;
  for (const simulator::LensSurface& s : lens.surfaces) {
    Series& series = s.stop && s.after.kind == simulator::Glass::Kind::fixed ? stop : glass;
    constexpr int kSteps = 40;
    if (&series == &stop) {
      for (double side : {-1.0, 1.0}) {
        series.points.insert(series.points.end(),
                             {{z, side * s.semi_diameter_mm}, {z, side * 1.3 * s.semi_diameter_mm}, {kNaN, 0}});
      }
    } else {
      for (int i = -kSteps; i <= kSteps; ++i) {
        const double r = s.semi_diameter_mm * i / kSteps;
        series.points.emplace_back(z + sag_mm(s, std::abs(r)), r);
      }
      series.points.emplace_back(kNaN, 0);
    }
    z += s.thickness_mm;
  }
  plot.series = {
      glass, stop, {"sensor", {{sensor_z, -lens.image_radius_mm}, {sensor_z, lens.image_radius_mm}}, false, false}};
  // From the sensor outwards through ever fewer surfaces from behind: where a ray meets each is where a shorter lens
  // ends.
  const simulator::PupilBounds bounds = find_pupil(lens, lens.reference_nm, lens.image_radius_mm);
  const char* const names[] = {"axis", "0.7 field", "full field"};
  const double fields[] = {0, 0.7, 0.98};
  for (int f = 0; f < 3; ++f) {
    Series rays{names[f], {}, f == 1, false};
    const simulator::PupilEllipse e = bounds.at(fields[f] * lens.image_radius_mm);
    for (double v : {-0.95, 0.0, 0.95}) {
      std::vector<std::pair<double, double>> path = {{sensor_z, fields[f] * lens.image_radius_mm}};
      bool passes = true;
      for (std::size_t first = lens.surfaces.size(); first-- > 0 && passes;) {
        // the same lens from surface `first` on; its frame starts at that surface
        simulator::Prescription rest = lens;
        rest.surfaces.erase(rest.surfaces.begin(), rest.surfaces.begin() + static_cast<std::ptrdiff_t>(first));
        double offset = 0;
        for (std::size_t i = 0; i < first; ++i) offset += lens.surfaces[i].thickness_mm;
        rest.surfaces.front().after = lens.surfaces[first].after;
        const simulator::TracedLens<double> traced(rest, lens.reference_nm, false);
        simulator::RayBatch<double, 1> ray{};
        ray.y[0] = fields[f] * lens.image_radius_mm;
        ray.z[0] = traced.sensor_z_mm();
        ray.m[0] = e.center_m + v * e.half_m;
        ray.n[0] = -std::sqrt(1 - ray.m[0] * ray.m[0]);
        traced.trace(ray);
        passes = ray.end[0] == 0;
        // a stop that is listed before the glass in front of it would send the drawn ray back
        if (ray.z[0] + offset < path.back().first) path.emplace_back(ray.z[0] + offset, ray.y[0]);
        if (first == 0 && passes) {
          const double ahead = 0.25 * std::abs(sensor_z) + path.back().first;
          path.emplace_back(path.back().first - ahead, path.back().second - ahead * ray.m[0] / ray.n[0]);
        }
      }
      if (passes) {
        rays.points.insert(rays.points.end(), path.begin(), path.end());
        rays.points.emplace_back(kNaN, 0);
      }
    }
    plot.series.push_back(rays);
  }
  return plot;
}

template <typename Value>
Series over_field(const std::string& name, const simulator::LensReport& report, const Value& value,
                  bool dashed = false) {
  Series series{name, {}, dashed, false};
  for (std::size_t k = 0; k < report.fields.size(); ++k) {
    if (report.fields[k].reached) series.points.emplace_back(report.field_of_radius[k], value(report.fields[k]));
  }
  return series;
}

template <typename Value>
Series over_cut(const std::string& name, const std::vector<simulator::CutPoint>& cut, const Value& value,
                bool dashed = false) {
  Series series{name, {}, dashed, false};
  for (const simulator::CutPoint& p : cut) series.points.emplace_back(p.field, value(p));
  return series;
}

Plot plot_of(std::string title, std::string x, std::string y, std::vector<Series> series) {
  Plot plot;
  plot.title = std::move(title);
  plot.x_label = std::move(x);
  plot.y_label = std::move(y);
  plot.series = std::move(series);
  return plot;
}

std::string field_plots(const simulator::LensReport& report) {
  using F = simulator::FieldAnalysis;
  const char* const field = "field, chief ray height over image radius";
  // The axis has no distortion: height over a height of 0. Next to it a sensor off the paraxial focus shows.
  Plot distortion =
      plot_of("Distortion", field, "%",
              {over_field("", report, [](const F& f) { return f.theta_rad > 0 ? 100 * f.distortion : kNaN; })});
  Plot curvature = plot_of("Field curvature: focus behind the sensor", field, "um",
                           {over_field("tangential", report, [](const F& f) { return 1e3 * f.tangential_focus; }),
                            over_field(
                                "sagittal", report, [](const F& f) { return 1e3 * f.sagittal_focus; }, true)});
  Plot illumination = plot_of("Relative illumination", field, "of the axis",
                              {over_field("traced", report, [](const F& f) { return f.relative_illumination; }),
                               over_field(
                                   "cos^4", report, [](const F& f) { return f.cos4; }, true),
                               over_field("unvignetted pupil", report, [](const F& f) { return f.pupil_fraction; })});
  Plot spot =
      plot_of("Spot, RMS radius", field, "um", {over_field("", report, [](const F& f) { return 1e3 * f.spot_rms; })});
  Plot chief_ray = plot_of("Chief ray at the sensor", field, "degrees",
                           {over_field("", report, [](const F& f) { return f.chief_angle_rad * 180 / M_PI; })});
  Series rms{"RMS", {}, false, false}, largest{"largest", {}, true, false};
  for (const simulator::FastFormError& e : report.fast_form) {
    rms.points.emplace_back(e.field, e.rms_px);
    largest.points.emplace_back(e.field, e.largest_px);
  }
  Plot fast = plot_of("Fitted polynomials against the exact trace, single rays", "field, of the half diagonal",
                      "photosites", {rms, largest});
  fast.log_y = true;
  return "<h2>Over the field, focused at infinity</h2>" +
         html_plots({distortion, curvature, illumination, spot, chief_ray, fast});
}

std::string calibration_plots(const simulator::LensReport& report) {
  using P = simulator::CutPoint;
  const char* const position = "field position, half widths or half heights";
  const auto both = [&](const auto& value) {
    return std::vector<Series>{over_cut("along the middle row", report.horizontal, value),
                               over_cut("along the middle column", report.vertical, value, true)};
  };
  return "<h2>Expected calibration</h2><p>A point at depth D has the disparity S(x)/D + I(x), in DP pixels.</p>" +
         html_plots(
             {plot_of("Slope S", position, "DP px m", both([](const P& p) { return p.coefficients.slope_dp_px_m; })),
              plot_of("Intercept I", position, "DP px",
                      both([](const P& p) { return p.coefficients.intercept_dp_px; })),
              plot_of("alpha: disparity over signed blur", position, "", both([](const P& p) { return p.alpha; })),
              plot_of("Light of each view along the middle row", position, "of the whole pixel on the axis",
                      {over_cut("left", report.horizontal, [](const P& p) { return p.coefficients.left_light; }),
                       over_cut("right", report.horizontal, [](const P& p) { return p.coefficients.right_light; })})});
}

constexpr const char* kLensStyle = R"css(
.kernels { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 300px), 1fr)); gap: 1.2rem; }
.kernel div { display: grid; grid-template-columns: 1fr 1fr; gap: 4px; }
)css";

}  // namespace

std::string lens_page(const simulator::LensReport& report) {
  const Lens& lens = report.lens;
  std::string body = fmt::format("<h1>{}</h1>\n", escape_name(lens.name));
  for (const auto& [label, text] : {std::pair{"Source: ", lens.source}, std::pair{"Derived: ", lens.derived}}) {
    if (!text.empty())
      body += "<p class=\"soft\">" + std::string(label) + escape_html(printable(text, simulator::kLongestNoteBytes)) +
              "</p>\n";
  }
  for (const std::string& warning : report.warnings) body += "<p>Warning: " + escape_html(warning) + "</p>\n";
  if (const simulator::Prescription* prescription = simulator::prescription_of(lens)) {
    body += html_plots({cross_section(*prescription)});
    body += field_plots(report);
  }
  body += calibration_plots(report);
  const simulator::LensSampler sampler(lens, report.sensor);
  std::vector<Plot> pupils;
  for (const FieldPoint& point : kFieldPoints) pupils.push_back(pupil_plot(sampler, point));
  body += "<h2>The pupil, as the views share it</h2>" + html_plots(pupils);
  const double focus = 1 / lens.thin.focus_distance_m;
  // a blur of about 24 photosites either way
  const double step = 24 * report.sensor.pixel_pitch_m / (lens.thin.pupil_diameter_m() * lens.thin.image_distance_m());
  body += "<h2>Blur kernels of a point out of focus</h2><div class=\"kernels\">";
  for (const FieldPoint& point : kFieldPoints) {
    body += kernels(sampler, point, focus + step, fmt::format("near, {:.3g} m", 1 / (focus + step)));
    if (focus - step > 0)
      body += kernels(sampler, point, focus - step, fmt::format("far, {:.3g} m", 1 / (focus - step)));
    body += kernels(sampler, point, focus, "in focus");
  }
  body += "</div><details><summary>All figures</summary><pre>" + escape_html(simulator::to_text(report)) +
          "</pre></details>";
  return html_page(printable(lens.name), body, kLensStyle);
}

}  // namespace dualpixel::evaluation
