#include <algorithm>
#include <array>
#include <utility>

#include "tests/shared_folder.h"
#include "tests/simulator/scene/gltf/gltf_builder.h"

namespace dualpixel::simulator {
namespace {

/// Real files, not ours, which stand beside the repository on some machines only.
class GltfAssets : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = shared_folder() / "data/gltf";
    if (!std::filesystem::is_directory(folder_)) {
      GTEST_SKIP() << folder_ << " is absent (DUALPIXEL_SHARED may name the folder that holds data/gltf)";
    }
  }
  Scene read(const std::string& name) const { return read_gltf((folder_ / name).string()); }

  std::string message(const std::string& name) const {
    const std::string text = refusal([&] { read(name); });
    const std::string file = (folder_ / name).string() + ": ";
    EXPECT_TRUE(text.starts_with(file)) << text;
    return text.substr(std::min(text.size(), file.size()));
  }

 private:
  std::filesystem::path folder_;
};

TEST_F(GltfAssets, TrianglesOfRealFiles) {
  const std::pair<const char*, std::size_t> files[] = {
      {"gltf-transform/Box.glb", 12},
      {"gltf-transform/BoxTextured/BoxTextured.gltf", 12},
      {"gltf-transform/BoxVertexColors.glb", 12},
      {"gltf-transform/ShapeCollection.glb", 3542},
      {"tinygltf/Cube/Cube.gltf", 12},
      {"tinygltf/Cube-texture-ext/Cube-textransform.gltf", 12},
      {"tinygltf/CubeImageUriSpaces/CubeImageUriSpaces.gltf", 12},
      {"tinygltf/CubeImageUriSpaces/CubeImageUriMultipleSpaces.gltf", 12},
      {"tinygltf/SparseMorphTargets-issue280/singleBlendshapeCube_sparse.glb", 12},
      {"tinygltf/box01.glb", 12},
      // Kept by tinygltf as reminders of its own bugs, yet valid:
      {"tinygltf/regression/unassigned-skeleton.gltf", 8},
      {"tinygltf/regression/zero-sized-bin-chunk-issue-440.glb", 1},
  };
  for (const auto& [name, count] : files) {
    const Scene scene = read(name);
    std::size_t triangles = 0;
    for (const Mesh& mesh : scene.meshes) {
      triangles += mesh.triangles.size() * std::max<std::size_t>(mesh.placements.size(), 1);
    }
    EXPECT_EQ(triangles, count) << name;
  }
}

TEST_F(GltfAssets, TexturesColoursAndTransforms) {
  const Scene spaces = read("tinygltf/CubeImageUriSpaces/CubeImageUriMultipleSpaces.gltf");
  ASSERT_EQ(spaces.textures.size(), 1u);
  EXPECT_EQ(spaces.textures[0].width, 2);
  EXPECT_EQ(spaces.textures[0].height, 2);
  EXPECT_EQ(read("gltf-transform/BoxVertexColors.glb").meshes[0].colors.size(), 24u);
  // Offset (0, 1), a quarter turn, scale 0.5: the unit square stays inside it only if the turn has the right sign.
  const Scene transformed = read("tinygltf/Cube-texture-ext/Cube-textransform.gltf");
  const std::array<float, 6> map = transformed.materials[1].metallic_roughness_texture.uv_from_uv;
  const float expected[] = {0, 0.5f, 0, -0.5f, 0, 1};
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(map[i], expected[i], 1e-6f) << i;
}

TEST_F(GltfAssets, MalformedFilesAreRefusedWithTheirFault) {
  EXPECT_EQ(message("tinygltf/BoundsChecking/integer-out-of-bounds.gltf"),
            "/bufferViews/0/byteLength: 1e+300: must be an integer in [1, 44]");
  EXPECT_EQ(message("tinygltf/BoundsChecking/invalid-buffer-index.gltf"),
            "/bufferViews/1/buffer: 1: must be an integer in [0, 0], an index into buffers");
  EXPECT_EQ(message("tinygltf/BoundsChecking/invalid-buffer-view-index.gltf"),
            "/bufferViews/0/buffer: 0: the file has no buffers");
  EXPECT_EQ(message("tinygltf/BoundsChecking/invalid-primitive-indices.gltf"),
            "/bufferViews/0/buffer: 0: the file has no buffers");
}

TEST_F(GltfAssets, CompressedMeshesAreRefusedByTheExtensionsName) {
  EXPECT_TRUE(message("gltf-transform/DenseSphere.glb")
                  .starts_with("/extensionsRequired/1: \"KHR_draco_mesh_compression\": this required extension"));
}

}  // namespace
}  // namespace dualpixel::simulator
