#include "simulator/scene/gltf/files.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "simulator/scene/gltf/check.h"

namespace dualpixel::simulator {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kMostExternalBytes = std::size_t{4} << 30;  // of all files that one glTF names
constexpr std::uint32_t kJsonChunk = 0x4e4f534a;
constexpr std::uint32_t kBinChunk = 0x004e4942;
static_assert(std::endian::native == std::endian::little, "GLB and its buffers are little-endian");

/// The parts of a .gltf (no binary chunk) or .glb file.
struct Container {
  std::string json_text;
  std::optional<std::string_view> bin;
};

std::uint32_t word_at(std::string_view bytes, std::size_t offset) {
  std::uint32_t word;
  std::memcpy(&word, bytes.data() + offset, sizeof(word));
  return word;
}

/// glTF 2.0, section 4.4: a header of 12 bytes, then chunks with headers of 8.
Container open_container(std::string_view bytes, const std::string& name) {
  if (!bytes.starts_with("glTF")) return {std::string(bytes), std::nullopt};
  const auto fail = [&](const std::string& message) { throw InputError(printable(name) + ": " + message); };
  if (bytes.size() < 20) fail(fmt::format("truncated: {} bytes; a GLB has at least 20", bytes.size()));
  if (word_at(bytes, 4) != 2) fail(fmt::format("GLB version {}: must be 2", word_at(bytes, 4)));
  if (word_at(bytes, 8) != bytes.size()) {
    fail(fmt::format("the GLB header says {} bytes: must be the file's {}", word_at(bytes, 8), bytes.size()));
  }
  Container container;
  std::size_t chunk = 0;
  for (std::size_t offset = 12; offset < bytes.size(); ++chunk) {
    if (bytes.size() - offset < 8) fail(fmt::format("GLB chunk {}: its header is truncated", chunk));
    const std::uint32_t length = word_at(bytes, offset);
    const std::uint32_t type = word_at(bytes, offset + 4);
    offset += 8;
    if (length > bytes.size() - offset) {
      fail(fmt::format("GLB chunk {}: {} bytes: the file has {} left", chunk, length, bytes.size() - offset));
    }
    if (chunk == 0 && type != kJsonChunk) fail(fmt::format("GLB chunk 0: type {:#x}: must be JSON", type));
    if (chunk == 0) container.json_text = bytes.substr(offset, length);
    if (chunk == 1 && type == kBinChunk) container.bin = bytes.substr(offset, length);
    offset += length;
  }
  return container;
}

std::string percent_decoded(const std::string& uri, const std::string& file, const std::string& pointer) {
  std::string decoded;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      decoded += uri[i];
      continue;
    }
    const std::string digits = uri.substr(i + 1, 2);
    if (digits.size() != 2 || digits.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos) {
      fail_gltf(file, pointer, printable(uri) + ": % must be followed by two hexadecimal digits");
    }
    decoded += static_cast<char>(std::stoi(digits, nullptr, 16));
    i += 2;
  }
  return decoded;
}

/// The bytes that a URI names.
std::string read_uri(const std::string& uri, const std::string& folder, const std::string& file,
                     const std::string& pointer, std::size_t& bytes_left) {
  if (uri.starts_with("data:")) {
    const std::size_t comma = uri.find(',');
    if (comma == std::string::npos || !uri.substr(0, comma).ends_with(";base64")) {
      fail_gltf(file, pointer, printable(uri) + ": a data URI must be base64");
    }
    std::vector<unsigned char> bytes;
    std::string media_type;
    if (!tinygltf::DecodeDataURI(&bytes, media_type, "data:application/octet-stream;base64," + uri.substr(comma + 1), 0,
                                 false)) {
      fail_gltf(file, pointer, printable(uri) + ": holds no base64 data");
    }
    return std::string(bytes.begin(), bytes.end());
  }
  const std::string relative = percent_decoded(uri, file, pointer);
  const auto fail = [&](const std::string& why) { fail_gltf(file, pointer, printable(uri) + ": " + why); };
  if (folder.empty()) fail("must be a data URI: this glTF has no folder of its own");
  if (relative.empty() || relative.find('\0') != std::string::npos) fail("must name a file");
  std::error_code error;
  const fs::path root = fs::canonical(folder, error);
  const fs::path path = error ? fs::path() : fs::weakly_canonical(root / relative, error);
  if (error) fail("cannot be read: " + error.message());
  if (std::mismatch(root.begin(), root.end(), path.begin(), path.end()).first != root.end()) {
    fail("must name a file inside the glTF file's own folder");
  }
  if (!fs::exists(path, error)) fail("no such file");
  if (!fs::is_regular_file(path, error)) fail("must be a regular file");
  std::string bytes = read_file(path.string(), bytes_left);
  bytes_left -= bytes.size();
  return bytes;
}

