#include "scenes/people/people.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>

#include "scenes/people/makehuman/makehuman.h"
#include "scenes/people/photo/develop.h"
#include "scenes/people/places/surroundings.h"

namespace dualpixel::scenes {
namespace {

/// Faces are seeded where a detector would find them: turned less than this from the camera ...
const float kMostTurned = std::cos(1.15f);
/// ... and larger than a third of the largest face (Wadhwa et al. 2018, section 3.3) and than this.
constexpr float kSmallestFace_px = 9;

struct Size {
  int width, height;
};

Size any_size(RandomStream& rng) {
  constexpr Size kSizes[] = {{192, 256}, {192, 256}, {192, 256}, {192, 256}, {205, 256},
                             {256, 192}, {256, 192}, {256, 256}, {256, 256}, {144, 256}};
  return kSizes[rng.below(10)];
}

/// Of a hundred pictures: how many are framed so close or closer, and how many show at most one or two people. Training
/// sets have more of what is hard.
struct Shares {
  int close, portrait, half, one, two;
};
constexpr Shares kHeldOutShares = {22, 70, 90, 82, 95}, kTrainingShares = {18, 58, 84, 68, 88};

/// One of the people in a picture.
struct Sitter {
  PeopleSample truth;  ///< without picture and mask, in the photograph's own pixels
  int person = 0;      ///< channel of the exposure's coverage
};

/// What a rendered picture still is before it is developed.
struct Sitting {
  Rendering exposure;
  std::vector<Sitter> sitters;
  bool clear = true;  ///< nothing stands before the people, and no seat is left without its sitter: they can be cut out
  bool strange = false;  ///< RandomStream::strange
  std::vector<std::string> tags;
};

/// Whether the first thing on the way to a joint is that person, and about where the joint is.
bool sees(const RayTracer& tracer, vec3 eye, vec3 joint, int person, float within_m) {
  const vec3 d = joint - eye;
  const float distance = glm::length(d);
  const auto hit = tracer.intersector().intersect({eye, d / distance});
  return hit && tracer.scene().objects[hit->mesh].person == person && hit->t > distance - within_m;
}

/// How far before a joint the surface of its own part of the body lies, clothes and all: what is met nearer to the
/// camera is something else, be it of the same person.
float joint_depth_m(const Figure& figure, int keypoint) {
  // on the skin but for the shapes of noses and lids, and glasses; ears are met at a slant
  if (keypoint < 5) return 0.025f * figure.body.head_scale;
  // shoulder, elbow, wrist, hip, knee, ankle: the radii of figure.cpp's cones
  constexpr float kRadius[] = {0.0315f, 0.0235f, 0.016f, 0.072f, 0.034f, 0.022f};
  const float radius = kRadius[(keypoint - 5) / 2] * figure.body.stature_m * (1 + 0.25f * figure.body.girth);
  constexpr float kSlant = 1.4f;  // limbs up to 45 degrees from across the line of sight
  return kSlant * (radius + (keypoint < 11 ? figure.top_cloth_m : figure.legs_cloth_m));
}

/// Whether a detector would find this face.
bool is_frontal_and_seen(const Figure& figure, const simulator::CameraView& camera, const PeopleSample& sample,
                         const Image& coverage) {
  const vec3 eye(camera.world_from_camera[3]);
  const vec3 to_eye = glm::normalize(eye - figure.skeleton.head.origin);
  if (glm::dot(to_eye, figure.skeleton.head.axes[2]) < kMostTurned) return false;
  if (sample.face.z < kSmallestFace_px) return false;
  // nothing before it: an umbrella, a hand or a phone of their own is in the mask, too
  if (sample.keypoints[0].z != 2 || (sample.keypoints[1].z != 2 && sample.keypoints[2].z != 2)) return false;
  const int x0 = static_cast<int>(sample.face.x), y0 = static_cast<int>(sample.face.y),
            side = static_cast<int>(sample.face.z);
  float shown = 0;
  for (int y = std::max(y0, 0); y < std::min(y0 + side, coverage.height); ++y) {
    for (int x = std::max(x0, 0); x < std::min(x0 + side, coverage.width); ++x)
      shown += coverage.at(x, y, figure.person);
  }
  return shown > 0.6f * static_cast<float>(side * side);
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

/// What the camera aims at: the head, or of several the middle.
vec3 middle_of(const std::vector<Figure>& figures) {
  if (figures.size() == 1) return figures[0].skeleton.head.origin;
  const auto [lowest, tallest] = std::minmax_element(figures.begin(), figures.end(), [](const auto& a, const auto& b) {
    return a.skeleton.head.origin.y < b.skeleton.head.origin.y;
  });
  return {0, 0.5f * (lowest->skeleton.head.origin.y + tallest->skeleton.head.origin.y), 0};
}

/// The share of training pictures in which most is of no particular kind.
constexpr float kDomainRandomizedShare = 0.45f;

Sitting take_sitting(RandomStream rng, const MakeHumanAssets* makehuman) {
  if (rng.substream(8).chance(kDomainRandomizedShare)) rng.set_domain_randomized();
  Sitting sitting;
  sitting.strange = rng.domain_randomized();
  RandomStream plan = rng.substream(1);
  const Size size = any_size(plan);
  // head's share of the picture's height: close, portrait, half body, full body
  const Shares shares = plan.held_out() ? kHeldOutShares : kTrainingShares;
  const int framing = plan.below(100);
  const float share = framing < shares.close      ? plan.uniform(0.36f, 0.58f)
                      : framing < shares.portrait ? plan.uniform(0.22f, 0.36f)
                      : framing < shares.half     ? plan.uniform(0.14f, 0.22f)
                                                  : plan.uniform(0.09f, 0.13f);
  const int crowd = plan.below(100);
  const int people = crowd < shares.one || share > 0.45f ? 1 : crowd < shares.two ? 2 : 3 + plan.below(kMostPeople - 2);
  const float aspect = static_cast<float>(size.width) / static_cast<float>(size.height);
  float height_m = 0.235f / share;
  if (people > 1) height_m = std::max(height_m, 0.5f * static_cast<float>(people) / aspect);
  const float distance = std::max(height_m * plan.uniform(0.85f, 2.6f), 0.42f);
  const float head_x = people > 1 ? plan.uniform(0.42f, 0.58f) : 0.5f + 0.1f * plan.normal();
  const float head_y = std::clamp(0.16f + 0.8f * share + 0.07f * plan.normal(), 0.5f * share + 0.02f, 0.62f);

  SceneModel scene;
  sitting.tags.push_back(set_lighting(scene, rng.substream(2)));
  // the camera stands before the people, a little aside, at about the height of their eyes
  const float rise = std::clamp(0.13f * plan.normal(), -0.35f, 0.45f), aside = 0.06f * plan.normal();
  const float roll = 0.035f * plan.normal(), focus_error_m = 0.02f * plan.normal();
  // from a phone's pupil of 2 mm to a portrait lens's of 50 mm
  const float aperture_m =
      plan.chance(0.55f) ? plan.uniform(0.001f, 0.004f) : plan.uniform(0.006f, 0.05f) * std::min(distance, 1.0f);
  const auto camera_before = [&](vec3 head) {
    CameraSetup camera;
    camera.eye =
        head + distance * vec3(std::sin(aside) * std::cos(rise), std::sin(rise), std::cos(aside) * std::cos(rise));
    camera.eye.y = std::max(camera.eye.y, 0.15f);
    camera.target = head + vec3((0.5f - head_x) * height_m * aspect, (head_y - 0.5f) * height_m, 0);
    camera.roll = roll;
    camera.height_m = height_m;
    camera.width_px = size.width;
    camera.height_px = size.height;
    camera.aperture_m = aperture_m;
    camera.focus_m = glm::distance(camera.eye, head) - 0.08f + focus_error_m;
    return camera;
  };

  std::vector<FigureOptions> planned;
  std::vector<Figure> figures;  // their poses at first
  bool any_makehuman = false;
  const float spacing = plan.uniform(0.4f, 0.62f);
  for (int i = 0; i < people; ++i) {
    FigureOptions& options = planned.emplace_back();
    options.meters_per_px = height_m / static_cast<float>(size.height);
    options.person = i;
    const float x = (static_cast<float>(i) - 0.5f * static_cast<float>(people - 1)) * spacing;
    options.place = vec3(x, 0, people > 1 ? 0.12f * plan.normal() : 0);
    options.yaw = people > 1 ? -0.5f * x + 0.25f * plan.normal() : 0.35f * plan.normal();
    options.head_yaw = -0.75f * options.yaw + 0.16f * plan.normal();
    RandomStream gesture = rng.substream(10 + i);
    options.gesture = random_gesture(gesture);
    figures.push_back(pose_figure(rng.substream(20 + i), options));
    any_makehuman = any_makehuman || is_makehuman(rng.substream(20 + i), makehuman);
  }
  // what lies below the picture is not made; how tall MakeHuman's people are is known only when they are whole
  constexpr float kPeopleReach_m = 0.6f, kBlur_m = 0.05f;
  const simulator::CameraView before = make_camera(camera_before(middle_of(figures)));
  const float lowest_m = any_makehuman ? -1 : lowest_visible_m(before, kPeopleReach_m) - kBlur_m;
  for (int i = 0; i < people; ++i) {
    planned[i].lowest_m = lowest_m;
    figures[i] = add_any_figure(scene, rng.substream(20 + i), planned[i], makehuman);
  }
  const vec3 head = middle_of(figures);
  const CameraSetup camera_plan = camera_before(head);

  const float back = plan.chance(0.3f) ? plan.uniform(0.8f, 1.6f) : plan.uniform(1.5f, 6);
  sitting.tags.push_back(add_environment(scene, rng.substream(3), back));
  RandomStream extras = rng.substream(4);
  if (extras.chance(0.15f)) match_background(scene, extras);
  constexpr float kNearestBystander_m = 0.8f;
  const float room = back - 0.4f;  // most places have a wall at `back`
  if (extras.chance(0.25f) && room > kNearestBystander_m) {
    const int bystanders = 1 + extras.below(3);
    for (int i = 0; i < bystanders; ++i) {
      FigureOptions other;
      const float behind = extras.uniform(kNearestBystander_m, room);
      other.place = {extras.sign() * extras.uniform(0.15f, 0.45f) * (behind + distance) * height_m / distance, 0,
                     -behind};
      other.yaw = 6.2831853f * extras.uniform();
      other.meters_per_px = planned[0].meters_per_px * (behind + distance) / distance;
      other.person = kBystander;
      other.gesture = random_gesture(extras);
      add_any_figure(scene, extras.substream(i), other, makehuman);
    }
  }
  if (extras.chance(0.12f)) {
    const float bottom = head.y - (1 - head_y) * height_m;
    add_foreground(scene, rng.substream(5), camera_plan.eye, bottom + extras.uniform(0.05f, 0.3f) * height_m);
    sitting.tags.emplace_back("clutter");
  }
  const RayTracer tracer(scene);
  const simulator::CameraView camera = make_camera(camera_plan);
  const Visibility way = visibility_of(tracer, camera);
  if (way.bystanders) sitting.tags.emplace_back("bystanders");
  constexpr float kMostCovered = 0.002f;  // soles may lie in a floor
  sitting.clear = way.occluded < kMostCovered;
  for (const Figure& figure : figures) {
    const bool seat_seen = figure.pose.sitting && project(camera, figure.skeleton.pelvis.origin).y < size.height;
    sitting.clear = sitting.clear && !seat_seen;
  }
  RandomStream grain = rng.substream(6);
  sitting.exposure = render(tracer, camera, people, grain.seed());
  float largest = 0;
  for (const Figure& figure : figures) {
    PeopleSample truth = truth_of(tracer, camera, figure, sitting.exposure);
    if (!is_frontal_and_seen(figure, camera, truth, sitting.exposure.coverage)) continue;
    truth.people = people;
    largest = std::max(largest, truth.face.z * truth.face.w);
    sitting.sitters.push_back({std::move(truth), figure.person});
  }
  std::erase_if(sitting.sitters, [&](const Sitter& s) { return s.truth.face.z * s.truth.face.w < largest / 3; });
  return sitting;
}

/// A place with nobody in it, square, linear.
Image take_background(RandomStream rng) {
  SceneModel scene;
  set_lighting(scene, rng.substream(2));
  RandomStream plan = rng.substream(1);
  add_environment(scene, rng.substream(3), plan.uniform(0.5f, 5));
  CameraSetup camera;
  camera.eye = {plan.uniform(-0.3f, 0.3f), plan.uniform(1.0f, 1.8f), plan.uniform(0.5f, 2.5f)};
  camera.target = {plan.uniform(-0.3f, 0.3f), camera.eye.y + plan.uniform(-0.5f, 0.3f), 0};
  camera.height_m = glm::distance(camera.eye, camera.target) * plan.uniform(0.4f, 1.2f);
  camera.width_px = camera.height_px = kPictureSide_px;
  camera.focus_m = plan.uniform(0.4f, 3);
  camera.aperture_m = plan.chance(0.5f) ? plan.uniform(0.001f, 0.004f) : plan.uniform(0.006f, 0.05f);
  camera.roll = 0.04f * plan.normal();
  const RayTracer tracer(scene);
  return render(tracer, make_camera(camera), 0, plan.seed()).light;
}

/// People of `exposure` over a part of the background, linear.
Image composite_of(const Rendering& exposure, Image background, RandomStream rng) {
  const Image& people = exposure.people_light;
  Image out = people;
  set_mean_luminance(out, exposure.coverage, rng.uniform(0.7f, 1.4f));
  set_mean_luminance(background, {}, rng.uniform(0.4f, 1.6f));
  const float zoom = rng.uniform(0.5f, 0.99f);
  const bool flip = rng.chance(0.5f);
  const float room_x = static_cast<float>(background.width) - zoom * static_cast<float>(out.width) - 1;
  const float room_y = static_cast<float>(background.height) - zoom * static_cast<float>(out.height) - 1;
  const float left = std::max(room_x, 0.0f) * rng.uniform(), top = std::max(room_y, 0.0f) * rng.uniform();
  const vec3 tint = 1.0f + 0.12f * vec3(rng.normal(), rng.normal(), rng.normal());
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      float alpha = 0;
      for (int p = 0; p < exposure.coverage.channels; ++p) alpha += exposure.coverage.at(x, y, p);
      if (alpha > 0.999f) continue;
      const float u = left + zoom * static_cast<float>(flip ? out.width - 1 - x : x),
                  v = top + zoom * static_cast<float>(y);
      const int i = std::clamp(static_cast<int>(u), 0, background.width - 2),
                j = std::clamp(static_cast<int>(v), 0, background.height - 2);
      const float a = std::clamp(u - static_cast<float>(i), 0.0f, 1.0f),
                  b = std::clamp(v - static_cast<float>(j), 0.0f, 1.0f);
      for (int c = 0; c < 3; ++c) {
        const float upper = background.at(i, j, c) * (1 - a) + background.at(i + 1, j, c) * a;
        const float lower = background.at(i, j + 1, c) * (1 - a) + background.at(i + 1, j + 1, c) * a;
        out.at(x, y, c) += (1 - alpha) * tint[c] * (upper * (1 - b) + lower * b);
      }
    }
  }
  return out;
}

/// Develops a picture, centers it in the square and gives each of `people` a sample.
void finish(const Sitting& sitting, const std::vector<Sitter>& people, Image light, RandomStream rng,
            std::vector<PeopleSample>& out) {
  const Image& coverage = sitting.exposure.coverage;
  // as much for the people as for the whole picture, with an automatic exposure's errors
  Image weight(coverage.width, coverage.height, 1);
  for (std::size_t i = 0; i < weight.data.size(); ++i) {
    float shown = 0.3f;
    for (int p = 0; p < coverage.channels; ++p) shown += coverage.data[i * coverage.channels + p];
    weight.data[i] = shown;
  }
  set_mean_luminance(light, weight, 0.19f * std::exp2(0.6f * rng.normal()));
  const std::vector<std::uint8_t> photograph = process_photo(std::move(light), rng.substream(1));
  const int left = (kPictureSide_px - coverage.width) / 2, top = (kPictureSide_px - coverage.height) / 2;
  for (const auto& [truth, person] : people) {
    PeopleSample sample = truth;
    sample.picture.assign(static_cast<std::size_t>(kPictureSide_px) * kPictureSide_px * 3, 0);
    sample.mask.assign(static_cast<std::size_t>(kPictureSide_px) * kPictureSide_px, 0);
    for (int y = 0; y < coverage.height; ++y) {
      const std::size_t to = static_cast<std::size_t>(y + top) * kPictureSide_px + left;
      std::copy_n(photograph.begin() + static_cast<std::ptrdiff_t>(y) * coverage.width * 3, coverage.width * 3,
                  sample.picture.begin() + static_cast<std::ptrdiff_t>(to) * 3);
      for (int x = 0; x < coverage.width; ++x) {
        sample.mask[to + x] = static_cast<std::uint8_t>(std::lround(coverage.at(x, y, person) * 255));
      }
    }
    for (vec3& k : sample.keypoints) k += vec3(left, top, 0);
    sample.face += glm::vec4(left, top, 0, 0);
    out.push_back(std::move(sample));
  }
}

/// The backgrounds of a shard's composites, made when they are first wanted: a sample does not depend on how many
/// there are. Training's odd ones are strange, for people who are.
class Backgrounds {
 public:
  explicit Backgrounds(const RandomStream& rng) : rng_(rng) {}

