#include "simulator/render/journal.h"

#include <gtest/gtest.h>

#include "capture/error.h"
#include "tests/capture/temporary_folder.h"
#include "tests/simulator/test_scenes.h"

namespace dualpixel::simulator::testing {
namespace {

constexpr int kWidth = 72, kHeight = 40;  // 5 x 3 tiles, the last of them cut
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
  options.journal = journal;
  return render_views(RenderScene(scene), phone_camera(0.8, kWidth, kHeight), options);
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
    Journal journal(path, 1);
    EXPECT_GE(journal.known(), last_known);
    constexpr double kRecord = 24 + 16 * 16 * 6 * 4;  // bytes of a whole tile
    EXPECT_LE(share * static_cast<double>(bytes.size()) - static_cast<double>(read_bytes(path).size()), kRecord);
    last_known = journal.known();
    const Views resumed = render(&journal);
    EXPECT_EQ(resumed.left.data, whole.left.data);
    EXPECT_EQ(resumed.right.data, whole.right.data);
    EXPECT_EQ(journal.known(), last_known);
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
  options.journal = &journal;
  EXPECT_EQ(render_views(RenderScene(dark), phone_camera(0.8, kWidth, kHeight), options).left.data, views.left.data);
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
  EXPECT_EQ(Journal(path, 2).known(), 0u);  // another scene's
  bytes[bytes.size() / 2] ^= 1;
  write_bytes(path, bytes);
  const std::size_t known = Journal(path, 1).known();
  EXPECT_GT(known, 4u);
  EXPECT_LT(known, 10u);
  write_bytes(path, "not a journal");
  EXPECT_EQ(Journal(path, 1).known(), 0u);
  EXPECT_THROW(Journal(folder / "none" + std::string("/journal"), 1), InputError);
}

TEST(Journal, FingerprintsTellScenesAndLensesApart) {
  const CameraView camera = phone_camera(0.8, kWidth, kHeight);
  const std::uint64_t here = fingerprint(wall(), camera, "");
  EXPECT_EQ(fingerprint(wall(), camera, ""), here);
  EXPECT_NE(fingerprint(wall(), camera, "more"), here);
  EXPECT_NE(fingerprint(wall(), phone_camera(0.81, kWidth, kHeight), ""), here);
  Scene other = wall();
  other.meshes[0].positions[2].x += 1e-3f;
  EXPECT_NE(fingerprint(other, camera, ""), here);
  other = wall();
  other.environment.radiance_nits[1].y = 901;
  EXPECT_NE(fingerprint(other, camera, ""), here);
}

}  // namespace
}  // namespace dualpixel::simulator::testing
