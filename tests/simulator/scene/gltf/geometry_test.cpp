#include <cmath>

#include "tests/simulator/scene/gltf/gltf_builder.h"

namespace dualpixel::simulator {
namespace {

using nlohmann::json;

void expect_near(glm::vec3 a, glm::vec3 b, float tolerance = 1e-6f) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

/// Normal of a triangle by its winding.
glm::vec3 face_normal(const Mesh& mesh, std::size_t i = 0) {
  const glm::uvec3 t = mesh.triangles[i];
  return glm::normalize(
      glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
}

TEST(GltfGeometry, ATriangleWithoutIndices) {
  const Scene scene = one_triangle().read();
  ASSERT_EQ(scene.meshes.size(), 1u);
  const Mesh& mesh = scene.meshes[0];
  ASSERT_EQ(mesh.positions.size(), 3u);
  EXPECT_EQ(mesh.positions[1], glm::vec3(1, 0, 0));
  ASSERT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(mesh.triangles[0], glm::uvec3(0, 1, 2));
  EXPECT_EQ(mesh.object_id, 1u);
  EXPECT_FALSE(mesh.person);
  EXPECT_TRUE(mesh.normals.empty());
  EXPECT_EQ(scene.object_names, std::vector<std::string>{"triangle"});
  EXPECT_EQ(mesh.material, 0);  // the default one, appended to none
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.materials[0].metallic, 1);
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(GltfGeometry, IndicesOfEveryWidth) {
  for (const int width : {1, 2, 4}) {
    GltfBuilder gltf = one_triangle();
    const int indices = width == 1   ? gltf.add_accessor<std::uint8_t>({2, 0, 1}, "SCALAR")
                        : width == 2 ? gltf.add_accessor<std::uint16_t>({2, 0, 1}, "SCALAR")
                                     : gltf.add_accessor<std::uint32_t>({2, 0, 1}, "SCALAR");
    if (width == 4) gltf.root["accessors"][indices]["componentType"] = 5125;
    gltf.primitive()["indices"] = indices;
    EXPECT_EQ(gltf.read().meshes[0].triangles[0], glm::uvec3(2, 0, 1)) << width;
  }
}

TEST(GltfGeometry, StripsAndFansBecomeLists) {
  GltfBuilder gltf = one_triangle();
  gltf.primitive()["attributes"]["POSITION"] =
      gltf.add_accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0}, "VEC3");
  gltf.primitive()["mode"] = 5;
  const std::vector<glm::uvec3> strip = {{0, 1, 2}, {1, 3, 2}, {2, 3, 4}};
  const Mesh mesh = gltf.read().meshes[0];
  EXPECT_EQ(mesh.triangles, strip);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(face_normal(mesh, i), glm::vec3(0, 0, 1));

  gltf.primitive()["attributes"]["POSITION"] = gltf.add_accessor<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, "VEC3");
  gltf.primitive()["mode"] = 6;
  const std::vector<glm::uvec3> fan = {{1, 2, 0}, {2, 3, 0}};
  EXPECT_EQ(gltf.read().meshes[0].triangles, fan);
}

TEST(GltfGeometry, PointsAndLinesAreNoTriangles) {
  GltfBuilder gltf = one_triangle();
  json points = gltf.primitive();
  points["mode"] = 0;
  gltf.root["meshes"][0]["primitives"].push_back(points);
  EXPECT_EQ(gltf.read().meshes.size(), 1u);
}

TEST(GltfGeometry, StrideAndOffsets) {
  GltfBuilder gltf = one_triangle();
  // x y z u v, interleaved
  const std::vector<float> data = {0, 0, 0, 0.25f, 0.5f, 2, 0, 0, 1, 0, 0, 3, 0, 0, 1};
  const int view = gltf.add_view(data.data(), data.size() * 4, 20);
  const json uv = {{"bufferView", view}, {"byteOffset", 12}, {"componentType", 5126}, {"count", 3}, {"type", "VEC2"}};
  const json position = {{"bufferView", view}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}};
  gltf.root["accessors"].push_back(position);
  gltf.root["accessors"].push_back(uv);
  gltf.primitive()["attributes"] = {{"POSITION", 1}, {"TEXCOORD_0", 2}};
  const Mesh mesh = gltf.read().meshes[0];
  EXPECT_EQ(mesh.positions[2], glm::vec3(0, 3, 0));
  EXPECT_EQ(mesh.uv0[0], glm::vec2(0.25f, 0.5f));
  EXPECT_EQ(mesh.uv0[2], glm::vec2(0, 1));
}

