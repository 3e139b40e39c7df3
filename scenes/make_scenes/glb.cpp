#include "scenes/make_scenes/glb.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "capture/files.h"

namespace dualpixel::scenes {
namespace {

using nlohmann::json;

std::string word(std::size_t value) {
  const auto v = static_cast<std::uint32_t>(value);
  return {reinterpret_cast<const char*>(&v), 4};
}

void pad(std::string& bytes, char with) { bytes.resize((bytes.size() + 3) / 4 * 4, with); }

std::vector<unsigned char> png(const Texture& texture) {
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  const auto output = OIIO::ImageOutput::create("png");
  output->set_ioproxy(&memory);
  OIIO::ImageSpec spec(texture.size, texture.size, 3, OIIO::TypeDesc::UINT8);
  spec.attribute("png:compressionLevel", 6);
  if (!output->open("texture.png", spec) || !output->write_image(OIIO::TypeDesc::UINT8, texture.rgb.data()) ||
      !output->close()) {
    throw std::runtime_error("a texture could not be encoded: " + output->geterror());
  }
  return bytes;
}

}  // namespace

void Mesh::add_quad(glm::vec3 corner, glm::vec3 a, glm::vec3 b, glm::vec2 repeat) {
  const auto first = static_cast<unsigned>(positions.size());
  for (const glm::vec3& p : {corner, corner + a, corner + a + b, corner + b}) positions.push_back(p);
  for (const glm::vec2& uv : {glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0), glm::vec2(0, 0)}) {
    uvs.push_back(uv * repeat);
  }
  triangles.push_back({first, first + 1, first + 2});
  triangles.push_back({first, first + 2, first + 3});
}

int Glb::add_view(const void* data, std::size_t bytes) {
  pad(bin_, '\0');
  root_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bin_.size()}, {"byteLength", bytes}});
  bin_.append(static_cast<const char*>(data), bytes);
  return static_cast<int>(root_["bufferViews"].size()) - 1;
}

int Glb::add_texture(const Texture& texture) {
  const std::vector<unsigned char> bytes = png(texture);
  root_["images"].push_back({{"bufferView", add_view(bytes.data(), bytes.size())}, {"mimeType", "image/png"}});
  root_["textures"].push_back({{"source", root_["images"].size() - 1}});
  return static_cast<int>(root_["textures"].size()) - 1;
}

int Glb::add_material(int texture, glm::vec3 color, bool unlit, float roughness) {
  json pbr = {
      {"baseColorFactor", {color.x, color.y, color.z, 1}}, {"metallicFactor", 0}, {"roughnessFactor", roughness}};
  if (texture >= 0) pbr["baseColorTexture"] = {{"index", texture}};
  json material = {{"pbrMetallicRoughness", pbr}, {"doubleSided", true}};
  if (unlit) {
    material["extensions"]["KHR_materials_unlit"] = json::object();
    root_["extensionsUsed"] = {"KHR_materials_unlit"};
  }
  root_["materials"].push_back(material);
  return static_cast<int>(root_["materials"].size()) - 1;
}

void Glb::add_node(const std::string& name, const Mesh& mesh, int material, bool person) {
  const auto add_accessor = [&](const void* data, std::size_t count, int components, int type) {
    static const char* const kTypes[] = {"", "SCALAR", "VEC2", "VEC3"};
    const int view = add_view(data, count * components * 4);
    root_["accessors"].push_back(
        {{"bufferView", view}, {"componentType", type}, {"count", count}, {"type", kTypes[components]}});
    return root_["accessors"].size() - 1;
  };
  constexpr int kFloat = 5126, kUint = 5125;
  glm::vec3 low = mesh.positions.front(), high = low;
  for (const glm::vec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
  json primitive = {{"material", material}};
  const auto position = add_accessor(mesh.positions.data(), mesh.positions.size(), 3, kFloat);
  root_["accessors"][position]["min"] = {low.x, low.y, low.z};
  root_["accessors"][position]["max"] = {high.x, high.y, high.z};
  primitive["attributes"]["POSITION"] = position;
  if (!mesh.normals.empty()) {
    primitive["attributes"]["NORMAL"] = add_accessor(mesh.normals.data(), mesh.normals.size(), 3, kFloat);
  }
  if (!mesh.uvs.empty())
    primitive["attributes"]["TEXCOORD_0"] = add_accessor(mesh.uvs.data(), mesh.uvs.size(), 2, kFloat);
  primitive["indices"] = add_accessor(mesh.triangles.data(), mesh.triangles.size() * 3, 1, kUint);
  root_["meshes"].push_back({{"primitives", {primitive}}});
  json node = {{"name", name}, {"mesh", root_["meshes"].size() - 1}};
  if (person) node["extras"] = {{"category", "person"}};
  root_["nodes"].push_back(node);
}

void Glb::add_camera(const std::string& name, glm::vec3 position, glm::vec3 look_at) {
  const glm::quat q = glm::quat_cast(glm::inverse(glm::lookAt(position, look_at, glm::vec3(0, 1, 0))));
  root_["cameras"].push_back({{"type", "perspective"}, {"perspective", {{"yfov", 0.614}, {"znear", 0.01}}}});
  root_["nodes"].push_back({{"name", name},
                            {"camera", root_["cameras"].size() - 1},
                            {"translation", {position.x, position.y, position.z}},
                            {"rotation", {q.x, q.y, q.z, q.w}}});
}

void Glb::add_sun(glm::vec3 direction, glm::vec3 color, float lux) {
  const glm::quat q = glm::quat_cast(glm::inverse(glm::lookAt(glm::vec3(0), direction, glm::vec3(0, 1, 0))));
  root_["extensionsUsed"].push_back("KHR_lights_punctual");
  root_["extensions"]["KHR_lights_punctual"]["lights"].push_back(
      {{"type", "directional"}, {"color", {color.x, color.y, color.z}}, {"intensity", lux}});
  root_["nodes"].push_back(
      {{"name", "sun"}, {"rotation", {q.x, q.y, q.z, q.w}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
}

void Glb::write(const std::string& path) const {
  json root = root_;
  json indices = json::array();
  for (std::size_t i = 0; i < root["nodes"].size(); ++i) indices.push_back(i);
  root["scene"] = 0;
  root["scenes"] = {{{"nodes", indices}}};
  root["buffers"] = {{{"byteLength", bin_.size()}}};
  std::string text = root.dump();
  std::string bin = bin_;
  pad(text, ' ');
  pad(bin, '\0');
  std::string bytes = "glTF" + word(2) + word(28 + text.size() + bin.size());
  bytes += word(text.size()) + "JSON" + text;
  bytes += word(bin.size()) + std::string("BIN\0", 4) + bin;
  replace_file(path, bytes);
}

}  // namespace dualpixel::scenes
