// A traced lens as rendering sees it: furnace, pupils, the fast form against the exact one, focus, and lenses that
// cannot work.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "capture/error.h"
#include "capture/image/image_io.h"
#include "capture/json_fields.h"
#include "simulator/lens/aberrated/aberrated_json.h"
#include "simulator/lens/aberrated/aberrated_twin.h"
#include "simulator/lens/disparity_field.h"
#include "simulator/lens/lens_file.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/lens/prescription/prescription.h"
#include "simulator/lens/prescription/pupil_bounds.h"
#include "simulator/lens/prescription/ray_counts.h"
#include "simulator/lens/prescription/ray_trace.h"
#include "simulator/sampling/sobol.h"
#include "tests/simulator/test_scenes.h"
#include "tests/temporary_folder.h"

namespace dualpixel::simulator::testing {
namespace {

std::string shipped(const std::string& name) { return DUALPIXEL_SOURCE_DIR "/lens_models/" + name + ".json"; }

/// Without color the pupils of one wavelength need to be found instead of three.
Lens read_monochrome(const std::string& name, double focus_distance_m) {
  nlohmann::json json = read_json_file(shipped(name));
  json.erase("wavelengths_nm");
  return read_lens(json, name, "", focus_distance_m);
}

/// A 4:3 sensor that fills the lens's picture.
SensorGrid full_sensor(const Lens& lens, int width_px) {
  const int height_px = width_px * 3 / 4;
  const double radius_m = prescription_of(lens)->image_radius_mm * 1e-3;
  return phone_sensor(width_px, height_px, 2 * radius_m / std::hypot(width_px, height_px));
}

// A closed box that glows with 100 nits: whatever the lens blocks, each photosite must see 100 nits times its relative
// illumination, found apart from the sampler by counting which of a fine grid of directions pass.
TEST(SlowTracedFurnace, ShowsRelativeIlluminationAndNothingElse) {
  Scene scene;
  scene.materials = {glowing(100)};
  for (float side : {-50.0f, 50.0f}) {
    scene.meshes.push_back(make_quad({-50, -50, side}, {100, 0, 0}, {0, 100, 0}, 0));
    scene.meshes.push_back(make_quad({-50, side, -50}, {100, 0, 0}, {0, 0, 100}, 0));
    scene.meshes.push_back(make_quad({side, -50, -50}, {0, 100, 0}, {0, 0, 100}, 0));
  }
  const RenderScene world(scene);
  for (const char* name : {"phone_6p_4.2mm_f1.8", "full_frame_50mm_f1.8"}) {
    for (bool exact : {false, true}) {
      Lens lens = read_monochrome(name, 5);
      lens.split = {};  // microlenses do not take in all light
      std::get<PrescriptionModel>(lens.model).exact_trace = exact;
      // a strip one photosite high from the axis to the edge of the field
      SensorGrid sensor = full_sensor(lens, 2688);
      sensor.principal_point_px = {0.5, 0.5};
      sensor.width_px = 1600;
      sensor.height_px = 1;
      const CameraView camera{glm::mat4(1), LensSampler(lens, sensor)};
      const Image image = undivided(render_views(world, camera, {256, 0, 3}));
      const PupilBounds bounds = find_pupil(*prescription_of(lens), prescription_of(lens)->wavelengths_nm[1],
                                            prescription_of(lens)->image_radius_mm);
      for (int first = 0; first < sensor.width_px; first += 100) {
        double seen = 0, expected = 0;
        for (int x = first; x < first + 100; ++x) {
          seen += image.at(x, 0, 1) / 100;
          expected += bounds.at(1e3 * sensor.pixel_pitch_m * x).pass_area / bounds.nodes[0].pass_area;
        }
        // 25 600 samples of which one in 200 is lost: 0.15 % at three standard errors; the counting grid of 48 x 96
        // cells has some 200 of its 4000 on the rim, each uncertain by 0.3: 0.1 %, three times that
        EXPECT_NEAR(seen, expected, 0.0045 * expected) << name << ' ' << exact << ' ' << first;
      }
    }
  }
}

// Ninety per cent of a lens's pupil ellipses passes, over the area of the sensor.
TEST(SlowPupilEllipses, PassNineRaysInTen) {
  for (const char* name : {"phone_6p_4.2mm_f1.8", "phone_7p_4.9mm_f1.85", "full_frame_50mm_f1.8",
                           "double_gauss_100mm_f5", "portrait_100mm_f1.1", "telephoto_250mm_f5.4"}) {
    const Lens lens = read_monochrome(name, 20);
    const Prescription& prescription = *prescription_of(lens);
    const SensorGrid sensor = full_sensor(lens, 64);
    const PupilBounds bounds =
        find_pupil(prescription, prescription.reference_nm, 1e3 * glm::length(sensor.middle_m(0, 0)));
    double passed = 0, aimed = 0;
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 64; ++x) {
        const PupilEllipse ellipse = bounds.at(1e3 * glm::length(sensor.middle_m(x, y)));
        passed += ellipse.pass_area;
        aimed += M_PI * ellipse.half_l * ellipse.half_m;
      }
    }
    EXPECT_GE(passed, 0.9 * aimed) << name << ' ' << passed / aimed;
  }
}

