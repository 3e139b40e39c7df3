#include <cstdio>
#include <exception>
#include <string>

#include "scenes/make_scenes/portrait_scene.h"
#include "scenes/make_scenes/test_targets.h"

/// Writes the shipped scenes' glTF files into a folder: the same bytes every time.
int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: dualpixel_make_scenes FOLDER\n", stderr);
    return 2;
  }
  try {
    const std::string folder = argv[1];
    dualpixel::scenes::make_calibration_target(folder + "/calibration_target.glb");
    dualpixel::scenes::make_slanted_planes(folder + "/slanted_planes.glb");
    dualpixel::scenes::make_occlusion_edges(folder + "/occlusion_edges.glb");
    dualpixel::scenes::make_portrait(folder + "/portrait.glb");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "dualpixel_make_scenes: %s\n", error.what());
    return 1;
  }
}