/// What tinygltf may "open": the bytes of each URI under the key that replaced it.
using Bytes = std::map<std::string, std::string>;

/// Replaces every URI, and a GLB's binary chunk, by a key.
Bytes take_uris(json& root, const std::optional<std::string_view>& bin, const std::string& folder,
                const std::string& file) {
  Bytes bytes;
  std::size_t bytes_left = kMostExternalBytes;
  for (const std::string array : {"buffers", "images"}) {
    if (!root.contains(array)) continue;
    for (std::size_t i = 0; i < root[array].size(); ++i) {
      json& object = root[array][i];
      const std::string pointer = fmt::format("/{}/{}/uri", array, i);
      const std::string key = fmt::format("{}-{}", array, i);
      if (object.contains("uri")) {
        bytes[key] = read_uri(object["uri"].get<std::string>(), folder, file, pointer, bytes_left);
      } else if (array == "buffers") {
        bytes[key] = *bin;
      } else {
        continue;
      }
      if (bytes[key].empty()) fail_gltf(file, pointer, "must not be empty");
      if (array == "buffers") {
        const std::size_t needed = object["byteLength"].get<std::size_t>();
        if (bytes[key].size() < needed) {
          fail_gltf(file, fmt::format("/buffers/{}/byteLength", i),
                    fmt::format("{}: there are {} bytes", needed, bytes[key].size()));
        }
        bytes[key].resize(needed);
      }
      object["uri"] = key;
    }
  }
  return bytes;
}

bool key_exists(const std::string& key, void* bytes) { return static_cast<Bytes*>(bytes)->count(key) > 0; }

std::string same_key(const std::string& key, void*) { return key; }

bool move_bytes(std::vector<unsigned char>* out, std::string*, const std::string& key, void* bytes) {
  std::string& source = static_cast<Bytes*>(bytes)->at(key);
  out->assign(source.begin(), source.end());
  source = {};
  return true;
}

bool write_nothing(std::string*, const std::string&, const std::vector<unsigned char>&, void*) { return false; }

[[maybe_unused]] bool size_of_key(std::size_t* size, std::string*, const std::string& key, void* bytes) {
  *size = static_cast<Bytes*>(bytes)->at(key).size();
  return true;
}

/// A template, since tinygltf has GetFileSizeInBytes only from version 2.9 on.
template <typename Callbacks>
Callbacks read_from(Bytes& bytes) {
  Callbacks callbacks{};
  callbacks.FileExists = key_exists;
  callbacks.ExpandFilePath = same_key;
  callbacks.ReadWholeFile = move_bytes;
  callbacks.WriteWholeFile = write_nothing;
  if constexpr (requires { callbacks.GetFileSizeInBytes; }) callbacks.GetFileSizeInBytes = size_of_key;
  callbacks.user_data = &bytes;
  return callbacks;
}

bool keep_encoded(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes,
                  int size, void*) {
  image->image.assign(bytes, bytes + size);
  return true;
}

/// An attribute that the mesh's targets morph and that is not read; empty where there is none.
std::string ignored_morph(const json& mesh) {
  for (const json& primitive : mesh.at("primitives")) {
    for (const json& target : primitive.value("targets", json::array())) {
      for (const auto& [attribute, accessor] : target.items()) {
        if (attribute != "POSITION" && attribute != "NORMAL" && attribute != "TANGENT") return printable(attribute);
      }
    }
  }
  return {};
}

