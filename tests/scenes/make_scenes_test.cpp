// The shipped scenes are made by code: the same bytes as the built ones, and each with a scene file that names it.
#include <gtest/gtest.h>

#include <cstdlib>

#include "capture/json_fields.h"
#include "simulator/simulate.h"
#include "tests/temporary_folder.h"

namespace dualpixel {
namespace {

TEST(SlowScenes, AreTheSameBytesEveryTime) {
  const TemporaryFolder again;
  ASSERT_EQ(std::system(("'" DUALPIXEL_MAKE_SCENES "' '" + again.path.string() + "'").c_str()), 0);
  EXPECT_EQ(again.names().size(), 4u);
  for (const std::string& name : again.names()) {
    EXPECT_TRUE(read_bytes(again / name) == read_bytes(DUALPIXEL_SCENES_DIR "/" + name)) << name;
  }
}

TEST(Scenes, EveryShippedFileIsAValidScene) {
  for (const std::string name : {"portrait", "calibration_target", "slanted_planes", "occlusion_edges"}) {
    const std::string path = DUALPIXEL_SCENES_DIR "/" + name + ".json";
    const simulator::Simulation simulation = simulator::read_simulation(read_json_file(path), path);
    EXPECT_EQ(simulation.gltf_path, DUALPIXEL_SCENES_DIR "/" + name + ".glb");
  }
}

}  // namespace
}  // namespace dualpixel
