#include "simulator/scene/gltf/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "simulator/scene/gltf/light_kinds.h"

namespace dualpixel::simulator {
namespace {

using nlohmann::json;

// With these bounds no sum or product of sizes below comes near 2^64, and tinygltf's int fields hold every value.
constexpr std::uint64_t kLargestBufferBytes = std::numeric_limits<std::int32_t>::max();
constexpr std::uint64_t kMostElements = 1 << 26;
constexpr double kLargestNumber = 1e12;  // of factors, intensities, translations: far from float's limit

/// What an accessor holds, as far as those who refer to it must know.
struct Accessor {
  std::string type;
  int component_type = 0;
  bool normalized = false;
  bool has_view = false;
  std::uint64_t count = 0;
};

/// Component types as a set of bits, plain ones and normalized ones.
constexpr int plain(int component_type) { return 1 << (component_type - 5120); }
constexpr int normalized(int component_type) { return plain(component_type) << 8; }
constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125,
              kFloat = 5126;
constexpr int kFloatOrNormalized = plain(kFloat) | normalized(kUnsignedByte) | normalized(kUnsignedShort);
constexpr int kNormalizedSigned = normalized(kByte) | normalized(kShort);
constexpr int kAnySmallInteger = plain(kByte) | plain(kUnsignedByte) | plain(kShort) | plain(kUnsignedShort) |
                                 normalized(kUnsignedByte) | normalized(kUnsignedShort) | kNormalizedSigned;

/// What an attribute may hold (glTF 2.0, table in section 3.7.2.1; KHR_mesh_quantization adds `quantized`).
struct AttributeRule {
  const char* name;  ///< up to its set index
  const char* types;
  int formats;
  int quantized;
  const char* allowed;
};
constexpr AttributeRule kAttributeRules[] = {
    {"POSITION", "VEC3", plain(kFloat), kAnySmallInteger, "VEC3 of FLOAT"},
    {"NORMAL", "VEC3", plain(kFloat), kNormalizedSigned, "VEC3 of FLOAT"},
    {"TEXCOORD_", "VEC2", kFloatOrNormalized, kAnySmallInteger, "VEC2 of FLOAT or normalized UNSIGNED_BYTE or _SHORT"},
    {"COLOR_", "VEC3 VEC4", kFloatOrNormalized, 0, "VEC3 or VEC4 of FLOAT or normalized UNSIGNED_BYTE or _SHORT"},
    {"_WIDTH", "SCALAR", plain(kFloat), 0, "SCALAR of FLOAT"},
    {"JOINTS_", "VEC4", plain(kUnsignedByte) | plain(kUnsignedShort), 0, "VEC4 of UNSIGNED_BYTE or UNSIGNED_SHORT"},
    {"WEIGHTS_", "VEC4", kFloatOrNormalized, 0, "VEC4 of FLOAT or normalized UNSIGNED_BYTE or _SHORT"},
};

/// Commands of glTF Transform (npm install --global @gltf-transform/cli) that take an extension out of a file.
struct Converter {
  const char* extension;
  const char* command;
};
constexpr Converter kConverters[] = {
    {"KHR_draco_mesh_compression", "gltf-transform cp in.glb out.glb"},
    {"EXT_meshopt_compression", "gltf-transform cp in.glb out.glb"},
    {"KHR_texture_basisu", "gltf-transform ktxdecompress in.glb out.glb"},
    {"EXT_texture_webp", "gltf-transform png in.glb out.glb --formats '*'"},
};

std::string how_to_do_without(const json& extension) {
  for (const Converter& converter : kConverters) {
    if (extension == converter.extension) return fmt::format("; convert it: {}", converter.command);
  }
  return "";
}

std::string component_name(int component_type) {
  switch (component_type) {
    case kByte:
      return "BYTE";
    case kUnsignedByte:
      return "UNSIGNED_BYTE";
    case kShort:
      return "SHORT";
    case kUnsignedShort:
      return "UNSIGNED_SHORT";
    case kUnsignedInt:
      return "UNSIGNED_INT";
    default:
      return "FLOAT";
  }
}

std::string format_name(const Accessor& accessor) {
  return fmt::format("{} of {}{}", accessor.type, accessor.normalized ? "normalized " : "",
                     component_name(accessor.component_type));
}

std::uint64_t component_bytes(int component_type) {
  return component_type <= kUnsignedByte ? 1 : component_type <= kUnsignedShort ? 2 : 4;
}

std::uint64_t component_count(const std::string& type) {
  if (type == "SCALAR") return 1;
  const std::uint64_t n = type.back() - '0';
  return type.starts_with("VEC") ? n : n * n;
}

std::uint64_t element_bytes(const Accessor& accessor) {
  const std::uint64_t component = component_bytes(accessor.component_type);
  if (!accessor.type.starts_with("MAT")) return component_count(accessor.type) * component;
  const std::uint64_t rows = accessor.type.back() - '0';
  return rows * ((rows * component + 3) / 4 * 4);  // columns start at multiples of 4 bytes
}

std::string dump(const json& value) { return printable(value.dump(-1, ' ', false, json::error_handler_t::replace)); }

/// One object of the file: its value, its JSON pointer, and its fields with their checks.
struct Item {
  const json& value;
  std::string at;
  Fields fields;
  Item(const json& value_, const std::string& file, const std::string& at_)
      : value(value_), at(at_), fields(value_, file, at_) {}
};

class Checker {
 public:
  Checker(const json& root, const std::string& file, std::optional<std::size_t> bin_bytes)
      : file_(file), root_(root, file, ""), bin_bytes_(bin_bytes) {}

