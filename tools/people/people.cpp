#include "tools/people/people.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "tools/people/develop.h"
#include "tools/people/makehuman.h"
#include "tools/people/surroundings.h"

namespace dualpixel::tools {
namespace {

/// Faces are seeded where a detector would find them: turned less than this from the camera ...
const float kMostTurned = std::cos(1.15f);
/// ... and larger than a third of the largest face (Wadhwa et al. 2018, section 3.3) and than this.
constexpr float kSmallestFace_px = 9;

struct Size {
  int width, height;
};

Size any_size(Dice& dice) {
  constexpr Size kSizes[] = {{192, 256}, {192, 256}, {192, 256}, {192, 256}, {205, 256},
                             {256, 192}, {256, 192}, {256, 256}, {256, 256}, {144, 256}};
  return kSizes[dice.below(10)];
}

/// What a rendered picture still is before it is developed.
struct Sitting {
  Exposure exposure;
  std::vector<PeopleSample> samples;  ///< without pictures, in the photograph's own pixels
  bool clear = true;                  ///< nothing stands before the people: they can be cut out
  std::vector<std::string> tags;
};

/// Whether the first thing on the way to a joint is that person, and about where the joint is.
bool sees(const World& world, vec3 eye, vec3 joint, int person, float within_m) {
  const vec3 d = joint - eye;
  const float distance = glm::length(d);
  const auto hit = world.intersector().intersect({eye, d / distance});
  return hit && world.stage().pieces[hit->mesh].person == person && hit->t > distance - within_m;
}

PeopleSample truth_of(const World& world, const simulator::CameraView& camera, const Figure& figure,
                      const Exposure& exposure) {
  PeopleSample sample;
  const vec3 eye(camera.world_from_camera[3]);
  const auto joints = keypoints_of(figure);
  const Image& coverage = exposure.coverage;
  for (int i = 0; i < kKeypoints; ++i) {
    const vec3 at = project(camera, joints[i]);
    const bool inside = at.z > 0.05f && at.x >= 0 && at.y >= 0 && at.x < static_cast<float>(coverage.width) &&
                        at.y < static_cast<float>(coverage.height);
    // eyes and nose lie on the surface, other joints within it
    const float within = i < 5 ? 0.06f : (i == 11 || i == 12 ? 0.2f : 0.13f) * figure.body.stature_m / 1.7f;
    const bool seen = inside && sees(world, eye, joints[i], figure.person, within) &&
                      coverage.at(static_cast<int>(at.x), static_cast<int>(at.y), figure.person) > 0.5f;
    sample.keypoints[i] = {at.x, at.y, inside ? (seen ? 2.0f : 1.0f) : 0.0f};
  }
  sample.face = face_box(figure, camera);
  sample.tags = figure.tags;
  return sample;
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

/// Gives something that a person wears the colours of something behind: edges without contrast.
void match_background(Stage& stage, Dice& dice) {
  std::vector<int> worn, behind;
  for (const Piece& piece : stage.pieces) {
    const Look::Kind kind = stage.looks[static_cast<std::size_t>(piece.look)].kind;
    if (piece.person < 0) {
      behind.push_back(piece.look);
    } else if (kind < Look::Kind::skin || kind == Look::Kind::hair) {
      worn.push_back(piece.look);
    }
  }
  if (worn.empty() || behind.empty()) return;
  const Look& from = stage.looks[static_cast<std::size_t>(behind[dice.below(static_cast<int>(behind.size()))])];
  for (int i = 0; i < 2; ++i) {
    Look& to = stage.looks[static_cast<std::size_t>(worn[dice.below(static_cast<int>(worn.size()))])];
    to.a = from.a, to.b = from.b, to.c = from.c;
  }
}

Figure add_any_figure(Stage& stage, Dice dice, const FigureOptions& options, const MakeHumanAssets* makehuman) {
  Dice which = dice.of(99);
  if (makehuman && which.chance(0.5f)) return add_makehuman_figure(stage, *makehuman, dice, options);
  return add_figure(stage, dice, options);
}

Sitting take_sitting(Dice dice, const MakeHumanAssets* makehuman) {
  Sitting sitting;
  Dice plan = dice.of(1);
  const Size size = any_size(plan);
  // head's share of the picture's height: close, portrait, half body, full body
  const int framing = plan.below(100);
  const float share = framing < 22   ? plan.in(0.36f, 0.58f)
                      : framing < 70 ? plan.in(0.22f, 0.36f)
                      : framing < 90 ? plan.in(0.14f, 0.22f)
                                     : plan.in(0.09f, 0.13f);
  const int crowd = plan.below(100);
  const int people = crowd < 82 || share > 0.45f ? 1 : crowd < 95 ? 2 : 3 + plan.below(kMostPeople - 2);
  const float aspect = static_cast<float>(size.width) / static_cast<float>(size.height);
  float height_m = 0.235f / share;
  if (people > 1) height_m = std::max(height_m, 0.5f * static_cast<float>(people) / aspect);
  const float distance = std::max(height_m * plan.in(0.85f, 2.6f), 0.42f);
  const float head_x = people > 1 ? plan.in(0.42f, 0.58f) : 0.5f + 0.1f * plan.normal();
  const float head_y = std::clamp(0.16f + 0.8f * share + 0.07f * plan.normal(), 0.5f * share + 0.02f, 0.62f);

  Stage stage;
  sitting.tags.push_back(set_light(stage, dice.of(2)));
  const float around = 0.5f * plan.normal();  // the camera walks about the person by so much
  std::vector<Figure> figures;
  FigureOptions options;
  options.metres_per_px = height_m / static_cast<float>(size.height);
  options.seen_below_head_m = (1 - head_y) * height_m * 1.25f + 0.1f;
  const float spacing = plan.in(0.4f, 0.62f);
  float tallest = 0, lowest = 9;
  for (int i = 0; i < people; ++i) {
    options.person = i;
    const float x = (static_cast<float>(i) - 0.5f * static_cast<float>(people - 1)) * spacing;
    options.place = vec3(x, 0, people > 1 ? 0.12f * plan.normal() : 0);
    options.yaw = people > 1 ? -0.5f * x + 0.25f * plan.normal() : 0.35f * plan.normal();
    options.head_yaw = -0.75f * options.yaw + 0.16f * plan.normal();
    Dice gesture = dice.of(10 + i);
    options.gesture = any_gesture(gesture);
    figures.push_back(add_any_figure(stage, dice.of(20 + i), options, makehuman));
    tallest = std::max(tallest, figures.back().skeleton.head.origin.y);
    lowest = std::min(lowest, figures.back().skeleton.head.origin.y);
  }
  // the camera stands before the person, a little aside, at about the height of the eyes; then all else turns with it
  const vec3 head = people == 1 ? figures[0].skeleton.head.origin : vec3(0, 0.5f * (tallest + lowest), 0);
  const float rise = std::clamp(0.13f * plan.normal(), -0.35f, 0.45f), aside = 0.12f * around;
  CameraPlan camera_plan;
  camera_plan.eye =
      head + distance * vec3(std::sin(aside) * std::cos(rise), std::sin(rise), std::cos(aside) * std::cos(rise));
  camera_plan.eye.y = std::max(camera_plan.eye.y, 0.15f);
  camera_plan.target = head + vec3((0.5f - head_x) * height_m * aspect, (head_y - 0.5f) * height_m, 0);
  camera_plan.roll = 0.035f * plan.normal();
  camera_plan.height_m = height_m;
  camera_plan.width_px = size.width;
  camera_plan.height_px = size.height;
  // from a phone's pupil of 2 mm to a portrait lens's of 50 mm
  camera_plan.aperture_m =
      plan.chance(0.55f) ? plan.in(0.001f, 0.004f) : plan.in(0.006f, 0.05f) * std::min(distance, 1.0f);
  camera_plan.focus_m = glm::distance(camera_plan.eye, head) - 0.08f + 0.02f * plan.normal();

  const float back = plan.chance(0.3f) ? plan.in(0.8f, 1.6f) : plan.in(1.5f, 6);
  sitting.tags.push_back(add_surroundings(stage, dice.of(3), back));
  Dice extras = dice.of(4);
  if (extras.chance(0.15f)) match_background(stage, extras);
  if (extras.chance(0.18f)) {  // bystanders
    const int bystanders = 1 + extras.below(3);
    for (int i = 0; i < bystanders; ++i) {
      FigureOptions other;
      const float behind = extras.in(1.5f, 6);
      other.place = {extras.sign() * extras.in(0.15f, 0.45f) * (behind + distance) * height_m / distance, 0, -behind};
      other.yaw = 6.2831853f * extras.unit();
      other.metres_per_px = options.metres_per_px * (behind + distance) / distance;
      other.person = -1;
      other.gesture = any_gesture(extras);
      add_any_figure(stage, extras.of(i), other, makehuman);
    }
    sitting.tags.emplace_back("bystanders");
  }
  if (extras.chance(0.12f)) {
    const float bottom = head.y - (1 - head_y) * height_m;
    add_clutter(stage, dice.of(5), camera_plan.eye, bottom + extras.in(0.05f, 0.3f) * height_m);
    sitting.clear = false;
    sitting.tags.emplace_back("clutter");
  }
  const World world(stage);
  const simulator::CameraView camera = make_camera(camera_plan);
  Dice grain = dice.of(6);
  sitting.exposure = shoot(world, camera, people, grain.seed());
  float largest = 0;
  for (const Figure& figure : figures) {
    PeopleSample sample = truth_of(world, camera, figure, sitting.exposure);
    if (!is_frontal_and_seen(figure, camera, sample, sitting.exposure.coverage)) continue;
    largest = std::max(largest, sample.face.z * sample.face.w);
    sitting.samples.push_back(std::move(sample));
    sitting.samples.back().people = people;
    // which person: for the mask
    sitting.samples.back().picture_index = figure.person;
  }
  std::erase_if(sitting.samples, [&](const PeopleSample& s) { return s.face.z * s.face.w < largest / 3; });
  return sitting;
}

/// A place with nobody in it, square, linear.
Image take_background(Dice dice) {
  Stage stage;
  set_light(stage, dice.of(2));
  Dice plan = dice.of(1);
  add_surroundings(stage, dice.of(3), plan.in(0.5f, 5));
  CameraPlan camera;
  camera.eye = {plan.in(-0.3f, 0.3f), plan.in(1.0f, 1.8f), plan.in(0.5f, 2.5f)};
  camera.target = {plan.in(-0.3f, 0.3f), camera.eye.y + plan.in(-0.5f, 0.3f), 0};
  camera.height_m = glm::distance(camera.eye, camera.target) * plan.in(0.4f, 1.2f);
  camera.width_px = camera.height_px = kPictureSide_px;
  camera.focus_m = plan.in(0.4f, 3);
  camera.aperture_m = plan.chance(0.5f) ? plan.in(0.001f, 0.004f) : plan.in(0.006f, 0.05f);
  camera.roll = 0.04f * plan.normal();
  const World world(stage);
  return shoot(world, make_camera(camera), 0, plan.seed()).light;
}

/// People of `exposure` over a part of the background, linear.
Image composite_of(const Exposure& exposure, Image background, Dice dice) {
  const Image& people = exposure.people_light;
  Image out = people;
  expose_to(out, exposure.coverage, dice.in(0.7f, 1.4f));
  expose_to(background, {}, dice.in(0.4f, 1.6f));
  const float zoom = dice.in(0.5f, 0.99f);
  const bool flip = dice.chance(0.5f);
  const float room_x = static_cast<float>(background.width) - zoom * static_cast<float>(out.width) - 1;
  const float room_y = static_cast<float>(background.height) - zoom * static_cast<float>(out.height) - 1;
  const float left = std::max(room_x, 0.0f) * dice.unit(), top = std::max(room_y, 0.0f) * dice.unit();
  const vec3 tint = 1.0f + 0.12f * vec3(dice.normal(), dice.normal(), dice.normal());
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

/// Develops a picture, centres it in the square and gives each of `people` a sample.
void finish(const Sitting& sitting, const std::vector<PeopleSample>& people, Image light, Dice dice,
            std::vector<PeopleSample>& out) {
  const Image& coverage = sitting.exposure.coverage;
  // as much for the people as for the whole picture, with an automatic exposure's errors
  Image weight(coverage.width, coverage.height, 1);
  for (std::size_t i = 0; i < weight.data.size(); ++i) {
    float shown = 0.3f;
    for (int p = 0; p < coverage.channels; ++p) shown += coverage.data[i * coverage.channels + p];
    weight.data[i] = shown;
  }
  expose_to(light, weight, 0.19f * std::exp2(0.6f * dice.normal()));
  const std::vector<std::uint8_t> photograph = develop(std::move(light), dice.of(1));
  const int left = (kPictureSide_px - coverage.width) / 2, top = (kPictureSide_px - coverage.height) / 2;
  for (const PeopleSample& seen : people) {
    PeopleSample sample = seen;
    sample.picture.assign(static_cast<std::size_t>(kPictureSide_px) * kPictureSide_px * 3, 0);
    sample.mask.assign(static_cast<std::size_t>(kPictureSide_px) * kPictureSide_px, 0);
    for (int y = 0; y < coverage.height; ++y) {
      const std::size_t to = static_cast<std::size_t>(y + top) * kPictureSide_px + left;
      std::copy_n(photograph.begin() + static_cast<std::ptrdiff_t>(y) * coverage.width * 3, coverage.width * 3,
                  sample.picture.begin() + static_cast<std::ptrdiff_t>(to) * 3);
      for (int x = 0; x < coverage.width; ++x) {
        sample.mask[to + x] = static_cast<std::uint8_t>(std::lround(coverage.at(x, y, seen.picture_index) * 255));
      }
    }
    for (vec3& k : sample.keypoints) k += vec3(left, top, 0);
    sample.face += glm::vec4(left, top, 0, 0);
    out.push_back(std::move(sample));
  }
}

}  // namespace

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
  const Dice dice = Dice(options.seed, options.held_out).of(static_cast<std::uint64_t>(shard));
  std::vector<Image> backgrounds(options.composites > 0 ? std::clamp(count / 16, 3, 32) : 0);
  std::atomic<int> done = 0;
  const int in_all = static_cast<int>(backgrounds.size()) + count / (1 + options.composites);
  const auto one_done = [&] {
    if (progress) progress(std::min(0.99, static_cast<double>(++done) / in_all));
  };
  tbb::parallel_for(std::size_t{0}, backgrounds.size(), [&](std::size_t i) {
    backgrounds[i] = take_background(dice.of(1'000'000 + i));
    one_done();
  });
  std::vector<PeopleSample> samples;
  int first = 0;
  while (static_cast<int>(samples.size()) < count) {
    // as many as fill the shard if each shows one person; the same for any number of threads
    const int round = std::max((count - static_cast<int>(samples.size())) / (1 + options.composites), 1);
    std::vector<std::vector<PeopleSample>> made(round);
    tbb::parallel_for(0, round, [&](int i) {
      const int index = first + i;
      const Dice picture = dice.of(static_cast<std::uint64_t>(index));
      const Sitting sitting = take_sitting(picture, options.makehuman.get());
      one_done();
      if (sitting.samples.empty()) return;
      std::vector<PeopleSample>& out = made[i];
      finish(sitting, sitting.samples, sitting.exposure.light, picture.of(50), out);
      const int whole = static_cast<int>(out.size());
      for (int k = 0; k < options.composites && sitting.clear; ++k) {
        Dice mix = picture.of(100 + k);
        const Image& background =
            backgrounds[static_cast<std::size_t>(mix.below(static_cast<int>(backgrounds.size())))];
        // of several people one: the others are in the next
        const PeopleSample& one = sitting.samples[static_cast<std::size_t>(k) % sitting.samples.size()];
        finish(sitting, {one}, composite_of(sitting.exposure, background, mix.of(1)), mix.of(2), out);
      }
      for (std::size_t k = 0; k < out.size(); ++k) {
        out[k].composite = static_cast<int>(k) >= whole;
        out[k].picture_index = index * (1 + options.composites) + std::max(static_cast<int>(k) - whole + 1, 0);
        Dice own = picture.of(7);
        out[k].seed = own.seed();
        if (!out[k].composite) out[k].tags.insert(out[k].tags.end(), sitting.tags.begin(), sitting.tags.end());
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

}  // namespace dualpixel::tools
