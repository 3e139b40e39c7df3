#include "simulator/scene/gltf/material.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <istream>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <streambuf>
#include <string_view>
#include <tuple>

#include "capture/error.h"
#include "capture/image/faults/png_fault.h"
#include "simulator/scene/gltf/check.h"
#include "simulator/scene/paged_bytes.h"

namespace dualpixel::simulator {
namespace {

constexpr int kLongestSide = 16384;
constexpr std::int64_t kMostTexels = std::int64_t{1} << 32;
constexpr int kStripRows = 64;                        // that are decoded at a time
constexpr std::int64_t kMostDecodedTexels = 1 << 25;  // half a gigabyte of them

/// OpenImageIO's name of an image's format by its magic bytes; "" for what glTF does not allow.
std::string format_of(const std::vector<unsigned char>& bytes) {
  using namespace std::string_view_literals;
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (head.starts_with("\x89PNG\r\n\x1a\n"sv)) return "png";
  if (head.starts_with("\xff\xd8\xff"sv)) return "jpeg";
  return "";
}

struct TexelsLeft {
  std::int64_t in_memory, in_all;
};

/// Room for the texture's texels, in memory or paged.
std::uint8_t* make_room(Texture& texture, std::int64_t texels, TexelsLeft& left) {
  const std::size_t bytes = static_cast<std::size_t>(texels) * 4;
  left.in_all -= texels;
  if (texels <= left.in_memory) {
    left.in_memory -= texels;
    texture.rgba.resize(bytes);
    return texture.rgba.data();
  }
  const std::shared_ptr<std::uint8_t[]> paged = paged_bytes(bytes);
  texture.paged = paged;
  return paged.get();
}

/// Bytes in memory, to be read as a stream.
struct MemoryBuffer : std::streambuf {
  explicit MemoryBuffer(const std::vector<unsigned char>& bytes) {
    char* first = const_cast<char*>(reinterpret_cast<const char*>(bytes.data()));  // only read
    setg(first, first, first + bytes.size());
  }
};

/// Decodes an image of 1 to 4 channels (gray, gray and alpha, RGB, RGBA) into `texture`.
void decode_image(const GltfFile& file, int index, TexelsLeft& left, Texture& texture) {
  const auto fail = [&](const std::string& message) {
    fail_gltf(file.name, fmt::format("/images/{}", index), message);
  };
  const std::vector<unsigned char>& bytes = file.model.images[index].image;
  const std::string format = format_of(bytes);
  if (format.empty()) fail("must be a PNG or JPEG image");
  if (format == "png") {
    MemoryBuffer buffer(bytes);
    std::istream png(&buffer);
    if (const auto fault = fault_of_png(png)) fail("cannot be decoded: " + *fault);
  }
  // The size is checked from the header, before a small file can unpack to gigabytes.
  OIIO::Filesystem::IOMemReader memory(const_cast<unsigned char*>(bytes.data()), bytes.size());
  const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(format);
  OIIO::ImageSpec spec, as_stored;
  as_stored["oiio:UnassociatedAlpha"] = 1;
  const auto library_error = [&] { return printable(input->geterror().substr(0, 200)); };
  if (!input || !input->set_ioproxy(&memory)) fail("this build of OpenImageIO cannot read " + format);
  if (!input->open("image." + format, spec, as_stored)) fail("cannot be decoded: " + library_error());
  const std::int64_t texels = std::int64_t{spec.width} * spec.height;
  if (spec.width < 1 || spec.height < 1 || spec.width > kLongestSide || spec.height > kLongestSide ||
      spec.nchannels < 1 || spec.nchannels > 4) {
    fail(fmt::format("{} x {} texels of {} channels: must be 1 to {} a side, of 1 to 4 channels", spec.width,
                     spec.height, spec.nchannels, kLongestSide));
  }
  if (texels > left.in_all) {
    fail(fmt::format("{} x {} texels: all textures together must have at most {}", spec.width, spec.height,
                     kMostTexels));
  }
  texture.width = spec.width;
  texture.height = spec.height;
  std::uint8_t* to = nullptr;
  const bool color = spec.nchannels >= 3;
  const bool alpha = spec.nchannels % 2 == 0;
  std::vector<std::uint8_t> strip(static_cast<std::size_t>(spec.width) * spec.nchannels * kStripRows);
  for (int y = 0; y < spec.height; y += kStripRows) {
    const int end = std::min(y + kStripRows, spec.height);
    if (!input->read_scanlines(0, 0, y, end, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, strip.data())) {
      fail("cannot be decoded: " + library_error());
    }
    if (y == 0) to = make_room(texture, texels, left);  // a header alone is not believed
    const std::uint8_t* from = strip.data();
    for (std::int64_t i = 0; i < std::int64_t{end - y} * spec.width; ++i, from += spec.nchannels, to += 4) {
      for (int c = 0; c < 3; ++c) to[c] = from[color ? c : 0];
      to[3] = alpha ? from[spec.nchannels - 1] : 255;
    }
  }
}

Wrap wrap_of(int gl_name) {
  switch (gl_name) {
    case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
      return Wrap::clamp;
    case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
      return Wrap::mirror;
    default:
      return Wrap::repeat;
  }
}

/// uv' = translation * rotation * scale * uv. The rotation is counter-clockwise as seen with v pointing down
/// (KHR_texture_transform's text; the matrix printed there turns the other way, KhronosGroup/glTF issue 1563).
std::array<float, 6> affine_map(const tinygltf::Value& transform) {
  const auto number = [&](const char* key, int i, double absent) {
    return transform.Has(key) ? transform.Get(key).Get(i).GetNumberAsDouble() : absent;
  };
  const double angle = transform.Has("rotation") ? transform.Get("rotation").GetNumberAsDouble() : 0;
  const double sx = number("scale", 0, 1), sy = number("scale", 1, 1);
  const double map[] = {std::cos(angle) * sx,  std::sin(angle) * sy, number("offset", 0, 0),
                        -std::sin(angle) * sx, std::cos(angle) * sy, number("offset", 1, 0)};
  std::array<float, 6> result;
  std::copy(std::begin(map), std::end(map), result.begin());
  return result;
}

/// The textures in use, each once for linear and once for sRGB values.
class TextureTable {
 public:
  TextureTable(const GltfFile& file, std::vector<Texture>& textures, std::int64_t texels_in_memory)
      : file_(file), textures_(textures), left_{texels_in_memory, kMostTexels} {}

