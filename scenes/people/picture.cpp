#include "scenes/people/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/people/environment/environment.h"
#include "scenes/people/environment/foreground.h"
#include "scenes/people/environment/lighting.h"
#include "scenes/people/makehuman/makehuman_figure.h"
#include "scenes/people/photo/camera.h"
#include "scenes/people/procedural_figure.h"
#include "scenes/people/truth.h"

namespace dualpixel::scenes {
namespace {

struct Size {
  int width, height;
};

Size random_size(RandomStream& rng) {
  constexpr Size kSizes[] = {{192, 256}, {192, 256}, {192, 256}, {192, 256}, {205, 256},
                             {256, 192}, {256, 192}, {256, 256}, {256, 256}, {144, 256}};
  return kSizes[rng.below(10)];
}

/// Of a hundred pictures: how many are framed this close or closer, and how many show at most one or two people.
/// Training sets have more hard ones.
struct Shares {
  int close, portrait, half, one, two;
};
constexpr Shares kHeldOutShares = {22, 70, 90, 82, 95}, kTrainingShares = {18, 58, 84, 68, 88};

/// What is drawn of a picture before its people: size, framing, how many people, and the camera.
struct Framing {
  Size size;
  int people = 1;
  float aspect = 1;
  float height_m = 1;                   ///< what the picture's height covers at the people
  float distance = 1;                   ///< of the camera, meters
  float head_x = 0, head_y = 0;         ///< where the head is, as fractions of the picture
  float rise = 0, aside = 0, roll = 0;  ///< of the camera, radians
  float focus_error_m = 0, aperture_m = 0;
};

void draw_framing(Framing& framing, RandomStream& rng) {
  framing.size = random_size(rng);
  // height of the head over the picture's: close, portrait, half body, full body
  const Shares shares = rng.held_out() ? kHeldOutShares : kTrainingShares;
  const int closeness = rng.below(100);
  const float share = closeness < shares.close      ? rng.uniform(0.36f, 0.58f)
                      : closeness < shares.portrait ? rng.uniform(0.22f, 0.36f)
                      : closeness < shares.half     ? rng.uniform(0.14f, 0.22f)
                                                    : rng.uniform(0.09f, 0.13f);
  const int crowd = rng.below(100);
  framing.people = crowd < shares.one || share > 0.45f ? 1 : crowd < shares.two ? 2 : 3 + rng.below(kMostPeople - 2);
  framing.aspect = static_cast<float>(framing.size.width) / static_cast<float>(framing.size.height);
  framing.height_m = 0.235f / share;
  if (framing.people > 1)
    framing.height_m = std::max(framing.height_m, 0.5f * static_cast<float>(framing.people) / framing.aspect);
  framing.distance = std::max(framing.height_m * rng.uniform(0.85f, 2.6f), 0.42f);
  framing.head_x = framing.people > 1 ? rng.uniform(0.42f, 0.58f) : 0.5f + 0.1f * rng.normal();
  framing.head_y = std::clamp(0.16f + 0.8f * share + 0.07f * rng.normal(), 0.5f * share + 0.02f, 0.62f);
}

/// The camera is in front of the people, a little aside, at about the height of their eyes.
void draw_camera(Framing& framing, RandomStream& rng) {
  framing.rise = std::clamp(0.13f * rng.normal(), -0.35f, 0.45f), framing.aside = 0.06f * rng.normal();
  framing.roll = 0.035f * rng.normal(), framing.focus_error_m = 0.02f * rng.normal();
  // from a phone's pupil of 2 mm to a portrait lens's of 50 mm
  framing.aperture_m =
      rng.chance(0.55f) ? rng.uniform(0.001f, 0.004f) : rng.uniform(0.006f, 0.05f) * std::min(framing.distance, 1.0f);
}

CameraSetup camera_towards(vec3 head, const Framing& f) {
  CameraSetup camera;
  camera.eye = head + f.distance * vec3(std::sin(f.aside) * std::cos(f.rise), std::sin(f.rise),
                                        std::cos(f.aside) * std::cos(f.rise));
  camera.eye.y = std::max(camera.eye.y, 0.15f);
  camera.target = head + vec3((0.5f - f.head_x) * f.height_m * f.aspect, (f.head_y - 0.5f) * f.height_m, 0);
  camera.roll = f.roll;
  camera.height_m = f.height_m;
  camera.width_px = f.size.width;
  camera.height_px = f.size.height;
  camera.aperture_m = f.aperture_m;
  camera.focus_m = glm::distance(camera.eye, head) - 0.08f + f.focus_error_m;
  return camera;
}

/// Gives something that a person wears the colors of something behind: edges without contrast.
void match_background(SceneModel& scene, RandomStream& rng) {
  std::vector<int> worn, behind;
  for (const SceneObject& object : scene.objects) {
    const Material::Kind kind = scene.materials[static_cast<std::size_t>(object.material)].kind;
    if (object.person < 0) {
      behind.push_back(object.material);
    } else if (kind < Material::Kind::skin || kind == Material::Kind::hair) {
      worn.push_back(object.material);
    }
  }
  if (worn.empty() || behind.empty()) return;
  const Material& from = scene.materials[static_cast<std::size_t>(behind[rng.below(static_cast<int>(behind.size()))])];
  for (int i = 0; i < 2; ++i) {
    Material& to = scene.materials[static_cast<std::size_t>(worn[rng.below(static_cast<int>(worn.size()))])];
    to.a = from.a, to.b = from.b, to.c = from.c;
  }
}

bool is_makehuman(const RandomStream& rng, const MakeHumanAssets* makehuman) {
  return makehuman && rng.substream(99).chance(0.5f);
}

Figure add_any_figure(SceneModel& scene, const RandomStream& rng, const FigureOptions& options,
                      const MakeHumanAssets* makehuman) {
  return is_makehuman(rng, makehuman) ? add_makehuman_figure(scene, *makehuman, rng, options)
                                      : add_figure(scene, rng, options);
}

/// What the camera aims at: the head, or the middle of several.
vec3 middle_of(const std::vector<Figure>& figures) {
  if (figures.size() == 1) return figures[0].skeleton.head.origin;
  const auto [lowest, tallest] = std::minmax_element(figures.begin(), figures.end(), [](const auto& a, const auto& b) {
    return a.skeleton.head.origin.y < b.skeleton.head.origin.y;
  });
  return {0, 0.5f * (lowest->skeleton.head.origin.y + tallest->skeleton.head.origin.y), 0};
}

/// Turns a person anyhow, more often towards the camera than away from it.
void turn_anyhow(FigureOptions& options, RandomStream& rng) {
  constexpr float kSideways = 1.75f, kBack = 3.1415927f;
  const float turn = rng.chance(0.85f) ? rng.uniform(-kSideways, kSideways) : kBack + rng.uniform(-1.4f, 1.4f);
  options.head_yaw = 0.4f * rng.normal();
  options.yaw = turn - options.head_yaw;
}

/// Draws the people of a picture and adds them to the scene.
std::vector<Figure> add_people(SceneModel& scene, RandomStream rng, RandomStream& framing_rng, const Framing& framing,
                               const MakeHumanAssets* makehuman, bool faces) {
  const int people = framing.people;
  std::vector<FigureOptions> planned;
  std::vector<Figure> figures;  // their poses at first
  bool any_makehuman = false;
  const float spacing = framing_rng.uniform(0.4f, 0.62f);
  for (int i = 0; i < people; ++i) {
    FigureOptions& options = planned.emplace_back();
    options.meters_per_px = framing.height_m / static_cast<float>(framing.size.height);
    options.person = i;
    const float x = (static_cast<float>(i) - 0.5f * static_cast<float>(people - 1)) * spacing;
    options.position = vec3(x, 0, people > 1 ? 0.12f * framing_rng.normal() : 0);
    options.yaw = people > 1 ? -0.5f * x + 0.25f * framing_rng.normal() : 0.35f * framing_rng.normal();
    options.head_yaw = -0.75f * options.yaw + 0.16f * framing_rng.normal();
    if (faces) turn_anyhow(options, framing_rng);
    RandomStream gesture = rng.substream(10 + i);
    options.gesture = random_gesture(gesture);
    figures.push_back(pose_figure(rng.substream(20 + i), options));
    any_makehuman = any_makehuman || is_makehuman(rng.substream(20 + i), makehuman);
  }
  // what lies below the picture is not made; the height of MakeHuman's people is known only when they are complete
  constexpr float kPeopleReach_m = 0.6f, kBlur_m = 0.05f;
  const simulator::CameraView before = make_camera(camera_towards(middle_of(figures), framing));
  const float lowest_m = any_makehuman ? -1 : lowest_visible_m(before, kPeopleReach_m) - kBlur_m;
  for (int i = 0; i < people; ++i) {
    planned[i].lowest_m = lowest_m;
    figures[i] = add_any_figure(scene, rng.substream(20 + i), planned[i], makehuman);
  }
  return figures;
}

/// At times, people further back who are in no mask. `room_m`: how far behind the people a wall may be.
void add_bystanders(SceneModel& scene, RandomStream& rng, const Framing& framing, float room_m,
                    const MakeHumanAssets* makehuman) {
  constexpr float kNearest_m = 0.8f;
  if (!(rng.chance(0.25f) && room_m > kNearest_m)) return;
  const float distance = framing.distance, height_m = framing.height_m;
  const int bystanders = 1 + rng.below(3);
  for (int i = 0; i < bystanders; ++i) {
    FigureOptions other;
    const float behind = rng.uniform(kNearest_m, room_m);
    other.position = {rng.sign() * rng.uniform(0.15f, 0.45f) * (behind + distance) * height_m / distance, 0, -behind};
    other.yaw = 6.2831853f * rng.uniform();
    other.meters_per_px = height_m / static_cast<float>(framing.size.height) * (behind + distance) / distance;
    other.person = kBystander;
    other.gesture = random_gesture(rng);
    add_any_figure(scene, rng.substream(i), other, makehuman);
  }
}

/// The truth of all whose faces a detector would find, and that are a third of the largest or more (Wadhwa et al. 2018,
/// section 3.3).
std::vector<Subject> subjects_of(const RayTracer& tracer, const simulator::CameraView& camera,
                                 const std::vector<Figure>& figures, const Rendering& rendering) {
  std::vector<Subject> subjects;
  float largest = 0;
  for (const Figure& figure : figures) {
    PeopleSample truth = truth_of(tracer, camera, figure, rendering);
    if (!is_face_detectable(figure, camera, truth, rendering.coverage)) continue;
    truth.people = static_cast<int>(figures.size());
    largest = std::max(largest, truth.face.z * truth.face.w);
    subjects.push_back({std::move(truth), figure.person});
  }
  std::erase_if(subjects, [&](const Subject& s) { return s.truth.face.z * s.truth.face.w < largest / 3; });
  return subjects;
}

/// The truth of all whose face would be in the picture, also where it is hidden or turned away.
std::vector<Subject> all_subjects_of(const RayTracer& tracer, const simulator::CameraView& camera,
                                     const std::vector<Figure>& figures, const Rendering& rendering) {
  std::vector<Subject> subjects;
  for (const Figure& figure : figures) {
    PeopleSample truth = truth_of(tracer, camera, figure, rendering);
    const vec2 center = vec2(truth.face) + 0.5f * truth.face.z;
    const auto width = static_cast<float>(rendering.coverage.width),
               height = static_cast<float>(rendering.coverage.height);
    if (!(center.x >= 0 && center.x <= width && center.y >= 0 && center.y <= height)) continue;
    truth.people = static_cast<int>(figures.size());
    truth.tags.push_back(fmt::format("turn:{:.0f}", glm::degrees(turn_of(figure, camera))));
    constexpr float kAnySide = 1.75f;
    if (!is_face_detectable(figure, camera, truth, rendering.coverage, kAnySide))
      truth.tags.emplace_back("face:hidden");
    subjects.push_back({std::move(truth), figure.person});
  }
  return subjects;
}

/// The share of training pictures that are domain-randomized.
constexpr float kDomainRandomizedShare = 0.45f;

}  // namespace

PeoplePicture render_people(RandomStream rng, const MakeHumanAssets* makehuman, bool faces) {
  if (rng.substream(8).chance(kDomainRandomizedShare)) rng.set_domain_randomized();
  PeoplePicture picture;
  picture.domain_randomized = rng.domain_randomized();
  RandomStream framing_rng = rng.substream(1);
  Framing framing;
  draw_framing(framing, framing_rng);
  SceneModel scene;
  picture.tags.push_back(set_lighting(scene, rng.substream(2)));
  draw_camera(framing, framing_rng);
  const std::vector<Figure> figures = add_people(scene, rng, framing_rng, framing, makehuman, faces);
  const vec3 head = middle_of(figures);
  const CameraSetup setup = camera_towards(head, framing);

  const float back = framing_rng.chance(0.3f) ? framing_rng.uniform(0.8f, 1.6f) : framing_rng.uniform(1.5f, 6);
  picture.tags.push_back(add_environment(scene, rng.substream(3), back));
  RandomStream extras = rng.substream(4);
  if (extras.chance(0.15f)) match_background(scene, extras);
  // most environments have a wall at `back`; a bystander's face would be one without truth
  if (!faces) add_bystanders(scene, extras, framing, back - 0.4f, makehuman);
  if (extras.chance(0.12f)) {
    const float bottom = head.y - (1 - framing.head_y) * framing.height_m;
    add_foreground(scene, rng.substream(5), setup.eye, bottom + extras.uniform(0.05f, 0.3f) * framing.height_m);
    picture.tags.emplace_back("clutter");
  }

  const RayTracer tracer(scene);
  const simulator::CameraView camera = make_camera(setup);
  const Visibility visibility = visibility_of(tracer, camera);
  if (visibility.bystanders) picture.tags.emplace_back("bystanders");
  constexpr float kMostOccluded = 0.002f;  // soles may lie in a floor
  picture.can_cut_out = visibility.occluded < kMostOccluded;
  for (const Figure& figure : figures) {
    const bool seat_visible =
        figure.pose.sitting && project(camera, figure.skeleton.pelvis.origin).y < framing.size.height;
    picture.can_cut_out = picture.can_cut_out && !seat_visible;
  }
  RandomStream sampling = rng.substream(6);
  picture.rendering = render(tracer, camera, framing.people, sampling.seed());
  picture.subjects = faces ? all_subjects_of(tracer, camera, figures, picture.rendering)
                           : subjects_of(tracer, camera, figures, picture.rendering);
  return picture;
}

Image render_background(RandomStream rng) {
  SceneModel scene;
  set_lighting(scene, rng.substream(2));
  RandomStream own = rng.substream(1);
  add_environment(scene, rng.substream(3), own.uniform(0.5f, 5));
  CameraSetup camera;
  camera.eye = {own.uniform(-0.3f, 0.3f), own.uniform(1.0f, 1.8f), own.uniform(0.5f, 2.5f)};
  camera.target = {own.uniform(-0.3f, 0.3f), camera.eye.y + own.uniform(-0.5f, 0.3f), 0};
  camera.height_m = glm::distance(camera.eye, camera.target) * own.uniform(0.4f, 1.2f);
  camera.width_px = camera.height_px = kPictureSide_px;
  camera.focus_m = own.uniform(0.4f, 3);
  camera.aperture_m = own.chance(0.5f) ? own.uniform(0.001f, 0.004f) : own.uniform(0.006f, 0.05f);
  camera.roll = 0.04f * own.normal();
  const RayTracer tracer(scene);
  return render(tracer, make_camera(camera), 0, own.seed()).light;
}

}  // namespace dualpixel::scenes
