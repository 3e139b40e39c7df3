#include <sys/stat.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "tests/simulator/scene/gltf/gltf_builder.h"

namespace dualpixel::simulator {
namespace {

using nlohmann::json;

/// The message over a triangle that `bend` has bent; without "test.glb: ", which every one must start with.
std::string message(const std::function<void(GltfBuilder&)>& bend) {
  GltfBuilder gltf = one_triangle();
  bend(gltf);
  const std::string text = refusal([&] { gltf.read(); });
  EXPECT_TRUE(text.starts_with("test.glb: ")) << text;
  return text.substr(std::min<std::size_t>(10, text.size()));
}

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(GltfHostile, Container) {
  const auto refused = [](const std::string& bytes) { return refusal([&] { read_gltf_bytes(bytes, "a.glb", ""); }); };
  const std::string good = one_triangle().glb();
  EXPECT_EQ(refused(good.substr(0, 19)), "a.glb: truncated: 19 bytes; a GLB has at least 20");
  EXPECT_EQ(refused(good.substr(0, good.size() - 4)), "a.glb: the GLB header says " + std::to_string(good.size()) +
                                                          " bytes: must be the file's " +
                                                          std::to_string(good.size() - 4));
  std::string bad = good;
  bad[4] = 1;
  EXPECT_EQ(refused(bad), "a.glb: GLB version 1: must be 2");
  bad = good;
  bad.replace(12, 4, "\xff\xff\xff\xff");
  EXPECT_NE(refused(bad).find("GLB chunk 0: 4294967295 bytes: the file has"), std::string::npos);
  bad = good;
  bad[16] = 'X';
  EXPECT_NE(refused(bad).find("GLB chunk 0: type 0x4e4f5358: must be JSON"), std::string::npos);
  EXPECT_TRUE(refused("").starts_with("a.glb: "));
  EXPECT_TRUE(refused("{\"asset\":").starts_with("a.glb: "));
  EXPECT_TRUE(refused("[]").starts_with("a.glb: "));
  EXPECT_TRUE(refused("null").starts_with("a.glb: "));
}

TEST(GltfHostile, DeepNesting) {
  GltfBuilder gltf = one_triangle();
  std::string text = gltf.root.dump();
  text.insert(1, "\"extras\":" + std::string(20000, '[') + std::string(20000, ']') + ",");
  EXPECT_EQ(refusal([&] { read_gltf_bytes(text, "a.gltf", ""); }), "a.gltf: nested deeper than 256 levels");
}

TEST(GltfHostile, AssetAndExtensions) {
  EXPECT_EQ(message([](auto& g) { g.root.erase("asset"); }), "/asset: is required");
  EXPECT_EQ(message([](auto& g) { g.root["asset"]["version"] = "1.0"; }), "/asset/version: 1.0: must be 2.0");
  EXPECT_EQ(message([](auto& g) { g.root["asset"]["version"] = 2; }), "/asset/version: 2: must be a string");
  EXPECT_EQ(message([](auto& g) { g.root["asset"]["minVersion"] = "2.1"; }), "/asset/minVersion: 2.1: must be 2.0");
  EXPECT_TRUE(message([](auto& g) {
                g.root["extensionsRequired"] = {"KHR_texture_transform", "KHR_draco_mesh_compression"};
              })
                  .starts_with("/extensionsRequired/1: \"KHR_draco_mesh_compression\": this required extension is not "
                               "supported (these are: KHR_lights_punctual, "));
  EXPECT_TRUE(message([](auto& g) {
                g.root["extensionsRequired"] = {"KHR_texture_basisu"};
              }).ends_with("; convert it: gltf-transform ktxdecompress in.glb out.glb"));
  EXPECT_EQ(message([](auto& g) { g.root["extensionsUsed"] = {7}; }), "/extensionsUsed/0: 7: must be a string");
}

TEST(GltfHostile, WhatIsNotReadIsIgnoredWithAWarning) {
  GltfBuilder gltf = one_triangle();
  gltf.root["extensionsUsed"] = {"VENDOR_sparkle"};
  gltf.root["animations"] = {{{"channels", "nonsense"}}};
  gltf.root["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 0}}, {{"NORMAL", 0}, {"COLOR_0", 0}}};
  const Scene scene = gltf.read();
  ASSERT_EQ(scene.warnings.size(), 3u);
  EXPECT_EQ(scene.warnings[0], "test.glb: extension VENDOR_sparkle is ignored");
  EXPECT_EQ(scene.warnings[1], "test.glb: /meshes/0: morph targets of COLOR_0 are ignored");
  EXPECT_NE(scene.warnings[2].find("animations are ignored"), std::string::npos);
}

TEST(GltfHostile, Buffers) {
  EXPECT_EQ(message([](auto& g) {
              g.root["buffers"] = {{{"byteLength", 40}}};
            }),
            "/buffers/0/byteLength: 40: the GLB's binary chunk has 36 bytes");
  EXPECT_EQ(message([](auto& g) {
              g.root["buffers"] = {{{"byteLength", 36}}, {{"byteLength", 36}}};
            }),
            "/buffers/1/uri: is required (only a GLB's buffer 0 does without)");
  EXPECT_EQ(message([](auto& g) {
              g.root["buffers"] = {{{"byteLength", -1}}};
            }),
            "/buffers/0/byteLength: -1: must be an integer in [1, 2147483647]");
  EXPECT_EQ(message([](auto& g) {
              g.root["buffers"] = {{{"byteLength", 36}, {"uri", "data:text/html,x"}}};
            }),
            "/buffers/0/uri: data:text/html,x: a data URI must be base64");
  EXPECT_EQ(message([](auto& g) {
              g.root["buffers"] = {{{"byteLength", 36}, {"uri", "data:application/octet-stream;base64,AAAA"}}};
            }),
            "/buffers/0/byteLength: 36: there are 3 bytes");
  EXPECT_EQ(message([](auto& g) {
              g.root["buffers"] = {{{"byteLength", 36}, {"uri", "a.bin"}}};
            }),
            "/buffers/0/uri: a.bin: must be a data URI: this glTF has no folder of its own");
}

TEST(GltfHostile, Views) {
  const auto view = [](const json& patch) { return message([&](auto& g) { g.root["bufferViews"][0].update(patch); }); };
  EXPECT_EQ(view({{"buffer", 1}}), "/bufferViews/0/buffer: 1: must be an integer in [0, 0], an index into buffers");
  EXPECT_EQ(view({{"byteLength", 37}}), "/bufferViews/0/byteLength: 37: must be an integer in [1, 36]");
  EXPECT_EQ(view({{"byteLength", 1e300}}), "/bufferViews/0/byteLength: 1e+300: must be an integer in [1, 36]");
  EXPECT_EQ(view({{"byteOffset", 18446744073709551612u}}),
            "/bufferViews/0/byteOffset: 18446744073709551612: must be an integer in [0, 35]");
  EXPECT_EQ(view({{"byteOffset", 4}}), "/bufferViews/0/byteLength: 36: must be an integer in [1, 32]");
  EXPECT_EQ(view({{"byteStride", 13}}), "/bufferViews/0/byteStride: 13: must be a multiple of 4");
  EXPECT_EQ(view({{"byteStride", 256}}), "/bufferViews/0/byteStride: 256: must be an integer in [4, 252]");
  EXPECT_EQ(message([](auto& g) { g.root["bufferViews"] = 7; }), "/bufferViews: 7: must be an array");
  EXPECT_EQ(message([](auto& g) { g.root["bufferViews"][0] = 7; }), "/bufferViews/0: 7: must be an object");
}

TEST(GltfHostile, Accessors) {
  const auto accessor = [](const json& patch) {
    return message([&](auto& g) { g.root["accessors"][0].update(patch); });
  };
  EXPECT_EQ(accessor({{"count", 4}}), "/accessors/0/count: 4: reaches to byte 48 of bufferView 0, which has 36 bytes");
  EXPECT_EQ(accessor({{"count", 0}}), "/accessors/0/count: 0: must be an integer in [1, 67108864]");
  EXPECT_EQ(accessor({{"count", "3"}}), "/accessors/0/count: \"3\": must be an integer in [1, 67108864]");
  EXPECT_EQ(accessor({{"byteOffset", 4}}),
            "/accessors/0/count: 3: reaches to byte 40 of bufferView 0, which has 36 bytes");
  EXPECT_EQ(accessor({{"byteOffset", 18446744073709551615u}}),
            "/accessors/0/byteOffset: 18446744073709551615: must be an integer in [0, 2147483647]");
  EXPECT_EQ(accessor({{"bufferView", 1}}),
            "/accessors/0/bufferView: 1: must be an integer in [0, 0], an index into bufferViews");
  EXPECT_TRUE(accessor({{"componentType", 5124}}).starts_with("/accessors/0/componentType: 5124: must be one of 5120"));
  EXPECT_TRUE(accessor({{"type", "VEC5"}}).starts_with("/accessors/0/type: \"VEC5\": must be one of 'SCALAR'"));
  EXPECT_EQ(message([](auto& g) { g.root["bufferViews"][0]["byteStride"] = 8; }),
            "/accessors/0/bufferView: 0: its byteStride of 8 is less than an element's 12 bytes");
}

TEST(GltfHostile, SparseAccessors) {
  const auto sparse = [](const json& patch, const std::vector<std::uint16_t>& elements = {0, 2}) {
    return message([&](auto& g) {
      const int indices = g.add_view(elements.data(), elements.size() * 2);
      const std::vector<float> values(elements.size() * 3);
      json sparse_json = {{"count", elements.size()},
                          {"indices", {{"bufferView", indices}, {"componentType", 5123}}},
                          {"values", {{"bufferView", g.add_view(values.data(), values.size() * 4)}}}};
      sparse_json.merge_patch(patch);
      g.root["accessors"][0]["sparse"] = sparse_json;
    });
  };
  EXPECT_EQ(sparse(json::object(), {0, 3}),
            "/accessors/0/sparse/indices: entry 1 is 3: must increase and be less than 3");
  EXPECT_EQ(sparse(json::object(), {2, 2}),
            "/accessors/0/sparse/indices: entry 1 is 2: must increase and be less than 3");
  EXPECT_EQ(sparse({{"count", 4}}), "/accessors/0/sparse/count: 4: must be an integer in [1, 3]");
  EXPECT_EQ(sparse({{"count", 3}}),
            "/accessors/0/sparse/indices/count: 3: reaches to byte 6 of bufferView 1, which has 4 bytes");
  EXPECT_EQ(sparse({{"values", {{"byteOffset", 4}}}}),
            "/accessors/0/sparse/values/count: 2: reaches to byte 28 of bufferView 2, which has 24 bytes");
  EXPECT_EQ(sparse({{"indices", {{"bufferView", 9}}}}),
            "/accessors/0/sparse/indices/bufferView: 9: must be an integer in [0, 2], an index into bufferViews");
}

TEST(GltfHostile, Meshes) {
  EXPECT_EQ(message([](auto& g) { g.primitive()["attributes"] = json::object(); }),
            "/meshes/0/primitives/0/attributes/POSITION: is required");
  EXPECT_EQ(message([](auto& g) { g.primitive()["attributes"]["POSITION"] = 5; }),
            "/meshes/0/primitives/0/attributes/POSITION: 5: must be an integer in [0, 0], an index into accessors");
  EXPECT_EQ(
      message([](auto& g) { g.primitive()["attributes"]["NORMAL"] = g.add_accessor(std::vector<float>(6), "VEC3"); }),
      "/meshes/0/primitives/0/attributes/NORMAL: 1: has 2 elements: must have 3, as POSITION has");
  EXPECT_EQ(
      message([](auto& g) { g.primitive()["attributes"]["NORMAL"] = g.add_accessor(std::vector<float>(6), "VEC2"); }),
      "/meshes/0/primitives/0/attributes/NORMAL: 1: is VEC2 of FLOAT: must be VEC3 of FLOAT (smaller integers "
      "with KHR_mesh_quantization)");
  EXPECT_EQ(message([](auto& g) { g.primitive()["mode"] = 7; }),
            "/meshes/0/primitives/0/mode: 7: must be one of 0, 1, 2, 3, 4, 5, 6");
  EXPECT_EQ(message([](auto& g) { g.primitive()["material"] = 0; }),
            "/meshes/0/primitives/0/material: 0: the file has no materials");
  EXPECT_EQ(message([](auto& g) { g.primitive()["indices"] = 0; }),
            "/meshes/0/primitives/0/indices: 0: is VEC3 of FLOAT: must be SCALAR of UNSIGNED_BYTE, _SHORT or _INT");
  EXPECT_EQ(message([](auto& g) { g.root["meshes"][0]["weights"] = {1}; }),
            "/meshes/0/weights: 1 weights: must be 0, one for each morph target");
  EXPECT_EQ(message([](auto& g) { g.root["meshes"][0]["primitives"] = json::array(); }),
            "/meshes/0/primitives: must not be empty");
}

TEST(GltfHostile, IndicesBeyondTheVertices) {
  EXPECT_EQ(message([](auto& g) {
              g.primitive()["indices"] = g.template add_accessor<std::uint16_t>({0, 1, 3}, "SCALAR");
            }),
            "/accessors/1: entry 2 is 3: must be less than the 3 vertices");
}

TEST(GltfHostile, ValuesThatAreNoPlaces) {
  const auto vertex = [](float x) { return message([&](auto& g) { std::memcpy(g.bin.data() + 12, &x, 4); }); };
  EXPECT_EQ(vertex(kNaN), "/accessors/0: element 1 holds nan: must be finite");
  EXPECT_EQ(vertex(-kInfinity), "/accessors/0: element 1 holds -inf: must be finite");
  EXPECT_EQ(vertex(1e7f), "/accessors/0: vertex 1 stands at (1e+07, 0, 0) m: must be within 1e+06 m of the origin");
  EXPECT_EQ(message([](auto& g) {
              g.primitive()["attributes"]["TEXCOORD_0"] = g.template add_accessor<float>({0, 0, kNaN, 0, 0, 0}, "VEC2");
            }),
            "/accessors/1: element 1 holds nan: must be finite");
  EXPECT_TRUE(message([](auto& g) {
                g.node()["scale"] = {1e11, 1, 1};
              }).starts_with("/accessors/0: vertex 1 stands at (1e+11, 0, 0) m"));
}

TEST(GltfHostile, NodeTransforms) {
  const auto node = [](const json& patch) { return message([&](auto& g) { g.node().update(patch); }); };
  EXPECT_EQ(node({{"scale", {1, 0, 1}}}), "/nodes/0/scale: [1, 0, 1]: a singular transform: must not be 0");
  EXPECT_EQ(node({{"rotation", {0, 0, 0, 0}}}), "/nodes/0/rotation: [0, 0, 0, 0]: must be a unit quaternion");
  EXPECT_EQ(node({{"matrix", {1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}}),
            "/nodes/0/matrix: its determinant is 0: must not be singular");
  EXPECT_EQ(node({{"matrix", {1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}}),
            "/nodes/0/matrix: 0.5 at 3: the bottom row must be 0, 0, 0, 1");
  EXPECT_EQ(node({{"translation", {0, 1e30, 0}}}), "/nodes/0/translation: 1e+30: must be numbers in [-1e+12, 1e+12]");
  EXPECT_TRUE(node({{"translation", {0, "x", 0}}}).starts_with("/nodes/0/translation: [0,\"x\",0]: must be 3 "));
  EXPECT_EQ(node({{"translation", {0, 0, 0}}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}}),
            "/nodes/0/matrix: must not stand beside translation");
  // JSON has no NaN, and a number too large for a double is an error of parsing.
  const std::string text = R"({"asset":{"version":"2.0"},"nodes":[{"scale":[NaN,1,1]}]})";
  EXPECT_TRUE(refusal([&] { read_gltf_bytes(text, "a.gltf", ""); }).starts_with("a.gltf: parse error"));
  const std::string huge = R"({"asset":{"version":"2.0"},"nodes":[{"scale":[1e999,1,1]}]})";
  EXPECT_TRUE(refusal([&] { read_gltf_bytes(huge, "a.gltf", ""); }).starts_with("a.gltf: "));
}

TEST(GltfHostile, NodesThatAreNoTree) {
  const auto nodes = [](const json& list) { return message([&](auto& g) { g.root["nodes"] = list; }); };
  EXPECT_EQ(nodes({{{"mesh", 0}}, {{"children", {2}}}, {{"children", {1}}}}),
            "/nodes/1/children: lead in a cycle: the nodes must form a tree");
  EXPECT_EQ(nodes({{{"mesh", 0}, {"children", {0}}}}),
            "/nodes/0/children/0: 0: is the node itself: the nodes must form a tree");
  EXPECT_EQ(nodes({{{"children", {2}}}, {{"children", {2}}}, {{"mesh", 0}}}),
            "/nodes/1/children/0: 2: already has a parent: the nodes must form a tree");
  EXPECT_EQ(nodes({{{"children", {3}}}}), "/nodes/0/children/0: 3: must be an integer in [0, 0], an index into nodes");
  EXPECT_EQ(nodes({{{"mesh", 0}, {"name", 5}}}), "/nodes/0/name: 5: must be a string");
  EXPECT_EQ(nodes({{{"mesh", 1}}}), "/nodes/0/mesh: 1: must be an integer in [0, 0], an index into meshes");
  EXPECT_EQ(nodes({{{"camera", 0}}}), "/nodes/0/camera: 0: the file has no cameras");
}

TEST(GltfHostile, Scenes) {
  EXPECT_EQ(message([](auto& g) { g.root["scenes"] = json::array(); }), "/scenes: is required: it says what to show");
  EXPECT_EQ(message([](auto& g) { g.root["scene"] = 1; }),
            "/scene: 1: must be an integer in [0, 0], an index into scenes");
  EXPECT_EQ(message([](auto& g) {
              g.root["scenes"][0]["nodes"] = {0, 0};
            }),
            "/scenes/0/nodes/1: 0: must be a node without parent, listed once");
  EXPECT_EQ(message([](auto& g) { g.root["scenes"][0]["nodes"] = json::array(); }),
            "the scene must show at least one triangle with area");
  EXPECT_EQ(message([](auto& g) {
              g.primitive()["indices"] = g.template add_accessor<std::uint16_t>({1, 1, 1}, "SCALAR");
            }),
            "the scene must show at least one triangle with area");
}

TEST(GltfHostile, Skins) {
  const auto skin = [](const json& patch, const std::vector<std::uint8_t>& joints = std::vector<std::uint8_t>(12)) {
    return message([&](auto& g) {
      g.node()["skin"] = 0;
      g.root["skins"] = {{{"joints", {0}}}};
      g.root["skins"][0].update(patch);
      g.primitive()["attributes"]["JOINTS_0"] = g.add_accessor(joints, "VEC4");
      g.primitive()["attributes"]["WEIGHTS_0"] = g.add_accessor(std::vector<float>(12, 0.25f), "VEC4");
    });
  };
  EXPECT_EQ(skin({{"joints", json::array()}}), "/skins/0/joints: must not be empty");
  EXPECT_EQ(skin({{"joints", {8}}}), "/skins/0/joints/0: 8: must be an integer in [0, 0], an index into nodes");
  EXPECT_TRUE(skin({{"inverseBindMatrices", 0}})
                  .starts_with("/skins/0/inverseBindMatrices: 0: is 3 VEC3 of FLOAT: must be at least 1 MAT4"));
  EXPECT_EQ(skin(json::object(), {0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}),
            "/accessors/1: entry 5 is 1: must be less than the 1 joints of the skin");
  EXPECT_EQ(message([](auto& g) {
              g.node()["skin"] = 0;
              g.root["skins"] = {{{"joints", {0}}}};
            }),
            "/nodes/0/skin: 0: the node must have a mesh with JOINTS_0 and WEIGHTS_0");
}

TEST(GltfHostile, MaterialsTexturesLightsCameras) {
  const auto with = [](const char* key, const json& element) {
    return message([&](auto& g) { g.root[key] = json::array({element}); });
  };
  EXPECT_EQ(with("materials", {{"pbrMetallicRoughness", {{"baseColorFactor", {1, 2, 1, 1}}}}}),
            "/materials/0/pbrMetallicRoughness/baseColorFactor: 2: must be numbers in [0, 1]");
  EXPECT_EQ(with("materials", {{"pbrMetallicRoughness", {{"roughnessFactor", -1}}}}),
            "/materials/0/pbrMetallicRoughness/roughnessFactor: -1: must be a number in [0, 1]");
  EXPECT_EQ(with("materials", {{"normalTexture", {{"index", 0}}}}),
            "/materials/0/normalTexture/index: 0: the file has no textures");
  EXPECT_EQ(with("materials", {{"emissiveTexture", {{"texCoord", 0}}}}),
            "/materials/0/emissiveTexture/index: is required");
  EXPECT_TRUE(with("materials", {{"alphaMode", "CUT"}}).starts_with("/materials/0/alphaMode: \"CUT\": must be one of"));
  EXPECT_EQ(with("textures", {{"source", 0}}), "/textures/0/source: 0: the file has no images");
  EXPECT_EQ(with("images", json::object()), "/images/0: must have either a uri or a bufferView");
  EXPECT_TRUE(with("samplers", {{"wrapS", 1}}).starts_with("/samplers/0/wrapS: 1: must be one of"));
  EXPECT_TRUE(with("cameras", {{"type", "fisheye"}}).starts_with("/cameras/0/type: \"fisheye\": must be one of"));
  EXPECT_TRUE(with("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 4}}}})
                  .starts_with("/cameras/0/perspective/yfov: 4: must be a number in"));
  const auto light = [](const json& element) {
    return message([&](auto& g) { g.root["extensions"]["KHR_lights_punctual"]["lights"] = json::array({element}); });
  };
  EXPECT_EQ(light({{"type", "point"}, {"intensity", -1}}),
            "/extensions/KHR_lights_punctual/lights/0/intensity: -1: must be a number in [0, 1e+12]");
  EXPECT_EQ(light({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.5}, {"outerConeAngle", 0.5}}}}),
            "/extensions/KHR_lights_punctual/lights/0/spot/innerConeAngle: 0.5: must be less than 0.5");
  EXPECT_EQ(message([](auto& g) { g.node()["extensions"]["KHR_lights_punctual"]["light"] = 0; }),
            "/nodes/0/extensions/KHR_lights_punctual/light: 0: the file has no lights");
}

/// A .gltf in a folder of its own, whose buffer is `uri`.
struct GltfOnDisk {
  TemporaryFolder folder;
  GltfBuilder gltf = one_triangle();

