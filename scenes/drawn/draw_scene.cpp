#include "scenes/drawn/draw_scene.h"

#include <algorithm>
#include <cmath>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "scenes/drawn/face_box.h"
#include "scenes/drawn/meter.h"
#include "scenes/drawn/phone_lenses.h"
#include "simulator/lens/lens_file.h"
#include "simulator/scene_file.h"

namespace dualpixel::scenes {
namespace {

using nlohmann::json;
using Type = Parameter::Type;

/// Sensor and lens. Photosites of any size have the default's sensitivity per area, so that exposures stay.
void set_camera(json& scene, const Parameters& p) {
  constexpr double kPitch_um = 1.4;
  const int width = p.integer("width_px");
  const double pitch_um = 1e3 * p.number("sensor_width_mm") / width;
  const double area = pitch_um * pitch_um / (kPitch_um * kPitch_um);
  scene["sensor"] = {{"width_px", width},
                     {"height_px", width / 4 * 3},
                     {"pixel_pitch_um", pitch_um},
                     {"full_well_e", 6000 * area},
                     {"electrons_per_lux_s", {3600 * area, 4000 * area, 3200 * area}},
                     {"prnu", 0.005}};
  scene["lens"] = phone_lens(p.choice("lens"));
}

bool is_field(const std::string& assignment) {
  return assignment.substr(0, assignment.find('=')).find('.') != std::string::npos;
}

Parameters parameters_for(const SceneKind& kind, const SceneOrder& order) {
  std::vector<std::string> own;
  std::copy_if(order.assignments.begin(), order.assignments.end(), std::back_inserter(own), std::not_fn(is_field));
  return draw_parameters(kind.name, parameters_of(kind), own, order.seed);
}

void set_start(json& scene, const Parameters& parameters, std::uint64_t seed) {
  set_camera(scene, parameters);
  RandomStream shake = RandomStream(seed, false).substream(1);
  scene["burst"] = {{"frames", 9}, {"hand_shake", 1}, {"hand_shake_seed", shake.seed()}};
  scene["render"] = {{"samples_per_pixel", 64},
                     {"photograph_samples_per_pixel", 256},
                     {"all_in_focus_samples_per_pixel", 32},
                     {"max_bounces", 0},
                     {"seed", seed}};
}

void set_fields(json& scene, const SceneOrder& order) {
  std::vector<std::string> fields;
  std::copy_if(order.assignments.begin(), order.assignments.end(), std::back_inserter(fields), is_field);
  simulator::apply_overrides(scene, fields);
}

/// The scene file as `simulate` reads it. Faults are told of the kind, not of the file, which may not be where it will
/// stay.
simulator::Simulation read_drawn(const json& scene, const std::string& path, const SceneKind& kind) {
  try {
    return simulator::read_simulation(scene, path);
  } catch (const InputError& error) {
    const std::string what = error.what(), file = printable(path);
    throw InputError(what.starts_with(file) ? kind.name + what.substr(file.size()) : what);
  }
}

/// Of the lens and sensor as they were set. None for a camera that the scene's own fields move.
void set_face(SceneBuilder& builder, const simulator::Simulation& simulation) {
  if (builder.face.empty() || simulation.pose || simulation.face_px) return;
  const json box = face_box(builder.face, builder.eye, builder.forward, simulation);
  if (!box.is_null()) builder.scene["face_px"] = box;
}

}  // namespace

std::vector<Parameter> parameters_of(const SceneKind& kind) {
  std::vector<Parameter> all = {
      {"width_px", "photosites", Type::multiple_of_16, 128, 8192, 2688, 2688,
       "of the picture, whose height is 3/4 of it; the view stays the same"},
      {"sensor_width_mm", "mm", Type::number, 1, 5.64, 3.7632, 3.7632,
       "3.76: the 1.5 times enlarged middle that portrait modes use; 5.64: all that phone lenses draw"},
      {"lens",
       "",
       Type::number,
       0,
       0,
       0,
       0,
       "a phone lens of lens_models/",
       {std::begin(kPhoneLenses), std::end(kPhoneLenses)},
       "phone_6p"},
      {"stops", "EV", Type::number, -6, 3, 0, 0, "exposure beside what the meter says"}};
  all.insert(all.end(), kind.parameters.begin(), kind.parameters.end());
  return all;
}

std::string fixed_model_of(const SceneKind& kind, const SceneOrder& order) {
  const char* const parameter = kind.fixed_models.parameter;
  const auto& values = kind.fixed_models.values;
  if (parameter == nullptr) return "";
  // that parameter alone: there may be a million seeds
  std::vector<std::string> own;
  for (const std::string& assignment : order.assignments) {
    if (assignment.starts_with(std::string(parameter) + "=")) own.push_back(assignment);
  }
  const auto row = std::find_if(kind.parameters.begin(), kind.parameters.end(),
                                [&](const Parameter& p) { return p.name == std::string_view(parameter); });
  const std::string value = draw_parameters(kind.name, {&*row, 1}, own, order.seed).choice(parameter);
  return std::find(values.begin(), values.end(), value) != values.end() ? value : "";
}

std::vector<std::string> draw_scene(const SceneKind& kind, const SceneOrder& order, const std::string& folder) {
  const Parameters parameters = parameters_for(kind, order);
  const std::string path = folder + "/scene.json";
  read_drawn(scene_file_start(kind, order), path, kind);  // wrong fields are refused before anything is drawn
  std::vector<std::string> faults;
  for (int i = 0; i < kArrangements; ++i) {
    SceneBuilder builder;
    set_start(builder.scene, parameters, order.seed);
    kind.build(builder, parameters, RandomStream(order.seed, false).substream(2 + static_cast<std::uint64_t>(i)));
    builder.glb.write(folder + "/scene.glb");
    faults = meter(builder.scene, path, builder.shooting, order.seed, parameters.number("stops"));
    if (!faults.empty() && i + 1 < kArrangements) continue;
    set_fields(builder.scene, order);
    set_face(builder, read_drawn(builder.scene, path, kind));
    write_file(path, builder.scene.dump(2) + "\n");
    break;
  }
  return faults;
}

json scene_file_start(const SceneKind& kind, const SceneOrder& order) {
  SceneBuilder builder;
  const Parameters parameters = parameters_for(kind, order);
  set_start(builder.scene, parameters, order.seed);
  const simulator::EnvironmentModel model = kind.environment(parameters);
  if (model == simulator::EnvironmentModel::constant) builder.ambient(glm::vec3(1));  // some light, not yet known
  if (model == simulator::EnvironmentModel::sky) builder.scene["environment"] = {{"model", "sky"}};
  set_fields(builder.scene, order);
  return builder.scene;
}

SceneOrder read_scene_order(const std::string& path) {
  const json document = read_json_file(path);
  Fields fields(document, path);
  SceneOrder order;
  std::string title;
  if (fields.has("gltf")) fields.fail("gltf", "is of a scene that is drawn already: `dualpixel simulate` takes it");
  fields.required("kind").text("kind", order.kind);
  fields.text("title", title);
  fields.integer("seed", order.seed, 0, ~std::uint64_t{0});
  const json set = fields.raw("set");
  fields.done();
  if (!set.is_null() && !set.is_object()) fields.fail("set", "must be an object of names and values");
  order.assignments = assignments_of(set);
  return order;
}

std::vector<std::string> assignments_of(const json& set) {
  std::vector<std::string> assignments;
  for (const auto& [name, value] : set.items()) {
    assignments.push_back(name + "=" + (value.is_string() ? value.get<std::string>() : value.dump()));
  }
  return assignments;
}

}  // namespace dualpixel::scenes