// The polynomials' disparity against the exact trace's, which is what they are for; their stated limit is 0.01 DP px.
TEST(SlowRayPolynomials, KeepTheDisparityOfTheExactTrace) {
  for (const char* name : {"phone_6p_4.2mm_f1.8", "phone_7p_4.9mm_f1.85", "full_frame_50mm_f1.8"}) {
    Lens lens = read_monochrome(name, 1.5);
    const SensorGrid sensor = full_sensor(lens, 2688);
    const LensSampler fast(lens, sensor);
    std::get<PrescriptionModel>(lens.model).exact_trace = true;
    const LensSampler exact(lens, sensor);
    for (const auto& [x, y] :
         {std::pair{1344, 1008}, {1700, 1008}, {2300, 1300}, {1344, 300}, {2500, 200}, {2600, 1008}}) {
      const DisparityCoefficients a = trace_disparity(fast, x, y), b = trace_disparity(exact, x, y);
      EXPECT_NEAR(a.intercept_dp_px, b.intercept_dp_px, 0.01) << name << ' ' << x << ',' << y;
      EXPECT_NEAR(a.slope_dp_px_m, b.slope_dp_px_m, 0.002 * std::abs(b.slope_dp_px_m)) << name << ' ' << x << ',' << y;
      EXPECT_NEAR(a.left_light, b.left_light, 0.004) << name << ' ' << x << ',' << y;
    }
  }
}

// Disparity by rendering a glowing square through the lens must be what the disparity field says.
TEST(SlowTracedLens, RenderedDisparityIsTheFields) {
  Lens lens = read_monochrome("phone_6p_4.2mm_f1.8", 0.5);
  lens.split.kind = SplitKind::hard;
  const double depth = 1.2, pitch = 1.4e-6;
  for (const glm::dvec2 field_mm : {glm::dvec2(0), glm::dvec2(1.5, 0), glm::dvec2(-1.2, 1.4)}) {
    constexpr int kSize = 64;
    SensorGrid sensor{kSize, kSize, pitch, glm::dvec2(kSize / 2.0) - field_mm * 1e-3 / pitch};
    const CameraView camera{glm::mat4(1), LensSampler(lens, sensor)};
    const glm::dvec2 chief = camera.lens.chief_slope(field_mm.x * 1e-3, field_mm.y * 1e-3) * depth;
    const auto side = static_cast<float>(14 * pitch / lens.thin.image_distance_m() * depth);
    Scene scene;
    scene.materials = {glowing(100)};
    scene.meshes = {make_quad(
        {static_cast<float>(chief.x) - side / 2, static_cast<float>(chief.y) - side / 2, static_cast<float>(depth)},
        {side, 0, 0}, {0, side, 0}, 0)};
    const Views views = render_views(RenderScene(scene), camera, {512, 0, 7});
    const double rendered_dp_px = (moments(views.right).x - moments(views.left).x) / 2;
    const DisparityCoefficients c = trace_disparity(camera.lens, kSize / 2, kSize / 2, 16384);
    // The field is first order in the blur, 15 px here: what the bundle changes over it makes 0.005. Six seeds scatter
    // by 0.004.
    EXPECT_NEAR(rendered_dp_px, c.slope_dp_px_m / depth + c.intercept_dp_px, 0.005 + 3 * 0.004)
        << field_mm.x << ',' << field_mm.y;
  }
}

