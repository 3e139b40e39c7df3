#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "capture/files.h"
#include "capture/image/image_io.h"
#include "simulator/scene/gltf/material.h"
#include "tests/simulator/scene/gltf/gltf_builder.h"

namespace dualpixel::simulator {
namespace {

using nlohmann::json;

/// A PNG of 2 x 2 texels: red, green / blue, white.
std::string small_png() {
  Image image(2, 2, 3);
  image.data = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
  const TemporaryFolder folder;
  const std::string path = (folder.path / "small.png").string();
  write_png8(path, image);
  return read_file(path, 1 << 20);
}

const std::vector<std::uint8_t> kSmallPngTexels = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255};

/// Any picture that OpenImageIO writes.
std::string encoded(const std::string& extension, int width, int height, int channels, int value) {
  const TemporaryFolder folder;
  const std::string path = (folder.path / ("picture." + extension)).string();
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(path);
  OIIO::ImageSpec spec(width, height, channels, OIIO::TypeDesc::UINT8);
  spec["oiio:UnassociatedAlpha"] = 1;
  const std::vector<unsigned char> pixels(spec.image_bytes(), static_cast<unsigned char>(value));
  EXPECT_TRUE(output->open(path, spec) && output->write_image(spec.format, pixels.data()) && output->close());
  return read_file(path, 1 << 28);
}

std::string base64(const std::string& bytes) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      word = word << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0);
    }
    for (int j = 0; j < 4; ++j) text += i + j <= bytes.size() ? digits[word >> (18 - 6 * j) & 63] : '=';
  }
  return text;
}

/// A triangle whose base color is the embedded image.
GltfBuilder textured(const std::string& image) {
  GltfBuilder gltf = one_triangle();
  gltf.primitive()["attributes"]["TEXCOORD_0"] = gltf.add_accessor<float>({0, 0, 1, 0, 0, 1}, "VEC2");
  gltf.primitive()["material"] = 0;
  gltf.root["images"] = {{{"bufferView", gltf.add_view(image.data(), image.size())}, {"mimeType", "image/png"}}};
  gltf.root["textures"] = {{{"source", 0}}};
  gltf.material()["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
  return gltf;
}

TEST(GltfMaterial, Layers) {
  GltfBuilder gltf = one_triangle();
  gltf.root["materials"] = {
      {{"extensions",
        {{"KHR_materials_ior", {{"ior", 1.33}}},
         {"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularColorFactor", {1, 2, 3}}}},
         {"KHR_materials_clearcoat", {{"clearcoatFactor", 0.25}, {"clearcoatRoughnessFactor", 0.125}}},
         {"KHR_materials_sheen", {{"sheenColorFactor", {0.1, 0.2, 0.3}}, {"sheenRoughnessFactor", 0.75}}},
         {"KHR_materials_transmission", {{"transmissionFactor", 0.875}}},
         {"KHR_materials_volume",
          {{"thicknessFactor", 0.01}, {"attenuationDistance", 2}, {"attenuationColor", {1, 0.5, 0}}}}}}},
      {{"extensions", {{"KHR_materials_ior", {{"ior", 1.5}}}, {"KHR_materials_transmission", json::object()}}}},
      {{"extensions",
        {{"KHR_materials_transmission", {{"transmissionFactor", 1}, {"transmissionTexture", {{"index", 0}}}}}}}}};
  const Scene scene = gltf.read();
  ASSERT_TRUE(scene.materials[0].layers);
  const Layers& y = *scene.materials[0].layers;
  EXPECT_EQ(y.ior, 1.33f);
  EXPECT_EQ(y.specular, 0.5f);
  EXPECT_EQ(y.specular_color, glm::vec3(1, 2, 3));
  EXPECT_EQ(y.clearcoat, 0.25f);
  EXPECT_EQ(y.clearcoat_roughness, 0.125f);
  EXPECT_EQ(y.sheen_color, glm::vec3(0.1f, 0.2f, 0.3f));
  EXPECT_EQ(y.sheen_roughness, 0.75f);
  EXPECT_EQ(y.transmission, 0.875f);
  EXPECT_TRUE(y.solid);
  EXPECT_EQ(y.absorption_per_m.x, 0);
  EXPECT_NEAR(y.absorption_per_m.y, std::log(2) / 2, 1e-6);  // half is left after 2 m
  EXPECT_GT(y.absorption_per_m.z, 5);
  EXPECT_FALSE(scene.materials[1].layers);  // all as without extensions: the plain material
  EXPECT_TRUE(scene.materials[2].is_glass());
  EXPECT_FALSE(scene.materials[2].layers->solid);
  ASSERT_EQ(scene.warnings.size(), 1u);  // textures of extensions are not read
  EXPECT_NE(scene.warnings[0].find("/materials/2/extensions/KHR_materials_transmission/transmissionTexture"),
            std::string::npos);
}

