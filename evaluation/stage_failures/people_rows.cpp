#include <algorithm>
#include <cmath>
#include <random>

#include "capture/image/display.h"
#include "capture/image/resample.h"
#include "evaluation/metrics/mask_metrics.h"
#include "evaluation/stage_failures/stage_row.h"
#include "pipeline/segmentation/network.h"
#include "pipeline/segmentation/person_mask.h"
#include "scenes/people/environment/environment.h"
#include "scenes/people/environment/lighting.h"
#include "scenes/people/photo/camera.h"
#include "scenes/people/photo/process_photo.h"
#include "scenes/people/photo/render.h"
#include "scenes/people/procedural_figure.h"
#include "simulator/sampling/hash.h"

namespace dualpixel::evaluation {
namespace {

constexpr float kMeanLight = 0.2f;

/// How people are photographed. Of one person head and shoulders are seen.
struct Posing {
  int width_px = 384, height_px = 512;
  float height_m = 0.9f;  ///< what the picture's height covers at the people
  float turn_rad = 0;     ///< away from the camera
  int people = 1;         ///< side by side
};

struct PeopleShot {
  Image light;   ///< linear RGB
  Image people;  ///< true mask
};

/// People that no training set draws.
PeopleShot photograph_people(const Posing& posing, unsigned draw) {
  constexpr float kApart_m = 0.5f, kDistance_m = 2.2f;
  const scenes::RandomStream random(draw + 1, true);
  scenes::SceneModel scene;
  scenes::set_lighting(scene, random.substream(1));
  scenes::CameraSetup plan;
  plan.height_m = posing.height_m, plan.width_px = posing.width_px, plan.height_px = posing.height_px;
  for (int i = 0; i < posing.people; ++i) {
    scenes::FigureOptions options;
    options.position.x = kApart_m * (static_cast<float>(i) - 0.5f * static_cast<float>(posing.people - 1));
    options.yaw = posing.turn_rad;
    options.meters_per_px = posing.height_m / static_cast<float>(posing.height_px);
    options.person = i;
    const scenes::Figure figure = add_figure(scene, random.substream(10 + i), options);
    plan.target.y = i == 0 ? figure.skeleton.head.origin.y : std::max(plan.target.y, figure.skeleton.head.origin.y);
  }
  add_environment(scene, random.substream(2), 3);
  plan.eye = plan.target + glm::vec3(0, 0, kDistance_m * posing.height_m / 0.9f);
  plan.target.y -= 0.12f * posing.height_m;
  plan.focus_m = glm::distance(plan.eye, plan.target);
  const scenes::RayTracer tracer(scene);
  const scenes::Rendering rendering = render(tracer, make_camera(plan), posing.people, draw + 1);
  PeopleShot shot{rendering.light, Image(rendering.light.width, rendering.light.height)};
  for (std::size_t i = 0; i < shot.people.data.size(); ++i) {
    const float* covered = &rendering.coverage.data[i * rendering.coverage.channels];
    for (int person = 0; person < posing.people; ++person) shot.people.data[i] += covered[person];
  }
  scenes::set_mean_luminance(shot.light, {}, kMeanLight);
  return shot;
}

/// Finds faces, then people, as `portrait` does; the picture shows in color what it found.
StageOutcome overlap(const PeopleShot& shot) {
  static pipeline::PersonNetwork network;
  const pipeline::FoundPeople found = pipeline::find_people(shot.light, {}, network);
  const Image mask = found.faces.empty() ? Image(shot.people.width, shot.people.height)
                                         : resize_bilinear(found.mask, shot.people.width, shot.people.height);
  Image picture = encode_for_display(shot.light);
  for (std::size_t i = 0; i < mask.data.size(); ++i) {
    float* color = &picture.data[3 * i];
    const float gray = (color[0] + color[1] + color[2]) / 3, kept = mask.data[i];
    for (int c = 0; c < 3; ++c) color[c] = kept * color[c] + (1 - kept) * 0.5f * gray;
  }
  return {mask_iou(mask, shot.people), picture};
}

/// A board in front on the picture's left, which hides that share of the person.
PeopleShot behind_board(PeopleShot shot, double share) {
  double all = 0, hidden = 0;
  for (const float value : shot.people.data) all += value;
  for (int x = 0; x < shot.people.width && hidden < share * all; ++x) {
    for (int y = 0; y < shot.people.height; ++y) {
      hidden += shot.people.at(x, y);
      shot.people.at(x, y) = 0;
      for (int c = 0; c < 3; ++c) shot.light.at(x, y, c) = kMeanLight * (x % 48 < 2 ? 0.5f : 1.0f);
    }
  }
  return shot;
}

/// Noise of photons: of a pixel as bright as the mean, `share` of it.
PeopleShot with_photon_noise(PeopleShot shot, double share, unsigned draw) {
  std::mt19937_64 random(simulator::hash(draw));
  std::normal_distribution<float> normal;
  const auto deviation = static_cast<float>(share);
  for (float& value : shot.light.data) {
    value = std::max(value + deviation * std::sqrt(kMeanLight * std::max(value, 0.0f)) * normal(random), 0.0f);
  }
  return shot;
}

PeopleShot darkened(PeopleShot shot, double stops) {
  for (float& value : shot.light.data) value *= static_cast<float>(std::exp2(-stops));
  return shot;
}

/// A person whose face covers that share of the picture.
PeopleShot with_small_face(double percent, unsigned draw) {
  constexpr double kFace_m = 0.15;
  Posing posing;
  const double area_m2 = kFace_m * kFace_m / (percent / 100);
  posing.height_m = static_cast<float>(std::sqrt(area_m2 * posing.height_px / posing.width_px));
  return photograph_people(posing, draw);
}

PeopleShot side_by_side(int people, unsigned draw) {
  Posing posing;
  posing.people = people;
  if (people > 1) {
    std::swap(posing.width_px, posing.height_px);
    posing.height_m = std::max(posing.height_m, 0.4f * static_cast<float>(people));
  }
  return photograph_people(posing, draw);
}

PeopleShot turned_away(double degrees, unsigned draw) {
  Posing posing;
  posing.turn_rad = static_cast<float>(glm::radians(degrees));
  return photograph_people(posing, draw);
}

StageRow people_row(StageRow row, PeopleShot (*shot)(double value, unsigned draw)) {
  row.stage = "people";
  row.figure = "intersection over union with the true mask";
  row.limit = 0.75;
  row.falls = true;
  row.reason = "A quarter of what is either the person or taken for it is wrong.";
  row.make = [shot](double value, unsigned draw) { return overlap(shot(value, draw)); };
  return row;
}

}  // namespace

std::vector<StageRow> people_rows() {
  if (!pipeline::has_person_network()) return {};
  const auto row = [](const std::string& name, const std::string& title, const std::string& sweep,
                      const std::string& key, const std::vector<double>& values, const std::string& note,
                      PeopleShot (*shot)(double, unsigned)) {
    StageRow all;
    all.name = name, all.title = title, all.sweep = sweep, all.key = key, all.values = values, all.note = note;
    return people_row(all, shot);
  };
  return {
      row("turned", "Turned away", "turn of the person, degrees", "turn_deg", {0, 30, 60, 75, 90, 135, 180},
          "From 90 degrees on there is less and less of a face to begin from; at 180 it is the back view.",
          turned_away),
      row("covered", "Partly covered", "share of the person behind a board", "share", {0, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8},
          "From the picture's left; half of the face is hidden at about .5.",
          [](double share, unsigned draw) { return behind_board(photograph_people({}, draw), share); }),
      row("several", "Several people", "people side by side", "people", {1, 2, 3, 4, 5},
          "The more there are, the smaller are their faces in the picture.",
          [](double people, unsigned draw) { return side_by_side(static_cast<int>(people), draw); }),
      row("small", "Small in the picture", "area of the face, % of the picture", "percent", {8, 4, 2, 1.2, 0.8, 0.4},
          "Faces under .93 % of the picture are taken for bystanders' (`seed_faces.least_of_picture`).",
          with_small_face),
      row("dark", "Dark", "stops under the exposure that metering gives", "stops", {0, 2, 3, 4, 5, 6, 8},
          "Without noise.", [](double stops, unsigned draw) { return darkened(photograph_people({}, draw), stops); }),
      row("noisy", "Noisy", "noise of a pixel over its signal, at the picture's mean", "noise",
          {0, 0.2, 0.4, 0.8, 1.6, 3.2}, "Photons alone, at 384 x 512 pixels.",
          [](double noise, unsigned draw) { return with_photon_noise(photograph_people({}, draw), noise, draw); }),
  };
}

}  // namespace dualpixel::evaluation