TEST(Focus, MovesTheImageOfItsDistanceToTheSensor) {
  for (double distance_mm : {200.0, 1000.0, 30000.0}) {
    Lens lens = read_lens_file(shipped("full_frame_50mm_f1.8"), distance_mm * 1e-3);
    const Prescription& p = *prescription_of(lens);
    const Prescription design =
        *prescription_of(read_lens_file(shipped("full_frame_50mm_f1.8"), std::numeric_limits<double>::infinity()));
    const double offset = design.surfaces.back().thickness_mm - paraxial(design).back_focus;
    const double image = paraxial_image_distance(p, paraxial(p).entrance_pupil_z - distance_mm);
    EXPECT_NEAR(p.surfaces.back().thickness_mm - image, offset, 1e-7);
    // b of the ideal twin is that of two paraxial rays: no light of the focus distance is blurred but by the offset
    EXPECT_NEAR(lens.thin.blur_diameter_m(distance_mm * 1e-3), 0, 1e-15);
  }
  // a named gap instead of the whole lens
  nlohmann::json inner = read_json_file(shipped("full_frame_50mm_f1.8"));
  inner["focus_gap"] = 4;
  const Lens lens = read_lens(inner, "inner.json", "", 2.0);
  const Prescription& p = *prescription_of(lens);
  EXPECT_NEAR(p.surfaces.back().thickness_mm, inner["surfaces"].back()["thickness_mm"].get<double>(), 1e-12);
  EXPECT_NE(p.surfaces[4].thickness_mm, inner["surfaces"][4]["thickness_mm"].get<double>());
}

TEST(SlowAberratedTwin, FollowsTheTracedPhoneLens) {
  Lens lens = read_monochrome("phone_6p_4.2mm_f1.8", 1.5);
  lens.split = {};  // the lens alone: microlenses also see how steeply rays meet the sensor
  const SensorGrid sensor = full_sensor(lens, 2688);
  const Lens twin = aberrated_twin(lens);
  for (double focus_m : {0.3, 1.5, std::numeric_limits<double>::infinity()}) {
    const LensSampler traced(refocused(lens, focus_m), sensor), fitted(refocused(twin, focus_m), sensor);
    double sum = 0, most = 0;
    int count = 0;
    for (int y = 60; y < 2016; y += 270) {
      for (int x = 70; x < 2688; x += 250) {
        const DisparityCoefficients a = trace_disparity(traced, x, y, 1024), b = trace_disparity(fitted, x, y, 1024);
        for (double depth_m : {0.3, 1.0, 10.0}) {
          const double error = (b.slope_dp_px_m - a.slope_dp_px_m) / depth_m + b.intercept_dp_px - a.intercept_dp_px;
          sum += error * error;
          most = std::max(most, std::abs(error));
          ++count;
        }
      }
    }
    EXPECT_LT(most, 0.1) << focus_m;
    EXPECT_LT(std::sqrt(sum / count), 0.035) << focus_m;
  }
}

