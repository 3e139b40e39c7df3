#include <cstdio>
#include <exception>
#include <string>

#include "scenes/make_scenes/portrait_scene.h"
#include "scenes/test_targets/test_targets.h"

/// Writes the shipped scenes' glTF files into a folder: the same bytes every time.
int main(int argc, char** argv) {
  if (argc != 2 || argv[1][0] == '-') {
    std::fputs("usage: dualpixel_make_scenes FOLDER\n", stderr);
    return 2;
  }
  try {
    const std::string folder = argv[1];
    const auto make = [&](const char* name, void (*add)(dualpixel::scenes::Glb&)) {
      dualpixel::scenes::Glb glb;
      add(glb);
      glb.write(folder + "/" + name + ".glb");
    };
    make("calibration_target", dualpixel::scenes::add_calibration_target);
    make("slanted_planes", dualpixel::scenes::add_slanted_planes);
    make("occlusion_edges", dualpixel::scenes::add_occlusion_edges);
    dualpixel::scenes::make_portrait(folder + "/portrait.glb");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "dualpixel_make_scenes: %s\n", error.what());
    return 1;
  }
}
