#include "scenes/people/places/surroundings.h"

#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

namespace dualpixel::scenes {
namespace {

using Kind = Look::Kind;

mat3 about_y(float angle) { return mat3(glm::rotate(glm::mat4(1), angle, vec3(0, 1, 0))); }

/// What builds one place, piece by piece.
class Builder {
 public:
  Builder(Stage& stage, Dice& dice) : stage_(stage), dice_(dice), first_(stage.pieces.size()) {}

  Piece& piece(const Look& look) {
    Piece& p = stage_.pieces.emplace_back();
    p.look = stage_.add(look);
    return p;
  }
  void box(vec3 centre, vec3 half, const Look& look, float yaw = 0) {
    add_box(piece(look), centre, about_y(yaw), half, dice_.in3(0, 1));
  }
  void quad(vec3 corner, vec3 a, vec3 b, const Look& look) { add_quad(piece(look), corner, a, b); }
  /// Turns all that was built about the people.
  void turn(float yaw) {
    const mat3 axes = about_y(yaw);
    for (std::size_t i = first_; i < stage_.pieces.size(); ++i) {
      for (vec3& p : stage_.pieces[i].positions) p = axes * p;
      for (vec3& n : stage_.pieces[i].normals) n = axes * n;
    }
  }

 private:
  Stage& stage_;
  Dice& dice_;
  std::size_t first_;
};

Look plain(vec3 color, float gloss = 0) {
  Look look;
  look.a = color;
  look.gloss = gloss;
  return look;
}

Look glowing(vec3 radiance) {
  Look look = plain(vec3(1));
  look.emission = radiance;
  return look;
}

Look leaves_look(Dice& dice) {
  Look look;
  look.kind = Kind::foliage;
  look.scale_m = dice.in(0.03f, 0.12f);
  look.seed = dice.seed();
  look.a = {dice.in(0.04f, 0.2f), dice.in(0.12f, 0.35f), dice.in(0.02f, 0.1f)};
  if (dice.chance(0.12f)) look.a = {dice.in(0.3f, 0.5f), dice.in(0.12f, 0.25f), 0.04f};  // autumn
  look.c = look.a * vec3(dice.in(0.6f, 2), dice.in(0.6f, 1.4f), dice.in(0.4f, 1.3f));
  look.softness = 0.4f;
  return look;
}

/// Leaves as single rhombi about the surface of an ellipsoid.
void add_leaves(Piece& piece, Dice& dice, vec3 centre, vec3 radii, int count, float leaf_m) {
  for (int i = 0; i < count; ++i) {
    const vec3 random = dice.in3(-1, 1);
    const vec3 out = glm::normalize(random + 0.001f);
    const vec3 p = centre + radii * out * (0.6f + 0.45f * dice.unit());
    const vec3 along = glm::normalize(out + 0.9f * dice.in3(-1, 1) - vec3(0, 0.3f, 0));
    const vec3 across = glm::normalize(glm::cross(along, out + 0.5f * dice.in3(-1, 1)) + 0.001f);
    const float length = leaf_m * dice.in(0.6f, 1.4f), half = 0.3f * length;
    const auto first = static_cast<unsigned>(piece.positions.size());
    for (const vec3& q : {p, p + 0.5f * length * along + half * across, p + length * along,
                          p + 0.5f * length * along - half * across}) {
      piece.positions.push_back(q);
      piece.rest.push_back(vec3(q.x, q.y, q.z) + 0.7f * random);
      piece.normals.push_back(glm::normalize(glm::cross(along, across) + 0.6f * out));
    }
    piece.triangles.emplace_back(first, first + 1, first + 2);
    piece.triangles.emplace_back(first, first + 2, first + 3);
  }
}

void add_tree(Builder& build, Dice& dice, vec3 foot, float tall) {
  Look bark;
  bark.kind = Kind::rough;
  bark.scale_m = 0.1f;
  bark.seed = dice.seed();
  bark.a = vec3(0.2f, 0.14f, 0.1f) * dice.in(0.4f, 1.6f);
  bark.b = 0.3f * bark.a;
  const vec3 top = foot + vec3(dice.in(-0.5f, 0.5f), tall, 0);
  add_tube(build.piece(bark), {foot, glm::mix(foot, top, 0.5f) + dice.in3(-0.15f, 0.15f), top},
           {0.045f * tall, 0.03f * tall, 0.01f * tall}, 8);
  Piece& leaves = build.piece(leaves_look(dice));
  for (int i = 0; i < 4; ++i) {
    add_leaves(leaves, dice, top + tall * 0.25f * dice.in3(-1, 1), tall * vec3(0.28f, 0.2f, 0.28f), 220, 0.06f * tall);
  }
}

void add_plant(Builder& build, Dice& dice, vec3 foot) {
  const float tall = dice.in(0.4f, 1.4f);
  add_tube(build.piece(plain(any_color(dice))), {foot, foot, foot + vec3(0, 0.25f, 0), foot + vec3(0, 0.25f, 0)},
           {0, 0.1f, 0.14f, 0}, 10);
  add_leaves(build.piece(leaves_look(dice)), dice, foot + vec3(0, 0.25f + 0.5f * tall, 0),
             vec3(0.3f, 0.5f * tall, 0.3f), 120, dice.in(0.1f, 0.25f));
}

void add_room(Builder& build, Dice& dice, float back, bool library) {
  const float half = dice.in(2, 5), tall = dice.in(2.3f, 3.2f), front = 5;
  const Look wall = wall_look(dice);
  Look floor = wall_look(dice);
  if (dice.chance(0.6f)) {
    floor.kind = Kind::planks;
    floor.scale_m = dice.in(0.08f, 0.2f);
    floor.a = vec3(0.36f, 0.2f, 0.1f) * dice.in(0.4f, 1.6f), floor.c = 0.5f * floor.a;
  }
  build.quad({-half, 0, -back}, {2 * half, 0, 0}, {0, tall, 0}, wall);
  build.quad({-half, 0, front}, {2 * half, 0, 0}, {0, 0, -front - back}, floor);
  build.quad({-half, tall, -back}, {2 * half, 0, 0}, {0, 0, front + back}, plain(vec3(dice.in(0.6f, 0.9f))));
  Look side_wall = dice.chance(0.7f) ? wall : wall_look(dice);
  build.quad({-half, 0, front}, {0, 0, -front - back}, {0, tall, 0}, side_wall);
  build.quad({half, 0, -back}, {0, 0, front + back}, {0, tall, 0}, side_wall);
  // things on and before the back wall
  const int things = library ? 7 : 2 + dice.below(5);
  for (int i = 0; i < things; ++i) {
    const float x = dice.in(-0.8f, 0.8f) * half;
    const float z = -back + 0.02f;
    switch (library ? (i % 2 == 0 ? 2 : 5) : dice.below(9)) {
      case 0: {  // picture
        const vec3 size(dice.in(0.15f, 0.6f), dice.in(0.15f, 0.5f), 0.015f);
        const float y = dice.in(1.2f, 1.9f);
        build.box({x, y, z}, size + vec3(0.03f, 0.03f, -0.004f), plain(any_color(dice)));
        Look picture = wall_look(dice);
        picture.kind = Kind::collage;
        picture.scale_m = dice.in(0.1f, 0.5f);
        build.box({x, y, z}, size, picture);
        break;
      }
      case 1: {  // window
        const vec3 size(dice.in(0.4f, 1.1f), dice.in(0.5f, 0.9f), 0.02f);
        const float y = dice.in(1.2f, 1.8f);
        build.box({x, y, z}, size + vec3(0.06f, 0.06f, -0.005f), plain(vec3(dice.in(0.3f, 0.9f))));
        Look outside = dice.chance(0.5f) ? leaves_look(dice) : wall_look(dice);
        outside.emission = vec3(dice.in(1, 6));
        build.box({x, y, z}, size, dice.chance(0.4f) ? glowing(vec3(dice.in(1.5f, 6)) * vec3(0.9f, 1, 1.1f)) : outside);
        for (const float bar : {-0.33f, 0.33f})
          build.box({x + bar * size.x, y, z + 0.02f}, {0.02f, size.y, 0.02f}, plain(vec3(0.7f)));
        if (dice.chance(0.5f)) {
          Look curtain = cloth_look(dice);
          curtain.kind = Kind::stripes_along;
          curtain.scale_m = 0.08f;
          curtain.b = 0.7f * curtain.a;
          for (const float s : {-1.0f, 1.0f})
            build.box({x + s * size.x, 1.3f, z + 0.06f}, {0.2f, 1.2f, 0.02f}, curtain);
        }
        break;
      }
      case 2: {  // shelf of books
        Look look;
        look.kind = Kind::books;
        look.scale_m = dice.in(0.03f, 0.06f);
        look.seed = dice.seed();
        look.a = vec3(0.36f, 0.22f, 0.12f) * dice.in(0.3f, 1.8f);
        look.b = 0.4f * look.a;
        const float high = dice.in(0.5f, 1.1f);
        build.box({x, high, z + 0.15f}, {dice.in(0.4f, 1.2f), high, 0.16f}, look);
        break;
      }
      case 3: {  // door
        build.box({x, 1, z}, {0.45f, 1.02f, 0.02f}, plain(any_color(dice), 0.1f));
        break;
      }
      case 4: {  // sofa
        const Look cloth = cloth_look(dice);
        const float depth = dice.in(0.5f, std::max(back - 0.6f, 0.6f));
        build.box({x, 0.22f, -depth - 0.3f}, {0.8f, 0.22f, 0.4f}, cloth);
        build.box({x, 0.5f, -depth - 0.65f}, {0.8f, 0.4f, 0.12f}, cloth);
        for (int k = 0; k < 2; ++k)
          build.box({x - 0.4f + 0.8f * static_cast<float>(k), 0.56f, -depth - 0.45f}, {0.22f, 0.18f, 0.08f},
                    cloth_look(dice), 0.2f);
        break;
      }
      case 5: {  // table, cupboard
        const Look wood = wall_look(dice);
        build.box({x, 0.4f, -dice.in(0.7f, std::max(back - 0.3f, 0.8f))},
                  {dice.in(0.3f, 0.8f), dice.in(0.3f, 0.6f), 0.25f}, wood, dice.in(-0.5f, 0.5f));
        break;
      }
      case 6:
        add_plant(build, dice, {x, 0, -dice.in(0.6f, std::max(back - 0.3f, 0.7f))});
        break;
      case 7: {  // lamp
        const vec3 at(x, dice.in(1.3f, 2), -dice.in(0.6f, std::max(back - 0.2f, 0.7f)));
        add_tube(build.piece(plain(vec3(0.1f))), {vec3(at.x, 0, at.z), at}, {0.012f, 0.012f}, 5);
        add_tube(build.piece(glowing(vec3(3, 2.3f, 1.4f) * dice.in(0.5f, 2))), {at, at + vec3(0, 0.25f, 0)},
                 {0.2f, 0.12f}, 12);
        break;
      }
      default: {  // screens, clocks, notices
        const float y = dice.in(0.8f, 1.8f);
        build.box({x, y, z + 0.03f}, {dice.in(0.1f, 0.5f), dice.in(0.1f, 0.35f), 0.03f},
                  dice.chance(0.5f) ? plain(vec3(0.02f), 0.5f) : wall_look(dice));
      }
    }
  }
}

void add_garden(Builder& build, Dice& dice, float back) {
  Look grass;
  grass.kind = dice.chance(0.7f) ? Kind::grass : Kind::paving;
  grass.a = vec3(dice.in(0.06f, 0.2f), dice.in(0.14f, 0.3f), dice.in(0.02f, 0.08f));
  if (grass.kind == Kind::paving) grass.a = vec3(dice.in(0.2f, 0.5f)), grass.b = 0.4f * grass.a;
  grass.c = grass.a * dice.in(0.5f, 1.8f);
  grass.scale_m = 0.4f;
  grass.seed = dice.seed();
  build.quad({-30, 0, 8}, {60, 0, 0}, {0, 0, -50}, grass);
  const int layers = 1 + dice.below(3);
  for (int i = 0; i < layers; ++i) {
    const float z = -back - 2.5f * static_cast<float>(i) - dice.in(0, 1);
    const float high = dice.in(0.8f, 3.5f);
    if (dice.chance(0.5f)) {
      build.quad({-20, 0, z}, {40, 0, 0}, {0, high, 0}, leaves_look(dice));
    }
    Piece& hedge = build.piece(leaves_look(dice));
    for (int k = 0; k < 6; ++k) {
      add_leaves(hedge, dice,
                 {dice.in(-3, 3) - z * 0.2f * dice.in(-1, 1), high * dice.in(0.2f, 0.9f), z + dice.in(0, 0.5f)},
                 {dice.in(0.4f, 1), dice.in(0.4f, 0.9f), 0.4f}, 150, dice.in(0.08f, 0.3f));
    }
  }
  const int trees = dice.below(4);
  for (int i = 0; i < trees; ++i) add_tree(build, dice, {dice.in(-5, 5), 0, -back - dice.in(0.5f, 8)}, dice.in(2, 6));
}

void add_street(Builder& build, Dice& dice, float back) {
  Look ground = wall_look(dice);
  ground.kind = Kind::paving;
  ground.a = vec3(dice.in(0.1f, 0.5f)), ground.b = 0.5f * ground.a, ground.c = 0.8f * ground.a;
  ground.scale_m = dice.in(0.3f, 1);
  build.quad({-40, 0, 10}, {80, 0, 0}, {0, 0, -80}, ground);
  for (const float side : {-1.0f, 1.0f}) {
    for (int i = 0; i < 4; ++i) {
      Look house = wall_look(dice);
      if (dice.chance(0.75f)) house.kind = Kind::facade, house.scale_m = dice.in(1.4f, 3);
      const float depth = dice.in(2, 4), tall = dice.in(2.5f, 8);
      build.box({side * (dice.in(2.5f, 6) + 2), tall, -back - 8 * static_cast<float>(i)}, {2, tall, depth}, house);
    }
  }
  if (dice.chance(0.6f)) {
    Look house = wall_look(dice);
    house.kind = dice.chance(0.7f) ? Kind::facade : Kind::crowd;
    house.scale_m = house.kind == Kind::facade ? dice.in(1.4f, 3) : 0.5f;
    const float tall = house.kind == Kind::facade ? dice.in(3, 9) : 2.1f;
    build.box({0, tall, -back - dice.in(4, 25)}, {15, tall, 1}, house);
  }
  const int cars = dice.below(4);
  for (int i = 0; i < cars; ++i) {
    const Look paint = plain(any_color(dice), 0.5f);
    const float x = dice.in(-4, 4), z = -back - dice.in(1, 12), yaw = dice.chance(0.5f) ? 0.0f : 1.5f;
    build.box({x, 0.65f, z}, {2.1f, 0.38f, 0.85f}, paint, yaw);
    build.box({x, 1.2f, z}, {1.1f, 0.26f, 0.75f}, plain(vec3(0.03f), 0.7f), yaw);
  }
  const int posts = dice.below(4);
  for (int i = 0; i < posts; ++i) {
    const float x = dice.in(-3, 3), z = -back - dice.in(0, 8);
    add_tube(build.piece(plain(vec3(dice.in(0.02f, 0.3f)))), {{x, 0, z}, {x, 5, z}}, {0.06f, 0.05f}, 8);
    if (dice.chance(0.4f)) build.box({x, dice.in(1.8f, 2.6f), z}, {0.35f, 0.35f, 0.02f}, wall_look(dice));
  }
  if (dice.chance(0.4f)) add_tree(build, dice, {dice.in(-4, 4), 0, -back - dice.in(1, 6)}, dice.in(2, 6));
}

void add_landscape(Builder& build, Dice& dice, float back) {
  Look ground = wall_look(dice);
  ground.kind = dice.chance(0.5f) ? Kind::grass : Kind::rough;
  ground.a = dice.chance(0.4f) ? vec3(0.5f, 0.42f, 0.3f) : vec3(0.15f, 0.25f, 0.08f) * dice.in(0.5f, 2);
  ground.c = ground.b = 0.6f * ground.a;
  build.quad({-200, 0, 10}, {400, 0, 0}, {0, 0, -400}, ground);
  if (dice.chance(0.5f))
    build.quad({-200, 0.01f, -back - 5}, {400, 0, 0}, {0, 0, -200}, plain(vec3(0.06f, 0.12f, 0.16f), 0.3f));
  const int hills = 2 + dice.below(3);
  for (int i = 0; i < hills; ++i) {
    Piece& hill =
        build.piece(dice.chance(0.5f) ? leaves_look(dice) : plain(vec3(0.12f, 0.18f, 0.22f) * dice.in(0.5f, 2)));
    const float z = -30 - 20 * static_cast<float>(i), wide = dice.in(15, 40);
    add_ball(hill, {dice.in(-40, 40), -2, z}, {wide, dice.in(3, 14), 8}, mat3(1), 10);
  }
}

void add_lights_at_night(Builder& build, Dice& dice, float back) {
  build.quad({-30, 0, 8}, {60, 0, 0}, {0, 0, -40}, plain(vec3(0.05f), 0.1f));
  build.quad({-30, 0, -back - 14}, {60, 0, 0}, {0, 20, 0}, wall_look(dice));
  const int lights = 30 + dice.below(60);
  for (int i = 0; i < lights; ++i) {
    const float z = -back - dice.in(1, 12);
    const vec3 color = dice.chance(0.5f) ? vec3(1, 0.75f, 0.4f) : any_color(dice) + 0.1f;
    add_ball(build.piece(glowing(color * dice.in(4, 40))), {dice.in(-0.5f, 0.5f) * (3 - z), dice.in(0.2f, 3.2f), z},
             vec3(dice.in(0.01f, 0.07f)), mat3(1), 4);
  }
}

void add_painted(Builder& build, Dice& dice, float back) {
  // anything at all, large: stands for what no other place has
  Look look = wall_look(dice);
  if (dice.chance(0.6f)) {
    constexpr Kind kKinds[] = {Kind::collage, Kind::foliage, Kind::crowd, Kind::rough};
    look.kind = kKinds[dice.below(4)];
    look.scale_m = dice.in(0.15f, 0.9f);
    if (look.kind == Kind::foliage) look.a = leaves_look(dice).a, look.c = 1.5f * look.a;
  }
  build.quad({-12, -1, -back}, {24, 0, 0}, {0, 9, 0}, look);
  build.quad({-12, 0, 5}, {24, 0, 0}, {0, 0, -back - 5}, wall_look(dice));
  const int things = dice.below(7);
  for (int i = 0; i < things; ++i) {
    const bool box = dice.chance(0.5f);
    const vec3 half = box ? dice.in3(0.05f, 0.5f) : vec3(dice.in(0.05f, 0.4f));
    // behind the people, however it is turned
    const float z = -std::max(dice.in(0.35f, 1) * back, 0.5f + (box ? std::hypot(half.x, half.z) : half.x));
    const vec3 at(dice.in(-1.5f, 1.5f) * (1 - 0.3f * z), dice.in(0.2f, 2), z);
    if (box) {
      build.box(at, half, wall_look(dice), dice.in(-1, 1));
    } else {
      add_ball(build.piece(wall_look(dice)), at, half, mat3(1), 10);
    }
  }
}

/// The same thing of no particular kind at each of `places`; it reaches up to 1.5 `size_m` from there.
void add_things(Builder& build, Dice& dice, const std::vector<vec3>& places, float size_m) {
  Look look = dice.chance(0.5f) ? wall_look(dice) : cloth_look(dice);
  const vec3 half = size_m * dice.in3(0.15f, 1), along = size_m * dice.in3(-1, 1), rest_shift = dice.in3(0, 1);
  const mat3 axes = about_y(dice.in(-1.5f, 1.5f));
  const float radius = 0.2f * half.x, middle_radius = radius * dice.in(0.5f, 1.5f);
  enum { kBox, kBall, kSheet, kTube, kShapes };
  const int shape = dice.below(kShapes);
  if (shape == kBall) look.scale_m /= half.y;  // a ball's rest places are of radius 1
  Piece& piece = build.piece(look);
  for (const vec3& at : places) {
    switch (shape) {
      case kBox:
        add_box(piece, at, axes, half, rest_shift);
        break;
      case kBall:
        add_ball(piece, at, half, mat3(1), 7);
        break;
      case kSheet:
        add_quad(piece, at - vec3(half.x, half.y, 0), vec3(2 * half.x, 0, half.z), vec3(0, 2 * half.y, -half.z),
                 rest_shift);
        break;
      default:
        add_tube(piece, {at - along, at - along, at, at + along, at + along}, {0, radius, middle_radius, radius, 0}, 7);
    }
  }
}

/// Ground, and mostly a wall beyond `deepest_m`.
void add_ground(Builder& build, Dice& dice, float deepest_m) {
  build.quad({-30, 0, 8}, {60, 0, 0}, {0, 0, -50}, wall_look(dice));
  if (!dice.chance(0.7f)) return;
  const float z = -deepest_m - dice.in(0.5f, 8);
  build.quad({-20, 0, z}, {40, 0, 0}, {0, 9, 0}, wall_look(dice));
}

constexpr float kLargestInJumble_m = 0.6f;

/// Anything, anywhere behind the people.
void add_jumble(Builder& build, Dice& dice, float back, int things) {
  for (int i = 0; i < things; ++i) {
    const float size_m = dice.in(0.08f, kLargestInJumble_m), z = -1.5f * size_m - 0.5f - dice.in(0, 1) * back;
    const float x = dice.in(-1, 1) * (1 - 0.7f * z), y = dice.in(0, 2.4f);
    add_things(build, dice, {{x, y, z}}, size_m);
  }
}

/// The same thing again and again, in rows: shelves, stalls, seats, fences, lamps. Returns how far back they reach.
float add_rows(Builder& build, Dice& dice, float back) {
  const int kinds = 1 + dice.below(3);
  float deepest_m = back;
  for (int k = 0; k < kinds; ++k) {
    const float across = dice.in(0.12f, 1.2f), upwards = dice.in(0.2f, 1.2f), inwards = dice.in(0.4f, 2);
    const int aside = 4, up = dice.chance(0.5f) ? 1 : 4, deep = 1 + dice.below(3);
    const float low = dice.in(0, 1.2f), size_m = dice.in(0.25f, 0.7f) * std::min(across, upwards);
    const float first = -back * dice.in(0.6f, 1) - 0.5f - size_m;
    std::vector<vec3> places;
    for (int z = 0; z < deep; ++z) {
      for (int y = 0; y < up; ++y) {
        for (int x = -aside; x <= aside; ++x) {
          places.emplace_back(across * static_cast<float>(x), low + upwards * static_cast<float>(y),
                              first - inwards * static_cast<float>(z));
        }
      }
    }
    deepest_m = std::max(deepest_m, 1.5f * size_m - places.back().z);
    add_things(build, dice, places, size_m);
  }
  return deepest_m;
}

void add_market(Builder& build, Dice& dice, float back) {
  build.quad({-30, 0, 8}, {60, 0, 0}, {0, 0, -40}, wall_look(dice));
  build.quad({-20, 0, -back - 8}, {40, 0, 0}, {0, 9, 0}, wall_look(dice));
  for (int i = 0; i < 6; ++i) {
    const float x = dice.in(-4, 4), z = -back - dice.in(0, 5);
    Look awning = cloth_look(dice);
    awning.kind = Kind::stripes_along;
    awning.scale_m = 0.3f;
    build.quad({x - 1, 2.1f, z}, {2, 0, 0}, {0, 0.5f, -1.2f}, awning);
    build.box({x, 0.45f, z - 0.4f}, {1, 0.45f, 0.4f}, wall_look(dice));
    Piece& goods = build.piece(cloth_look(dice));
    for (int k = 0; k < 25; ++k)
      add_ball(goods, {x + dice.in(-0.9f, 0.9f), 0.95f, z - dice.in(0.1f, 0.7f)}, vec3(dice.in(0.04f, 0.1f)), mat3(1),
               4);
  }
}

/// What closes it off stands about `back` behind the people.
void add_place(Builder& build, Dice& dice, Place place, float back) {
  switch (place) {
    case Place::studio: {
      Look look = plain(any_color(dice));
      if (dice.chance(0.4f)) {
        look.kind = Kind::rough;
        look.scale_m = dice.in(0.3f, 1.5f);
        look.b = look.a * dice.in(0.5f, 0.9f);
        look.seed = dice.seed();
      }
      build.quad({-15, -1, -back}, {30, 0, 0}, {0, 12, 0}, look);
      build.quad({-15, 0, 6}, {30, 0, 0}, {0, 0, -6 - back}, look);
      break;
    }
    case Place::room:
      add_room(build, dice, back, false);
      break;
    case Place::library:
      add_room(build, dice, back, true);
      break;
    case Place::wall: {
      const float z = -0.35f - 0.4f * back * dice.unit();
      build.quad({-15, 0, z}, {30, 0, 0}, {0, 8, 0}, wall_look(dice));
      build.quad({-15, 0, 6}, {30, 0, 0}, {0, 0, -12}, wall_look(dice));
      if (dice.chance(0.3f)) build.box({dice.in(-1.5f, 1.5f), 1.2f, z}, {0.5f, 1.2f, 0.04f}, wall_look(dice));
      break;
    }
    case Place::garden:
      add_garden(build, dice, back);
      break;
    case Place::street:
      add_street(build, dice, back);
      break;
    case Place::painted:
      add_painted(build, dice, back);
      break;
    case Place::landscape:
      add_landscape(build, dice, back);
      break;
    case Place::night:
      add_lights_at_night(build, dice, back);
      break;
    case Place::jumble:
      add_ground(build, dice, back + 0.5f + 3 * kLargestInJumble_m);
      add_jumble(build, dice, back, 8 + dice.below(40));
      break;
    case Place::rows:
      add_ground(build, dice, add_rows(build, dice, back));
      break;
    case Place::mixed: {  // things before whatever closes an ordinary place off
      constexpr Place kOrdinary[] = {Place::studio, Place::room,      Place::garden,
                                     Place::street, Place::landscape, Place::painted};
      const float behind_m = back + (1.5f * kLargestInJumble_m + 0.7f);  // most of what comes at 0.4 back
      add_place(build, dice, kOrdinary[dice.below(static_cast<int>(std::size(kOrdinary)))], behind_m);
      if (dice.chance(0.6f)) add_rows(build, dice, 0.4f * back);
      add_jumble(build, dice, 0.4f * back, dice.below(16));
      break;
    }
    case Place::market:
      add_market(build, dice, back);
      break;
  }
}

}  // namespace

std::string add_surroundings(Stage& stage, Dice dice, float back_m) {
  constexpr const char* kNames[] = {"studio", "room",   "wall", "garden", "street", "painted", "landscape",
                                    "night",  "jumble", "rows", "mixed",  "market", "library"};
  static_assert(std::size(kNames) == kPlaces && static_cast<int>(Place::library) == kPlaces - 1);
  constexpr Place kStrange[] = {Place::painted, Place::jumble, Place::rows, Place::mixed, Place::mixed};
  const Place place = dice.strange() && dice.chance(0.6f) ? kStrange[dice.below(static_cast<int>(std::size(kStrange)))]
                                                          : static_cast<Place>(dice.choose(kPlaces, kReservedPlaces));
  Builder build(stage, dice);
  stage.dome.seed = dice.seed();
  add_place(build, dice, place, back_m);
  build.turn(0.22f * dice.normal());
  return std::string("place:") + kNames[static_cast<int>(place)];
}

std::string set_light(Stage& stage, Dice dice) {
  constexpr const char* kNames[] = {"overcast", "sun",  "sun behind", "window", "ceiling", "softbox",
                                    "flash",    "lamp", "neon",       "golden", "skylight"};
  const int index = dice.choose(kLights, kReservedLights);
  const float side = dice.sign(), turn = dice.in(0.2f, 1.3f), up = dice.in(0.25f, 1.1f);
  const auto towards = [](float around, float height) {
    return vec3(std::sin(around) * std::cos(height), std::sin(height), std::cos(around) * std::cos(height));
  };
  const vec3 sky = glm::mix(vec3(0.55f, 0.75f, 1.1f), vec3(0.9f, 0.95f, 1), dice.unit());
  const vec3 warm = glm::mix(vec3(1, 0.93f, 0.84f), vec3(1, 0.62f, 0.33f), dice.unit());
  Dome& dome = stage.dome;
  KeyLight& key = stage.key;
  key.direction = towards(side * turn, up);
  dome.lobe_direction = key.direction;
  dome.sky = true;
  const vec3 ground = vec3(0.35f, 0.32f, 0.28f) * dice.in(0.4f, 1.2f);
  switch (static_cast<Light>(index)) {
    case Light::overcast:
      dome.up = vec3(1.1f), dome.horizon = vec3(0.75f), dome.down = ground * 0.6f;
      key.irradiance = vec3(dice.in(0.05f, 0.25f)), key.spread = 0.3f;
      break;
    case Light::sun_side:
      dome.up = 0.4f * sky, dome.horizon = 0.6f * sky, dome.down = ground;
      key.irradiance = vec3(1.6f, 1.5f, 1.35f) * dice.in(0.6f, 1.2f), key.spread = 0.02f;
      break;
    case Light::sun_behind:
      dome.up = 0.6f * sky, dome.horizon = 0.8f * sky, dome.down = ground;
      key.direction = towards(side * dice.in(2, 3.1f), dice.in(0.3f, 1));
      dome.lobe_direction = key.direction, dome.lobe = vec3(1, 0.95f, 0.8f) * dice.in(0.5f, 3);
      key.irradiance = vec3(2, 1.85f, 1.6f), key.spread = 0.02f;
      break;
    case Light::window:
      dome.up = vec3(0.35f), dome.horizon = vec3(0.3f), dome.down = ground * 0.6f;
      key.direction = towards(side * dice.in(0.9f, 1.8f), dice.in(0.0f, 0.6f));
      dome.lobe_direction = key.direction, dome.lobe = vec3(1, 1, 1.05f) * dice.in(0.6f, 2);
      key.irradiance = vec3(0.9f, 0.95f, 1), key.spread = dice.in(0.1f, 0.35f);
      break;
    case Light::ceiling:
      dome.up = warm * 0.8f, dome.horizon = warm * 0.5f, dome.down = ground;
      key.direction = towards(side * dice.in(0, 2.5f), dice.in(0.9f, 1.4f));
      key.irradiance = warm * dice.in(0.3f, 0.9f), key.spread = dice.in(0.06f, 0.3f);
      break;
    case Light::softbox:
      dome.up = vec3(0.25f), dome.horizon = vec3(0.25f), dome.down = vec3(0.2f);
      key.irradiance = vec3(1), key.spread = dice.in(0.08f, 0.3f);
      break;
    case Light::flash:
      dome.up = dome.horizon = vec3(dice.in(0.05f, 0.2f)), dome.down = vec3(0.05f);
      key.direction = towards(side * dice.in(0, 0.12f), dice.in(0.0f, 0.2f));
      key.irradiance = vec3(1.1f), key.spread = 0.02f;
      break;
    case Light::lamp:
      dome.up = warm * 0.12f, dome.horizon = warm * 0.15f, dome.down = ground * 0.3f;
      key.direction = towards(side * dice.in(0.5f, 2), dice.in(-0.1f, 0.8f));
      key.irradiance = warm * 1.2f, key.spread = dice.in(0.05f, 0.3f);
      break;
    case Light::golden:
      dome.up = vec3(0.3f, 0.42f, 0.65f), dome.horizon = vec3(0.9f, 0.6f, 0.4f), dome.down = ground;
      key.direction = towards(side * dice.in(0.3f, 2.7f), dice.in(0.05f, 0.3f));
      dome.lobe_direction = key.direction, dome.lobe = vec3(1.5f, 0.9f, 0.4f);
      key.irradiance = vec3(1.6f, 1, 0.55f), key.spread = 0.04f;
      break;
    case Light::neon: {
      const vec3 one = any_color(dice) + 0.1f, two = any_color(dice) + 0.1f;
      dome.up = vec3(0.08f), dome.horizon = 0.3f * one, dome.down = vec3(0.05f);
      dome.lobe_direction = towards(-side * dice.in(0.8f, 2), 0.2f), dome.lobe = 2.0f * one, dome.lobe_sharpness = 2;
      key.irradiance = 1.5f * two, key.spread = 0.2f;
      break;
    }
    case Light::skylight:
      dome.up = vec3(1.6f, 1.6f, 1.7f), dome.horizon = vec3(0.2f), dome.down = ground * 0.8f;
      key.direction = towards(side, 1.35f);
      key.irradiance = vec3(0.5f), key.spread = 0.35f;
      break;
  }
  return std::string("light:") + kNames[index];
}

void add_clutter(Stage& stage, Dice dice, vec3 camera, float top_m) {
  Builder build(stage, dice);
  const float between = dice.in(0.25f, 0.6f);
  const vec3 at = camera * between;
  switch (dice.below(4)) {
    case 0: {  // the near edge of a table
      const float y = top_m - dice.in(0.02f, 0.12f);
      build.box({at.x, y - 0.02f, 0.35f + at.z * 0.5f}, {2.5f, 0.02f, std::max(at.z * 0.5f - 0.1f, 0.1f)},
                wall_look(dice));
      for (int i = 0; i < 3; ++i) {
        const vec3 half = dice.in3(0.02f, 0.06f);
        build.box({at.x + dice.in(-0.4f, 0.4f), y + half.y, 0.35f + at.z * dice.in(0.2f, 0.6f)}, half, cloth_look(dice),
                  dice.in(-1, 1));
      }
      break;
    }
    case 1:  // leaves from one side or below
      add_leaves(build.piece(leaves_look(dice)), dice,
                 {at.x + dice.sign() * dice.in(0.15f, 0.4f), top_m - dice.in(0.0f, 0.2f), at.z}, vec3(0.18f), 40,
                 0.09f);
      break;
    case 2: {  // rail
      const float y = top_m - dice.in(0.0f, 0.15f);
      const Look metal = plain(any_color(dice), 0.3f);
      add_tube(build.piece(metal), {{at.x - 3, y, at.z}, {at.x + 3, y, at.z}}, {0.02f, 0.02f}, 6);
      for (int i = -6; i < 7; ++i) {
        const float x = at.x + 0.14f * static_cast<float>(i);
        add_tube(build.piece(metal), {{x, 0, at.z}, {x, y, at.z}}, {0.007f, 0.007f}, 5);
      }
      break;
    }
    default:  // somebody's shoulder, a cushion, a dog's back
      add_ball(build.piece(cloth_look(dice)),
               {at.x + dice.sign() * dice.in(0.15f, 0.4f), top_m - dice.in(0.12f, 0.3f), at.z},
               vec3(0.17f, 0.14f, 0.1f), mat3(1), 12);
  }
}

}  // namespace dualpixel::scenes