  const Image& any(RandomStream& rng, bool strange) {
    auto i = static_cast<std::size_t>(rng.below(kCount));
    if (!rng.held_out()) i = i / 2 * 2 + (strange ? 1 : 0);
    std::call_once(made_[i], [&] {
      RandomStream own = rng_.substream(1'000'000 + i);
      if (strange) own.set_domain_randomized();
      // isolated, so that Embree's own tasks cannot make this thread wait for the flag that it holds
      tbb::this_task_arena::isolate([&] { images_[i] = take_background(own); });
    });
    return images_[i];
  }

 private:
  static constexpr int kCount = 32;
  RandomStream rng_;
  std::array<std::once_flag, kCount> made_;
  std::array<Image, kCount> images_;
};

}  // namespace

PeopleSample truth_of(const RayTracer& tracer, const simulator::CameraView& camera, const Figure& figure,
                      const Rendering& exposure) {
  PeopleSample sample;
  const vec3 eye(camera.world_from_camera[3]);
  const auto joints = keypoints_of(figure);
  const Image& coverage = exposure.coverage;
  for (int i = 0; i < kKeypoints; ++i) {
    const vec3 at = project(camera, joints[i]);
    const bool inside = at.z > 0.05f && at.x >= 0 && at.y >= 0 && at.x < static_cast<float>(coverage.width) &&
                        at.y < static_cast<float>(coverage.height);
    const bool seen = inside && sees(tracer, eye, joints[i], figure.person, joint_depth_m(figure, i)) &&
                      coverage.at(static_cast<int>(at.x), static_cast<int>(at.y), figure.person) > 0.5f;
    sample.keypoints[i] = {at.x, at.y, inside ? (seen ? 2.0f : 1.0f) : 0.0f};
  }
  sample.face = face_box(figure, camera);
  sample.tags = figure.tags;
  return sample;
}