  /// `info` is any of tinygltf's kinds of texture reference.
  template <typename Info>
  TextureSlot slot(const Info& info, bool srgb) {
    TextureSlot slot;
    if (info.index < 0) return slot;
    slot.texture = texture(info.index, srgb);
    slot.uv_set = info.texCoord;
    const auto transform = info.extensions.find("KHR_texture_transform");
    if (transform != info.extensions.end()) {
      slot.uv_from_uv = affine_map(transform->second);
      if (transform->second.Has("texCoord")) slot.uv_set = transform->second.Get("texCoord").GetNumberAsInt();
    }
    return slot;
  }

 private:
  int texture(int index, bool srgb) {
    const auto [known, is_new] = indices_.try_emplace({index, srgb}, static_cast<int>(textures_.size()));
    if (!is_new) return known->second;
    const tinygltf::Texture& source = file_.model.textures[index];
    Texture& texture = textures_.emplace_back();
    texture.srgb = srgb;
    if (source.sampler >= 0) {
      const tinygltf::Sampler& sampler = file_.model.samplers[source.sampler];
      texture.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
      texture.wrap_u = wrap_of(sampler.wrapS);
      texture.wrap_v = wrap_of(sampler.wrapT);
    }
    decode_image(file_, source.source, left_, texture);
    if (kMostTexels - left_.in_all < kMostDecodedTexels) keep_decoded(texture);
    return known->second;
  }

  const GltfFile& file_;
  std::vector<Texture>& textures_;
  std::map<std::pair<int, bool>, int> indices_;
  TexelsLeft left_;
};

/// One of a material's extensions, and its numbers where it has them.
class ExtensionValues {
 public:
  ExtensionValues(const tinygltf::Material& material, const char* name) {
    const auto found = material.extensions.find(name);
    if (found != material.extensions.end()) values_ = &found->second;
  }
  float number(const char* key, float absent) const {
    return values_ && values_->Has(key) ? static_cast<float>(values_->Get(key).GetNumberAsDouble()) : absent;
  }
  glm::vec3 color(const char* key, glm::vec3 absent) const {
    if (!values_ || !values_->Has(key)) return absent;
    const tinygltf::Value& rgb = values_->Get(key);
    for (int c = 0; c < 3; ++c) absent[c] = static_cast<float>(rgb.Get(c).GetNumberAsDouble());
    return absent;
  }

