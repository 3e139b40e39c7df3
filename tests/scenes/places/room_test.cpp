// The second room behind an opening of the back wall, ray by ray.
#include "scenes/places/room.h"

#include <gtest/gtest.h>

#include <cmath>

#include "simulator/render/truth.h"
#include "simulator/simulate.h"
#include "tests/temporary_folder.h"

namespace dualpixel::scenes {
namespace {

constexpr float kWide_m = 4, kDeep_m = 5, kBeyond_m = 3, kEye_m = 1.4f;
constexpr int kWidth = 64, kHeight = 48;
constexpr float kPitch_mm = 0.0588f, kFocal_mm = 4.3f;

/// Depths of an unfurnished room, seen along its axis from x = 0, y = kEye_m, z = 0.
Truth looked_into(float beyond_m) {
  const TemporaryFolder folder;
  SceneBuilder build;
  build.scene["sensor"] = {{"width_px", kWidth}, {"height_px", kHeight}, {"pixel_pitch_um", 1e3 * kPitch_mm}};
  build.scene["lens"] = {{"model", "thin"}, {"focal_length_mm", kFocal_mm}, {"f_number", 1000}};
  build.scene["camera"]["focus_distance_m"] = "inf";
  RoomOptions room;
  room.wide_m = kWide_m, room.deep_m = kDeep_m, room.beyond_m = beyond_m, room.furniture = 0;
  furnish_room(build, RandomStream(3, false), room);
  build.camera({0, kEye_m, 0}, {0, kEye_m, -1});
  build.glb.write(folder / "scene.glb");
  const simulator::Simulation simulation = simulator::read_simulation(build.scene, folder / "scene.json");
  const simulator::Scene scene = simulator::load_scene(simulation);
  const simulator::RenderScene world(scene, simulation.light);
  return simulator::trace_truth(world, simulator::place_camera(simulation, scene));
}

/// Where the ray through a pixel's middle meets the plane of the back wall: x, and height over the floor.
glm::vec2 on_back_wall(int x, int y) {
  const float scale = kDeep_m * kPitch_mm / kFocal_mm;
  return {scale * (static_cast<float>(x) + 0.5f - 0.5f * kWidth),
          kEye_m - scale * (static_cast<float>(y) + 0.5f - 0.5f * kHeight)};
}

TEST(SlowRoom, TheOpeningShowsASecondRoomAndTheWallBesideItDoesNot) {
  const Truth truth = looked_into(kBeyond_m);
  // .4 of the room's width, and 2.1 m high; below the lamps, which may hang from 1.7 m halfway to the wall
  const float half = 0.5f * 0.4f * kWide_m, lowest_lamp_m = kEye_m + 0.3f * kDeep_m / (0.55f * kDeep_m);
  const float farthest = kDeep_m + 0.12f + kBeyond_m;  // behind a wall of 12 cm
  int inside = 0, outside = 0;
  float deepest = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const glm::vec2 at = on_back_wall(x, y);
      if (at.y < 0.1f || at.y > lowest_lamp_m) continue;  // the skirting, the floor, lamps
      const float depth = truth.depth_m.at(x, y);
      if (std::abs(at.x) < half - 0.05f) {
        ++inside;
        EXPECT_GT(depth, kDeep_m + 0.05f) << x << ' ' << y;
        EXPECT_LE(depth, farthest + 1e-3f) << x << ' ' << y;
        deepest = std::max(deepest, depth);
      } else if (std::abs(at.x) > half + 0.05f && std::abs(at.x) < 0.5f * kWide_m - 0.05f) {
        ++outside;
        EXPECT_NEAR(depth, kDeep_m, 0.02f) << x << ' ' << y;  // the jambs stand out of the wall by 2 cm
      }
    }
  }
  EXPECT_GT(inside, 200);
  EXPECT_GT(outside, 200);
  EXPECT_NEAR(deepest, farthest, 1e-3);  // beside the piece at its end
}

TEST(Room, WithoutASecondRoomTheBackWallIsTheFarthest) {
  const Truth truth = looked_into(0);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_LE(truth.depth_m.at(x, y), kDeep_m + 1e-3f) << x << " " << y;
    }
  }
}

}  // namespace
}  // namespace dualpixel::scenes
