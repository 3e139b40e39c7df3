// Pictures of a file under construction, which other threads encode meanwhile.
#include "scenes/gltf/glb.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstdint>
#include <utility>

#include "capture/files.h"
#include "simulator/scene/gltf/gltf.h"
#include "tests/temporary_folder.h"

namespace dualpixel::scenes {
namespace {

constexpr int kSize = 512, kPictures = 100;  // more than may wait at a time

Texture picture(int index) {
  Texture texture{kSize, std::vector<std::uint8_t>(std::size_t{3} * kSize * kSize)};
  for (std::size_t i = 0; i < texture.rgb.size(); ++i) {
    texture.rgb[i] = static_cast<std::uint8_t>(i * (2 * static_cast<std::size_t>(index) + 1) >> 8);
  }
  return texture;
}

Glb with_pictures() {
  Glb glb;
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.uvs = {{0, 0}, {1, 0}, {0, 1}};
  mesh.triangles = {{0, 1, 2}};
  for (int i = 0; i < kPictures; ++i) {
    glb.add_node("part", mesh, glb.add_material(glb.add_texture(picture(i)), glm::vec3(1), true));
  }
  return glb;
}

TEST(Glb, HoldsItsPicturesInTheirOrderForAnyThreads) {
  const TemporaryFolder folder;
  const std::string by_all = (folder.path / "all.glb").string(), by_one = (folder.path / "one.glb").string();
  with_pictures().write(by_all);
  with_pictures();  // dropped while its pictures are encoded
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    Glb glb = with_pictures();
    const Glb moved = std::move(glb);
    moved.write(by_one);
  }
  EXPECT_TRUE(read_file(by_all, 1 << 28) == read_file(by_one, 1 << 28));
  const simulator::Scene scene = simulator::read_gltf(by_all);
  ASSERT_EQ(scene.textures.size(), static_cast<std::size_t>(kPictures));
  for (int i = 0; i < kPictures; ++i) {
    const Texture made = picture(i);
    int wrong = 0;
    for (std::size_t t = 0; t < std::size_t{kSize} * kSize; ++t) {
      for (int c = 0; c < 3; ++c) wrong += scene.textures[i].rgba[4 * t + c] != made.rgb[3 * t + c];
    }
    EXPECT_EQ(wrong, 0) << i;
  }
}

}  // namespace
}  // namespace dualpixel::scenes