TEST(GltfGeometry, SparseAccessorsReplaceElements) {
  for (const bool with_view : {true, false}) {
    GltfBuilder gltf = one_triangle();
    const std::uint16_t indices[] = {1, 2};
    const float values[] = {5, 0, 0, 0, 7, 0};
    const int indices_view = gltf.add_view(indices, sizeof(indices));
    const int values_view = gltf.add_view(values, sizeof(values));
    json& accessor = gltf.root["accessors"][0];
    if (!with_view) accessor.erase("bufferView");
    accessor["sparse"] = {{"count", 2},
                          {"indices", {{"bufferView", indices_view}, {"componentType", 5123}}},
                          {"values", {{"bufferView", values_view}}}};
    const Mesh mesh = gltf.read().meshes[0];
    EXPECT_EQ(mesh.positions[0], glm::vec3(0));
    EXPECT_EQ(mesh.positions[1], glm::vec3(5, 0, 0));
    EXPECT_EQ(mesh.positions[2], glm::vec3(0, 7, 0));
  }
}

TEST(GltfGeometry, QuantizedAttributes) {
  GltfBuilder gltf = one_triangle();
  gltf.root["extensionsRequired"] = gltf.root["extensionsUsed"] = {"KHR_mesh_quantization"};
  const std::vector<std::int16_t> positions = {0, 0, 0, 0, 100, 0, 0, 0, 0, -200, 0, 0};  // padded to 8 bytes
  const int view = gltf.add_view(positions.data(), positions.size() * 2, 8);
  gltf.root["accessors"].push_back({{"bufferView", view}, {"componentType", 5122}, {"count", 3}, {"type", "VEC3"}});
  const std::vector<std::int8_t> normals = {0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0};
  const int normals_view = gltf.add_view(normals.data(), normals.size(), 4);
  gltf.root["accessors"].push_back(
      {{"bufferView", normals_view}, {"componentType", 5120}, {"normalized", true}, {"count", 3}, {"type", "VEC3"}});
  const int uv = gltf.add_accessor<std::uint16_t>({0, 65535, 13107, 0, 0, 0}, "VEC2", true);
  gltf.primitive()["attributes"] = {{"POSITION", 1}, {"NORMAL", 2}, {"TEXCOORD_0", uv}};
  gltf.node()["scale"] = {0.01, 0.01, 0.01};
  const Mesh mesh = gltf.read().meshes[0];
  expect_near(mesh.positions[1], {1, 0, 0});
  expect_near(mesh.positions[2], {0, -2, 0});
  expect_near(mesh.normals[0], {0, 0, 1});
  EXPECT_FLOAT_EQ(mesh.uv0[0].y, 1);
  EXPECT_FLOAT_EQ(mesh.uv0[1].x, 0.2f);  // 13107 / 65535
}

TEST(GltfGeometry, NormalizedSignedIntegersEndAtMinusOne) {
  GltfBuilder gltf = one_triangle();
  gltf.root["extensionsUsed"] = {"KHR_mesh_quantization"};
  gltf.primitive()["attributes"]["POSITION"] =
      gltf.add_accessor<std::int16_t>({-32768, 0, 0, 0, 32767, 0, 0, 0, 0}, "VEC3", true);
  const Mesh mesh = gltf.read().meshes[0];
  EXPECT_EQ(mesh.positions[0].x, -1);
  EXPECT_EQ(mesh.positions[1].y, 1);
}

TEST(GltfGeometry, ColorsAreLinearAndHaveAlpha) {
  GltfBuilder gltf = one_triangle();
  gltf.primitive()["attributes"]["COLOR_0"] =
      gltf.add_accessor<std::uint8_t>({255, 0, 51, 102, 0, 0, 0, 255, 1, 2, 3, 4}, "VEC4", true);
  const glm::vec4 c = gltf.read().meshes[0].colors[0];
  EXPECT_FLOAT_EQ(c.r, 1);
  EXPECT_FLOAT_EQ(c.b, 0.2f);
  EXPECT_FLOAT_EQ(c.a, 0.4f);
  gltf.primitive()["attributes"]["COLOR_0"] = gltf.add_accessor<float>({0.5f, 0.25f, 2, 0, 0, 0, 0, 0, 0}, "VEC3");
  EXPECT_EQ(gltf.read().meshes[0].colors[0], glm::vec4(0.5f, 0.25f, 1, 1));
}