// Where the sensor's own split says nearly nothing about focus, as these microlenses at the picture's edge, the fit
// must not be read from it.
TEST(SlowAberratedTwin, OfALensBehindTiltedMicrolenses) {
  const Lens lens = read_lens_file(shipped("full_frame_50mm_f4_dual_pixel"), 1.0);
  const Lens twin = aberrated_twin(lens);
  EXPECT_EQ(twin.split.kind, SplitKind::microlens);
  const SensorGrid sensor = full_sensor(lens, 1344);
  const LensSampler traced(lens, sensor), fitted(twin, sensor);
  double sum = 0, most = 0;
  int count = 0;
  for (int y = 60; y < 1008; y += 222) {
    for (int x = 32; x < 1344; x += 64) {
      const DisparityCoefficients a = trace_disparity(traced, x, y, 1024), b = trace_disparity(fitted, x, y, 1024);
      for (double depth_m : {0.6, 1.5, 10.0}) {
        const double error = (b.slope_dp_px_m - a.slope_dp_px_m) / depth_m + b.intercept_dp_px - a.intercept_dp_px;
        sum += error * error;
        most = std::max(most, std::abs(error));
        ++count;
      }
    }
  }
  // Towards the corners chief rays turn away from any one point that they could come from: 0.11 is what that leaves.
  EXPECT_LT(most, 0.12);
  EXPECT_LT(std::sqrt(sum / count), 0.05);
}

TEST(LensFiles, OfAberratedLensesHoldDiffractionAndGlare) {
  nlohmann::json json = read_json_file(shipped("phone_aberrated_4.4mm_f1.8"));
  json["diffraction"] = true;
  json["veiling_glare"] = 0.05;
  const nlohmann::json written = aberrated_lens_json(read_lens(json, "a.json", "", 1.0));
  const Lens read = read_lens(written, "written.json", "", 1.0);
  EXPECT_TRUE(read.diffraction);
  EXPECT_EQ(read.veiling_glare, 0.05);
}

TEST(AberratedTwin, RefusesALensThatIsNone) {
  Lens thin;
  EXPECT_THROW(aberrated_twin(thin), InputError);
  // its light ends well before its picture is said to
  nlohmann::json dark = read_json_file(shipped("double_gauss_100mm_f5"));
  dark["image_radius_mm"] = 4 * dark["image_radius_mm"].get<double>();
  EXPECT_THROW(aberrated_twin(read_lens(dark, "dark.json", "", 5.0)), InputError);
}

// A full-frame camera's measured disparity over the field. What made the public simulator fall too steeply towards the
// edge is that its two halves share no light: microlenses that are shifted for a more distant pupil than this lens's
// let one half see mostly stray light there, which carries no disparity.
TEST(RealCamera, FullFrameDisparityOverTheField) {
  const nlohmann::json data = read_json_file(DUALPIXEL_SOURCE_DIR "/tests/data/optics/full_frame_disparity.json");
  const Lens lens = read_lens_file(shipped("full_frame_50mm_f4_dual_pixel"), 1.0);
  const LensSampler sampler(lens, {768, 512, 36e-3 / 768, {384, 256}});
  double sum = 0, edge[2] = {}, measured_edge[2] = {};
  for (int plane = 0; plane < 2; ++plane) {
    const double depth_m = data["depth_m"][plane];
    std::cout << depth_m << " m:";
    for (int row = 0; row < 5; ++row) {
      for (int column = 0; column < 9; ++column) {
        const int x = static_cast<int>(384 + (column - 4) * 0.22 * 384),
                  y = static_cast<int>(256 + (row - 2) * 0.4 * 256);
        const DisparityCoefficients c = trace_disparity(sampler, x, y);
        const double ours_px = 2 * (c.slope_dp_px_m / depth_m + c.intercept_dp_px);
        const double measured_px = data["measured_px"][plane][row][column];
        sum += (ours_px - measured_px) * (ours_px - measured_px);
        if (row == 2) std::cout << fmt::format(" {:.2f}", ours_px);
        if (column % 8 == 0 && row == 2) {
          edge[plane] += ours_px / 2;
          measured_edge[plane] += measured_px / 2;
        }
      }
    }
    std::cout << '\n';
  }
  std::cout << fmt::format("RMS gap {:.3f} px over the 9 x 5 grid at both depths\n", std::sqrt(sum / 90));
  EXPECT_LT(std::sqrt(sum / 90), 0.085);
  for (int plane = 0; plane < 2; ++plane) {
    const auto& peer = data["public_simulator_px"][plane];
    const double peer_gap = std::abs(0.5 * (peer[0].get<double>() + peer[8].get<double>()) - measured_edge[plane]);
    EXPECT_LT(std::abs(edge[plane] - measured_edge[plane]), peer_gap / 2);
  }
}

