#include "simulator/journal.h"

#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "capture/error.h"
#include "simulator/sampling/hash.h"
#include "tests/simulator/test_scenes.h"
#include "tests/temporary_folder.h"

namespace dualpixel::simulator::testing {
namespace {

constexpr int kJournalWidth = 72, kJournalHeight = 40;  // 5 x 3 tiles, the last of them cut
constexpr std::size_t kTiles = 15;

Scene wall() {
  Scene scene;
  scene.materials = {diffuse(0.7f)};
  scene.meshes = {make_quad({-1, -1, 1.5f}, {2, 0, 0.5f}, {0, 2, 0}, 0)};
  scene.environment = {2, 1, {glm::vec3(100), glm::vec3(900)}};
  return scene;
}

Views render(Journal* journal, std::uint64_t seed = 5) {
  const Scene scene = wall();
  RenderOptions options{16, 0, seed};
  options.store = journal;
  return render_views(RenderScene(scene), phone_camera(0.8, kJournalWidth, kJournalHeight), options);
}

/// How many tiles of render() with seed 5 and 16 samples the journal at `path` knows.
std::size_t known(const std::string& path) {
  Journal journal(path, 1);
  Views views{Image(kJournalWidth, kJournalHeight, 3), Image(kJournalWidth, kJournalHeight, 3)};
  const SampleMap map = uniform_map(kJournalWidth, kJournalHeight, 16);
  std::size_t count = 0;
  for (int i = 0; i < map.columns() * map.rows(); ++i) count += journal.restore(hash(5, 16), tile_at(map, i), views);
  return count;
}

// A file that ends anywhere, as a killed program leaves it, loses what was not yet whole and nothing else.
TEST(Journal, GoesOnWhereItWasToTheSameBytes) {
  const TemporaryFolder folder;
  const std::string path = folder / "journal";
  const Views whole = render(nullptr);
  {
    Journal journal(path, 1);
    EXPECT_EQ(render(&journal).left.data, whole.left.data);
  }
  const std::string bytes = read_bytes(path);
  std::size_t last_known = 0;
  for (double share : {0.0, 0.1, 0.5, 0.9, 1.0}) {
    write_bytes(path, bytes.substr(0, static_cast<std::size_t>(share * static_cast<double>(bytes.size()))));
    EXPECT_GE(known(path), last_known);
    constexpr double kRecord = 24 + 16 * 16 * 6 * 4;  // bytes of a whole tile
    EXPECT_LE(share * static_cast<double>(bytes.size()) - static_cast<double>(read_bytes(path).size()), kRecord);
    last_known = known(path);
    Journal journal(path, 1);
    const Views resumed = render(&journal);
    EXPECT_EQ(resumed.left.data, whole.left.data);
    EXPECT_EQ(resumed.right.data, whole.right.data);
    EXPECT_EQ(read_bytes(path).size(), bytes.size());
  }
  EXPECT_EQ(last_known, kTiles);
}

// Tiles come from the file, not from rendering again: another scene of the same name would show.
TEST(Journal, DoesNotRenderWhatItKnows) {
  const TemporaryFolder folder;
  const std::string path = folder / "journal";
  {
    Journal journal(path, 1);
    render(&journal);
  }
  Journal journal(path, 1);
  const Views views = render(&journal);
  Scene dark = wall();
  dark.environment = {};
  RenderOptions options{16, 0, 5};
  options.store = &journal;
  EXPECT_EQ(render_views(RenderScene(dark), phone_camera(0.8, kJournalWidth, kJournalHeight), options).left.data,
            views.left.data);
  EXPECT_NE(render(&journal, 6).left.data, views.left.data);  // another render of the same capture
}

TEST(Journal, DropsWhatItCannotTrust) {
  const TemporaryFolder folder;
  const std::string path = folder / "journal";
  {
    Journal journal(path, 1);
    render(&journal);
  }
  std::string bytes = read_bytes(path);
  bytes[bytes.size() / 2] ^= 1;
  write_bytes(path, bytes);
  const std::size_t left = known(path);
  EXPECT_GT(left, 4u);
  EXPECT_LT(left, 10u);
}

// Cut or altered at any byte, a journal gives back whole tiles as they were, or is refused.
TEST(SlowJournal, CutOrAlteredAnywhereGivesNothingElse) {
  const TemporaryFolder folder;
  const std::string path = folder / "journal";
  const SampleMap map = uniform_map(20, 4, 1);
  const auto pixels = [](int tile) {
    Views views{Image(20, 4, 3), Image(20, 4, 3)};
    for (std::size_t i = 0; i < views.left.data.size(); ++i) {
      views.left.data[i] = static_cast<float>(i + 1 + 1000 * tile);
      views.right.data[i] = -views.left.data[i];
    }
    return views;
  };
  const int tiles = map.columns() * map.rows();
  ASSERT_EQ(tiles, 2);
  {
    Journal journal(path, 1);
    for (int tile = 0; tile < tiles; ++tile) journal.add(7, tile_at(map, tile), pixels(tile));
  }
  const std::string whole = read_bytes(path);
  // How many tiles come back, each as it was; -1: refused.
  const auto given_back = [&](const std::string& bytes) {
    write_bytes(path, bytes);
    try {
      Journal journal(path, 1);
      int count = 0;
      for (int i = 0; i < tiles; ++i) {
        const Tile tile = tile_at(map, i);
        const Views expected = pixels(i);
        Views views{Image(20, 4, 3), Image(20, 4, 3)};
        if (!journal.restore(7, tile, views)) continue;
        ++count;
        for (int y = tile.y0; y < tile.y1; ++y) {
          for (int x = 3 * tile.x0; x < 3 * tile.x1; ++x) {
            EXPECT_EQ(views.left.row(y)[x], expected.left.row(y)[x]);
            EXPECT_EQ(views.right.row(y)[x], expected.right.row(y)[x]);
          }
        }
      }
      return count;
    } catch (const InputError&) {
      return -1;
    }
  };
  constexpr std::size_t kHeader = 16;
  int before = 0;
  for (std::size_t length = 0; length <= whole.size(); ++length) {
    const int now = given_back(whole.substr(0, length));
    ASSERT_GE(now, before) << length;
    before = now;
  }
  EXPECT_EQ(before, tiles);
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string altered = whole;
    altered[at] ^= 0x10;
    const int now = given_back(altered);
    ASSERT_LT(now, tiles) << at;
    ASSERT_EQ(now == -1, at < kHeader) << at;
  }
}

TEST(Journal, RefusesAnothersAndLeavesItAsItIs) {
  const TemporaryFolder folder;
  const std::string path = folder / "journal";
  {
    Journal journal(path, 1);
    render(&journal);
  }
  const std::string bytes = read_bytes(path);
  const auto refusal = [&](std::uint64_t key) { return message_of<InputError>([&] { Journal(path, key); }); };
  EXPECT_NE(refusal(2).find(path + ": was begun with another scene"), std::string::npos) << refusal(2);
  EXPECT_EQ(read_bytes(path), bytes);
  for (const std::string foreign : {"mine", "not a journal, but some notes"}) {
    write_bytes(path, foreign);
    EXPECT_NE(refusal(1).find(path + ": is not a journal"), std::string::npos) << refusal(1);
    EXPECT_EQ(read_bytes(path), foreign);
  }
}

TEST(Journal, RefusesWhatCannotBeWritten) {
  const TemporaryFolder folder;
  EXPECT_THROW(Journal(folder / "none" + std::string("/journal"), 1), InputError);
  EXPECT_THROW(Journal(folder.path.string(), 1), InputError);
  EXPECT_THROW(Journal(folder / std::string(300, 'a'), 1), InputError);  // longer than a name may be
}

// Tile 14 is the cut one in the corner of this picture, and a whole one of a larger picture: not the same.
TEST(Journal, DoesNotTakeTilesOfAnotherSize) {
  const TemporaryFolder folder;
  {
    Journal journal(folder / "journal", 1);
    render(&journal);
  }
  Journal journal(folder / "journal", 1);
  Views views{Image(kJournalWidth + 8, kJournalHeight + 8, 3), Image(kJournalWidth + 8, kJournalHeight + 8, 3)};
  const SampleMap larger = uniform_map(kJournalWidth + 8, kJournalHeight + 8, 16);
  ASSERT_EQ(larger.samples.size(), kTiles);
  EXPECT_FALSE(journal.restore(hash(5, 16), tile_at(larger, kTiles - 1), views));
  EXPECT_TRUE(journal.restore(hash(5, 16), tile_at(larger, 0), views));
}

/// A scene with one of everything that a picture depends on.
Scene full_scene() {
  Scene scene = wall();
  Mesh& mesh = scene.meshes[0];
  mesh.normals.assign(4, {0, 0, -1});
  mesh.colors.assign(4, glm::vec4(1));
  mesh.uv1 = mesh.uv0;
  scene.textures = {Texture{1, 1, true, false, Wrap::repeat, Wrap::repeat, {1, 2, 3, 4}, {}}};
  scene.lights = {PunctualLight{}};
  return scene;
}

TEST(Journal, FingerprintsTellScenesAndLensesApart) {
  const CameraView camera = phone_camera(0.8, kJournalWidth, kJournalHeight);
  const std::uint64_t here = fingerprint(full_scene(), camera, "");
  EXPECT_EQ(fingerprint(full_scene(), camera, ""), here);
  EXPECT_NE(fingerprint(full_scene(), camera, "more"), here);
  EXPECT_NE(fingerprint(full_scene(), phone_camera(0.81, kJournalWidth, kJournalHeight), ""), here);
  CameraView elsewhere = camera;
  elsewhere.world_from_camera[3].x = 1e-6f;
  EXPECT_NE(fingerprint(full_scene(), elsewhere, ""), here);
  const std::vector<std::function<void(Scene&)>> changes = {
      [](Scene& s) { s.source_hash = "other"; },
      [](Scene& s) { s.meshes[0].positions[2].x += 1e-3f; },
      [](Scene& s) { s.meshes[0].normals[2].x = 1e-3f; },
      [](Scene& s) { s.meshes[0].uv0[1].x = 0.9f; },
      [](Scene& s) { s.meshes[0].uv1[1].x = 0.9f; },
      [](Scene& s) { s.meshes[0].colors[3].y = 0.9f; },
      [](Scene& s) { std::swap(s.meshes[0].triangles[0], s.meshes[0].triangles[1]); },
      [](Scene& s) { s.meshes[0].material = 1; },
      [](Scene& s) { s.meshes[0].placements.resize(1); },
      [](Scene& s) { s.meshes[0].placements.resize(2); },
      [](Scene& s) { s.textures[0].width = 2; },
      [](Scene& s) { s.textures[0].height = 2; },
      [](Scene& s) { s.textures[0].srgb = false; },
      [](Scene& s) { s.textures[0].nearest = true; },
      [](Scene& s) { s.textures[0].wrap_u = Wrap::clamp; },
      [](Scene& s) { s.textures[0].wrap_v = Wrap::mirror; },
      [](Scene& s) { s.textures[0].rgba[2] = 9; },
      [](Scene& s) { s.materials[0].base_color.y = 0.1f; },
      [](Scene& s) { s.materials[0].metallic = 0.1f; },
      [](Scene& s) { s.materials[0].roughness = 0.1f; },
      [](Scene& s) { s.materials[0].emission_nits.z = 0.1f; },
      [](Scene& s) { s.materials[0].normal_scale = 0.1f; },
      [](Scene& s) { s.materials[0].alpha_cutoff = 0.1f; },
      [](Scene& s) { s.materials[0].double_sided = true; },
      [](Scene& s) { s.materials[0].unlit = true; },
      [](Scene& s) { s.materials[0].base_color_texture.texture = 0; },
      [](Scene& s) { s.materials[0].metallic_roughness_texture.texture = 0; },
      [](Scene& s) { s.materials[0].emissive_texture.uv_set = 1; },
      [](Scene& s) { s.materials[0].normal_texture.uv_from_uv[2] = 0.5f; },
      [](Scene& s) { s.lights[0].kind = PunctualLight::Kind::spot; },
      [](Scene& s) { s.lights[0].intensity.x = 1; },
      [](Scene& s) { s.lights[0].position.x = 1; },
      [](Scene& s) {
        s.lights[0].direction = {0, -1, 0};
      },
      [](Scene& s) { s.lights[0].range_m = 1; },
      [](Scene& s) { s.lights[0].cos_inner_cone = 0.9f; },
      [](Scene& s) { s.lights[0].cos_outer_cone = 0.8f; },
      [](Scene& s) { s.lights.clear(); },
      [](Scene& s) { s.unlit_white_nits = 101; },
      [](Scene& s) { s.environment.radiance_nits[1].y = 901; },
      [](Scene& s) { std::swap(s.environment.width, s.environment.height); },
  };
  std::set<std::uint64_t> seen = {here};
  for (std::size_t i = 0; i < changes.size(); ++i) {
    Scene other = full_scene();
    changes[i](other);
    EXPECT_TRUE(seen.insert(fingerprint(other, camera, "")).second) << "change " << i;
  }
}

}  // namespace
}  // namespace dualpixel::simulator::testing
