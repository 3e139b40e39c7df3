#include "simulator/scene/gltf/accessor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "simulator/scene/gltf/check.h"

namespace dualpixel::simulator {
namespace {

const unsigned char* view_bytes(const tinygltf::Model& model, int view, std::size_t offset) {
  const tinygltf::BufferView& v = model.bufferViews[view];
  return model.buffers[v.buffer].data.data() + v.byteOffset + offset;
}

/// One component of type Stored as T (glTF 2.0, section 3.11: c / max, not below -1).
template <typename T, typename Stored>
T component(const unsigned char* bytes, bool normalized) {
  Stored value;
  std::memcpy(&value, bytes, sizeof(value));  // accessors may be unaligned
  if constexpr (std::is_floating_point_v<T> && std::is_integral_v<Stored>) {
    if (normalized) return std::max(static_cast<T>(value) / static_cast<T>(std::numeric_limits<Stored>::max()), T(-1));
  }
  return static_cast<T>(value);
}

/// Elements `stride` bytes apart into `out`, one after the other. Each is `columns` runs of `rows` components.
template <typename T, typename Stored>
void read_elements(const unsigned char* bytes, std::size_t stride, std::size_t count, int columns, int rows,
                   bool normalized, T* out) {
  // A matrix's columns start at multiples of 4 bytes.
  const std::size_t column_bytes = columns == 1 ? 0 : (rows * sizeof(Stored) + 3) / 4 * 4;
  for (std::size_t i = 0; i < count; ++i, bytes += stride) {
    for (int c = 0; c < columns; ++c) {
      for (int r = 0; r < rows; ++r) {
        *out++ = component<T, Stored>(bytes + c * column_bytes + r * sizeof(Stored), normalized);
      }
    }
  }
}

/// `stride` 0: elements are adjacent.
template <typename T>
void read_elements(const unsigned char* bytes, std::size_t stride, std::size_t count, int type, int component_type,
                   bool normalized, T* out) {
  const bool matrix = type == TINYGLTF_TYPE_MAT2 || type == TINYGLTF_TYPE_MAT3 || type == TINYGLTF_TYPE_MAT4;
  const int components = tinygltf::GetNumComponentsInType(type);
  const int columns = matrix ? static_cast<int>(std::lround(std::sqrt(components))) : 1;
  const int rows = components / columns;
  const auto read = [&]<typename Stored>(Stored) {
    const std::size_t column_bytes = rows * sizeof(Stored);
    const std::size_t bytes_each = matrix ? columns * ((column_bytes + 3) / 4 * 4) : column_bytes;
    read_elements<T, Stored>(bytes, stride > 0 ? stride : bytes_each, count, columns, rows, normalized, out);
  };
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return read(std::int8_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return read(std::uint8_t{});
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return read(std::int16_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return read(std::uint16_t{});
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return read(std::uint32_t{});
    default:
      return read(float{});
  }
}

template <typename T>
std::vector<T> read_accessor(const GltfFile& file, int index) {
  const tinygltf::Model& model = file.model;
  const tinygltf::Accessor& accessor = model.accessors[index];
  const int components = tinygltf::GetNumComponentsInType(accessor.type);
  std::vector<T> values(accessor.count * components);  // zeros where there is no view
  if (accessor.bufferView >= 0) {
    read_elements(view_bytes(model, accessor.bufferView, accessor.byteOffset),
                  model.bufferViews[accessor.bufferView].byteStride, accessor.count, accessor.type,
                  accessor.componentType, accessor.normalized, values.data());
  }
  if (!accessor.sparse.isSparse) return values;

  const auto& sparse = accessor.sparse;
  std::vector<std::uint32_t> targets(sparse.count);
  read_elements(view_bytes(model, sparse.indices.bufferView, sparse.indices.byteOffset), 0, targets.size(),
                TINYGLTF_TYPE_SCALAR, sparse.indices.componentType, false, targets.data());
  std::vector<T> replacements(targets.size() * components);
  read_elements(view_bytes(model, sparse.values.bufferView, sparse.values.byteOffset), 0, targets.size(), accessor.type,
                accessor.componentType, accessor.normalized, replacements.data());
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (targets[i] >= accessor.count || (i > 0 && targets[i] <= targets[i - 1])) {
      fail_gltf(file.name, fmt::format("/accessors/{}/sparse/indices", index),
                fmt::format("entry {} is {}: must increase and be less than {}", i, targets[i], accessor.count));
    }
    std::copy_n(&replacements[i * components], components, &values[std::size_t{targets[i]} * components]);
  }
  return values;
}

}  // namespace

std::vector<float> read_floats(const GltfFile& file, int accessor) {
  std::vector<float> values = read_accessor<float>(file, accessor);
  const auto bad = std::find_if(values.begin(), values.end(), [](float v) { return !std::isfinite(v); });
  if (bad != values.end()) {
    const int components = tinygltf::GetNumComponentsInType(file.model.accessors[accessor].type);
    fail_gltf(file.name, fmt::format("/accessors/{}", accessor),
              fmt::format("element {} holds {}: must be finite", (bad - values.begin()) / components, *bad));
  }
  return values;
}

std::vector<std::uint32_t> read_indices(const GltfFile& file, int accessor, std::size_t end, const char* meaning) {
  std::vector<std::uint32_t> values = read_accessor<std::uint32_t>(file, accessor);
  const auto bad = std::find_if(values.begin(), values.end(), [&](std::uint32_t v) { return v >= end; });
  if (bad != values.end()) {
    fail_gltf(file.name, fmt::format("/accessors/{}", accessor),
              fmt::format("entry {} is {}: must be less than the {} {}", bad - values.begin(), *bad, end, meaning));
  }
  return values;
}

}  // namespace dualpixel::simulator