  void check() {
    check_asset();
    check_extensions();
    each(root_, "buffers", [&](Item& buffer) { check_buffer(buffer); });
    each(root_, "bufferViews", [&](Item& view) { check_view(view); });
    each(root_, "accessors", [&](Item& accessor) { check_accessor(accessor); });
    each(root_, "images", [&](Item& image) { check_image(image); });
    each(root_, "samplers", [&](Item& sampler) { check_sampler(sampler); });
    each(root_, "textures", [&](Item& texture) { check_texture(texture); });
    each(root_, "materials", [&](Item& material) { check_material(material); });
    each(root_, "meshes", [&](Item& mesh) { check_mesh(mesh); });
    each(root_, "cameras", [&](Item& camera) { check_camera(camera); });
    each(root_, "skins", [&](Item& skin) { check_skin(skin); });
    Item extensions = child(root_, "extensions");
    Item lights = child(extensions, "KHR_lights_punctual");
    each(lights, "lights", [&](Item& light) { check_light(light); });
    light_count_ = array(lights, "lights").size();
    each(root_, "nodes", [&](Item& node) { check_node(node); });
    check_tree();
    each(root_, "animations", [&](Item& animation) { check_animation(animation); });
    each(root_, "scenes", [&](Item& scene) { check_scene(scene); });
    if (array(root_, "scenes").empty()) fail("/scenes", "is required: it says what to show");
    reference(root_, "scene", "scenes");
  }

 private:
  [[noreturn]] void fail(const std::string& pointer, const std::string& message) const {
    fail_gltf(file_, pointer, message);
  }

  /// The object under a key, or an empty one.
  Item child(const Item& item, const std::string& key) const {
    static const json empty = json::object();
    const auto found = item.value.find(key);
    return Item(found == item.value.end() ? empty : *found, file_, item.at + "/" + key);
  }

  /// The array under a key, or an empty one.
  const json& array(const Item& item, const std::string& key) const {
    static const json empty = json::array();
    const auto found = item.value.find(key);
    if (found == item.value.end()) return empty;
    if (!found->is_array()) fail(item.at + "/" + key, dump(*found) + ": must be an array");
    return *found;
  }

  /// visit(item) for every object of an array.
  template <typename Visit>
  void each(const Item& parent, const std::string& key, Visit visit) const {
    std::size_t i = 0;
    for (const json& element : array(parent, key)) {
      Item item(element, file_, fmt::format("{}/{}/{}", parent.at, key, i++));
      visit(item);
    }
  }

