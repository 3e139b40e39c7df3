// What scene files refuse, a program that fills the structs itself is told in the same words.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "simulator/scene_file.h"
#include "tests/temporary_folder.h"

namespace dualpixel::simulator::testing {
namespace {

std::string problem(const Simulation& s) {
  const auto found = check(s);
  return found ? found->field + ": " + found->message : "";
}

TEST(Options, DefaultsAreValid) { EXPECT_EQ(problem({}), ""); }

TEST(Options, EachProblemNamesFieldValueAndWhatIsAllowed) {
  const std::pair<std::string, void (*)(Simulation&)> cases[] = {
      {"sensor/width_px: 335: must be even", [](Simulation& s) { s.sensor.width_px = 335; }},
      {"sensor/width_px: 0: must be an integer in [2, 32768]", [](Simulation& s) { s.sensor.width_px = 0; }},
      {"sensor/height_px: 250: must be a multiple of 4", [](Simulation& s) { s.sensor.height_px = 250; }},
      {"sensor/dp_downsample_y: 2 x 3: a DP pixel must be", [](Simulation& s) { s.sensor.dp_downsample_y = 3; }},
      {"sensor/black_level_dn: 513: must be a number in [0, 512]",
       [](Simulation& s) { s.sensor.black_level_dn = 513; }},
      {"sensor/black_level_dn: 64.5: must be a whole number where the read-out is sum_and_left",
       [](Simulation& s) {
         s.sensor.readout = Readout::sum_and_left;
         s.sensor.black_level_dn = 64.5;
       }},
      {"sensor/electrons_per_lux_s: 0: must lie in", [](Simulation& s) { s.sensor.electrons_per_lux_s[1] = 0; }},
      {"sensor/color_matrix: 1e+308: must be a number in [-100, 100]",
       [](Simulation& s) { s.sensor.color_matrix = {1e308, -1e308, 1, 0, 1, 0, 0, 0, 1}; }},
      {"sensor/color_matrix: 0 electrons for each lx s of the illuminant under one filter: each row must see 0.001",
       [](Simulation& s) { s.sensor.color_matrix = {1, -1, 0, 0, 1, 0, 0, 0, 1}; }},
      {"sensor/color_matrix: determinant 0 where the illuminant is white: must have an inverse, 1e-06 to 1e+06",
       [](Simulation& s) { s.sensor.color_matrix = {1, 0, 0, 1, 0, 0, 0, 0, 1}; }},
      // rows that see almost as much of one color as they take of another: captures could not undo them
      {"sensor/color_matrix: determinant",
       [](Simulation& s) { s.sensor.color_matrix = {100, -99.999, 0, 0, 100, -99.999, -99.999, 0, 100}; }},
      {"sensor/illuminant: 1e-300: must be a number in [1e-06, 1e+06]",
       [](Simulation& s) { s.sensor.illuminant[0] = 1e-300; }},
      {"sensor/dark_current_e_per_s: 10: gathers 4.789e+51 electrons in 0.01 s at 200 C: must leave some of the well, "
       "5880 at most",
       [](Simulation& s) {
         s.sensor.dark_current_e_per_s = 10;
         s.sensor.temperature_c = 200;
         s.sensor.dark_current_doubling_c = 1;
       }},
      {"sensor/height_px: 8192: makes 67 million photosites: must be at most 55",
       [](Simulation& s) { s.sensor.width_px = s.sensor.height_px = 8192; }},
      {"sensor/prnu: nan: must be a number in [0, 0.5]", [](Simulation& s) { s.sensor.prnu = std::nan(""); }},
      {"exposure/iso: 0: must be a number in [1, 1e+06]", [](Simulation& s) { s.exposure.iso = 0; }},
      {"burst/interval_s: 0.04: must be a number in [0.5, 100000]", [](Simulation& s) { s.exposure.time_s = 0.5; }},
      {"burst/frames: 0: must be an integer in [1, 1000]", [](Simulation& s) { s.burst_frames = 0; }},
      {"environment/sun_glow_width_deg: 0: must", [](Simulation& s) { s.sky.sun_glow_width_deg = 0; }},
      {"environment/nits: -1: must lie in", [](Simulation& s) { s.environment_nits[2] = -1; }},
      {"face_px: 1, 1, 0, 1: must be x, y, width, height",
       [](Simulation& s) {
         s.face_px = {1, 1, 0, 1};
       }},
      {"face_px: -1, 1, 1, 1: must be x, y, width, height in photosites: x and y in [0, 65536]",
       [](Simulation& s) {
         s.face_px = {-1, 1, 1, 1};
       }},
      {"face_px: 1, 1, 1e+300, 1: must be",
       [](Simulation& s) {
         s.face_px = {1, 1, 1e300, 1};
       }},
      {"sensor/electrons_per_lux_s: 1e-30: must lie in",
       [](Simulation& s) { s.sensor.electrons_per_lux_s[0] = 1e-30; }},
      {"truth/photograph_aperture_scale: -1: must", [](Simulation& s) { s.photograph_aperture_scale = -1; }},
      {"truth/photograph_aperture_scale: 0: must", [](Simulation& s) { s.photograph_aperture_scale = 0; }},
      {"render/max_bounces: -1: must be an integer in [0, 1000]", [](Simulation& s) { s.render.max_bounces = -1; }},
      {"render/noise_fraction: 0: must be a number in [0.0001, 100]", [](Simulation& s) { s.noise_fraction = 0; }},
      {"render/error: nan: must be a number", [](Simulation& s) { s.render_error = std::nan(""); }},
      {"render/time_budget_s: -1: must be a number", [](Simulation& s) { s.time_budget_s = -1; }},
      {"render/error: give one of", [](Simulation& s) { s.noise_fraction = s.render_error = 1; }},
  };
  for (const auto& [expected, change] : cases) {
    Simulation s;
    change(s);
    EXPECT_EQ(problem(s).substr(0, expected.size()), expected);
  }
}

// Embree asserts against rays from 2^60 m and more.
TEST(Options, CamerasStayWhereRaysCanStart) {
  const auto refusal = [](nlohmann::json camera) {
    const nlohmann::json json = {{"version", 1}, {"gltf", "a.glb"}, {"camera", std::move(camera)}};
    return message_of<InputError>([&] { read_simulation(json, "scene.json"); });
  };
  EXPECT_EQ(refusal({{"position_m", {0, 0x1p63, 0}}, {"look_at_m", {0, 0, 0}}}),
            "scene.json: /camera/position_m: 9.223372036854776e+18: must be 3 numbers in [-1000000, 1000000]");
  EXPECT_EQ(refusal({{"position_m", {0, 0, 1}}, {"look_at_m", {0, 0, 0}}, {"up", {1e308, 1e308, 0}}}),
            "scene.json: /camera/up: 1e+308: must be 3 numbers in [-1000000, 1000000]");
}

TEST(Options, SceneFilesAreRefusedInTheSameWords) {
  const nlohmann::json json = {{"version", 1}, {"gltf", "a.glb"}, {"sensor", {{"width_px", 335}}}};
  try {
    read_simulation(json, "scene.json");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "scene.json: /sensor/width_px: 335: must be even: the mosaic repeats every 2");
  }
}

}  // namespace
}  // namespace dualpixel::simulator::testing
