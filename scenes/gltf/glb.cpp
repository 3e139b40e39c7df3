#include "scenes/gltf/glb.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <exception>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <stdexcept>
#include <utility>

#include "capture/files.h"

namespace dualpixel::scenes {
namespace {

using nlohmann::json;

constexpr int kFloat = 5126, kUint = 5125;

std::string word(std::size_t value) {
  const auto v = static_cast<std::uint32_t>(value);
  return {reinterpret_cast<const char*>(&v), 4};
}

void pad(std::string& bytes, char with) { bytes.resize((bytes.size() + 3) / 4 * 4, with); }

std::string png(int width, int height, int channels, const unsigned char* pixels, int level) {
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  const auto output = OIIO::ImageOutput::create("png");
  output->set_ioproxy(&memory);
  OIIO::ImageSpec spec(width, height, channels, OIIO::TypeDesc::UINT8);
  spec.attribute("png:compressionLevel", level);
  spec.attribute("oiio:UnassociatedAlpha", 1);  // or colors would be divided by it
  if (!output->open("texture.png", spec) || !output->write_image(OIIO::TypeDesc::UINT8, pixels) || !output->close()) {
    throw std::runtime_error("a texture could not be encoded: " + output->geterror());
  }
  return {bytes.begin(), bytes.end()};
}

}  // namespace

Glb::Views::~Views() {
  encoding.cancel();
  try {
    encoding.wait();
  } catch (...) {
    // of a file that nobody asked for
  }
}

void Glb::set_generator(const std::string& name, int png_level) {
  root_["asset"]["generator"] = name;
  png_level_ = png_level;
}

void Glb::use(const std::string& extension) {
  json& used = root_["extensionsUsed"];
  if (std::find(used.begin(), used.end(), extension) == used.end()) used.push_back(extension);
}

int Glb::add_view(std::string bytes) {
  views_->bytes.push_back(std::move(bytes));
  return static_cast<int>(views_->bytes.size()) - 1;
}

int Glb::add_texture(const Texture& texture) { return add_picture(texture.size, texture.size, 3, texture.rgb); }

int Glb::add_texture(int width, int height, const std::vector<unsigned char>& rgba) {
  return add_picture(width, height, 4, rgba);
}

int Glb::add_picture(int width, int height, int channels, const std::vector<unsigned char>& pixels) {
  constexpr std::size_t kMostWaiting = 1 << 26;  // bytes, where other threads do not keep up or there are none
  if (views_->waiting > kMostWaiting) views_->encoding.wait();
  const int view = add_view("");
  views_->waiting += pixels.size();
  views_->encoding.run([=, &waiting = views_->waiting, &bytes = views_->bytes.back(), level = png_level_] {
    bytes = png(width, height, channels, pixels.data(), level);
    waiting -= pixels.size();
  });
  root_["images"].push_back({{"bufferView", view}, {"mimeType", "image/png"}});
  root_["textures"].push_back({{"source", root_["images"].size() - 1}});
  return static_cast<int>(root_["textures"].size()) - 1;
}

int Glb::add_material(const GlbMaterial& from) {
  json pbr = {{"baseColorFactor", {from.color.x, from.color.y, from.color.z, 1}},
              {"metallicFactor", 0},
              {"roughnessFactor", from.roughness}};
  if (from.metallic > 0) pbr["metallicFactor"] = from.metallic;
  if (from.texture >= 0) pbr["baseColorTexture"] = {{"index", from.texture}};
  json material = {{"pbrMetallicRoughness", pbr}, {"doubleSided", true}};
  if (from.unlit) {
    material["extensions"]["KHR_materials_unlit"] = json::object();
    use("KHR_materials_unlit");
  }
  const float brightest = std::max({from.emission_nits.x, from.emission_nits.y, from.emission_nits.z});
  if (brightest > 0) {
    const glm::vec3 hue = from.emission_nits / brightest;
    material["emissiveFactor"] = {hue.x, hue.y, hue.z};
    material["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", brightest}};
    use("KHR_materials_emissive_strength");
  }
  if (from.transmission > 0) {
    material["extensions"]["KHR_materials_transmission"] = {{"transmissionFactor", from.transmission}};
    use("KHR_materials_transmission");
  }
  if (from.solid) {
    material["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 1}};
    use("KHR_materials_volume");
  }
  if (from.cut_out) material["alphaMode"] = "MASK";
  if (from.subsurface > 0) material["extras"]["subsurface"] = from.subsurface;
  root_["materials"].push_back(material);
  return static_cast<int>(root_["materials"].size()) - 1;
}

int Glb::add_material(int texture, glm::vec3 color, bool unlit, float roughness) {
  return add_material({.texture = texture, .color = color, .unlit = unlit, .roughness = roughness});
}

std::size_t Glb::add_accessor(const void* data, std::size_t count, int components, int type) {
  static const char* const kTypes[] = {"", "SCALAR", "VEC2", "VEC3"};
  const int view = add_view({static_cast<const char*>(data), count * components * 4});
  root_["accessors"].push_back(
      {{"bufferView", view}, {"componentType", type}, {"count", count}, {"type", kTypes[components]}});
  return root_["accessors"].size() - 1;
}

std::size_t Glb::add_positions(const std::vector<glm::vec3>& positions) {
  glm::vec3 low = positions.front(), high = low;
  for (const glm::vec3& p : positions) low = glm::min(low, p), high = glm::max(high, p);
  const std::size_t accessor = add_accessor(positions.data(), positions.size(), 3, kFloat);
  root_["accessors"][accessor]["min"] = {low.x, low.y, low.z};
  root_["accessors"][accessor]["max"] = {high.x, high.y, high.z};
  return accessor;
}

json Glb::primitive(const Mesh& mesh, int material) {
  json primitive = {{"material", material}};
  const auto add_floats = [&](const auto& values, int components) {
    return add_accessor(values.data(), values.size(), components, kFloat);
  };
  primitive["attributes"]["POSITION"] = add_positions(mesh.positions);
  if (!mesh.normals.empty()) primitive["attributes"]["NORMAL"] = add_floats(mesh.normals, 3);
  if (!mesh.uvs.empty()) primitive["attributes"]["TEXCOORD_0"] = add_floats(mesh.uvs, 2);
  primitive["indices"] = add_accessor(mesh.triangles.data(), mesh.triangles.size() * 3, 1, kUint);
  return primitive;
}

void Glb::add_node(const std::string& name, const Mesh& mesh, int material, bool person) {
  root_["meshes"].push_back({{"primitives", {primitive(mesh, material)}}});
  json node = {{"name", name}, {"mesh", root_["meshes"].size() - 1}};
  if (person) node["extras"] = {{"category", "person"}};
  root_["nodes"].push_back(node);
}

void Glb::add_colored_person(const std::string& name, const Mesh& mesh, const std::vector<glm::vec3>& colors,
                             int material) {
  json colored = primitive(mesh, material);
  colored["attributes"]["COLOR_0"] = add_accessor(colors.data(), colors.size(), 3, kFloat);
  root_["meshes"].push_back({{"primitives", {colored}}});
  add_person_node(name);
}

void Glb::add_person_node(const std::string& name) {
  root_["nodes"].push_back(
      {{"name", name}, {"mesh", root_["meshes"].size() - 1}, {"extras", {{"category", "person"}}}});
}

void Glb::add_person_hair(const std::string& name, const std::vector<glm::vec3>& points,
                          const std::vector<float>& widths_m, const std::vector<glm::vec3>& colors,
                          const std::vector<glm::uvec2>& segments, int material) {
  constexpr int kLines = 1;
  json hair = {{"material", material}, {"mode", kLines}};
  hair["attributes"]["POSITION"] = add_positions(points);
  hair["attributes"]["_WIDTH"] = add_accessor(widths_m.data(), widths_m.size(), 1, kFloat);
  hair["attributes"]["COLOR_0"] = add_accessor(colors.data(), colors.size(), 3, kFloat);
  hair["indices"] = add_accessor(segments.data(), segments.size() * 2, 1, kUint);
  root_["meshes"].push_back({{"primitives", {hair}}});
  add_person_node(name);
}

int Glb::add_mesh(const std::vector<std::pair<const Mesh*, int>>& parts) {
  json primitives = json::array();
  for (const auto& [mesh, material] : parts) primitives.push_back(primitive(*mesh, material));
  root_["meshes"].push_back({{"primitives", primitives}});
  return static_cast<int>(root_["meshes"].size()) - 1;
}

void Glb::add_instance(const std::string& name, int mesh, const glm::mat4& pose) {
  json matrix = json::array();
  for (int i = 0; i < 16; ++i) matrix.push_back(pose[i / 4][i % 4]);
  root_["nodes"].push_back({{"name", name}, {"mesh", mesh}, {"matrix", matrix}});
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
  use("KHR_lights_punctual");
  root_["extensions"]["KHR_lights_punctual"]["lights"].push_back(
      {{"type", "directional"}, {"color", {color.x, color.y, color.z}}, {"intensity", lux}});
  root_["nodes"].push_back(
      {{"name", "sun"}, {"rotation", {q.x, q.y, q.z, q.w}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
}

void Glb::move_last_node(float from_s, glm::vec3 from, float to_s, glm::vec3 to) {
  const float times[] = {from_s, to_s};
  const glm::vec3 places[] = {from, to};
  const std::size_t input = add_accessor(times, 2, 1, kFloat);
  root_["accessors"][input]["min"] = {from_s};
  root_["accessors"][input]["max"] = {to_s};
  const std::size_t output = add_accessor(places, 2, 3, kFloat);
  json& animation = root_["animations"][0];
  animation["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", "LINEAR"}});
  animation["channels"].push_back({{"sampler", animation["samplers"].size() - 1},
                                   {"target", {{"node", root_["nodes"].size() - 1}, {"path", "translation"}}}});
}

void Glb::write(const std::string& path) const {
  if (views_->encoding.wait() != tbb::task_group_status::complete) throw std::runtime_error("textures were given up");
  json root = root_;
  std::string bin;
  for (const std::string& view : views_->bytes) {
    pad(bin, '\0');
    root["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", view.size()}});
    bin += view;
  }
  json indices = json::array();
  for (std::size_t i = 0; i < root["nodes"].size(); ++i) indices.push_back(i);
  root["scene"] = 0;
  root["scenes"] = {{{"nodes", indices}}};
  root["buffers"] = {{{"byteLength", bin.size()}}};
  std::string text = root.dump();
  pad(text, ' ');
  pad(bin, '\0');
  std::string bytes = "glTF" + word(2) + word(28 + text.size() + bin.size());
  bytes += word(text.size()) + "JSON" + text;
  bytes += word(bin.size()) + std::string("BIN\0", 4) + bin;
  replace_file(path, bytes);
}

}  // namespace dualpixel::scenes