TEST(GltfMaterial, SubsurfaceIsAnExtra) {
  GltfBuilder gltf = one_triangle();
  gltf.root["materials"] = {
      {{"extras", {{"subsurface", 0.75}}}}, {{"extras", "words"}}, {{"extras", {{"subsurface", 0}}}}};
  const Scene scene = gltf.read();
  ASSERT_TRUE(scene.materials[0].layers);
  EXPECT_EQ(scene.materials[0].layers->subsurface, 0.75f);
  EXPECT_FALSE(scene.materials[1].layers);
  EXPECT_FALSE(scene.materials[2].layers);
  gltf.root["materials"] = {{{"extras", {{"subsurface", 1.5}}}}};
  const std::string message = refusal([&] { gltf.read(); });
  EXPECT_NE(message.find("/materials/0/extras/subsurface: 1.5"), std::string::npos) << message;
}

TEST(GltfMaterial, EmissiveGlassIsDrawnOpaque) {
  GltfBuilder gltf = one_triangle();
  const json glass = {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                      {"KHR_materials_volume", {{"thicknessFactor", 0.01}}}};
  gltf.root["materials"] = {{{"emissiveFactor", {0, 1, 0}}, {"extensions", glass}}, {{"extensions", glass}}};
  const Scene scene = gltf.read();
  EXPECT_FALSE(scene.materials[0].is_glass());
  EXPECT_FALSE(scene.materials[0].layers);  // diffuse again
  EXPECT_TRUE(scene.materials[1].is_glass());
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("/materials/0/extensions/KHR_materials_transmission is ignored: emissive and "
                                   "transmissive: drawn opaque"),
            std::string::npos);
}

TEST(GltfMaterial, LayersOutOfRangeAreRefused) {
  const auto refused = [](const char* extension, const char* field, const json& value) {
    GltfBuilder gltf = one_triangle();
    gltf.root["materials"] = {{{"extensions", {{extension, {{field, value}}}}}}};
    const std::string message = refusal([&] { gltf.read(); });
    EXPECT_NE(message.find(std::string(extension) + "/" + field), std::string::npos) << message;
  };
  refused("KHR_materials_ior", "ior", 0.5);
  refused("KHR_materials_ior", "ior", 11);
  refused("KHR_materials_specular", "specularFactor", 1.1);
  refused("KHR_materials_specular", "specularColorFactor", {1, -1, 1});
  refused("KHR_materials_clearcoat", "clearcoatFactor", -0.1);
  refused("KHR_materials_clearcoat", "clearcoatRoughnessFactor", 2);
  refused("KHR_materials_sheen", "sheenColorFactor", {0, 0, 2});
  refused("KHR_materials_sheen", "sheenRoughnessFactor", "rough");
  refused("KHR_materials_transmission", "transmissionFactor", 2);
  refused("KHR_materials_volume", "thicknessFactor", -1);
  refused("KHR_materials_volume", "attenuationDistance", 0);
  refused("KHR_materials_volume", "attenuationColor", {1, 1});
}

TEST(GltfMaterial, FactorsAndFlags) {
  GltfBuilder gltf = one_triangle();
  gltf.root["materials"] = {
      {{"name", "plain"}},
      {{"pbrMetallicRoughness",
        {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}}, {"metallicFactor", 0.5}, {"roughnessFactor", 0.6}}},
       {"emissiveFactor", {1, 0.5, 0}},
       {"doubleSided", true},
       {"alphaMode", "MASK"},
       {"alphaCutoff", 0.7},
       {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 2000}}}}}},
      {{"alphaMode", "BLEND"}, {"extensions", {{"KHR_materials_unlit", json::object()}}}}};
  gltf.primitive()["material"] = 1;
  const Scene scene = gltf.read();
  ASSERT_EQ(scene.materials.size(), 4u);  // and the default one
  EXPECT_EQ(scene.meshes[0].material, 1);
  const Material& plain = scene.materials[0];
  EXPECT_EQ(plain.base_color, glm::vec4(1));
  EXPECT_EQ(plain.metallic, 1);
  EXPECT_EQ(plain.roughness, 1);
  EXPECT_EQ(plain.emission_nits, glm::vec3(0));
  EXPECT_EQ(plain.alpha_cutoff, 0);
  EXPECT_FALSE(plain.double_sided);
  EXPECT_FALSE(plain.unlit);
  EXPECT_EQ(plain.base_color_texture.texture, -1);
  const Material& rich = scene.materials[1];
  EXPECT_EQ(rich.base_color, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_EQ(rich.metallic, 0.5f);
  EXPECT_EQ(rich.roughness, 0.6f);
  EXPECT_EQ(rich.emission_nits, glm::vec3(2000, 1000, 0));
  EXPECT_TRUE(rich.double_sided);
  EXPECT_EQ(rich.alpha_cutoff, 0.7f);
  EXPECT_EQ(scene.materials[2].alpha_cutoff, 0.5f);
  EXPECT_TRUE(scene.materials[2].unlit);
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(scene.warnings[0], "test.glb: /materials/2/alphaMode: BLEND is taken as MASK at 0.5");
}

