#include "simulator/scene/gltf/material.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <tuple>

#include "capture/error.h"
#include "simulator/scene/gltf/image.h"

namespace dualpixel::simulator {
namespace {

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
  TextureTable(const GltfFile& file, std::vector<Texture>& textures) : file_(file), textures_(textures) {}

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

  /// The image of each texture.
  const std::vector<int>& images() const { return images_; }

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
    images_.push_back(source.source);
    return known->second;
  }

  const GltfFile& file_;
  std::vector<Texture>& textures_;
  std::map<std::pair<int, bool>, int> indices_;
  std::vector<int> images_;
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
  TextureTable textures(file, scene.textures);
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
  decode_images(file, textures.images(), scene.textures, texels_in_memory);
}

}  // namespace dualpixel::simulator
