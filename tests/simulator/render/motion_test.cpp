#include "simulator/render/motion.h"
#include "simulator/lens/prescription/prescription.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "capture/json_fields.h"
#include "simulator/lens/lens_file.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

/// A wall across the whole view, facing a camera at the origin that looks along +z.
Scene wall(float depth_m) {
  Scene scene;
  scene.materials = {glowing(100)};
  scene.meshes = {make_quad({-9, -9, depth_m}, {18, 0, 0}, {0, 18, 0}, 0)};
  return scene;
}

CameraView moved(CameraView camera, const glm::dmat4& pose) {
  camera.world_from_camera = glm::mat4(pose);
  return camera;
}

/// Barycentric weights are floats, 2^-24 of a wall 18 m wide at 0.5 m, seen with a focal length of 318 photosites;
/// three such errors add up.
constexpr double kRoundingPx = 3 * 18 / 0.5 * 318 * 0x1p-24;

// A turn moves every point alike, whatever its depth: the pinhole's homography.
TEST(TraceMotion, IsTheHomographyOfATurn) {
  const CameraView first = phone_camera(1, 96, 64, {}, 14e-6);
  const double turn_rad = 0.01, focal_px = thin(first).image_distance_m() / 14e-6;
  const CameraView later = moved(first, glm::rotate(glm::dmat4(1), turn_rad, glm::dvec3(0, 1, 0)));
  for (const float depth_m : {0.5f, -1.0f}) {  // behind the camera: nothing is hit
    const Scene scene = wall(depth_m);
    const Image motion = trace_motion(RenderScene(scene), first, scene, later);
    for (int y = 0; y < 64; y += 7) {
      for (int x = 0; x < 96; x += 7) {
        const double u = (x + 0.5 - 48) / focal_px, v = (y + 0.5 - 32) / focal_px;
        const double z = std::sin(turn_rad) * u + std::cos(turn_rad);
        const double to_x = focal_px * (std::cos(turn_rad) * u - std::sin(turn_rad)) / z, to_y = focal_px * v / z;
        EXPECT_NEAR(motion.at(x, y, 0), to_x - (x + 0.5 - 48), kRoundingPx);
        EXPECT_NEAR(motion.at(x, y, 1), to_y - (y + 0.5 - 32), kRoundingPx);
      }
    }
  }
}

TEST(TraceMotion, IsTheParallaxOfAShiftBeforeAPlane) {
  const CameraView first = phone_camera(1, 96, 64, {}, 14e-6);
  const double focal_px = thin(first).image_distance_m() / 14e-6, depth_m = 0.5;
  const glm::dvec3 shift_m(3e-3, -kRoundingPx, 5e-3);
  const CameraView later = moved(first, glm::translate(glm::dmat4(1), shift_m));
  const Scene scene = wall(0.5f);
  const Image motion = trace_motion(RenderScene(scene), first, scene, later);
  Scene shifted = scene;  // the wall moves the other way: the same picture
  for (glm::vec3& position : shifted.meshes[0].positions) position -= glm::vec3(shift_m);
  const Image of_object = trace_motion(RenderScene(scene), first, shifted, first);
  for (int y = 0; y < 64; y += 7) {
    for (int x = 0; x < 96; x += 7) {
      const double u = x + 0.5 - 48, v = y + 0.5 - 32, z = depth_m - shift_m.z;
      EXPECT_NEAR(motion.at(x, y, 0), (u * depth_m - focal_px * shift_m.x) / z - u, kRoundingPx);
      EXPECT_NEAR(motion.at(x, y, 1), (v * depth_m - focal_px * shift_m.y) / z - v, kRoundingPx);
      EXPECT_NEAR(of_object.at(x, y, 0), motion.at(x, y, 0), kRoundingPx);
      EXPECT_NEAR(of_object.at(x, y, 1), motion.at(x, y, 1), kRoundingPx);
    }
  }
}

TEST(TraceMotion, IsInfiniteBehindTheCamera) {
  const CameraView first = phone_camera(1, 16, 16);
  const Scene scene = wall(0.5f);
  const CameraView beyond = moved(first, glm::translate(glm::dmat4(1), glm::dvec3(0, 0, 0.6)));
  const Image motion = trace_motion(RenderScene(scene), first, scene, beyond);
  for (const float value : motion.data) EXPECT_EQ(value, INFINITY);
}

