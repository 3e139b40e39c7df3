// What the reader stores once and what it copies.
#include "tests/simulator/scene/gltf/placed_sheets.h"

namespace dualpixel::simulator {
namespace {

using nlohmann::json;

constexpr std::size_t kVertices = 13 * 13, kTriangles = 2 * 12 * 12;

std::size_t stored_vertices(const Scene& scene) {
  std::size_t sum = 0;
  for (const Mesh& mesh : scene.meshes) sum += mesh.positions.size();
  return sum;
}

std::size_t placements(const Scene& scene) {
  std::size_t sum = 0;
  for (const Mesh& mesh : scene.meshes) sum += mesh.placements.size();
  return sum;
}

/// Two nodes, beside each other, and what a test does to them.
template <typename Bend>
Scene two_sheets(const Bend& bend) {
  GltfBuilder gltf = placed_sheets(json::parse(R"([{}, {"translation": [3, 0, 0]}])"), true);
  bend(gltf);
  return gltf.read();
}

TEST(GltfInstance, AMeshOfSeveralNodesIsStoredOnce) {
  const Scene scene = placed_sheets(sheets_in_view(), true).read();
  ASSERT_EQ(scene.meshes.size(), 1u);
  const Mesh& mesh = scene.meshes[0];
  EXPECT_EQ(mesh.positions.size(), kVertices);
  EXPECT_EQ(mesh.triangles.size(), kTriangles);
  ASSERT_EQ(mesh.placements.size(), 6u);
  for (std::uint32_t i = 0; i < 6; ++i) {
    EXPECT_EQ(mesh.placements[i].object_id, i + 1);
    EXPECT_EQ(mesh.placements[i].person, i == 1);
  }
}

// Each vertex of each instance is that of the copy, up to the rounding of its own coordinates (at most 1), of the
// matrix, of their products and sums in float, and of the copy: 7 of half an ulp of the largest term at most.
TEST(GltfInstance, PlacementsLeadToWhereTheCopiesAre) {
  for (const double far : {0.0, 3e4}) {  // a mesh that stands far from its own origin loses nothing by it
    const json nodes =
        far > 0 ? json::parse(R"([{"translation": [-3e4, 0, 5]}, {"translation": [-3e4, 2, 5]}])") : sheets_in_view();
    GltfBuilder builders[] = {placed_sheets(nodes, true), placed_sheets(nodes, false)};
    for (GltfBuilder& gltf : builders) {
      auto* positions = reinterpret_cast<float*>(gltf.bin.data());
      for (std::size_t i = 0; far > 0 && i < 3 * kVertices; i += 3) {
        positions[i] = std::round(64 * positions[i]) / 64 + static_cast<float>(far);
      }
    }
    const Scene shared = builders[0].read(), copied = builders[1].read();
    ASSERT_EQ(shared.meshes.size(), 1u);
    ASSERT_EQ(copied.meshes.size(), nodes.size());
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      const glm::mat4x3& matrix = shared.meshes[0].placements[k].world_from_mesh;
      for (std::size_t i = 0; i < kVertices; ++i) {
        const glm::vec3 own = shared.meshes[0].positions[i], there = copied.meshes[k].positions[i];
        const glm::vec3 here = matrix * glm::vec4(own, 1);
        for (int c = 0; c < 3; ++c) {
          EXPECT_LE(std::abs(own[c]), 1);
          float terms = std::abs(matrix[3][c]);
          for (int j = 0; j < 3; ++j) terms += std::abs(matrix[j][c]);
          EXPECT_NEAR(here[c], there[c], 7 * 0x1p-24f * terms) << k << ' ' << i;
        }
      }
    }
  }
}

TEST(GltfInstance, CopiesAreMadeWhereAnInstanceCannotBe) {
  EXPECT_EQ(placements(two_sheets([](GltfBuilder&) {})), 2u);
  const auto expect_copies = [](const char* what, const Scene& scene, std::size_t copies) {
    EXPECT_EQ(scene.meshes.size() - (placements(scene) > 0), copies) << what;
    for (const Mesh& mesh : scene.meshes) EXPECT_TRUE(mesh.placements.empty() || mesh.object_id == 0) << what;
  };
  expect_copies("a mesh used once", placed_sheets(json::parse("[{}]"), true).read(), 1);
  expect_copies("few triangles", placed_sheets(json::parse("[{}, {}]"), true, 2).read(), 2);
  expect_copies("many of few triangles", placed_sheets(json(100, json::object()), true, 2).read(), 0);
  expect_copies("emission", two_sheets([](GltfBuilder& g) { g.material()["emissiveFactor"] = {0, 0.1, 0}; }), 2);
  expect_copies("weights of the node's own", two_sheets([](GltfBuilder& g) {
                  g.primitive()["targets"] = {{{"POSITION", 0}}};
                  g.root["meshes"][0]["weights"] = {0};
                  g.node(1)["weights"] = {1};
                }),
                2);
  expect_copies("a node outside of the scene", two_sheets([](GltfBuilder& g) { g.root["scenes"][0]["nodes"] = {1}; }),
                1);
  // of three nodes only the one that is bent
  const auto of_three = [&](const char* what, const json& bent) {
    expect_copies(what, two_sheets([&](GltfBuilder& g) {
                    g.root["nodes"].push_back({{"mesh", 0}});
                    g.root["nodes"].back().update(bent);
                    g.root["scenes"][0]["nodes"].push_back(2);
                  }),
                  1);
  };
  of_three("flat", {{"scale", {1, 1, 1e-7}}});
  of_three("sheared", {{"matrix", {1, 0, 0, 0, 8, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}});
  of_three("tiny", {{"scale", {1e-7, 1e-7, 1e-7}}});
  of_three("large", {{"scale", {6e5, 1, 1}}});
}

// Which nodes share must not change from one moment to the next: those that move have copies at any time.
TEST(GltfInstance, NodesThatMoveHaveCopies) {
  GltfBuilder gltf = placed_sheets(json::parse(R"([{}, {}, {"children": [3]}, {}])"), true);
  const json sampler = {{"input", gltf.add_accessor<float>({0, 1}, "SCALAR")},
                        {"output", gltf.add_accessor<float>({0, 0, 0, 1, 0, 0}, "VEC3")}};
  const json channel = {{"sampler", 0}, {"target", {{"node", 2}, {"path", "translation"}}}};
  gltf.root["animations"] = json::array({{{"samplers", {sampler}}, {"channels", {channel}}}});
  EXPECT_EQ(placements(gltf.read()), 4u);
  const Scene moving = read_gltf_bytes(gltf.glb(), "test.glb", "", 0.5);
  ASSERT_EQ(moving.meshes.size(), 3u);
  EXPECT_EQ(moving.meshes[0].placements.size(), 2u);
  EXPECT_EQ(moving.meshes[1].object_id, 3u);
  EXPECT_EQ(moving.meshes[2].object_id, 4u);
  EXPECT_EQ(moving.meshes[2].positions[0].x, -0.5f);
}

TEST(SlowGltfInstance, TooManyAndSingularAndTooFarPlacementsAreRefused) {
  // 1024 primitives of one mesh, 1025 nodes: 2^20 placements and 1024 more
  json nodes = json::array();
  for (int i = 0; i < 1025; ++i) nodes.push_back(json::object());
  GltfBuilder gltf = placed_sheets(nodes, true, 6);
  const json primitive = gltf.primitive();
  for (int i = 1; i < 1024; ++i) gltf.root["meshes"][0]["primitives"].push_back(primitive);
  EXPECT_EQ(refusal([&] { gltf.read(); }),
            "test.glb: /nodes/1024/mesh: 0: the scene must place primitives at most 1048576 times");
  gltf.root["scenes"][0]["nodes"].erase(1024);
  const Scene scene = gltf.read();
  EXPECT_EQ(placements(scene), std::size_t{1} << 20);
  EXPECT_EQ(stored_vertices(scene), 1024u * 7 * 7);

  const auto message = [](const json& transform) {
    return refusal([&] { two_sheets([&](GltfBuilder& g) { g.node(1).update(transform); }); });
  };
  EXPECT_TRUE(
      message({{"translation", {2e6, 0, 0}}}).starts_with("test.glb: /accessors/0: vertex 0 stands at (2e+06, "));
  EXPECT_EQ(message({{"scale", {0, 1, 1}}}),
            "test.glb: /nodes/1/scale: [0, 1, 1]: a singular transform: must not be 0");
  EXPECT_TRUE(message({{"scale", {1e9, 1, 1}}}).starts_with("test.glb: /accessors/0: vertex 0 stands at (-1e+09, "));
}

// 68 nodes that instance a million vertices share them; copies would be 2^26 and more.
TEST(SlowGltfInstance, SharedVerticesCountOnce) {
  const auto with_emission = [](double red) {
    json nodes = json::array();
    for (int i = 0; i < 68; ++i) nodes.push_back(json::object());
    GltfBuilder gltf = placed_sheets(nodes, true);
    gltf.material()["emissiveFactor"] = {red, 0, 0};
    json primitive = gltf.primitive();
    gltf.root["accessors"].push_back({{"componentType", 5126}, {"count", 1000000}, {"type", "VEC3"}});  // all at 0
    primitive["attributes"] = {{"POSITION", 4}};
    gltf.root["meshes"][0]["primitives"].push_back(primitive);
    return gltf;
  };
  EXPECT_EQ(placements(with_emission(0).read()), 68u);
  EXPECT_EQ(refusal([&] { with_emission(1).read(); }),
            "test.glb: /nodes/67/mesh: 0: the scene must have at most 67108864 vertices and corners of triangles, "
            "those of a shared mesh counted once");
}

}  // namespace
}  // namespace dualpixel::simulator
