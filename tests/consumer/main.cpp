#include <capture/capture.h>
#include <capture/json_fields.h>
#include <pipeline/portrait/run_portrait.h>
#include <pipeline/segmentation/faces.h>
#include <pipeline/segmentation/network.h>
#include <simulator/lens/disparity_field.h>
#include <simulator/scene_file.h>
#include <simulator/simulate.h>

#include <iostream>
#include <nlohmann/json.hpp>

/// What the camera of a scene file sees in the middle of the picture.
void describe_scene(const std::string& path) {
  const dualpixel::simulator::Simulation simulation =
      dualpixel::simulator::read_simulation(dualpixel::read_json_file(path), path);
  const dualpixel::simulator::Scene scene = dualpixel::simulator::load_scene(simulation);
  const dualpixel::simulator::CameraView camera = dualpixel::simulator::place_camera(simulation, scene);
  const dualpixel::simulator::SensorGrid& sensor = camera.lens.sensor();
  const dualpixel::simulator::DisparityField field(camera.lens);
  std::cout << scene.meshes.size() << " meshes, disparity of infinity "
            << field.at(0.5 * sensor.width_px, 0.5 * sensor.height_px).intercept_dp_px << " DP px\n";
}

// Calls into the libraries, so that linking proves them: consumer [SCENE.json | CAPTURE --portrait].
int main(int argc, char** argv) try {
  if (argc == 2) describe_scene(argv[1]);
  if (argc == 3) {
    const dualpixel::Capture capture = dualpixel::read_capture(argv[1], false);
    std::cout << dualpixel::pipeline::run_portrait(capture).stages.size() << " stages\n";
  }
  if (dualpixel::pipeline::has_person_network()) {
    std::cout << dualpixel::pipeline::find_faces(dualpixel::Image(64, 64, 3)).size() << " faces\n";
  }
  if (argc == 3 && dualpixel::pipeline::has_person_network()) dualpixel::pipeline::PersonNetwork();
} catch (const std::exception& error) {
  std::cerr << error.what() << '\n';
  return 2;
}
