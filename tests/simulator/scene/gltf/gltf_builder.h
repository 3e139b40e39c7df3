#pragma once
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "capture/error.h"
#include "simulator/scene/gltf/gltf.h"
#include "tests/temporary_folder.h"

namespace dualpixel::simulator {

/// A glTF file under construction: JSON that a test may bend at will, and the binary chunk that it speaks of.
struct GltfBuilder {
  nlohmann::json root = {{"asset", {{"version", "2.0"}}}, {"scene", 0}};
  std::string bin;

  int add_view(const void* data, std::size_t bytes, int stride = 0) {
    bin.resize((bin.size() + 3) / 4 * 4);
    nlohmann::json view = {{"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", bytes}};
    if (stride > 0) view["byteStride"] = stride;
    bin.append(static_cast<const char*>(data), bytes);
    root["bufferViews"].push_back(view);
    return static_cast<int>(root["bufferViews"].size()) - 1;
  }

  /// `count` elements of adjacent components.
  template <typename T>
  int add_accessor(const std::vector<T>& values, const std::string& type, bool normalized = false) {
    const std::size_t components = type == "SCALAR" ? 1 : type == "MAT4" ? 16 : type.back() - '0';
    nlohmann::json accessor = {{"bufferView", add_view(values.data(), values.size() * sizeof(T))},
                               {"componentType", component_type<T>()},
                               {"count", values.size() / components},
                               {"type", type}};
    if (normalized) accessor["normalized"] = true;
    root["accessors"].push_back(accessor);
    return static_cast<int>(root["accessors"].size()) - 1;
  }

  nlohmann::json& primitive() { return root["meshes"][0]["primitives"][0]; }
  nlohmann::json& node(int i = 0) { return root["nodes"][i]; }
  nlohmann::json& material() { return root["materials"][0]; }

  std::string glb() const {
    nlohmann::json complete = root;
    if (!bin.empty() && !root.contains("buffers")) complete["buffers"] = {{{"byteLength", bin.size()}}};
    std::string text = complete.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string binary = bin;
    binary.resize((binary.size() + 3) / 4 * 4);
    std::string bytes = "glTF" + word(2) + word(static_cast<std::uint32_t>(28 + text.size() + binary.size()));
    bytes += word(static_cast<std::uint32_t>(text.size())) + "JSON" + text;
    return bytes + word(static_cast<std::uint32_t>(binary.size())) + std::string("BIN\0", 4) + binary;
  }

  Scene read() const { return read_gltf_bytes(glb(), "test.glb", ""); }

  static std::string word(std::uint32_t value) {
    std::string bytes(4, '\0');
    std::memcpy(bytes.data(), &value, 4);
    return bytes;
  }

 private:
  template <typename T>
  static int component_type() {
    if (std::is_same_v<T, float>) return 5126;
    return (sizeof(T) == 1 ? 5121 : sizeof(T) == 2 ? 5123 : 5126) - (std::is_signed_v<T> ? 1 : 0);
  }
};

/// One node with one triangle: (0, 0, 0), (1, 0, 0), (0, 1, 0).
inline GltfBuilder one_triangle() {
  GltfBuilder gltf;
  const int positions = gltf.add_accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
  gltf.primitive()["attributes"]["POSITION"] = positions;
  gltf.root["nodes"] = {{{"mesh", 0}, {"name", "triangle"}}};
  gltf.root["scenes"] = {{{"nodes", {0}}}};
  return gltf;
}

/// The message with which `read` refuses its input; "" and a failure where it does not.
template <typename Read>
std::string refusal(Read read) {
  try {
    read();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string_view(error.what()).find('\n'), std::string_view::npos) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "was not refused";
  return "";
}

}  // namespace dualpixel::simulator
