#include "simulator/render/shading/surface.h"
#include "simulator/render/intersector.h"

#include <gtest/gtest.h>

#include <cmath>

#include "capture/image/image_io.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

/// 2 x 1: black, white; alpha 0, 255.
Texture two_texels(bool srgb) {
  Texture t;
  t.width = 2;
  t.height = 1;
  t.srgb = srgb;
  t.rgba = {0, 0, 0, 0, 255, 255, 255, 255};
  return t;
}

TEST(Texture, BilinearBetweenTexelCentresAndWrapsAround) {
  Texture t = two_texels(false);
  EXPECT_FLOAT_EQ(sample_texture(t, {0.25f, 0.5f}).x, 0);
  EXPECT_FLOAT_EQ(sample_texture(t, {0.75f, 0.5f}).x, 1);
  EXPECT_FLOAT_EQ(sample_texture(t, {0.5f, 0.5f}).x, 0.5f);
  EXPECT_FLOAT_EQ(sample_texture(t, {0.0f, 0.5f}).x, 0.5f);  // repeat
  EXPECT_FLOAT_EQ(sample_texture(t, {-1.25f, 0.5f}).x, 1);
  t.wrap_u = Wrap::clamp;
  EXPECT_FLOAT_EQ(sample_texture(t, {0.0f, 0.5f}).x, 0);
  EXPECT_FLOAT_EQ(sample_texture(t, {7.0f, 0.5f}).x, 1);
  t.wrap_u = Wrap::mirror;
  EXPECT_FLOAT_EQ(sample_texture(t, {1.25f, 0.5f}).x, 1);
  EXPECT_FLOAT_EQ(sample_texture(t, {1.75f, 0.5f}).x, 0);
  t.nearest = true;
  EXPECT_FLOAT_EQ(sample_texture(t, {0.49f, 0.5f}).x, 0);
}

TEST(Texture, SrgbIsDecodedBeforeFilteringAndAlphaIsNot) {
  Texture t = two_texels(true);
  t.rgba = {188, 188, 188, 128, 188, 188, 188, 128};
  EXPECT_NEAR(sample_texture(t, {0.3f, 0.5f}).x, std::pow((188 / 255.0 + 0.055) / 1.055, 2.4), 1e-6);
  EXPECT_NEAR(sample_texture(t, {0.3f, 0.5f}).w, 128 / 255.0, 1e-6);
  for (int byte = 0; byte < 256; ++byte) {
    t.rgba[0] = static_cast<std::uint8_t>(byte);
    EXPECT_NEAR(decode_texel(t, 0).x, linear_from_srgb(static_cast<float>(byte) / 255), 1e-6);
  }
}

TEST(Texture, SurvivesUselessCoordinates) {
  const Texture t = two_texels(false);
  for (float bad : {NAN, INFINITY, -INFINITY, 1e30f}) EXPECT_TRUE(std::isfinite(sample_texture(t, {bad, bad}).x));
}

// Half of the quad is cut away: rays pass there and stop on the other half, both for nearest hits and for shadows.
TEST(Intersector, AlphaCutOutsLetRaysThrough) {
  Scene scene;
  scene.textures = {two_texels(false)};
  scene.textures[0].nearest = true;
  scene.materials = {diffuse(0.5f)};
  scene.materials[0].base_color_texture.texture = 0;
  scene.materials[0].alpha_cutoff = 0.5f;
  scene.meshes = {make_quad({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, 0)};
  const Intersector intersector(scene);
  for (float x : {-0.5f, 0.5f}) {
    RayPacket rays{};
    alignas(64) int active[kPacket] = {};
    for (int i = 0; i < kPacket; ++i) {
      rays.origin_x[i] = x;
      rays.direction_z[i] = 1;
      rays.far[i] = 10;
      rays.mesh[i] = kNoMesh;
      active[i] = i % 3 ? -1 : 0;
    }
    for (int width : {1, 8, 16}) {
      RayPacket met = rays;
      int hidden[kPacket];
      intersector.intersect(active, met, true, width);
      intersector.occluded(active, rays, true, hidden, width);
      for (int i = 0; i < kPacket; ++i) {
        EXPECT_EQ(met.mesh[i] != kNoMesh, active[i] && x > 0);
        EXPECT_NEAR(met.far[i], active[i] && x > 0 ? 1 : 10, 1e-6);
        EXPECT_EQ(hidden[i], x > 0 ? active[i] : 0);
      }
    }
  }
}

// Debian's Embree ends the program over each of these.
TEST(Intersector, RaysThatAreNoneMeetNothing) {
  Scene scene;
  scene.materials = {diffuse(0.5f)};
  scene.meshes = {make_quad({-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, 0)};
  const Intersector intersector(scene);
  RayPacket rays{};
  alignas(64) int active[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    rays.direction_z[i] = 1;
    rays.far[i] = 10;
    active[i] = i < 14 ? -1 : 0;
  }
  const float bad[] = {NAN, INFINITY, -INFINITY, 0x1p63f, -0x1p64f, 3e38f};
  for (int i = 0; i < 6; ++i) {
    rays.origin_x[i] = bad[i];
    rays.direction_y[6 + i] = bad[i];
  }
  rays.far[12] = NAN;
  for (int width : {1, 8, 16}) {
    RayPacket met = rays;
    int hidden[kPacket];
    intersector.intersect(active, met, true, width);
    intersector.occluded(active, rays, true, hidden, width);
    for (int i = 0; i < 13; ++i) {
      EXPECT_EQ(met.mesh[i], kNoMesh) << i;
      EXPECT_EQ(hidden[i], -1) << i;
    }
    EXPECT_EQ(met.mesh[13], 0u);
    EXPECT_EQ(hidden[13], -1);
    EXPECT_EQ(hidden[14], 0);
  }
  EXPECT_FALSE(intersector.intersect(Ray{{0, 0, 0x1p64f}, {0, 0, -1}}));
  EXPECT_TRUE(intersector.intersect(Ray{}));
}

// A normal map whose texel says "up along +u" bends the shading normal towards the texture's u direction.
TEST(Surface, NormalMapFollowsTextureAxes) {
  Scene scene;
  Texture t = two_texels(false);
  t.rgba = {255, 128, 128, 255, 255, 128, 128, 255};
  scene.textures = {t};
  scene.materials = {diffuse(0.5f)};
  scene.materials[0].normal_texture.texture = 0;
  const Mesh quad = make_quad({0, 0, 1}, {1, 0, 0}, {0, 1, 0}, 0);
  RayPacket rays{};  // all meet triangle 0
  int lanes[kPacket] = {};
  lanes[5] = -1;
  rays.u[5] = rays.v[5] = 0.3f;
  rays.direction_z[5] = 1;
  const auto surface = [&](const std::array<float, 6>& uv_from_uv) {
    scene.materials[0].normal_texture.uv_from_uv = uv_from_uv;
    SurfacePacket packet;
    surfaces_at(scene, quad, lanes, rays, packet);
    return packet.at(5);
  };
  const Surface s = surface({1, 0, 0, 0, 1, 0});
  EXPECT_NEAR(std::abs(s.normal.x), 1, 0.01);
  EXPECT_LE(s.geometric_normal.z, -0.999f);  // towards the camera
  // KHR_texture_transform turns the picture, and with it what the picture says of directions
  EXPECT_NEAR(surface({-1, 0, 1, 0, 1, 0}).normal.x, -s.normal.x, 0.01);
  EXPECT_NEAR(std::abs(surface({0, 1, 0, -1, 0, 1}).normal.y), 1, 0.01);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