std::vector<std::string> ignored_features(const json& root, const std::string& name) {
  std::vector<std::string> warnings;
  for (const json& extension : root.value("extensionsUsed", json::array())) {
    if (std::none_of(std::begin(kSupportedExtensions), std::end(kSupportedExtensions),
                     [&](const char* supported) { return extension == supported; })) {
      warnings.push_back(
          fmt::format("{}: extension {} is ignored", printable(name), printable(extension.get<std::string>())));
    }
  }
  const json meshes = root.value("meshes", json::array());
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    if (const std::string attribute = ignored_morph(meshes[i]); !attribute.empty()) {
      warnings.push_back(fmt::format("{}: /meshes/{}: morph targets of {} are ignored", printable(name), i, attribute));
    }
  }
  return warnings;
}

/// Tells parts of buffers apart by where they are, not by what they hold.
struct ByPlace {
  bool operator()(std::string_view a, std::string_view b) const {
    return std::pair(a.data(), a.size()) < std::pair(b.data(), b.size());
  }
};

std::size_t bytes_of(const auto& parts) {
  std::size_t sum = 0;
  for (const std::string_view part : parts) sum += part.size();
  return sum;
}

/// In no order of theirs: other programs write the same parts in another.
std::string hash_of_sorted(const auto& parts) {
  std::vector<std::string> hashes;
  for (const std::string_view part : parts) hashes.push_back(hash_of(part));
  std::sort(hashes.begin(), hashes.end());
  return hash_of(fmt::format("{}", fmt::join(hashes, " ")));
}

}  // namespace

GltfFile load_gltf(const std::string& bytes, const std::string& name, const std::string& folder, bool with_animations) {
  const Container container = open_container(bytes, name);
  json root = parse_json(container.json_text, name);
  // what is not read is not checked
  const bool ignored = !with_animations && root.is_object() && root.erase("animations") > 0;
  check_gltf(root, name, container.bin ? std::optional(container.bin->size()) : std::nullopt);

  GltfFile file{name, {}, ignored_features(root, name), {}};
  if (ignored) {
    file.warnings.push_back(printable(name) + ": animations are ignored: nodes keep the pose that the file gives them");
  }
  Bytes uri_bytes = take_uris(root, container.bin, folder, name);
  std::string hashes = hash_of(bytes);
  for (const auto& [key, value] : uri_bytes) hashes += hash_of(value);
  file.source_hash = hash_of(hashes);
  const std::string text = root.dump();
  root = nullptr;

  tinygltf::TinyGLTF loader;
  loader.SetFsCallbacks(read_from<tinygltf::FsCallbacks>(uri_bytes));
  loader.SetImageLoader(keep_encoded, nullptr);
  std::string error, warning;
  if (!loader.LoadASCIIFromString(&file.model, &error, &warning, text.c_str(), static_cast<unsigned>(text.size()),
                                  "")) {
    throw InputError(printable(name) + ": tinygltf: " + printable(error.substr(0, error.find('\n'))));
  }
  return file;
}

std::string hash_of_geometry(const std::string& bytes, const std::string& name, const std::string& folder) {
  try {
    const Container container = open_container(bytes, name);
    json root = parse_json(container.json_text, name);
    if (root.is_object()) root.erase("animations");  // which load_gltf() does not check either
    check_gltf(root, name, container.bin ? std::optional(container.bin->size()) : std::nullopt);
    json parts = {{"buffers", root.at("buffers")}};
    const Bytes buffers = take_uris(parts, container.bin, folder, name);
    std::set<std::size_t> pictures;
    for (const json& image : root.value("images", json::array())) {
      if (image.contains("bufferView")) pictures.insert(image["bufferView"].get<std::size_t>());
    }
    const json& views = root.at("bufferViews");
    std::set<std::string_view, ByPlace> covered;  // views may be many, and all of them cover one large buffer
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (pictures.contains(i)) continue;
      const std::string_view buffer = buffers.at(fmt::format("buffers-{}", views[i]["buffer"].get<std::size_t>()));
      covered.insert(
          buffer.substr(views[i].value("byteOffset", std::size_t{0}), views[i]["byteLength"].get<std::size_t>()));
    }
    std::size_t given = 0;
    for (const auto& [place, buffer] : buffers) given += buffer.size();
    if (!covered.empty() && bytes_of(covered) <= given) return hash_of_sorted(covered);
  } catch (const InputError&) {
  } catch (const json::exception&) {
  }
  return hash_of(bytes);
}

}  // namespace dualpixel::simulator