// --- what cannot work -------------------------------------------------------------------------------------------

Prescription ball(double index, double radius_mm) {
  Prescription p;
  p.image_radius_mm = 1;
  p.wavelengths_nm.fill(p.reference_nm);
  LensSurface front, back;
  front.curvature_per_mm = 1 / radius_mm;
  front.thickness_mm = 2 * radius_mm;
  front.semi_diameter_mm = 0.999 * radius_mm;
  front.stop = true;
  front.after = {Glass::Kind::abbe, {index, 0}};
  back.curvature_per_mm = -1 / radius_mm;
  back.thickness_mm = 1;
  back.semi_diameter_mm = 0.999 * radius_mm;
  p.surfaces = {front, back};
  return p;
}

template <class Edit>
RayBatch<double, 1> trace_one(const Prescription& lens, Edit edit, bool clip = true) {
  RayBatch<double, 1> ray{};
  ray.z[0] = -10;
  ray.n[0] = 1;
  edit(ray);
  TracedLens<double>(lens, 587.5618, clip).trace(ray);
  return ray;
}

void expect_finite(const RayBatch<double, 1>& ray) {
  for (double v : {ray.x[0], ray.y[0], ray.z[0], ray.l[0], ray.m[0], ray.n[0]}) EXPECT_TRUE(std::isfinite(v));
}

TEST(Trace, EveryRayEndsInACountedWay) {
  const Prescription lens = ball(1.5, 2);
  RayCounts counts;
  const auto add = [&](const RayBatch<double, 1>& ray) {
    expect_finite(ray);
    counts.add(ray);
  };
  add(trace_one(lens, [](auto&) {}));
  EXPECT_EQ(counts.through, 1u);
  add(trace_one(lens, [](auto& r) { r.y[0] = 1.9985; }));  // inside the sphere, outside its clear aperture
  EXPECT_EQ(counts.clipped, 1u);
  add(trace_one(lens, [](auto& r) { r.y[0] = 3; }));
  EXPECT_EQ(counts.missed, 1u);
  // from the dense side a flat ray cannot leave: total reflection
  Prescription plate;
  LensSurface in, out;
  in.thickness_mm = 1, in.semi_diameter_mm = 100, in.stop = true, in.after = {Glass::Kind::abbe, {1.8, 0}};
  out.curvature_per_mm = -1.0 / 3, out.thickness_mm = 5, out.semi_diameter_mm = 2.99;
  plate.surfaces = {in, out};
  add(trace_one(plate, [](auto& r) { r.y[0] = 2.8; }));
  EXPECT_EQ(counts.reflected, 1u);
  // Snell on the axis of a plate: leaves as it came
  const RayBatch<double, 1> through = trace_one(lens, [](auto& r) { r.y[0] = 1; });
  const double a = std::asin(0.5), b = std::asin(0.5 / 1.5);
  EXPECT_NEAR(std::asin(-through.m[0]), 2 * (a - b), 1e-12);  // deviation of a ball lens
}

// A wavy surface that a steep ray meets three times: the first one counts. Brute force on a fine grid agrees.
TEST(Trace, FindsTheFirstOfSeveralIntersections) {
  Prescription lens;
  LensSurface wavy;
  wavy.terms = {{4, 0.4}, {6, -0.16}, {8, 0.015}};
  wavy.semi_diameter_mm = 2.2;
  wavy.thickness_mm = 1;
  wavy.stop = true;
  lens.surfaces = {wavy};
  for (double slope : {-1.2, -0.6, 0.3, 1.4}) {
    for (double y : {-1.8, -0.9, 0.1, 1.5}) {
      const double n = 1 / std::hypot(1, slope), m = slope * n;
      const RayBatch<double, 1> ray = trace_one(
          lens, [&](auto& r) { r.z[0] = -3, r.y[0] = y - 3 * slope, r.m[0] = m, r.n[0] = n; }, false);
      double first = -3;
      while (first < 3 && first < sag_mm(wavy, std::abs(y + first * slope))) first += 1e-5;
      if (ray.end[0] != 0) continue;
      EXPECT_NEAR(ray.z[0], first, 2e-5) << slope << ' ' << y;
    }
  }
}