std::array<vec3, kKeypoints> keypoints_of(const Figure& figure) {
  const Skeleton& k = figure.skeleton;
  std::array<vec3, kKeypoints> joints;
  std::copy(figure.face_points.begin(), figure.face_points.end(), joints.begin());
  std::size_t next = figure.face_points.size();
  for (const auto* pair : {&k.shoulder, &k.elbow, &k.wrist, &k.hip, &k.knee, &k.ankle}) {
    for (const vec3& joint : *pair) joints[next++] = joint;
  }
  return joints;
}

glm::vec4 face_box(const Figure& figure, const simulator::CameraView& camera) {
  vec2 low(1e9f), high(-1e9f);
  for (const vec3& p : figure.face_outline) {
    const vec2 at(project(camera, p));
    low = glm::min(low, at);
    high = glm::max(high, at);
  }
  const float side = std::max(high.x - low.x, high.y - low.y);
  const vec2 corner = 0.5f * (low + high) - 0.5f * side;
  return {corner, side, side};
}

std::vector<PeopleSample> make_people_shard(const PeopleOptions& options, int shard, int count,
                                            const std::function<void(double)>& progress) {
  const RandomStream rng = RandomStream(options.seed, options.held_out).substream(static_cast<std::uint64_t>(shard));
  Backgrounds backgrounds(rng);
  std::atomic<int> done = 0;
  const int in_all = std::max(count / (1 + options.composites), 1);
  std::vector<PeopleSample> samples;
  int first = 0;
  while (static_cast<int>(samples.size()) < count) {
    // as many as fill the shard if each shows one person; the same for any number of threads
    const int round = std::max((count - static_cast<int>(samples.size())) / (1 + options.composites), 1);
    std::vector<std::vector<PeopleSample>> made(round);
    tbb::parallel_for(0, round, [&](int i) {
      const int index = first + i;
      const RandomStream picture = rng.substream(static_cast<std::uint64_t>(index));
      const Sitting sitting = take_sitting(picture, options.makehuman.get());
      if (progress) progress(std::min(0.99, static_cast<double>(++done) / in_all));
      if (sitting.sitters.empty()) return;
      std::vector<PeopleSample>& out = made[i];
      finish(sitting, sitting.sitters, sitting.exposure.light, picture.substream(50), out);
      const int whole = static_cast<int>(out.size());
      for (int k = 0; k < options.composites && sitting.clear; ++k) {
        RandomStream mix = picture.substream(100 + k);
        const Image& background = backgrounds.any(mix, sitting.strange);
        // of several people one: the others are in the next
        const Sitter& one = sitting.sitters[static_cast<std::size_t>(k) % sitting.sitters.size()];
        finish(sitting, {one}, composite_of(sitting.exposure, background, mix.substream(1)), mix.substream(2), out);
      }
      for (std::size_t k = 0; k < out.size(); ++k) {
        out[k].composite = static_cast<int>(k) >= whole;
        out[k].picture_index = index * (1 + options.composites) + std::max(static_cast<int>(k) - whole + 1, 0);
        RandomStream own = picture.substream(7);
        out[k].seed = own.seed();
        if (!out[k].composite) out[k].tags.insert(out[k].tags.end(), sitting.tags.begin(), sitting.tags.end());
        if (sitting.strange) out[k].tags.emplace_back("strange");
      }
    });
    for (auto& several : made) {
      for (PeopleSample& sample : several) samples.push_back(std::move(sample));
    }
    first += round;
  }
  samples.resize(static_cast<std::size_t>(count));
  return samples;
}

}  // namespace dualpixel::scenes
