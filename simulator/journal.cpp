#include "simulator/journal.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <vector>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "capture/error.h"
#include "simulator/lens/lens_packet.h"
#include "simulator/render/camera_view.h"
#include "simulator/render/sample_map.h"
#include "simulator/render/views.h"
#include "simulator/sampling/hash.h"
#include "simulator/scene/scene.h"

namespace dualpixel::simulator {
namespace {

constexpr std::uint64_t kMagic = 0x316c6e726a7064ull;  // "dpjrnl1"

struct Header {
  std::uint64_t magic, key;
};

struct Record {
  std::uint64_t render;
  std::int32_t tile;
  std::uint32_t floats;    ///< that follow
  std::uint64_t checksum;  ///< of them and of what is above
};

std::uint64_t checksum(const Record& record, const std::vector<float>& pixels) {
  return hash(hash(record.render, record.tile, record.floats), XXH64(pixels.data(), pixels.size() * sizeof(float), 0));
}

/// Calls visit(first number of the left row, of the right row, how many) for each row of the tile.
template <typename Images, typename Visit>
void each_row(const Tile& tile, Images& views, const Visit& visit) {
  for (int y = tile.y0; y < tile.y1; ++y) {
    visit(&views.left.at(tile.x0, y), &views.right.at(tile.x0, y), 3 * (tile.x1 - tile.x0));
  }
}

template <typename Values>
std::uint64_t hash_of(const Values& values) {
  return XXH64(values.data(), values.size() * sizeof(*values.data()), 0);
}

/// The hash of one thing after another.
struct Sum {
  std::uint64_t value;