TEST(Prescriptions, SurfacesThatCrossAreReported) {
  Prescription lens = ball(1.5, 2);
  EXPECT_TRUE(overlaps(lens).empty() || lens.surfaces[0].stop);
  lens.surfaces[0].stop = false;
  lens.surfaces[0].thickness_mm = 1;
  LensSurface stop;
  stop.stop = true;
  stop.semi_diameter_mm = 1;
  lens.surfaces.insert(lens.surfaces.begin(), stop);
  ASSERT_EQ(overlaps(lens).size(), 1u);
  EXPECT_NE(overlaps(lens)[0].find("surfaces 1 and 2 cross"), std::string::npos);
}

TEST(SlowPrescriptions, ATinyStopPassesALittleAndNothingIsNaN) {
  nlohmann::json json = read_json_file(shipped("phone_6p_4.2mm_f1.8"));
  json["surfaces"][0]["semi_diameter_mm"] = 1e-3;
  const Lens lens = read_lens(json, "tiny.json", "", 1.0);
  const LensSampler sampler(lens, full_sensor(lens, 16));
  const DisparityCoefficients c = trace_disparity(sampler, 12, 6);
  EXPECT_GT(sampler.lux_per_nit(), 0);
  EXPECT_TRUE(std::isfinite(c.slope_dp_px_m) && std::isfinite(c.left_light));
}

// A stop that clips all that other rims would: how fast light falls off no longer depends on how small it is. Of 4096
// rays of which one in 200 is lost, three standard errors are .3 %; the rest is the stop's own size at
// f/32.
TEST(SlowPrescriptions, AreLitOverTheFieldHoweverFarTheyAreStoppedDown) {
  for (const char* name : {"phone_6p_4.2mm_f1.8", "full_frame_50mm_f1.8"}) {
    const auto light_over_the_field = [&](double f_number) {
      nlohmann::json json = read_json_file(shipped(name));
      json["f_number"] = f_number;
      json.erase("wavelengths_nm");
      const Lens lens = read_lens(json, "a.json", "", 2.0);
      const LensSampler sampler(lens, full_sensor(lens, 16));
      std::vector<double> light;
      for (const int column : {10, 13, 15}) {
        const DisparityCoefficients c = trace_disparity(sampler, column, 6);
        light.push_back(c.left_light + c.right_light);
      }
      return light;
    };
    const std::vector<double> open = light_over_the_field(32);
    for (const double f_number : {128, 1000}) {
      const std::vector<double> light = light_over_the_field(f_number);
      for (std::size_t i = 0; i < light.size(); ++i) {
        EXPECT_GT(open[i], 0.1) << name;
        EXPECT_NEAR(light[i] / open[i], 1, 0.03) << name << ", place " << i << ", f/" << f_number;
      }
    }
  }
}