TEST(GltfMaterial, EmbeddedTextureTexelForTexel) {
  const Scene scene = textured(small_png()).read();
  ASSERT_EQ(scene.textures.size(), 1u);
  const Texture& texture = scene.textures[0];
  EXPECT_EQ(texture.width, 2);
  EXPECT_EQ(texture.height, 2);
  EXPECT_TRUE(texture.srgb);
  EXPECT_FALSE(texture.nearest);
  EXPECT_EQ(texture.wrap_u, Wrap::repeat);
  EXPECT_EQ(texture.rgba, kSmallPngTexels);
  EXPECT_EQ(scene.materials[0].base_color_texture.texture, 0);
}

TEST(GltfMaterial, TexturesThatOutgrowMemoryArePaged) {
  Image image(5, 150, 3);
  std::vector<std::uint8_t> texels;
  for (int i = 0; i < 5 * 150; ++i) {
    for (int c = 0; c < 3; ++c) {
      image.data[3 * i + c] = static_cast<float>(i * 37 % 101 >> c & 1);
      texels.push_back(image.data[3 * i + c] > 0 ? 255 : 0);
    }
    texels.push_back(255);
  }
  const TemporaryFolder folder;
  const std::string path = (folder.path / "rows.png").string();
  write_png8(path, image);
  GltfBuilder gltf = textured(read_file(path, 1 << 20));
  gltf.material()["normalTexture"]["index"] = 0;  // the same again, as linear numbers
  const GltfFile file = load_gltf(gltf.glb(), "test.glb", "", false);
  for (const std::int64_t room : {2 * 750, 750, 749}) {
    Scene scene;
    read_materials(file, scene, room);
    keep_decoded(scene.textures);
    ASSERT_EQ(scene.textures.size(), 2u);
    for (int i = 0; i < 2; ++i) {
      Texture& texture = scene.textures[i];
      EXPECT_EQ(texture.paged != nullptr, (i + 1) * 750 > room) << room;
      EXPECT_EQ(texture.rgba.empty(), (i + 1) * 750 > room) << room;
      EXPECT_TRUE(std::ranges::equal(texture.bytes(), texels)) << room;
      ASSERT_EQ(texture.decoded.size(), 750u);
      texture.decoded.clear();
      for (const std::size_t t : {0, 333, 749}) {
        EXPECT_EQ(decode_texel(texture, t),
                  glm::vec4(texels[4 * t], texels[4 * t + 1], texels[4 * t + 2], 255) / 255.0f);
      }
    }
  }
}

TEST(GltfMaterial, NoRoomToPageToIsOneClearLine) {
  const char* set = std::getenv("TMPDIR");
  const std::string before = set ? set : "";
  const GltfFile file = load_gltf(textured(small_png()).glb(), "test.glb", "", false);
  setenv("TMPDIR", "/dev/null/none", 1);
  Scene scene;
  EXPECT_EQ(refusal([&] { read_materials(file, scene, 0); }),
            "/dev/null/none: cannot hold 16 bytes of textures: Not a directory: set TMPDIR to a folder that can");
  before.empty() ? unsetenv("TMPDIR") : setenv("TMPDIR", before.c_str(), 1);
}

TEST(GltfMaterial, FirstOfSeveralFaultyPicturesIsNamed) {
  const std::string broken = small_png().substr(0, 45), other = "GIF89a...";
  for (const bool broken_first : {true, false}) {
    GltfBuilder gltf = textured(broken_first ? broken : other);
    const std::string second = "data:image/png;base64," + base64(broken_first ? other : broken);
    gltf.root["images"].push_back({{"uri", second}});
    gltf.root["textures"].push_back({{"source", 1}});
    gltf.material()["normalTexture"]["index"] = 1;
    const std::string message = refusal([&] { gltf.read(); });
    EXPECT_TRUE(
        message.starts_with(broken_first ? "test.glb: /images/0: cannot" : "test.glb: /images/0: must be a PNG"))
        << message;
  }
}