TEST(TraceMotion, FindsTheMeshWhoseTrianglesDiffer) {
  const Scene scene = wall(0.5f);
  EXPECT_FALSE(mesh_that_differs(scene, scene));
  Scene other = scene;
  other.meshes[0].triangles.pop_back();
  EXPECT_EQ(mesh_that_differs(scene, other), 0u);
  other = scene;
  other.meshes.push_back(scene.meshes[0]);
  EXPECT_EQ(mesh_that_differs(scene, other), 1u);
}

/// A whole sensor for a lens, coarse.
CameraView whole_view(const Lens& lens, double image_radius_m) {
  return {glm::mat4(1), LensSampler(lens, phone_sensor(64, 48, 2 * image_radius_m / 80))};
}

/// Turns the camera by `turn_rad` about y and compares: the chief ray of the point that motion leads to must run to the
/// turned direction of the pixel's own chief ray. Returns the share of the pixels for which there is such a point.
double check_turned(const CameraView& first, double turn_rad) {
  const glm::dmat4 pose = glm::rotate(glm::dmat4(1), turn_rad, glm::dvec3(0, 1, 0));
  const CameraView later = moved(first, pose);
  const Scene scene = wall(-1);  // nothing is seen: points are infinitely far
  const Image motion = trace_motion(RenderScene(scene), first, scene, later);
  const SensorGrid& sensor = first.lens.sensor();
  int found = 0;
  for (int y = 0; y < sensor.height_px; ++y) {
    for (int x = 0; x < sensor.width_px; ++x) {
      if (std::isinf(motion.at(x, y, 0))) continue;
      ++found;
      const glm::dvec2 from_m = sensor.middle_m(x, y);
      const glm::dvec2 to_m = sensor.middle_m(x + motion.at(x, y, 0), y + motion.at(x, y, 1));
      const glm::dvec3 turned =
          glm::transpose(glm::dmat3(glm::mat3(pose))) * glm::dvec3(first.lens.chief_slope(from_m.x, from_m.y), 1);
      const glm::dvec2 seen = first.lens.chief_slope(to_m.x, to_m.y);
      // a thousandth of a photosite, in slopes
      const double allowed = 1e-3 * sensor.pixel_pitch_m / first.lens.lens().thin.image_distance_m();
      EXPECT_NEAR(seen.x, turned.x / turned.z, allowed) << x << ',' << y;
      EXPECT_NEAR(seen.y, turned.y / turned.z, allowed) << x << ',' << y;
      EXPECT_LT(glm::length(to_m), 100 * sensor.pixel_pitch_m * sensor.width_px) << x << ',' << y;
    }
  }
  return static_cast<double>(found) / (sensor.width_px * sensor.height_px);
}

// Chief rays of a lens of glass are known up to the corners of the picture and go on straight beyond: a hand's turn and
// one by half the field lead every point to another, the corners' to one outside of the picture.
TEST(TraceMotion, FollowsChiefRaysOfAPrescriptionBeyondThePicture) {
  constexpr const char* kFile = DUALPIXEL_SOURCE_DIR "/lens_models/phone_7p_4.9mm_f1.85.json";
  nlohmann::json json = read_json_file(kFile);
  json.erase("wavelengths_nm");  // the pupils of one wavelength are found in a third of the time
  const Lens lens = read_lens(json, kFile, "", 1);
  const CameraView camera = whole_view(lens, prescription_of(lens)->image_radius_mm * 1e-3);
  EXPECT_EQ(check_turned(camera, 0.01), 1);
  EXPECT_EQ(check_turned(camera, 0.4), 1);
}

// The twin's distortion is a polynomial that means nothing far beyond the picture: a point is right, or there is none.
TEST(TraceMotion, FollowsChiefRaysOfAnAberratedLensOrSaysThatThereAreNone) {
  const Lens lens = read_lens_file(DUALPIXEL_SOURCE_DIR "/lens_models/phone_aberrated_4.4mm_f1.8.json", 1);
  const CameraView camera = whole_view(lens, std::get<Aberrations>(lens.model).image_radius_mm * 1e-3);
  EXPECT_EQ(check_turned(camera, 0.01), 1);
  EXPECT_GT(check_turned(camera, 0.4), 0.5);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