TEST(GltfGeometry, TransformsComposeDownTheTree) {
  GltfBuilder gltf = one_triangle();
  const float h = std::sqrt(0.5f);
  gltf.root["nodes"] = {{{"translation", {10, 0, 0}}, {"rotation", {0, 0, h, h}}, {"children", {1}}},
                        {{"mesh", 0}, {"scale", {2, 3, 1}}, {"translation", {1, 0, 0}}}};
  const Scene scene = gltf.read();
  const Mesh& mesh = scene.meshes[0];
  // Scaled, moved by +x, turned by 90 degrees about z (x becomes y), moved by +10 x.
  expect_near(mesh.positions[0], {10, 1, 0}, 1e-5f);
  expect_near(mesh.positions[1], {10, 3, 0}, 1e-5f);
  expect_near(mesh.positions[2], {7, 1, 0}, 1e-5f);
  EXPECT_EQ(mesh.object_id, 2u);
  EXPECT_EQ(scene.object_names[0], "node 0");
}

TEST(GltfGeometry, MatrixIsColumnMajor) {
  GltfBuilder gltf = one_triangle();
  gltf.node()["matrix"] = {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1};
  const Mesh mesh = gltf.read().meshes[0];
  EXPECT_EQ(mesh.positions[1], glm::vec3(4, 6, 6));
  EXPECT_EQ(mesh.positions[2], glm::vec3(3, 5, 6));
}

TEST(GltfGeometry, NormalsFollowNonUniformScale) {
  GltfBuilder gltf = one_triangle();
  const float h = std::sqrt(0.5f);
  gltf.primitive()["attributes"]["NORMAL"] = gltf.add_accessor<float>({h, h, 0, h, h, 0, h, h, 0}, "VEC3");
  gltf.node()["scale"] = {2, 1, 1};
  // The inverse transpose: (1/2, 1, 0), normalized.
  expect_near(gltf.read().meshes[0].normals[0], glm::normalize(glm::vec3(0.5f, 1, 0)));
}

TEST(GltfGeometry, MirroringKeepsWindingAndNormalTogether) {
  GltfBuilder gltf = one_triangle();
  gltf.primitive()["attributes"]["NORMAL"] = gltf.add_accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  for (const json& scale : {json{-1, 1, 1}, json{1, 1, -1}, json{-1, -1, -1}, json{-1, -1, 1}}) {
    gltf.node()["scale"] = scale;
    const Mesh mesh = gltf.read().meshes[0];
    expect_near(mesh.normals[0], {0, 0, scale[2] == -1 ? -1 : 1});
    expect_near(face_normal(mesh), mesh.normals[0]);
  }
}

TEST(GltfGeometry, NormalsWithoutDirectionTakeTheFaces) {
  GltfBuilder gltf = one_triangle();
  gltf.primitive()["attributes"]["NORMAL"] = gltf.add_accessor<float>({0, 0, 0, 0, 1, 0, 0, 0, 2}, "VEC3");
  const Mesh mesh = gltf.read().meshes[0];
  EXPECT_EQ(mesh.normals[0], glm::vec3(0, 0, 1));
  EXPECT_EQ(mesh.normals[1], glm::vec3(0, 1, 0));
  EXPECT_EQ(mesh.normals[2], glm::vec3(0, 0, 1));
}

TEST(GltfGeometry, TrianglesWithoutAreaAreCountedAndLeftOut) {
  GltfBuilder gltf = one_triangle();
  gltf.primitive()["indices"] = gltf.add_accessor<std::uint16_t>({0, 1, 1, 0, 1, 2, 2, 2, 2}, "SCALAR");
  const Scene scene = gltf.read();
  EXPECT_EQ(scene.meshes[0].triangles.size(), 1u);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(scene.warnings[0], "test.glb: /nodes/0/mesh: 2 triangles without area are left out");
}