  /// An index into the array `target` of the file.
  std::uint64_t index(const json& value, const std::string& pointer, const std::string& target) const {
    const std::uint64_t size = target == "lights" ? light_count_ : array(root_, target).size();
    if (size == 0) fail(pointer, fmt::format("{}: the file has no {}", dump(value), target));
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() >= size) {
      fail(pointer, fmt::format("{}: must be an integer in [0, {}], an index into {}", dump(value), size - 1, target));
    }
    return value.get<std::uint64_t>();
  }
  std::optional<std::uint64_t> reference(const Item& item, const std::string& key, const std::string& target) const {
    const auto found = item.value.find(key);
    if (found == item.value.end()) return std::nullopt;
    return index(*found, item.at + "/" + key, target);
  }
  std::uint64_t required_reference(Item& item, const std::string& key, const std::string& target) const {
    item.fields.required(key);
    return *reference(item, key, target);
  }
  std::vector<std::uint64_t> references(const Item& item, const std::string& key, const std::string& target) const {
    std::vector<std::uint64_t> result;
    for (const json& value : array(item, key)) {
      result.push_back(index(value, fmt::format("{}/{}/{}", item.at, key, result.size()), target));
    }
    return result;
  }

  /// `N` numbers within a range; `values` where they are not given.
  template <std::size_t N>
  std::array<double, N> numbers(Item& item, const std::string& key, std::array<double, N> values, double low,
                                double high) const {
    item.fields.numbers(key, values.data(), N);
    for (const double value : values) {
      if (!(value >= low && value <= high)) {
        item.fields.fail(key, fmt::format("{:g}: must be numbers in [{:g}, {:g}]", value, low, high));
      }
    }
    return values;
  }

  int one_of(Item& item, const std::string& key, const std::vector<int>& allowed) const {
    const auto found = item.value.find(key);
    if (found == item.value.end()) return 0;
    for (const int a : allowed) {
      if (*found == a) return a;
    }
    item.fields.fail(key, fmt::format("{}: must be one of {}", dump(*found), fmt::join(allowed, ", ")));
  }

  void check_asset() {
    root_.fields.required("asset");
    Item asset = child(root_, "asset");
    std::string version, least_version = "2.0";
    asset.fields.required("version").text("version", version).text("minVersion", least_version);
    if (!version.starts_with("2.")) asset.fields.fail("version", printable(version) + ": must be 2.0");
    if (least_version != "2.0") asset.fields.fail("minVersion", printable(least_version) + ": must be 2.0");
  }

  void check_extensions() {
    for (const std::string key : {"extensionsUsed", "extensionsRequired"}) {
      std::size_t i = 0;
      for (const json& name : array(root_, key)) {
        const std::string pointer = fmt::format("/{}/{}", key, i++);
        if (!name.is_string()) fail(pointer, dump(name) + ": must be a string");
        quantized_ = quantized_ || name == "KHR_mesh_quantization";
        const bool known = std::any_of(std::begin(kSupportedExtensions), std::end(kSupportedExtensions),
                                       [&](const char* supported) { return name == supported; });
        if (!known && key == "extensionsRequired") {
          fail(pointer, fmt::format("{}: this required extension is not supported (these are: {}){}", dump(name),
                                    fmt::join(kSupportedExtensions, ", "), how_to_do_without(name)));
        }
      }
    }
  }

  void check_buffer(Item& buffer) {
    std::uint64_t bytes = 0;
    std::string uri;
    buffer.fields.required("byteLength").integer("byteLength", bytes, 1, kLargestBufferBytes).text("uri", uri);
    if (!buffer.value.contains("uri")) {
      if (!buffer_bytes_.empty() || !bin_bytes_) {
        buffer.fields.fail("uri", "is required (only a GLB's buffer 0 does without)");
      }
      if (bytes > *bin_bytes_) {
        buffer.fields.fail("byteLength", fmt::format("{}: the GLB's binary chunk has {} bytes", bytes, *bin_bytes_));
      }
    }
    buffer_bytes_.push_back(bytes);
  }

  void check_view(Item& view) {
    const std::uint64_t available = buffer_bytes_[required_reference(view, "buffer", "buffers")];
    std::uint64_t offset = 0;
    View checked;
    view.fields.integer("byteOffset", offset, 0, available - 1);
    view.fields.required("byteLength").integer("byteLength", checked.bytes, 1, available - offset);
    view.fields.integer("byteStride", checked.stride, 4, 252);
    if (checked.stride % 4 != 0) {
      view.fields.fail("byteStride", fmt::format("{}: must be a multiple of 4", checked.stride));
    }
    views_.push_back(checked);
  }