  void write_buffer(const std::string& name) { folder.write(name, gltf.bin); }
  std::string path(const std::string& uri) {
    gltf.root["buffers"] = {{{"byteLength", gltf.bin.size()}, {"uri", uri}}};
    return folder.write("scene/a.gltf", gltf.root.dump());
  }
  /// The message without the folder's name, which changes from run to run.
  std::string message(const std::string& uri) {
    const std::string file = path(uri);
    std::string text = refusal([&] { read_gltf(file); });
    EXPECT_TRUE(text.starts_with(file + ": ")) << text;
    return text.substr(std::min(text.size(), file.size() + 2));
  }
};

TEST(GltfFiles, UrisNameFilesInTheOwnFolder) {
  GltfOnDisk disk;
  disk.write_buffer("scene/a.bin");
  disk.write_buffer("scene/deep er/b+%.bin");
  EXPECT_EQ(read_gltf(disk.path("a.bin")).meshes.size(), 1u);
  EXPECT_EQ(read_gltf(disk.path("./deep%20er/b+%25.bin")).meshes.size(), 1u);
  EXPECT_EQ(read_gltf(disk.path("deep er/../a.bin")).meshes.size(), 1u);
}

TEST(GltfFiles, NothingElseIsOpened) {
  GltfOnDisk disk;
  disk.write_buffer("outside.bin");
  disk.write_buffer("scene/a.bin");
  std::filesystem::create_symlink("../outside.bin", disk.folder.path / "scene/link.bin");
  std::filesystem::create_directory(disk.folder.path / "scene/folder");
  std::filesystem::create_directory(disk.folder.path / "scene-beside");
  disk.write_buffer("scene-beside/a.bin");
  ASSERT_EQ(mkfifo((disk.folder.path / "scene/fifo").c_str(), 0600), 0);

  const std::string inside = ": must name a file inside the glTF file's own folder";
  for (const std::string uri : {"../outside.bin", "%2e%2e/outside.bin", "../../../../../../etc/passwd", "/etc/passwd",
                                "link.bin", "../scene-beside/a.bin", "/dev/zero"}) {
    EXPECT_EQ(disk.message(uri), "/buffers/0/uri: " + uri + inside);
  }
  EXPECT_EQ(disk.message("folder"), "/buffers/0/uri: folder: must be a regular file");
  EXPECT_EQ(disk.message("."), "/buffers/0/uri: .: must be a regular file");
  EXPECT_EQ(disk.message("fifo"), "/buffers/0/uri: fifo: must be a regular file");
  EXPECT_EQ(disk.message("none.bin"), "/buffers/0/uri: none.bin: no such file");
  EXPECT_EQ(disk.message("a%00.bin"), "/buffers/0/uri: a%00.bin: must name a file");
  EXPECT_EQ(disk.message("a%2.bin"), "/buffers/0/uri: a%2.bin: % must be followed by two hexadecimal digits");
  EXPECT_EQ(disk.message(""), "/buffers/0/uri: : must name a file");
  EXPECT_EQ(disk.message("http://example.org/a.bin"), "/buffers/0/uri: http://example.org/a.bin: no such file");
  disk.folder.write("scene/short.bin", "abc");
  EXPECT_EQ(disk.message("short.bin"), "/buffers/0/byteLength: 36: there are 3 bytes");
}

TEST(GltfFiles, AMissingRelativeFileIsNotLookedUpInTheWorkingFolder) {
  GltfOnDisk disk;
  disk.write_buffer("a.bin");
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(disk.folder.path);
  EXPECT_EQ(disk.message("a.bin"), "/buffers/0/uri: a.bin: no such file");
  // Read by a relative name, the glTF's own folder is still where it looks.
  disk.write_buffer("scene/a.bin");
  disk.path("a.bin");
  std::filesystem::current_path(disk.folder.path / "scene");
  EXPECT_EQ(read_gltf("a.gltf").meshes.size(), 1u);
  std::filesystem::current_path(before);
}

TEST(GltfFiles, WhatIsNoRegularFile) {
  const TemporaryFolder folder;
  EXPECT_NE(refusal([&] { read_gltf((folder.path / "none.glb").string()); }).find("none.glb: no such file"),
            std::string::npos);
  EXPECT_NE(refusal([&] { read_gltf(folder.path.string()); }).find("is a folder"), std::string::npos);
  EXPECT_FALSE(refusal([] { read_gltf(""); }).empty());
}

/// A small file with most features, so that changed bytes reach most of the reader.
GltfBuilder rich_scene() {
  GltfBuilder gltf = one_triangle();
  json& attributes = gltf.primitive()["attributes"];
  attributes["NORMAL"] = gltf.add_accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  attributes["JOINTS_0"] = gltf.add_accessor(std::vector<std::uint8_t>(12), "VEC4");
  attributes["WEIGHTS_0"] = gltf.add_accessor(std::vector<float>(12, 0.25f), "VEC4");
  gltf.primitive()["indices"] = gltf.add_accessor<std::uint16_t>({0, 1, 2}, "SCALAR");
  gltf.primitive()["targets"] = {{{"POSITION", 0}}};
  gltf.primitive()["material"] = 0;
  gltf.root["meshes"][0]["weights"] = {0.5};
  const std::uint8_t index = 1;
  const float value[] = {2, 0, 0};
  const int index_view = gltf.add_view(&index, 1), value_view = gltf.add_view(value, 12);
  gltf.root["accessors"][0]["sparse"] = {{"count", 1},
                                         {"indices", {{"bufferView", index_view}, {"componentType", 5121}}},
                                         {"values", {{"bufferView", value_view}}}};
  const unsigned char png[] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\1\0\0\0\1\b\0\0\0\0:~\x9bU";
  gltf.root["images"] = {{{"bufferView", gltf.add_view(png, sizeof(png))}}};
  gltf.root["textures"] = {{{"source", 0}}};
  gltf.root["materials"] = {{{"emissiveFactor", {1, 1, 1}}, {"alphaMode", "MASK"}}};
  gltf.root["skins"] = {{{"joints", {1}}}};
  gltf.root["nodes"] = {{{"mesh", 0}, {"skin", 0}},
                        {{"translation", {1, 2, 3}}, {"rotation", {0, 0, 0, 1}}, {"scale", {1, 1, 2}}, {"camera", 0}}};
  gltf.root["scenes"][0]["nodes"] = {0, 1};
  gltf.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}}};
  gltf.root["extensionsUsed"] = {"KHR_lights_punctual"};
  gltf.root["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "spot"}, {"spot", {{"outerConeAngle", 0.5}}}}};
  gltf.root["nodes"][1]["extensions"]["KHR_lights_punctual"]["light"] = 0;
  return gltf;
}