TEST(GltfGeometry, MorphTargetsAtTheirDefaultWeights) {
  GltfBuilder gltf = one_triangle();
  const int up = gltf.add_accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  const int right = gltf.add_accessor<float>({4, 0, 0, 4, 0, 0, 4, 0, 0}, "VEC3");
  gltf.primitive()["targets"] = {{{"POSITION", up}}, {{"POSITION", right}}};
  EXPECT_EQ(gltf.read().meshes[0].positions[0], glm::vec3(0));
  gltf.root["meshes"][0]["weights"] = {0.5, 0.25};
  EXPECT_EQ(gltf.read().meshes[0].positions[0], glm::vec3(1, 0, 0.5f));
  gltf.node()["weights"] = {1, 0};  // the node's take precedence
  EXPECT_EQ(gltf.read().meshes[0].positions[0], glm::vec3(0, 0, 1));
}

TEST(GltfGeometry, SkinsTakeTheTreesPose) {
  GltfBuilder gltf = one_triangle();
  // Joint 1 (node 2) was bound at x = 1 and now stands at (1, 2, 0), under a root moved by z = 5.
  gltf.root["nodes"] = {{{"mesh", 0}, {"skin", 0}, {"translation", {100, 0, 0}}},
                        {{"children", {2}}, {"translation", {0, 0, 5}}},
                        {{"translation", {1, 2, 0}}}};
  gltf.root["scenes"][0]["nodes"] = {0, 1};
  const int bind = gltf.add_accessor<float>(
      {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1}, "MAT4");
  gltf.root["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", bind}}};
  gltf.primitive()["attributes"]["JOINTS_0"] =
      gltf.add_accessor<std::uint8_t>({0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, "VEC4");
  gltf.primitive()["attributes"]["WEIGHTS_0"] =
      gltf.add_accessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0}, "VEC4");
  const Mesh mesh = gltf.read().meshes[0];
  expect_near(mesh.positions[0], {0, 0, 5});  // all of joint 0; the node's own matrix does not count
  expect_near(mesh.positions[1], {1, 2, 5});  // all of joint 1: (1,0,0) - 1 + (1,2,5)
  expect_near(mesh.positions[2], {0, 2, 5});  // half of each: (0,1,5) and (0,3,5)
}