  /// The bytes of each; none may have padding.
  template <typename... Values>
  void add(const Values&... values) {
    ((value = hash(value, XXH64(&values, sizeof values, 0))), ...);
  }
  template <typename Values>
  void add_bytes(const Values& values) {
    value = hash(value, hash_of(values), values.size());
  }
};

void add_mesh(const Mesh& mesh, Sum& sum) {
  sum.add_bytes(mesh.positions);
  sum.add_bytes(mesh.normals);
  sum.add_bytes(mesh.uv0);
  sum.add_bytes(mesh.uv1);
  sum.add_bytes(mesh.colors);
  sum.add_bytes(mesh.triangles);
  if (mesh.is_hair()) sum.add_bytes(mesh.radii);
  sum.add(mesh.material);
  for (const Placement& placement : mesh.placements) sum.add(placement.world_from_mesh);
}

void add_material(const Material& m, Sum& sum) {
  sum.add(m.base_color, m.metallic, m.roughness, m.emission_nits, m.normal_scale, m.alpha_cutoff, m.double_sided,
          m.unlit);
  if (const std::optional<Layers>& y = m.layers) {
    sum.add(y->ior, y->specular, y->specular_color, y->clearcoat, y->clearcoat_roughness, y->sheen_color,
            y->sheen_roughness, y->transmission, y->solid, y->absorption_per_m);
  }
  for (const TextureSlot* slot :
       {&m.base_color_texture, &m.metallic_roughness_texture, &m.emissive_texture, &m.normal_texture}) {
    sum.add(slot->texture, slot->uv_set, slot->uv_from_uv);
  }
}

}  // namespace

Journal::Journal(const std::string& path, std::uint64_t key) : path_(path) {
  const Header ours{kMagic, key};
  Header header{};
  std::uint64_t good = 0;  // bytes that hold whole records
  std::error_code error;
  if (std::filesystem::is_regular_file(path, error)) {
    file_.open(path, std::ios::in | std::ios::binary);
    file_.read(reinterpret_cast<char*>(&header), sizeof header);
    const auto there = static_cast<std::size_t>(file_.gcount());
    if (std::memcmp(&header, &ours, std::min(there, sizeof kMagic)) != 0) {
      throw InputError(printable(path) +
                       ": is not a journal of a render: move it away, or choose another output folder");
    }
    if (std::memcmp(&header, &ours, there) != 0) {
      throw InputError(printable(path) +
                       ": was begun with another scene, other options or another version: remove it to begin anew");
    }
    if (file_) good = read_records();
    file_.close();
    file_.clear();
  }
  const bool anew = good == 0;
  error.clear();
  if (!anew) std::filesystem::resize_file(path, good, error);
  file_.open(path, std::ios::in | std::ios::out | std::ios::binary | (anew ? std::ios::trunc : std::ios::ate));
  if (anew) file_.write(reinterpret_cast<const char*>(&ours), sizeof ours);
  if (!file_ || error) throw InputError(printable(path) + ": cannot be written");
}

std::uint64_t Journal::read_records() {
  std::uint64_t good = sizeof(Header);
  Record record;
  std::vector<float> pixels;
  while (file_.read(reinterpret_cast<char*>(&record), sizeof record)) {
    constexpr std::uint32_t kMostFloats = 6 * SampleMap::kTile * SampleMap::kTile;
    if (record.floats > kMostFloats) break;
    pixels.resize(record.floats);
    if (!file_.read(reinterpret_cast<char*>(pixels.data()), record.floats * sizeof(float))) break;
    if (checksum(record, pixels) != record.checksum) break;
    records_[{record.render, record.tile}] = {good + sizeof record, record.floats};
    good += sizeof record + record.floats * sizeof(float);
  }
  return good;
}

bool Journal::restore(std::uint64_t render, const Tile& tile, Views& views) {
  const std::lock_guard lock(mutex_);
  const auto record = records_.find({render, tile.index});
  if (record == records_.end()) return false;
  // a render of another size has tiles of other sizes under the same numbers
  const auto floats = static_cast<std::uint32_t>(6 * (tile.x1 - tile.x0) * (tile.y1 - tile.y0));
  if (record->second.floats != floats) return false;
  file_.seekg(static_cast<std::streamoff>(record->second.offset));
  each_row(tile, views, [&](float* left, float* right, int count) {
    const auto bytes = static_cast<std::streamsize>(count * sizeof(float));
    file_.read(reinterpret_cast<char*>(left), bytes).read(reinterpret_cast<char*>(right), bytes);
  });
  if (!file_) throw InputError(printable(path_) + ": cannot be read any more");
  return true;
}

void Journal::add(std::uint64_t render, const Tile& tile, const Views& views) {
  std::vector<float> pixels;
  each_row(tile, views, [&](const float* left, const float* right, int count) {
    pixels.insert(pixels.end(), left, left + count);
    pixels.insert(pixels.end(), right, right + count);
  });
  Record record{render, tile.index, static_cast<std::uint32_t>(pixels.size()), 0};
  record.checksum = checksum(record, pixels);
  const std::lock_guard lock(mutex_);
  file_.seekp(0, std::ios::end);
  file_.write(reinterpret_cast<const char*>(&record), sizeof record);
  file_.write(reinterpret_cast<const char*>(pixels.data()),
              static_cast<std::streamsize>(pixels.size() * sizeof(float)));
  file_.flush();
  if (!file_) throw InputError(printable(path_) + ": cannot be written: is the disk full?");
}

std::uint64_t fingerprint(const Scene& scene, const CameraView& camera, const std::string& more) {
  Sum sum{hash_of(more)};
  sum.add_bytes(scene.source_hash);
  for (const Mesh& mesh : scene.meshes) add_mesh(mesh, sum);
  for (const Texture& t : scene.textures) {
    sum.add(t.width, t.height, t.srgb, t.nearest, t.wrap_u, t.wrap_v);
    sum.add_bytes(t.bytes());
  }
  for (const Material& material : scene.materials) add_material(material, sum);
  for (const PunctualLight& l : scene.lights) {
    sum.add(l.kind, l.intensity, l.position, l.direction, l.range_m, l.cos_inner_cone, l.cos_outer_cone);
  }
  sum.add(scene.environment.width, scene.environment.height, scene.unlit_white_nits);
  sum.add_bytes(scene.environment.radiance_nits);
  sum.add(camera.world_from_camera);
  // of the lens what it does to rays
  float s[4][kPacket];
  for (int i = 0; i < kPacket; ++i) {
    for (int d = 0; d < 4; ++d) s[d][i] = unit_float(static_cast<std::uint32_t>(hash(i, d)));
  }
  const SensorGrid& sensor = camera.lens.sensor();
  for (int point = 0; point < 16; ++point) {
    LensPacket rays;
    camera.lens.sample(point % 4 * (sensor.width_px - 1) / 3, point / 4 * (sensor.height_px - 1) / 3, point % 3, s,
                       rays);
    sum.add(rays);
  }
  return sum.value;
}

}  // namespace dualpixel::simulator
