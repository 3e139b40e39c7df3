#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/kinds/kinds.h"
#include "scenes/math.h"
#include "scenes/procedural/noise.h"
#include "scenes/textures/lettering.h"
#include "scenes/things/things.h"

/// A table from above its edge: things on it, a wall behind. World axes: the table's top is y = 0, its middle the
/// origin; the camera is at +z.
namespace dualpixel::scenes {
namespace {

using glm::vec2;
using glm::vec3;
using Type = Parameter::Type;

struct Table {
  float wide, deep;  ///< half sizes
};

void add_table(SceneBuilder& build, RandomStream rng, const Table& table) {
  Mesh top;
  add_solid_box(top, {0, -0.015f, 0}, {table.wide, 0.015f, table.deep}, 0.004f);
  const int kind = rng.below(5);
  if (kind <= 2) {
    build.add("table", top,
              wood_surface(rng.substream(1), wood_color(rng), rng.chance(0.6f) ? rng.uniform(0.06f, 0.16f) : 0.0f));
  } else {
    build.add("table", top, rough_surface(rng.substream(1), paint_color(rng), rng.uniform(0.05f, 0.2f), 0.5f));
  }
  if (kind < 2 || kind == 4) return;
  // a cloth, with the creases that it was folded along and a few folds
  const std::uint32_t seed = rng.seed();
  const float fold = rng.uniform(0.001f, 0.009f), turn = rng.uniform(-0.5f, 0.5f);
  Mesh cloth;
  add_sheet(cloth, 180, 140, {2 * table.wide, 2 * table.deep}, [&](float u, float v) {
    const vec3 p((2 * u - 1) * table.wide, 0, (2 * v - 1) * table.deep);
    const float along = p.x * std::cos(turn) + p.z * std::sin(turn),
                across = p.z * std::cos(turn) - p.x * std::sin(turn);
    const float ridge = 1 - std::abs(2 * noise(seed, vec3(along * 3, across * 14, 0)) - 1);
    const float crease = std::exp(-std::abs(p.x) / 0.004f) + std::exp(-std::abs(p.z) / 0.004f);
    return p + vec3(0, 0.0008f + fold * ridge * ridge * ridge * noise(seed + 1, p * 4.0f) + 0.0008f * crease, 0);
  });
  build.add("tablecloth", cloth,
            woven_surface(rng.substream(2), paint_color(rng), paint_color(rng), rng.uniform(0.0009f, 0.002f)));
}

/// The wall behind, with skirting board and pictures, or a shelf of books.
void add_background(SceneBuilder& build, RandomStream rng, float at_z) {
  Mesh wall;
  wall.add_quad({-4, -1, at_z}, {8, 0, 0}, {0, 4, 0}, {8, 4});
  const int kind = rng.below(5);
  const vec3 color = glm::max(paint_color(rng), vec3(0.06f));
  if (kind == 0) {
    build.add("wall", wall, brick_surface(rng.substream(1), vec3(0.36f, 0.15f, 0.09f) * rng.uniform(0.6f, 1.4f)));
  } else if (kind == 1) {
    build.add("wall", wall,
              tile_surface(rng.substream(1), glm::mix(color, vec3(0.7f), 0.6f), vec3(0.4f), {0.1f, 0.1f}, 0.06f));
  } else {
    build.add("wall", wall, rough_surface(rng.substream(1), color, rng.uniform(0.03f, 0.1f), 1.5f, 1.4f));
  }
  if (kind >= 3) {
    const float y = rng.uniform(0.02f, 0.3f), x = rng.uniform(-1.2f, -0.4f), length = rng.uniform(0.8f, 1.8f);
    Mesh board;
    add_solid_box(board, {x + 0.5f * length, y - 0.012f, at_z + 0.11f}, {0.5f * length, 0.012f, 0.11f}, 0.002f);
    build.add("shelf", board, wood_surface(rng.substream(2), wood_color(rng), 0));
    add_book_row(build, rng.substream(3), glm::translate(glm::mat4(1), vec3(x + 0.03f, y, at_z + 0.2f)), length - 0.05f,
                 0.26f);
  }
  const int pictures = kind == 4 ? 0 : rng.below(3);
  for (int i = 0; i < pictures; ++i) {
    const vec2 half(rng.uniform(0.08f, 0.22f), rng.uniform(0.08f, 0.22f));
    const vec3 middle(rng.uniform(-0.7f, 0.7f), rng.uniform(0.35f, 0.7f), at_z + 0.008f);
    Mesh frame, picture;
    add_solid_box(frame, middle, {half.x + 0.015f, half.y + 0.015f, 0.008f}, 0.002f);
    picture.add_quad(middle + vec3(-half.x, -half.y, 0.0085f), {2 * half.x, 0, 0}, {0, 2 * half.y, 0});
    Surface print = rng.chance(0.4f) ? page_surface(rng.substream(10 + i), 1)
                                     : rough_surface(rng.substream(10 + i), paint_color(rng), 0.5f, 1, 1.5f);
    print.repeat_m = 1;
    build.add("frame", frame, wood_surface(rng.substream(20 + i), wood_color(rng), 0));
    build.add("picture", picture, print);
  }
}

/// A sheet of light: a window or a lamp's shade.
void add_glowing_quad(SceneBuilder& build, const char* name, vec3 middle, vec3 half_a, vec3 half_b, vec3 nits) {
  Mesh quad;
  quad.add_quad(middle - half_a - half_b, 2.0f * half_a, 2.0f * half_b);
  build.add(name, quad, glowing_surface(nits));
}

void add_light(SceneBuilder& build, RandomStream rng, const std::string& light) {
  const float side = rng.sign();
  if (light == "sun") {
    const float elevation = rng.uniform(20, 60), azimuth = 180 + side * rng.uniform(30, 110);
    build.sky(elevation, azimuth, rng.uniform(30000, 70000), 3500, 7000, 2500);
  } else if (light == "overcast") {
    build.ambient(vec3(2600, 2800, 3100) * rng.uniform(0.5f, 1.2f));
  } else if (light == "window") {
    const float nits = rng.uniform(1500, 5000);
    const vec3 middle(side * rng.uniform(1.0f, 1.8f), rng.uniform(0.4f, 0.9f), rng.uniform(-0.3f, 0.8f));
    const vec3 across = glm::normalize(vec3(-middle.z, 0, middle.x));
    add_glowing_quad(build, "window", middle, across * rng.uniform(0.35f, 0.6f), {0, rng.uniform(0.4f, 0.65f), 0},
                     nits * vec3(0.92f, 1, 1.12f));
    build.ambient(vec3(0.05f * nits) * vec3(1.1f, 1, 0.88f));
  } else {  // lamp
    const float nits = rng.uniform(6000, 16000);
    const vec3 at(side * rng.uniform(0.35f, 0.9f), rng.uniform(0.45f, 0.8f), rng.uniform(-0.5f, 0.4f));
    Mesh bulb;
    add_ball(bulb, at, vec3(0.045f), 6);
    build.add("bulb", bulb, glowing_surface(nits * vec3(1.35f, 0.95f, 0.5f)));
    build.ambient(vec3(0.0016f * nits) * vec3(1.2f, 0.98f, 0.7f));
  }
}

struct Placed {
  vec2 at;
  float radius;
};

/// Things in free places, dense near the middle of the view, lower in front than behind. `scale`: the camera's
/// distance; a near camera would stand between or in things in front.
void add_things(SceneBuilder& build, RandomStream rng, int count, float scale, const Table& table, vec3& subject) {
  std::vector<Placed> placed;
  for (int i = 0; i < count; ++i) {
    RandomStream own = rng.substream(100 + i);
    for (int attempt = 0; attempt < 40; ++attempt) {
      const float back = own.uniform(-1, 1), z = i == 0 ? 0 : -back * table.deep * 0.9f;
      const float half_view = std::min(table.wide, scale * (0.25f + 0.3f * (back + 1)));
      const float x = i == 0 ? 0.1f * scale * own.normal() : own.uniform(-half_view, half_view);
      const Thing& thing = draw_thing(own, std::min(0.16f, 0.45f * scale + 0.03f), back < -0.25f ? 0.14f : 0.5f);
      const bool free = std::all_of(placed.begin(), placed.end(), [&](const Placed& p) {
        return glm::distance(p.at, vec2(x, z)) > p.radius + thing.radius_m;
      });
      const bool hides_the_rest = i > 0 && z + thing.radius_m > 0.35f * scale && scale < 0.5f;
      if (!free || hides_the_rest || std::abs(x) > table.wide || std::abs(z) > table.deep) continue;
      placed.push_back({{x, z}, thing.radius_m * 0.92f});
      thing.add(build, own.substream(1), standing({x, 0.0006f, z}, own.uniform(0, 2 * kPi)));
      if (i == 0) subject = {x, 0.35f * thing.height_m, z};
      break;
    }
  }
}

/// A ball that rolls past the subject, in front of it, while the burst is taken.
void add_rolling_ball(SceneBuilder& build, RandomStream rng, float distance, vec3 subject) {
  const float r = 0.05f * std::min(distance, 0.5f), side = rng.sign(), burst_s = 0.36f,
              speed = rng.uniform(0.25f, 0.6f) * distance;
  Mesh ball;
  add_ball(ball, vec3(0), vec3(r), 32);
  build.add("rolling ball", ball, plain_surface(rng.substream(1), paint_color(rng), 0.3f, 0.2f));
  const vec3 from(subject.x - side * 0.25f * distance, r + 0.001f, subject.z + 0.16f);
  build.glb.move_last_node(0, from, burst_s, from + vec3(side * speed * burst_s, 0, 0));
  build.scene["burst"]["animation"] = true;
  build.scene["burst"]["exposure_poses"] = 4;
}

void build_still_life(SceneBuilder& build, const Parameters& p, RandomStream rng) {
  build.scene["render"]["light_samples"] = 512;
  build.scene["render"]["max_bounces"] = 1;
  const float distance = p.real("distance_m"), height = std::sin(p.real("elevation_deg") * kPi / 180);
  const Table table{std::max(0.45f, 0.9f * distance), std::max(0.32f, 0.55f * distance)};
  add_table(build, rng.substream(1), table);
  add_background(build, rng.substream(2), -table.deep - p.real("wall_m"));
  add_light(build, rng.substream(3), p.choice("light"));
  vec3 subject(0, 0.05f, 0);
  add_things(build, rng.substream(4), p.integer("objects"), distance, table, subject);
  if (p.integer("moving") == 1) add_rolling_ball(build, rng.substream(6), distance, subject);
  RandomStream aim = rng.substream(5);
  const vec3 look =
      vec3(0.15f * distance * aim.normal() * 0.4f, subject.y, 0) * 1.0f + vec3(subject.x, 0, subject.z) * 0.6f;
  const float across = std::sqrt(1 - height * height), turn = 0.25f * aim.normal();
  const vec3 towards(across * std::sin(turn), height, across * std::cos(turn));
  build.camera(look + distance * towards, look);
  build.focus_on(subject);
  build.shooting.clear_m = 0.35f * distance;
  if (p.choice("light") == "lamp") build.shooting.key = 0.1f;
}

}  // namespace

SceneKind still_life_kind() {
  return {"still_life",
          "a table with things, in front of a wall",
          {{"objects", "", Type::integer, 1, 60, 9, 26,
            "things that are tried to be placed; those without room are left out"},
           {"distance_m", "m", Type::logarithmic, 0.12, 2, 0.28, 1.0, "from the camera to the middle of the table"},
           {"elevation_deg", "degrees", Type::number, 3, 85, 10, 40, "of the camera over the table's top"},
           {"wall_m", "m", Type::number, 0.05, 10, 0.15, 1.6, "from the table's back edge to the wall"},
           {"moving", "", Type::integer, 0, 1, 0, 0, "1: a ball rolls through the burst"},
           {"light", "", Type::number, 0, 0, 0, 0, "what lights it", {"window", "lamp", "overcast", "sun"}}},
          build_still_life,
          [](const Parameters& p) {
            return p.choice("light") == "sun" ? simulator::EnvironmentModel::sky
                                              : simulator::EnvironmentModel::constant;
          }};
}

}  // namespace dualpixel::scenes