TEST(GltfGeometry, SkinWeightsOfBothSetsAreNormalised) {
  GltfBuilder gltf = one_triangle();
  gltf.root["nodes"] = {{{"mesh", 0}, {"skin", 0}}, {{"translation", {8, 0, 0}}}, {{"translation", {0, 8, 0}}}};
  gltf.root["scenes"][0]["nodes"] = {0, 1, 2};
  gltf.root["skins"] = {{{"joints", {1, 2}}}};
  json& attributes = gltf.primitive()["attributes"];
  attributes["JOINTS_0"] = gltf.add_accessor(std::vector<std::uint16_t>(12, 0), "VEC4");
  attributes["JOINTS_1"] = gltf.add_accessor(std::vector<std::uint16_t>(12, 1), "VEC4");
  attributes["WEIGHTS_0"] = gltf.add_accessor<float>({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
  attributes["WEIGHTS_1"] = gltf.add_accessor<float>({1, 1, 1, 0, 0, 0, 2, 0, 0, 0, 0, 0}, "VEC4");
  const Mesh mesh = gltf.read().meshes[0];
  expect_near(mesh.positions[0], {2, 6, 0});  // a quarter of joint 0, three of joint 1
  expect_near(mesh.positions[1], {1, 8, 0});  // all of joint 1, though its weight is 2
  expect_near(mesh.positions[2], {8, 1, 0});  // held by none: it follows its first joint
}

TEST(GltfGeometry, OnlyTheDefaultSceneIsShown) {
  GltfBuilder gltf = one_triangle();
  gltf.root["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}}, {{"mesh", 0}}};
  gltf.root["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1, 2}}}};
  gltf.root["scene"] = 1;
  const Scene scene = gltf.read();
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.meshes[0].object_id, 2u);
  EXPECT_EQ(scene.object_names.size(), 3u);
}

TEST(GltfGeometry, PersonsAreMarkedDownTheTree) {
  GltfBuilder gltf = one_triangle();
  gltf.root["nodes"] = {{{"children", {1}}, {"extras", {{"category", "person"}}}},
                        {{"children", {2}}},
                        {{"mesh", 0}},
                        {{"mesh", 0}, {"extras", {{"category", "dog"}}}},
                        {{"mesh", 0}, {"extras", 7}}};
  gltf.root["scenes"][0]["nodes"] = {0, 3, 4};
  const Scene scene = gltf.read();
  ASSERT_EQ(scene.meshes.size(), 3u);
  EXPECT_TRUE(scene.meshes[0].person);
  EXPECT_FALSE(scene.meshes[1].person);
  EXPECT_FALSE(scene.meshes[2].person);
}

TEST(GltfGeometry, ADeepTreeNeedsNoDeepStack) {
  GltfBuilder gltf = one_triangle();
  constexpr int kDepth = 5000;
  gltf.root["nodes"] = json::array();
  for (int i = 0; i < kDepth; ++i)
    gltf.root["nodes"].push_back({{"translation", {0.001, 0, 0}}, {"children", {i + 1}}});
  gltf.root["nodes"].push_back({{"mesh", 0}});
  expect_near(gltf.read().meshes[0].positions[0], {5, 0, 0}, 1e-5f);
}

TEST(GltfGeometry, CamerasArePosesAndFieldsOfView) {
  GltfBuilder gltf = one_triangle();
  gltf.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}},
                          {{"type", "orthographic"},
                           {"name", "flat"},
                           {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0}, {"zfar", 1}}}}};
  const float h = std::sqrt(0.5f);
  // Turned by 90 degrees about y: it looks along -x. The scale must not reach the pose.
  gltf.root["nodes"].push_back(
      {{"camera", 0}, {"name", "view"}, {"translation", {1, 2, 3}}, {"rotation", {0, h, 0, h}}, {"scale", {2, 2, 2}}});
  gltf.root["nodes"].push_back({{"camera", 1}});
  gltf.root["scenes"][0]["nodes"] = {0, 1, 2};
  const Scene scene = gltf.read();
  ASSERT_EQ(scene.cameras.size(), 2u);
  const CameraNode& camera = scene.cameras[0];
  EXPECT_EQ(camera.name, "view");
  EXPECT_FLOAT_EQ(camera.vertical_fov_rad.value(), 0.7f);
  expect_near(glm::vec3(camera.world_from_node * glm::vec4(0, 0, -1, 0)), {-1, 0, 0});
  expect_near(glm::vec3(camera.world_from_node * glm::vec4(0, 1, 0, 0)), {0, 1, 0});
  expect_near(glm::vec3(camera.world_from_node * glm::vec4(1, 0, 0, 0)), {0, 0, -1});
  expect_near(glm::vec3(camera.world_from_node[3]), {1, 2, 3});
  EXPECT_EQ(scene.cameras[1].name, "flat");
  EXPECT_FALSE(scene.cameras[1].vertical_fov_rad.has_value());
}

TEST(GltfGeometry, PunctualLights) {
  GltfBuilder gltf = one_triangle();
  gltf.root["extensionsUsed"] = {"KHR_lights_punctual"};
  gltf.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"color", {1, 0.5, 0.25}}, {"intensity", 8}, {"range", 3}},
      {{"type", "spot"}, {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.5}}}},
      {{"type", "directional"}, {"intensity", 1000}}};
  const float h = std::sqrt(0.5f);
  const auto node = [](int light, const json& translation, const json& rotation) {
    return json{{"translation", translation},
                {"rotation", rotation},
                {"extensions", {{"KHR_lights_punctual", {{"light", light}}}}}};
  };
  gltf.root["nodes"].push_back(node(0, {1, 2, 3}, {0, 0, 0, 1}));
  gltf.root["nodes"].push_back(node(1, {0, 0, 0}, {-h, 0, 0, h}));  // -90 degrees about x: downwards
  gltf.root["nodes"].push_back(node(2, {0, 0, 0}, {0, 0, 0, 1}));
  gltf.root["scenes"][0]["nodes"] = {0, 1, 2, 3};
  const Scene scene = gltf.read();
  ASSERT_EQ(scene.lights.size(), 3u);
  EXPECT_EQ(scene.lights[0].kind, PunctualLight::Kind::point);
  EXPECT_EQ(scene.lights[0].intensity, glm::vec3(8, 4, 2));
  EXPECT_EQ(scene.lights[0].position, glm::vec3(1, 2, 3));
  EXPECT_EQ(scene.lights[0].range_m, 3);
  EXPECT_EQ(scene.lights[1].kind, PunctualLight::Kind::spot);
  expect_near(scene.lights[1].direction, {0, -1, 0});
  EXPECT_FLOAT_EQ(scene.lights[1].cos_inner_cone, std::cos(0.1f));
  EXPECT_FLOAT_EQ(scene.lights[1].cos_outer_cone, std::cos(0.5f));
  EXPECT_EQ(scene.lights[1].intensity, glm::vec3(1));
  EXPECT_EQ(scene.lights[2].kind, PunctualLight::Kind::directional);
  EXPECT_EQ(scene.lights[2].intensity, glm::vec3(1000));
  expect_near(scene.lights[2].direction, {0, 0, -1});
  EXPECT_EQ(scene.lights[2].range_m, 0);
}

