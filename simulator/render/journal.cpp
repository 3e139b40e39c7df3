#include "simulator/render/journal.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <vector>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "capture/error.h"
#include "simulator/render/views.h"
#include "simulator/sampling/hash.h"

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

}  // namespace

Journal::Journal(const std::string& path, std::uint64_t key) : path_(path) {
  const Header ours{kMagic, key};
  Header header{};
  std::uint64_t good = 0;  // bytes that hold whole records
  if (std::filesystem::is_regular_file(path)) {
    file_.open(path, std::ios::in | std::ios::binary);
    if (file_.read(reinterpret_cast<char*>(&header), sizeof header) && header.magic == kMagic && header.key == key) {
      good = sizeof header;
      Record record;
      std::vector<float> pixels;
      while (file_.read(reinterpret_cast<char*>(&record), sizeof record)) {
        constexpr std::uint32_t kMostFloats = 6 * SampleMap::kTile * SampleMap::kTile;
        if (record.floats > kMostFloats) break;
        pixels.resize(record.floats);
        if (!file_.read(reinterpret_cast<char*>(pixels.data()), record.floats * sizeof(float))) break;
        if (checksum(record, pixels) != record.checksum) break;
        places_[{record.render, record.tile}] = good + sizeof record;
        good += sizeof record + record.floats * sizeof(float);
      }
    }
    file_.close();
    file_.clear();
  }
  const bool anew = good == 0;
  if (!anew) std::filesystem::resize_file(path, good);
  file_.open(path, std::ios::in | std::ios::out | std::ios::binary | (anew ? std::ios::trunc : std::ios::ate));
  if (anew) file_.write(reinterpret_cast<const char*>(&ours), sizeof ours);
  if (!file_) throw InputError(printable(path) + ": cannot be written");
}

bool Journal::restore(std::uint64_t render, const Tile& tile, Views& views) {
  const std::lock_guard lock(mutex_);
  const auto place = places_.find({render, tile.index});
  if (place == places_.end()) return false;
  file_.seekg(static_cast<std::streamoff>(place->second));
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
  std::uint64_t sum = hash_of(more);
  const auto add = [&](std::uint64_t value) { sum = hash(sum, value); };
  for (const Mesh& mesh : scene.meshes) {
    add(hash_of(mesh.positions));
    add(hash_of(mesh.triangles));
    add(hash_of(mesh.uv0));
    add(hash_of(mesh.uv1));
  }
  for (const Texture& texture : scene.textures) add(hash_of(texture.rgba));
  add(hash_of(scene.environment.radiance_nits));
  // of the lens what it does to rays
  float s[4][kPacket];
  for (int i = 0; i < kPacket; ++i) {
    for (int d = 0; d < 4; ++d) s[d][i] = unit_float(static_cast<std::uint32_t>(hash(i, d)));
  }
  const SensorGrid& sensor = camera.lens.sensor();
  for (int place = 0; place < 16; ++place) {
    LensPacket rays;
    camera.lens.sample(place % 4 * (sensor.width_px - 1) / 3, place / 4 * (sensor.height_px - 1) / 3, place % 3, s,
                       rays);
    add(XXH64(&rays, sizeof rays, 0));
  }
  return sum;
}

}  // namespace dualpixel::simulator