// Any number of a good file made wild: it is refused, or its rays are finite wherever they carry light.
TEST(SlowPrescriptions, WildNumbersGiveNoWildRays) {
  const nlohmann::json good = read_json_file(shipped("phone_6p_4.2mm_f1.8"));
  int refused = 0, dark = 0, rendered = 0;
  for (std::uint64_t trial = 0; trial < 14; ++trial) {
    nlohmann::json json = good;
    json.erase("wavelengths_nm");
    json["exact_trace"] = trial % 2 == 0;
    const std::uint64_t draw = hash(trial, 17);
    nlohmann::json& surface = json["surfaces"][draw % json["surfaces"].size()];
    const char* const fields[] = {"radius_mm", "conic", "thickness_mm", "semi_diameter_mm"};
    const double factors[] = {-1, 0.01, 0.5, 1.7, 4, 100, 1e6, -1e-3};
    const char* field = fields[(draw >> 8) % 4];
    const double was = surface.contains(field) && surface[field].is_number() ? surface[field].get<double>() : 1.0;
    surface[field] = was * factors[(draw >> 16) % 8];
    if (surface.contains("asphere") && (draw >> 24) % 3 == 0) surface["asphere"]["4"] = factors[(draw >> 32) % 8];
    bool was_read = false;
    try {
      const Lens lens = read_lens(json, "wild.json", "", 1.0);
      was_read = true;
      const LensSampler sampler(lens, phone_sensor(8, 6, 0.8e-3));
      ++rendered;
      alignas(64) float s[4][kPacket];
      LensPacket packet;
      for (int pixel = 0; pixel < 48; ++pixel) {
        joint_samples(0, hash(pixel, trial), s);
        sampler.sample(pixel % 8, pixel / 8, 1, s, packet);
        for (int i = 0; i < kPacket; ++i) {
          ASSERT_TRUE(packet.left[i] >= 0 && packet.right[i] >= 0 && packet.left[i] + packet.right[i] < 1e3) << trial;
          if (packet.left[i] + packet.right[i] == 0) continue;
          ASSERT_TRUE(std::abs(packet.slope_x[i]) < 1e3 && std::abs(packet.slope_y[i]) < 1e3) << trial;
          ASSERT_TRUE(std::abs(packet.origin_x[i]) < 1e4 && std::abs(packet.origin_y[i]) < 1e4) << trial;
        }
      }
    } catch (const InputError&) {
      ++(was_read ? dark : refused);  // no light passes a lens that could be read
    }
  }
  EXPECT_GT(refused, 0);
  EXPECT_GT(rendered, 5);
}

TEST(Prescriptions, RefuseWhatCannotBeAndNameIt) {
  const nlohmann::json good = read_json_file(shipped("phone_6p_4.2mm_f1.8"));
  struct Case {
    const char* pointer;
    nlohmann::json value;
    const char* says;
  };
  for (const Case& c : std::initializer_list<Case>{
           {"/surfaces/0/semi_diameter_mm", 0, "/surfaces/0/semi_diameter_mm: 0"},
           {"/surfaces/1/radius_mm", 0, "/surfaces/1/radius_mm: 0"},
           {"/surfaces/1/radius_mm", 0.5, "/surfaces/1/semi_diameter_mm"},
           {"/surfaces/1/glass/nd", 0.5, "/surfaces/1/glass/nd: 0.5"},
           {"/surfaces/1/asphere/3.5", 1, "/surfaces/1/asphere/3.5: unknown field"},
           {"/surfaces/0/stop", false, "/surfaces: 0 of them"},
           {"/surfaces/3/stop", true, "/surfaces: 2 of them"},
           {"/surfaces", nlohmann::json::array(), "/surfaces: 0 surfaces: must be 1 to 200"},
           {"/f_number", 1.2, "/f_number: 1.2: the lens opens to f/1.8"},
           {"/wavelengths_nm", {600, 500, 10}, "/wavelengths_nm: 10"},
           {"/focus_gap", 99, "/focus_gap: 99"},
           {"/image_radius_mm", -1, "/image_radius_mm: -1"},
           {"/split",
            {{"model", "table"}, {"p", {0, 1}}, {"left", {1, 0}}, {"right", {0, 1}}},
            "/split/p: [0,1]: must ascend from -1"},
           {"/split", {{"model", "microlens"}, {"crosstalk", 0.6}}, "/split/crosstalk: 0.6"},
       }) {
    nlohmann::json json = good;
    json[nlohmann::json::json_pointer(c.pointer)] = c.value;
    try {
      read_lens(json, "bad.json", "", 1.0);
      ADD_FAILURE() << c.pointer << " was accepted";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(c.says), std::string::npos) << error.what();
      EXPECT_TRUE(std::string(error.what()).starts_with("bad.json: ")) << error.what();
    }
  }
  try {
    read_lens(good, "bad.json", "", 0.005);
    ADD_FAILURE() << "focus inside the focal length was accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("focus distance"), std::string::npos) << error.what();
  }
}