  /// That `count` elements of `bytes` each, `stride` apart, lie within the view that `item` names.
  void check_range(Item& item, std::uint64_t view, std::uint64_t count, std::uint64_t bytes,
                   std::uint64_t stride) const {
    std::uint64_t offset = 0;
    item.fields.integer("byteOffset", offset, 0, kLargestBufferBytes);
    const std::uint64_t end = offset + stride * (count - 1) + bytes;
    if (end > views_[view].bytes) {
      item.fields.fail("count", fmt::format("{}: reaches to byte {} of bufferView {}, which has {} bytes", count, end,
                                            view, views_[view].bytes));
    }
  }

  void check_accessor(Item& item) {
    Accessor accessor;
    Fields& fields = item.fields;
    fields.required("componentType").required("count").required("type");
    accessor.component_type =
        one_of(item, "componentType", {kByte, kUnsignedByte, kShort, kUnsignedShort, kUnsignedInt, kFloat});
    fields.choice("type", accessor.type, {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"});
    fields.integer("count", accessor.count, 1, kMostElements).boolean("normalized", accessor.normalized);
    const std::uint64_t bytes = element_bytes(accessor);
    if (const auto view = reference(item, "bufferView", "bufferViews")) {
      const std::uint64_t stride = views_[*view].stride > 0 ? views_[*view].stride : bytes;
      if (stride < bytes) {
        fields.fail("bufferView",
                    fmt::format("{}: its byteStride of {} is less than an element's {} bytes", *view, stride, bytes));
      }
      check_range(item, *view, accessor.count, bytes, stride);
      accessor.has_view = true;
    }
    if (item.value.contains("sparse")) {
      Item sparse = child(item, "sparse");
      std::uint64_t count = 0;
      sparse.fields.required("count").integer("count", count, 1, accessor.count);
      sparse.fields.required("indices").required("values");
      Item indices = child(sparse, "indices"), values = child(sparse, "values");
      indices.fields.required("componentType");
      const std::uint64_t index_bytes =
          component_bytes(one_of(indices, "componentType", {kUnsignedByte, kUnsignedShort, kUnsignedInt}));
      check_range(indices, required_reference(indices, "bufferView", "bufferViews"), count, index_bytes, index_bytes);
      check_range(values, required_reference(values, "bufferView", "bufferViews"), count, bytes, bytes);
    }
    accessors_.push_back(accessor);
  }

  void check_image(Item& image) const {
    std::string uri;
    image.fields.text("uri", uri);
    const auto view = reference(image, "bufferView", "bufferViews");
    if (image.value.contains("uri") == view.has_value()) fail(image.at, "must have either a uri or a bufferView");
  }

  void check_sampler(Item& sampler) const {
    one_of(sampler, "magFilter", {9728, 9729});
    one_of(sampler, "minFilter", {9728, 9729, 9984, 9985, 9986, 9987});
    for (const char* key : {"wrapS", "wrapT"}) one_of(sampler, key, {33071, 33648, 10497});
  }

  void check_texture(Item& texture) {
    reference(texture, "sampler", "samplers");
    texture_has_image_.push_back(reference(texture, "source", "images").has_value());
  }

  void check_texture_slot(Item& object, const std::string& key) const {
    if (!object.value.contains(key)) return;
    Item slot = child(object, key);
    const std::uint64_t texture = required_reference(slot, "index", "textures");
    if (!texture_has_image_[texture]) {
      fail(fmt::format("/textures/{}/source", texture), "is required, and must be an index into images");
    }
    int uv_set = 0;
    double number = 0;
    slot.fields.integer("texCoord", uv_set, 0, 1).number("scale", number, -kLargestNumber, kLargestNumber);
    Item extensions = child(slot, "extensions");
    Item transform = child(extensions, "KHR_texture_transform");
    numbers<2>(transform, "offset", {0, 0}, -kLargestNumber, kLargestNumber);
    numbers<2>(transform, "scale", {1, 1}, -kLargestNumber, kLargestNumber);
    transform.fields.number("rotation", number, -kLargestNumber, kLargestNumber).integer("texCoord", uv_set, 0, 1);
  }

  void check_material(Item& material) const {
    double number = 0;
    std::string text;
    bool flag = false;
    Item surface = child(material, "pbrMetallicRoughness");
    numbers<4>(surface, "baseColorFactor", {1, 1, 1, 1}, 0, 1);
    surface.fields.number("metallicFactor", number, 0, 1).number("roughnessFactor", number, 0, 1);
    check_texture_slot(surface, "baseColorTexture");
    check_texture_slot(surface, "metallicRoughnessTexture");
    numbers<3>(material, "emissiveFactor", {0, 0, 0}, 0, 1);
    check_texture_slot(material, "emissiveTexture");
    check_texture_slot(material, "normalTexture");
    material.fields.choice("alphaMode", text, {"OPAQUE", "MASK", "BLEND"});
    material.fields.number("alphaCutoff", number, 0, kLargestNumber).boolean("doubleSided", flag);
    Item extensions = child(material, "extensions");
    Item strength = child(extensions, "KHR_materials_emissive_strength");
    strength.fields.number("emissiveStrength", number, 0, kLargestNumber);
    child(extensions, "KHR_materials_unlit");
    check_layers(extensions);
    if (const auto extras = material.value.find("extras"); extras != material.value.end() && extras->is_object()) {
      child(material, "extras").fields.number("subsurface", number, 0, 1);
    }
  }

  /// Textures of these extensions are not read, and so not checked.
  void check_layers(const Item& extensions) const {
    constexpr double kHighestIor = 10;
    double number = 0, index = 1.5;
    Item ior = child(extensions, "KHR_materials_ior");
    ior.fields.number("ior", index, 0, kHighestIor);
    if (index > 0 && index < 1)
      ior.fields.fail("ior", fmt::format("{:g}: must be 0 or in [1, {}]", index, kHighestIor));
    Item specular = child(extensions, "KHR_materials_specular");
    specular.fields.number("specularFactor", number, 0, 1);
    numbers<3>(specular, "specularColorFactor", {1, 1, 1}, 0, kLargestNumber);
    Item coat = child(extensions, "KHR_materials_clearcoat");
    coat.fields.number("clearcoatFactor", number, 0, 1).number("clearcoatRoughnessFactor", number, 0, 1);
    Item sheen = child(extensions, "KHR_materials_sheen");
    numbers<3>(sheen, "sheenColorFactor", {0, 0, 0}, 0, 1);
    sheen.fields.number("sheenRoughnessFactor", number, 0, 1);
    child(extensions, "KHR_materials_transmission").fields.number("transmissionFactor", number, 0, 1);
    Item volume = child(extensions, "KHR_materials_volume");
    volume.fields.number("thicknessFactor", number, 0, kLargestNumber);
    volume.fields.number("attenuationDistance", number, 1e-9, kLargestNumber);
    numbers<3>(volume, "attenuationColor", {1, 1, 1}, 0, 1);
  }

  /// Every attribute that is listed: of a type that its name allows, and one element per vertex. Names that begin with
  /// an underscore are the application's, but for the widths of lines.
  void check_attributes(const Item& attributes, std::uint64_t vertices, bool of_lines) const {
    for (const auto& [name, value] : attributes.value.items()) {
      const std::string pointer = attributes.at + "/" + name;
      const Accessor& accessor = accessors_[index(value, pointer, "accessors")];
      const int format = accessor.normalized ? normalized(accessor.component_type) : plain(accessor.component_type);
      for (const AttributeRule& rule : kAttributeRules) {
        if (rule.name[0] == '_' && !of_lines) continue;
        const int allowed = rule.formats | (quantized_ ? rule.quantized : 0);
        if (name.starts_with(rule.name) &&
            (!(format & allowed) || std::string(rule.types).find(accessor.type) == std::string::npos)) {
          fail(pointer, fmt::format("{}: is {}: must be {}{}", dump(value), format_name(accessor), rule.allowed,
                                    rule.quantized ? " (smaller integers with KHR_mesh_quantization)" : ""));
        }
      }
      if (accessor.count != vertices) {
        fail(pointer,
             fmt::format("{}: has {} elements: must have {}, as POSITION has", dump(value), accessor.count, vertices));
      }
    }
  }

  void check_mesh(Item& mesh) {
    mesh.fields.required("primitives");
    if (array(mesh, "primitives").empty()) mesh.fields.fail("primitives", "must not be empty");
    std::optional<std::size_t> targets;
    bool skinned = true;
    each(mesh, "primitives", [&](Item& primitive) {
      primitive.fields.required("attributes");
      Item attributes = child(primitive, "attributes");
      const std::uint64_t vertices = accessors_[required_reference(attributes, "POSITION", "accessors")].count;
      const int mode = one_of(primitive, "mode", {0, 1, 2, 3, 4, 5, 6});
      const bool of_lines = mode >= 1 && mode <= 3;
      check_attributes(attributes, vertices, of_lines);
      skinned = skinned && attributes.value.contains("JOINTS_0") && attributes.value.contains("WEIGHTS_0");
      if (const auto indices = reference(primitive, "indices", "accessors")) check_indices(primitive, *indices);
      reference(primitive, "material", "materials");
      each(primitive, "targets", [&](Item& target) { check_attributes(target, vertices, of_lines); });
      const std::size_t count = array(primitive, "targets").size();
      if (count != targets.value_or(count)) {
        fail(primitive.at + "/targets",
             fmt::format("{} targets: must be {}, as in the mesh's first primitive", count, *targets));
      }
      targets = count;
    });
    meshes_.push_back({*targets, skinned});
    check_weights(mesh, *targets);
  }

  void check_indices(Item& primitive, std::uint64_t index) const {
    const Accessor& accessor = accessors_[index];
    const int unsigned_integers = plain(kUnsignedByte) | plain(kUnsignedShort) | plain(kUnsignedInt);
    if (accessor.type != "SCALAR" || accessor.normalized || !(plain(accessor.component_type) & unsigned_integers)) {
      primitive.fields.fail("indices", fmt::format("{}: is {}: must be SCALAR of UNSIGNED_BYTE, _SHORT or _INT", index,
                                                   format_name(accessor)));
    }
    if (!accessor.has_view) fail(fmt::format("/accessors/{}/bufferView", index), "is required of indices");
  }

  /// One weight for each morph target.
  void check_weights(Item& item, std::size_t targets) const {
    if (!item.value.contains("weights")) return;
    const json& weights = array(item, "weights");
    if (weights.size() != targets) {
      item.fields.fail("weights",
                       fmt::format("{} weights: must be {}, one for each morph target", weights.size(), targets));
    }
    for (const json& weight : weights) {
      if (!weight.is_number() || std::abs(weight.get<double>()) > kLargestNumber) {
        item.fields.fail("weights", fmt::format("{}: must be a number in [{:g}, {:g}]", dump(weight), -kLargestNumber,
                                                kLargestNumber));
      }
    }
  }

  void check_camera(Item& camera) const {
    std::string type;
    camera.fields.required("type").choice("type", type, {"perspective", "orthographic"});
    if (type != "perspective") return;
    camera.fields.required("perspective");
    Item perspective = child(camera, "perspective");
    double field_of_view = 0;
    perspective.fields.required("yfov").number("yfov", field_of_view, 1e-4, std::numbers::pi - 1e-4);
  }

  void check_skin(Item& skin) {
    skin.fields.required("joints");
    const std::size_t joints = references(skin, "joints", "nodes").size();
    if (joints == 0) skin.fields.fail("joints", "must not be empty");
    reference(skin, "skeleton", "nodes");
    if (const auto matrices = reference(skin, "inverseBindMatrices", "accessors")) {
      const Accessor& accessor = accessors_[*matrices];
      if (accessor.type != "MAT4" || accessor.component_type != kFloat || accessor.count < joints) {
        skin.fields.fail("inverseBindMatrices",
                         fmt::format("{}: is {} {}: must be at least {} MAT4 of FLOAT, one for each joint", *matrices,
                                     accessor.count, format_name(accessor), joints));
      }
    }
  }

  /// Every sampler that a channel uses has as many values as its path and interpolation ask for.
  void check_animation(Item& animation) const {
    struct Sampler {
      std::uint64_t keys = 0, output = 0;
      bool cubic = false;
    };
    std::vector<Sampler> samplers;
    each(animation, "samplers", [&](Item& item) {
      std::string interpolation = "LINEAR";
      item.fields.choice("interpolation", interpolation, {"LINEAR", "STEP", "CUBICSPLINE"});
      const std::uint64_t input = required_reference(item, "input", "accessors");
      const Accessor& times = accessors_[input];
      if (times.type != "SCALAR" || times.component_type != kFloat || times.count == 0) {
        item.fields.fail("input", fmt::format("{}: is {} {}: must be SCALAR of FLOAT, at least one", input, times.count,
                                              format_name(times)));
      }
      samplers.push_back(
          {times.count, required_reference(item, "output", "accessors"), interpolation == "CUBICSPLINE"});
    });
    each(animation, "channels", [&](Item& channel) {
      int index = 0;
      channel.fields.required("sampler");
      if (samplers.empty()) {
        channel.fields.fail("sampler", dump(channel.value["sampler"]) + ": the animation has no samplers");
      }
      channel.fields.integer("sampler", index, 0, static_cast<int>(samplers.size()) - 1);
      channel.fields.required("target");
      Item target = child(channel, "target");
      std::string path;
      target.fields.required("path").choice("path", path, {"translation", "rotation", "scale", "weights"});
      const auto node = reference(target, "node", "nodes");
      if (!node || path == "weights") return;  // not taken over
      if (root_.value["nodes"][*node].contains("matrix")) {
        target.fields.fail("node", fmt::format("{}: must not have a matrix", *node));
      }
      const Sampler& sampler = samplers[index];
      const Accessor& values = accessors_[sampler.output];
      const bool rotation = path == "rotation";
      const std::uint64_t count = sampler.keys * (sampler.cubic ? 3 : 1);
      if (values.type != (rotation ? "VEC4" : "VEC3") || values.count != count ||
          !(values.component_type == kFloat || (rotation && values.normalized))) {
        channel.fields.fail(
            "sampler",
            fmt::format("{}: its output is {} {}: {} must have {} {}", index, values.count, format_name(values), path,
                        count, rotation ? "VEC4 of FLOAT or normalized integers" : "VEC3 of FLOAT"));
      }
    });
  }

  void check_light(Item& light) const {
    std::string type;
    double intensity = 1, range = 1, outer = std::numbers::pi / 4, inner = 0;
    light.fields.required("type").choice("type", type, names_of(kLightKinds));
    numbers<3>(light, "color", {1, 1, 1}, 0, kLargestNumber);
    light.fields.number("intensity", intensity, 0, kLargestNumber);
    light.fields.number("range", range, std::numeric_limits<float>::min(), kLargestNumber);
    if (type != name_of(kLightKinds, PunctualLight::Kind::spot)) return;
    light.fields.required("spot");
    Item spot = child(light, "spot");
    spot.fields.number("outerConeAngle", outer, 1e-6, std::numbers::pi / 2);
    spot.fields.number("innerConeAngle", inner, 0, outer);
    if (inner >= outer) spot.fields.fail("innerConeAngle", fmt::format("{}: must be less than {}", inner, outer));
  }

  void check_node(Item& node) {
    reference(node, "camera", "cameras");
    const auto mesh = reference(node, "mesh", "meshes");
    const auto skin = reference(node, "skin", "skins");
    if (skin && !(mesh && meshes_[*mesh].skinned)) {
      node.fields.fail("skin", fmt::format("{}: the node must have a mesh with JOINTS_0 and WEIGHTS_0", *skin));
    }
    if (mesh) check_weights(node, meshes_[*mesh].targets);
    Item extensions = child(node, "extensions");
    if (extensions.value.contains("KHR_lights_punctual")) {
      Item light = child(extensions, "KHR_lights_punctual");
      required_reference(light, "light", "lights");
    }
    std::string name;
    node.fields.text("name", name);
    check_transform(node);
    children_.push_back(references(node, "children", "nodes"));
  }

  void check_transform(Item& node) const {
    for (const char* key : {"translation", "rotation", "scale"}) {
      if (node.value.contains(key) && node.value.contains("matrix")) {
        node.fields.fail("matrix", fmt::format("must not stand beside {}", key));
      }
    }
    numbers<3>(node, "translation", {0, 0, 0}, -kLargestNumber, kLargestNumber);
    const auto q = numbers<4>(node, "rotation", {0, 0, 0, 1}, -kLargestNumber, kLargestNumber);
    if (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] < 1e-6) {
      node.fields.fail("rotation", fmt::format("[{}]: must be a unit quaternion", fmt::join(q, ", ")));
    }
    const auto scale = numbers<3>(node, "scale", {1, 1, 1}, -kLargestNumber, kLargestNumber);
    for (const double s : scale) {
      if (std::abs(s) < kLeastScale) {
        node.fields.fail("scale", fmt::format("[{}]: a singular transform: must not be 0", fmt::join(scale, ", ")));
      }
    }
    // Column-major; singular is judged against the columns' lengths, so that tiny models pass.
    const auto m =
        numbers<16>(node, "matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, -kLargestNumber, kLargestNumber);
    const double determinant =
        m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) + m[8] * (m[1] * m[6] - m[2] * m[5]);
    double lengths = 1;
    for (const int c : {0, 4, 8}) lengths *= std::hypot(m[c], m[c + 1], m[c + 2]);
    if (!(std::abs(determinant) > 1e-9 * lengths) || lengths < kLeastScale * kLeastScale * kLeastScale) {
      node.fields.fail("matrix", fmt::format("its determinant is {:g}: must not be singular", determinant));
    }
    for (const int i : {3, 7, 11, 15}) {
      if (std::abs(m[i] - (i == 15)) > 1e-6) {
        node.fields.fail("matrix", fmt::format("{:g} at {}: the bottom row must be 0, 0, 0, 1", m[i], i));
      }
    }
  }

  /// Every node has one parent at most, and none is its own ancestor.
  void check_tree() {
    const std::size_t nodes = children_.size();
    has_parent_.assign(nodes, false);
    for (std::size_t parent = 0; parent < nodes; ++parent) {
      for (std::size_t i = 0; i < children_[parent].size(); ++i) {
        const std::uint64_t node = children_[parent][i];
        if (has_parent_[node] || node == parent) {
          fail(fmt::format("/nodes/{}/children/{}", parent, i),
               fmt::format("{}: {}: the nodes must form a tree", node,
                           node == parent ? "is the node itself" : "already has a parent"));
        }
        has_parent_[node] = true;
      }
    }
    // With one parent each, whatever no root leads to lies on a cycle or below one.
    std::vector<std::uint64_t> reached;
    for (std::size_t node = 0; node < nodes; ++node) {
      if (!has_parent_[node]) reached.push_back(node);
    }
    std::vector<bool> is_reached(nodes, false);
    for (std::size_t i = 0; i < reached.size(); ++i) {
      is_reached[reached[i]] = true;
      // One by one: of insert(), GCC 14 believes that it could overflow.
      for (const std::uint64_t child : children_[reached[i]]) reached.push_back(child);
    }
    for (std::size_t node = 0; node < nodes; ++node) {
      if (!is_reached[node]) {
        fail(fmt::format("/nodes/{}/children", node), "lead in a cycle: the nodes must form a tree");
      }
    }
  }

  void check_scene(Item& scene) const {
    std::vector<bool> listed(children_.size(), false);
    const std::vector<std::uint64_t> roots = references(scene, "nodes", "nodes");
    for (std::size_t i = 0; i < roots.size(); ++i) {
      if (has_parent_[roots[i]] || listed[roots[i]]) {
        fail(fmt::format("{}/nodes/{}", scene.at, i),
             fmt::format("{}: must be a node without parent, listed once", roots[i]));
      }
      listed[roots[i]] = true;
    }
  }

  static constexpr double kLeastScale = 1e-12;

  struct View {
    std::uint64_t bytes = 0;
    std::uint64_t stride = 0;  ///< 0: tightly packed
  };
  struct MeshFacts {
    std::size_t targets = 0;
    bool skinned = false;
  };

  const std::string& file_;
  Item root_;
  std::optional<std::size_t> bin_bytes_;
  bool quantized_ = false;
  std::vector<std::uint64_t> buffer_bytes_;
  std::vector<View> views_;
  std::vector<Accessor> accessors_;
  std::vector<bool> texture_has_image_;
  std::vector<MeshFacts> meshes_;
  std::uint64_t light_count_ = 0;
  std::vector<std::vector<std::uint64_t>> children_;
  std::vector<bool> has_parent_;
};

}  // namespace

void check_gltf(const json& root, const std::string& file, std::optional<std::size_t> bin_bytes) {
  Checker(root, file, bin_bytes).check();
}

void fail_gltf(const std::string& file, const std::string& pointer, const std::string& message) {
  throw InputError(fmt::format("{}: {}: {}", printable(file), printable(pointer), message));
}

}  // namespace dualpixel::simulator