TEST(GltfGeometry, LinesWithWidthsAreStrands) {
  for (const int mode : {1, 2, 3}) {
    GltfBuilder gltf;
    auto& p = gltf.primitive();
    p["attributes"]["POSITION"] = gltf.add_accessor<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 1, 1, 1}, "VEC3");
    p["attributes"]["_WIDTH"] = gltf.add_accessor<float>({0.1f, 0.2f, 0.3f, 0.4f}, "SCALAR");
    p["mode"] = mode;
    gltf.root["nodes"] = {{{"mesh", 0}, {"scale", {2, 2, 2}}}};
    gltf.root["scenes"] = {{{"nodes", {0}}}};
    const Scene scene = gltf.read();
    const Mesh& mesh = scene.meshes.at(0);
    EXPECT_TRUE(mesh.is_hair());
    EXPECT_FLOAT_EQ(mesh.radii.at(1), 0.2f);  // half of the width, twice as large
    EXPECT_EQ(mesh.positions.at(3), glm::vec3(2, 2, 2));
    const std::size_t segments[] = {0, 2, 4, 3};
    ASSERT_EQ(mesh.triangles.size(), segments[mode]);
    EXPECT_EQ(mesh.triangles[1], mode == 1 ? glm::uvec3(2, 3, 2) : glm::uvec3(1, 2, 1));
  }
}

TEST(GltfGeometry, WidthsMustBePositive) {
  GltfBuilder gltf;
  auto& p = gltf.primitive();
  p["attributes"]["POSITION"] = gltf.add_accessor<float>({0, 0, 0, 1, 0, 0}, "VEC3");
  p["attributes"]["_WIDTH"] = gltf.add_accessor<float>({0.1f, 0}, "SCALAR");
  p["mode"] = 1;
  gltf.root["nodes"] = {{{"mesh", 0}}};
  gltf.root["scenes"] = {{{"nodes", {0}}}};
  EXPECT_NE(refusal([&] { gltf.read(); }).find("width 0 of vertex 1: must be above 0"), std::string::npos);
}

GltfBuilder one_strand(float width, double scale, int mode = 1) {
  GltfBuilder gltf;
  auto& p = gltf.primitive();
  p["attributes"]["POSITION"] = gltf.add_accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  p["attributes"]["_WIDTH"] = gltf.add_accessor<float>({0.1f, width, 0.1f}, "SCALAR");
  p["mode"] = mode;
  gltf.root["nodes"] = {{{"mesh", 0}, {"scale", {scale, scale, scale}}}};
  gltf.root["scenes"] = {{{"nodes", {0}}}};
  return gltf;
}

TEST(GltfGeometry, WidthsAreBounded) {
  EXPECT_NE(refusal([] {
              one_strand(1e30f, 1).read();
            }).find("/accessors/1: width of vertex 1: its half, 5e+29 m in the world, must be 1e-09 to 1e+06 m"),
            std::string::npos);
  EXPECT_NE(refusal([] { one_strand(1e-30f, 1e-6).read(); }).find("width of vertex 1: its half"), std::string::npos);
  EXPECT_FLOAT_EQ(one_strand(4e-6f, 1e-3).read().meshes.at(0).radii.at(1), 2e-9f);
}

// Attributes that begin with an underscore are the application's, but for the one that makes lines strands.
TEST(GltfGeometry, WidthsOfTrianglesAreNotChecked) {
  for (const int mode : {1, 4}) {
    GltfBuilder gltf = one_strand(0.1f, 1, mode);
    gltf.primitive()["attributes"]["_WIDTH"] = 0;  // VEC3
    if (mode == 4) {
      EXPECT_FALSE(gltf.read().meshes.at(0).is_hair());
    } else {
      EXPECT_NE(refusal([&] { gltf.read(); }).find("must be SCALAR of FLOAT"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace dualpixel::simulator