 private:
  const tinygltf::Value* values_ = nullptr;
};

/// Beer's law: what is left after `distance_m` is `color`.
glm::vec3 absorption_of(glm::vec3 color, float distance_m) {
  constexpr float kDarkest = 1e-6f;  // black would be infinitely absorbing
  return -glm::log(glm::max(color, glm::vec3(kDarkest))) / distance_m;
}

/// What emits is opaque.
std::optional<Layers> read_layers(const tinygltf::Material& source, bool emits) {
  const ExtensionValues ior(source, "KHR_materials_ior"), specular(source, "KHR_materials_specular"),
      coat(source, "KHR_materials_clearcoat"), sheen(source, "KHR_materials_sheen"),
      transmission(source, "KHR_materials_transmission"), volume(source, "KHR_materials_volume");
  Layers y;
  y.ior = ior.number("ior", y.ior);
  y.specular = specular.number("specularFactor", y.specular);
  y.specular_color = specular.color("specularColorFactor", y.specular_color);
  y.clearcoat = coat.number("clearcoatFactor", 0);
  y.clearcoat_roughness = coat.number("clearcoatRoughnessFactor", 0);
  y.sheen_color = sheen.color("sheenColorFactor", y.sheen_color);
  y.sheen_roughness = sheen.number("sheenRoughnessFactor", 0);
  y.transmission = emits ? 0 : transmission.number("transmissionFactor", 0);
  y.solid = y.transmission > 0 && volume.number("thicknessFactor", 0) > 0;
  constexpr float kFar = std::numeric_limits<float>::infinity();
  if (y.solid) {
    y.absorption_per_m =
        absorption_of(volume.color("attenuationColor", glm::vec3(1)), volume.number("attenuationDistance", kFar));
  }
  const tinygltf::Value& extras = source.extras;
  if (extras.IsObject() && extras.Has("subsurface"))
    y.subsurface = static_cast<float>(extras.Get("subsurface").GetNumberAsDouble());
  const bool plain = y.ior == 1.5f && y.specular == 1 && y.specular_color == glm::vec3(1) && y.clearcoat == 0 &&
                     y.sheen_color == glm::vec3(0) && y.transmission == 0 && y.subsurface == 0;
  return plain ? std::nullopt : std::optional(y);
}

/// Names of textures in these extensions, which are not read.
std::vector<std::string> unread_textures(const tinygltf::Material& source) {
  std::vector<std::string> names;
  for (const auto& [extension, value] : source.extensions) {
    if (!extension.starts_with("KHR_materials_") || !value.IsObject()) continue;
    for (const std::string& key : value.Keys()) {
      if (key.ends_with("Texture")) names.push_back(extension + "/" + key);
    }
  }
  return names;
}

Material read_material(const tinygltf::Material& source, TextureTable& textures) {
  const tinygltf::PbrMetallicRoughness& surface = source.pbrMetallicRoughness;
  Material material;
  for (int c = 0; c < 4; ++c) material.base_color[c] = static_cast<float>(surface.baseColorFactor[c]);
  material.metallic = static_cast<float>(surface.metallicFactor);
  material.roughness = static_cast<float>(surface.roughnessFactor);
  material.normal_scale = static_cast<float>(source.normalTexture.scale);
  material.double_sided = source.doubleSided;
  if (source.alphaMode == "MASK") material.alpha_cutoff = static_cast<float>(source.alphaCutoff);
  if (source.alphaMode == "BLEND") material.alpha_cutoff = 0.5f;
  material.unlit = source.extensions.count("KHR_materials_unlit") > 0;

  double strength = 1;
  const auto extension = source.extensions.find("KHR_materials_emissive_strength");
  if (extension != source.extensions.end() && extension->second.Has("emissiveStrength")) {
    strength = extension->second.Get("emissiveStrength").GetNumberAsDouble();
  }
  for (int c = 0; c < 3; ++c) material.emission_nits[c] = static_cast<float>(source.emissiveFactor[c] * strength);

  material.base_color_texture = textures.slot(surface.baseColorTexture, true);
  material.metallic_roughness_texture = textures.slot(surface.metallicRoughnessTexture, false);
  material.emissive_texture = textures.slot(source.emissiveTexture, true);
  material.normal_texture = textures.slot(source.normalTexture, false);
  material.layers = read_layers(source, material.emission_nits != glm::vec3(0));
  return material;
}

}  // namespace

void read_materials(const GltfFile& file, Scene& scene, std::int64_t texels_in_memory) {
  TextureTable textures(file, scene.textures, texels_in_memory);
  for (std::size_t i = 0; i < file.model.materials.size(); ++i) {
    scene.materials.push_back(read_material(file.model.materials[i], textures));
    if (file.model.materials[i].alphaMode == "BLEND") {
      scene.warnings.push_back(
          fmt::format("{}: /materials/{}/alphaMode: BLEND is taken as MASK at 0.5", printable(file.name), i));
    }
    const ExtensionValues transmission(file.model.materials[i], "KHR_materials_transmission");
    if (scene.materials.back().emission_nits != glm::vec3(0) && transmission.number("transmissionFactor", 0) > 0) {
      scene.warnings.push_back(
          fmt::format("{}: /materials/{}/extensions/KHR_materials_transmission is ignored: emissive and transmissive: "
                      "drawn opaque",
                      printable(file.name), i));
    }
    for (const std::string& texture : unread_textures(file.model.materials[i])) {
      scene.warnings.push_back(fmt::format("{}: /materials/{}/extensions/{} is ignored: its factor holds all over",
                                           printable(file.name), i, printable(texture)));
    }
  }
  scene.materials.emplace_back();
}

}  // namespace dualpixel::simulator
