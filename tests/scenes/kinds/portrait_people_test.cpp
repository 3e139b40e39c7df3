#include "scenes/kinds/portrait_people.h"

#include <gtest/gtest.h>

#include "capture/image/image_io.h"
#include "scenes/people/makehuman/assets.h"
#include "simulator/simulate.h"
#include "tests/scenes/people/makehuman_assets.h"

namespace dualpixel::scenes {
namespace {

// Eyes of assets keep their picture, a little darker than white (0.9 of its light), and where it is clear nothing is.
TEST(PortraitPeople, AreMadeFromMakeHumansAssets) {
  const TemporaryFolder folder;
  write_makehuman(folder, smallest_body(), R"({"weights": {"head": [[0, 1.0]]}})");
  write_targets(folder, "");
  folder.write("eyes/round/round.mhclo", "obj_file a.obj\nverts 0\n0\n1\n2\n");
  folder.write("eyes/round/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
  std::filesystem::create_directories(folder / "eyes/materials");
  Image iris(4, 4, 4, 0.5f);
  for (int y = 0; y < 4; ++y) {
    iris.at(0, y, 3) = 0, iris.at(1, y, 3) = 1, iris.at(3, y, 3) = 1;
    iris.at(2, y, 3) = 0.6f;
  }
  write_png8(folder / "eyes/materials/iris.png", iris);

  const MakeHumanAssets assets(folder.path.string());
  SceneBuilder build;
  add_person(build, RandomStream(3, false), {.foot = {0, 0, -2}}, &assets);
  build.ambient(glm::vec3(1000));
  build.camera({0, 1.5f, 0}, {0, 1.5f, -1});
  build.glb.write(folder / "scene.glb");
  build.scene["camera"]["focus_distance_m"] = 1;
  const simulator::Scene scene = simulator::load_scene(simulator::read_simulation(build.scene, folder / "scene.json"));
  int eyes = 0;
  for (const simulator::Mesh& mesh : scene.meshes) {
    EXPECT_TRUE(mesh.person);
    const simulator::Material& material = scene.materials[static_cast<std::size_t>(mesh.material)];
    if (material.base_color_texture.texture < 0) continue;
    ++eyes;
    EXPECT_EQ(material.alpha_cutoff, 0.5f);
    const simulator::Texture& texture = scene.textures[static_cast<std::size_t>(material.base_color_texture.texture)];
    ASSERT_EQ(texture.width, 4);
    EXPECT_EQ(texture.bytes()[3], 0);
    EXPECT_EQ(texture.bytes()[4 + 3], 255);
    // sRGB 128 is .2159 of linear light; .9 of that is 121.8
    EXPECT_NEAR(texture.bytes()[4], 122, 1);
    EXPECT_EQ(texture.bytes()[8 + 3], 153);
    EXPECT_NEAR(texture.bytes()[8], 122, 1);
  }
  EXPECT_EQ(eyes, 1);
}

}  // namespace
}  // namespace dualpixel::scenes
