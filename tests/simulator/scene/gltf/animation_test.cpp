#include <cmath>
#include <functional>

#include "tests/simulator/scene/gltf/gltf_builder.h"

namespace dualpixel::simulator {
namespace {

using nlohmann::json;

/// A triangle with one channel: keys at 1 s and 3 s.
GltfBuilder animated(const std::string& path, const std::vector<float>& values, const std::string& interpolation) {
  GltfBuilder gltf = one_triangle();
  const int times = gltf.add_accessor<float>({1, 3}, "SCALAR");
  const int output = gltf.add_accessor<float>(values, path == "rotation" ? "VEC4" : "VEC3");
  const json sampler = {{"input", times}, {"output", output}, {"interpolation", interpolation}};
  const json channel = {{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}};
  gltf.root["animations"] = json::array({{{"samplers", {sampler}}, {"channels", {channel}}}});
  return gltf;
}

glm::vec3 corner_at(const GltfBuilder& gltf, double time_s) {
  return read_gltf_bytes(gltf.glb(), "test.glb", "", time_s).meshes[0].positions[1];  // (1, 0, 0) at rest
}

void expect_position(glm::vec3 a, glm::vec3 b) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-6f);
}

TEST(GltfAnimation, MovesTurnsAndScalesNodes) {
  const GltfBuilder moving = animated("translation", {0, 0, 0, 4, 0, 8}, "LINEAR");
  expect_position(corner_at(moving, 0), {1, 0, 0});    // before the first key
  expect_position(corner_at(moving, 1.5), {2, 0, 2});  // a quarter of the way
  expect_position(corner_at(moving, 9), {5, 0, 8});    // after the last
  expect_position(moving.read().meshes[0].positions[1], {1, 0, 0});
  expect_position(corner_at(animated("translation", {0, 0, 0, 4, 0, 8}, "STEP"), 2.9), {1, 0, 0});
  expect_position(corner_at(animated("scale", {1, 1, 1, 3, 1, 1}, "LINEAR"), 2), {2, 0, 0});
  // a quarter turn about z: half way at 2 s, the shorter way round although the second quaternion is negated
  const float h = std::sqrt(0.5f);
  expect_position(corner_at(animated("rotation", {0, 0, 0, 1, 0, 0, -h, -h}, "LINEAR"), 2), {h, h, 0});
}

TEST(GltfAnimation, IgnoresWithAWarningWhatItCannotPlay) {
  GltfBuilder gltf = animated("translation", std::vector<float>(18, 7.0f), "CUBICSPLINE");
  const Scene scene = read_gltf_bytes(gltf.glb(), "test.glb", "", 2);
  EXPECT_EQ(scene.meshes[0].positions[1], glm::vec3(1, 0, 0));
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("CUBICSPLINE"), std::string::npos);
}

TEST(GltfAnimation, RefusesWhatIsWrongAndNamesIt) {
  const auto message = [](const std::function<void(GltfBuilder&)>& change) {
    GltfBuilder gltf = animated("translation", {0, 0, 0, 4, 0, 8}, "LINEAR");
    change(gltf);
    return refusal([&] { read_gltf_bytes(gltf.glb(), "a.glb", "", 2); });
  };
  const auto channel = [](GltfBuilder& gltf) -> json& { return gltf.root["animations"][0]["channels"][0]; };
  const auto sampler = [](GltfBuilder& gltf) -> json& { return gltf.root["animations"][0]["samplers"][0]; };
  const auto names = [](const std::string& text, const std::string& word) {
    EXPECT_NE(text.find(word), std::string::npos) << text;
  };
  names(message([](GltfBuilder& g) { g.root["animations"] = 3; }), "/animations");
  names(message([&](GltfBuilder& g) { channel(g)["sampler"] = 1; }), "/channels/0/sampler");
  names(message([&](GltfBuilder& g) { channel(g)["target"]["node"] = 5; }), "/target/node");
  names(message([&](GltfBuilder& g) { channel(g)["target"]["path"] = "colour"; }), "/target/path");
  names(message([&](GltfBuilder& g) { channel(g)["target"]["path"] = "rotation"; }), "VEC4");
  names(message([&](GltfBuilder& g) { sampler(g)["input"] = 99; }), "/samplers/0/input");
  names(message([&](GltfBuilder& g) { sampler(g)["input"] = sampler(g)["output"]; }), "SCALAR");
  names(message([&](GltfBuilder& g) { sampler(g)["output"] = g.add_accessor<float>({1, 2, 3}, "VEC3"); }), "VEC3");
  names(message([&](GltfBuilder& g) { sampler(g)["input"] = g.add_accessor<float>({3, 1}, "SCALAR"); }), "increase");
  names(message([&](GltfBuilder& g) { sampler(g)["input"] = g.add_accessor<float>({1, NAN}, "SCALAR"); }), "finite");
  names(message([](GltfBuilder& g) { g.node()["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}; }),
        "matrix");
  GltfBuilder zero = animated("rotation", {0, 0, 0, 1, 0, 0, 0, 0}, "LINEAR");
  names(refusal([&] { read_gltf_bytes(zero.glb(), "a.glb", "", 2); }), "element 1: (0, 0, 0, 0): must not be 0");
}

}  // namespace
}  // namespace dualpixel::simulator