TEST(GltfMaterial, DataUriTexture) {
  GltfBuilder gltf = textured(small_png());
  gltf.root["images"][0] = {{"uri", "data:image/png;base64," + base64(small_png())}};
  EXPECT_EQ(gltf.read().textures[0].rgba, kSmallPngTexels);
}

TEST(GltfMaterial, ChannelsBecomeRgba) {
  for (const int channels : {1, 2, 3, 4}) {
    const Scene scene = textured(encoded("png", 3, 2, channels, 77)).read();
    const std::uint8_t alpha = channels % 2 == 0 ? 77 : 255;
    const std::vector<std::uint8_t> first(scene.textures[0].rgba.begin(), scene.textures[0].rgba.begin() + 4);
    EXPECT_EQ(first, (std::vector<std::uint8_t>{77, 77, 77, alpha})) << channels;
    EXPECT_EQ(scene.textures[0].width, 3);
  }
}

TEST(GltfMaterial, JpegTexture) {
  const Scene scene = textured(encoded("jpg", 16, 8, 3, 200)).read();
  EXPECT_EQ(scene.textures[0].height, 8);
  EXPECT_NEAR(scene.textures[0].rgba[0], 200, 2);  // JPEG's quantisation of an even gray
  EXPECT_EQ(scene.textures[0].rgba[3], 255);
}

TEST(GltfMaterial, SamplersAndColourSpaces) {
  GltfBuilder gltf = textured(small_png());
  gltf.root["samplers"] = {{{"magFilter", 9728}, {"wrapS", 33071}, {"wrapT", 33648}}};
  gltf.root["textures"] = {{{"source", 0}, {"sampler", 0}}};
  json& material = gltf.material();
  material["pbrMetallicRoughness"]["metallicRoughnessTexture"] = {{"index", 0}, {"texCoord", 1}};
  material["emissiveTexture"]["index"] = 0;
  material["normalTexture"] = {{"index", 0}, {"scale", 0.5}};
  const Scene scene = gltf.read();
  const Material& m = scene.materials[0];
  ASSERT_EQ(scene.textures.size(), 2u);  // once as sRGB, once as linear
  EXPECT_EQ(m.base_color_texture.texture, m.emissive_texture.texture);
  EXPECT_EQ(m.metallic_roughness_texture.texture, m.normal_texture.texture);
  EXPECT_TRUE(scene.textures[m.base_color_texture.texture].srgb);
  EXPECT_FALSE(scene.textures[m.normal_texture.texture].srgb);
  EXPECT_EQ(m.metallic_roughness_texture.uv_set, 1);
  EXPECT_EQ(m.normal_scale, 0.5f);
  for (const Texture& texture : scene.textures) {
    EXPECT_TRUE(texture.nearest);
    EXPECT_EQ(texture.wrap_u, Wrap::clamp);
    EXPECT_EQ(texture.wrap_v, Wrap::mirror);
  }
}

TEST(GltfMaterial, TextureTransformIsTranslationRotationScale) {
  GltfBuilder gltf = textured(small_png());
  gltf.material()["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] = {
      {"offset", {0.25, 0.5}}, {"rotation", std::numbers::pi / 2}, {"scale", {2, 3}}, {"texCoord", 1}};
  const TextureSlot slot = gltf.read().materials[0].base_color_texture;
  EXPECT_EQ(slot.uv_set, 1);
  // Scale (u, v) to (2u, 3v); a quarter turn, counter-clockwise to the eye with v downwards, takes u to -v and v to u.
  const float expected[] = {0, 3, 0.25f, -2, 0, 0.5f};
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(slot.uv_from_uv[i], expected[i], 1e-6f) << i;
}

TEST(GltfMaterial, PicturesThatAreRefused) {
  const auto message = [](const std::string& image) { return refusal([&] { textured(image).read(); }); };
  EXPECT_EQ(message("GIF89a..."), "test.glb: /images/0: must be a PNG or JPEG image");
  const std::string truncated = small_png().substr(0, 45);
  EXPECT_NE(message(truncated).find("test.glb: /images/0: cannot be decoded"), std::string::npos);
  const std::string wide = encoded("png", 16385, 1, 1, 0);
  EXPECT_EQ(message(wide),
            "test.glb: /images/0: 16385 x 1 texels of 1 channels: must be 1 to 16384 a side, of 1 to 4 channels");
  // A header that promises what a small file cannot hold is refused before memory is taken for it.
  std::string lying = small_png();
  lying.replace(16, 8, std::string("\0\0\x40\0\0\0\x40\0", 8));  // 16384 x 16384
  EXPECT_NE(message(lying).find("test.glb: /images/0: "), std::string::npos);
}

}  // namespace
}  // namespace dualpixel::simulator
