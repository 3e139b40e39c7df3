#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/json_fields.h"
#include "simulator/lens/lens.h"
#include "simulator/render/render_options.h"
#include "simulator/scene/environment.h"
#include "simulator/sensor/sensor.h"

/// The JSON file that places a camera in a scene: what to simulate, before anything is.
namespace dualpixel::simulator {

/// A camera of the scene file's own, for glTF files without one; replaces the node.
struct CameraPose {
  glm::dvec3 position_m{0};
  glm::dvec3 look_at_m{0};
  glm::dvec3 up{0, 1, 0};

  bool operator==(const CameraPose&) const = default;
};

/// What a scene JSON file says (docs/scene.md), every field checked. Units are in the names.
struct Simulation {
  std::string path;         ///< of this file
  std::string gltf_path;    ///< resolved against the JSON file's folder
  std::string camera_node;  ///< empty: the glTF file's first camera
  std::optional<CameraPose> pose;
  Lens lens;  ///< focused
  SensorOptions sensor;
  ExposureOptions exposure;
  int burst_frames = 9;
  double hand_shake = 0;  ///< scale of hand_shake()'s amplitudes; 0: the camera does not move
  std::uint64_t hand_shake_seed = 1;
  double frame_interval_s = 0.04;  ///< from one frame's exposure to the next; at least the exposure time
  int exposure_poses = 1;          ///< poses over each exposure that the frame is the mean of
  bool animation = false;          ///< glTF's animations play: frame i shows the scene at i * frame_interval_s
  EnvironmentModel environment_model = EnvironmentModel::none;
  std::array<double, 3> environment_nits{};
  SkyOptions sky;
  std::string environment_path;
  double environment_nits_per_unit = 1;
  double unlit_white_nits = 100;
  std::optional<double> model_size_m;  ///< longest side of the scene's box, scaled; empty: as the glTF file has it
  std::optional<std::array<double, 4>> face_px;
  double photograph_aperture_scale = 5;
  std::optional<Lens> photograph;  ///< focused; empty: the photograph looks through the ideal lens
  RenderOptions render;
  LightCacheOptions light;  ///< in the file's "render", as the other fields
  /// Set: every picture gets as many samples, tile by tile, as keep its error's RMS at this share of the sensor's
  /// noise; instead of the numbers of samples.
  std::optional<double> noise_fraction;
  std::optional<double> render_error;  ///< likewise, at this share of the signal 1.0
  /// Set: likewise, in the two views as many as this machine can draw in about this time, for the error to be the same
  /// share of the sensor's noise everywhere. How many depends on the machine: provenance names the share that was
  /// reached. Truth's pictures keep their numbers of samples.
  std::optional<double> time_budget_s;
  std::optional<int> photograph_samples_per_pixel;        ///< empty: render.samples_per_pixel
  std::optional<int> all_in_focus_samples_per_pixel;      ///< likewise
  bool with_all_in_focus = true, with_photograph = true;  ///< no fields of the file: whether truth gets these pictures
  nlohmann::json json;                                    ///< the document as it was read, overrides applied
  std::vector<std::string> warnings;  ///< a line for each thing in it that can be, but is seldom meant
};

/// Whether all numbers lie in their ranges and the fields agree with each other.
std::optional<OptionProblem> check(const Simulation& simulation);

/// The object `sensor` of a scene or camera file. Throws InputError.
SensorOptions read_sensor(Fields sensor);

/// Reads a scene JSON document that came from `path`, after overrides ("camera.focus_distance_m=0.9") were applied to
/// it. Throws InputError for unknown fields, values out of range, focus inside the focal length, and pictures that
/// would not fit into this machine's memory.
Simulation read_simulation(const nlohmann::json& json, const std::string& path);

/// A lens, and the sensor behind it where the file has one.
struct LensOfFile {
  Lens lens;  ///< focused
  std::optional<SensorOptions> sensor;
  std::string pointer;  ///< of the lens in the file
};

/// The lens that a lens, camera or scene file is or has; `json` came from `path`. Focused on `focus_distance_m`, or
/// where that is empty as the scene says, else on 1 m. Throws InputError.
LensOfFile read_lens_of(nlohmann::json json, const std::string& path, std::optional<double> focus_distance_m);

/// The frames of the burst differ in more than noise.
bool moves(const Simulation& simulation);

/// How many poses each frame is the mean of.
int poses_of(const Simulation& simulation);

/// Throws InputError where the pictures and scenes of `scene_bytes` would not fit into this machine's memory together.
void check_memory(const Simulation& simulation, double scene_bytes);

}  // namespace dualpixel::simulator