TEST(LensFiles, ReadTheirMapsFromBesideThem) {
  const std::string folder = ::testing::TempDir();
  Image map(2, 1);
  map.data = {0.25f, -0.25f};
  write_exr(folder + "/offset.exr", {{"Y", &map}}, false);
  const nlohmann::json json = {{"model", "aberrated"}, {"split_offset", {{"constant", 0.1}, {"map", "offset.exr"}}}};
  const Lens lens = read_lens(json, folder + "/lens.json", "", 1.0);
  EXPECT_NEAR(std::get<Aberrations>(lens.model).split_offset(-0.5, 0), 0.35, 1e-6);
  EXPECT_NEAR(std::get<Aberrations>(lens.model).split_offset(0.5, 0), -0.15, 1e-6);
  nlohmann::json missing = json;
  missing["split_offset"]["map"] = "none.exr";
  EXPECT_THROW(read_lens(missing, folder + "/lens.json", "", 1.0), InputError);
}

TEST(LensFiles, FieldsBesideAFileTakeThePlaceOfItsOwn) {
  const std::string scene = DUALPIXEL_SOURCE_DIR "/scenes/any.json", file = "../lens_models/full_frame_50mm_f1.8.json";
  const Lens lens = read_lens({{"file", file}, {"f_number", 4}, {"split", {{"model", "hard"}}}}, scene, "/lens", 2);
  EXPECT_NEAR(lens.thin.f_number, 4, 1e-9);
  EXPECT_EQ(lens.split.kind, SplitKind::hard);
  try {
    read_lens({{"file", file}, {"model", "thin"}}, scene, "/lens", 2);
    ADD_FAILURE() << "another model was accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("any.json: /lens/model: differs from that of " + file), std::string::npos);
  }
}

TEST(LensFiles, AFileMayNameAnotherButNotItself) {
  const std::string scene = DUALPIXEL_SOURCE_DIR "/scenes/any.json";
  // this one takes its surfaces from full_frame_50mm_f1.8.json
  const std::string file = "../lens_models/full_frame_50mm_f4_dual_pixel.json";
  const Lens lens = read_lens({{"file", file}, {"f_number", 8}}, scene, "/lens", 2);
  EXPECT_NEAR(lens.thin.f_number, 8, 1e-9);
  EXPECT_EQ(lens.split.kind, SplitKind::microlens);
  EXPECT_EQ(prescription_of(lens)->surfaces.size(),
            prescription_of(read_lens_file(shipped("full_frame_50mm_f1.8"), 2))->surfaces.size());
  const TemporaryFolder folder;
  const std::string round = folder / "round.json";
  std::ofstream(round) << R"({"version": 1, "file": "round.json"})";
  try {
    read_lens_file(round, 2);
    ADD_FAILURE() << "a circle was accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("round.json: /file: "), std::string::npos) << error.what();
  }
}

TEST(LensFiles, AllShippedOnesLoadFocusAndRoundTrip) {
  for (const char* name : {"phone_thin_4.4mm_f1.8", "phone_aberrated_4.4mm_f1.8", "phone_6p_4.2mm_f1.8",
                           "phone_7p_4.9mm_f1.85", "double_gauss_100mm_f5", "portrait_100mm_f1.1",
                           "telephoto_250mm_f5.4", "full_frame_50mm_f1.8", "full_frame_50mm_f4_dual_pixel"}) {
    const Lens lens = read_lens_file(shipped(name), 3);
    EXPECT_FALSE(lens.source.empty()) << name;
    EXPECT_NEAR(lens.thin.focus_distance_m, 3, 1e-12);
  }
  const Lens lens = read_lens_file(shipped("phone_aberrated_4.4mm_f1.8"), 0.8);
  const Lens again = read_lens(aberrated_lens_json(lens), "again.json", "", 0.8);
  // the focal length goes through meters and back
  EXPECT_NEAR(again.thin.focal_length_m, lens.thin.focal_length_m, 1e-15);
  nlohmann::ordered_json a = aberrated_lens_json(lens), b = aberrated_lens_json(again);
  a.erase("focal_length_mm");
  b.erase("focal_length_mm");
  EXPECT_EQ(a.dump(), b.dump());
}

}  // namespace
}  // namespace dualpixel::simulator::testing