TEST(GltfHostile, ChangedBytesAreReadOrRefusedButNeverCrash) {
  const std::string good = rich_scene().glb();
  ASSERT_EQ(read_gltf_bytes(good, "good.glb", "").meshes.size(), 1u);
  std::mt19937 random(20180801);
  int read = 0, refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string bytes = good;
    // The header and chunk lengths have tests of their own: most changes go to what lies behind.
    for (unsigned changes = 1 + random() % 3; changes > 0; --changes) {
      char& byte = bytes[20 + random() % (bytes.size() - 20)];
      const unsigned kind = random() % 4;
      if (kind == 0) byte = static_cast<char>(random());
      if (kind == 1) byte = static_cast<char>(byte ^ (1 << random() % 8));
      if (kind == 2) byte = "0123456789-.e,[]{}\""[random() % 19];
      if (kind == 3) byte = '9';
    }
    try {
      const Scene scene = read_gltf_bytes(bytes, "changed.glb", "");
      ++read;
      for (const Mesh& mesh : scene.meshes) {
        for (const glm::vec3& p : mesh.positions) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
        for (const glm::vec3& n : mesh.normals) ASSERT_TRUE(std::isfinite(n.x + n.y + n.z));
        for (const glm::uvec3& t : mesh.triangles) {
          ASSERT_LT(std::max({t.x, t.y, t.z}), mesh.positions.size());
        }
        ASSERT_LT(static_cast<std::size_t>(mesh.material), scene.materials.size());
      }
    } catch (const InputError&) {
      ++refused;
    }
  }
  EXPECT_GT(read, 200);
  EXPECT_GT(refused, 200);
}

}  // namespace
}  // namespace dualpixel::simulator
