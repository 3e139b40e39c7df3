#include <capture/capture.h>
#include <pipeline/portrait/run_portrait.h>
#include <simulator/scene/gltf/gltf.h>

#include <iostream>

// Counts what a capture or a glTF file holds: calls into the libraries, so that linking proves them.
int main(int argc, char** argv) try {
  if (argc == 3) std::cout << dualpixel::simulator::read_gltf(argv[2]).meshes.size() << " meshes\n";
  if (argc == 2) std::cout << dualpixel::read_capture(argv[1], false).frames.size() << " frames\n";
  std::cout << dualpixel::pipeline::PortraitResult().stages.size() << " stages\n";
  if (argc > 3) dualpixel::pipeline::run_portrait(dualpixel::Capture());
  if (dualpixel::pipeline::has_face_detector()) {
    std::cout << dualpixel::pipeline::find_faces(dualpixel::Image(64, 64, 3)).size() << " faces\n";
  }
  if (argc > 3 && dualpixel::pipeline::has_person_network()) dualpixel::pipeline::PersonNetwork();
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 2;
}
