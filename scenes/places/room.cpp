#include "scenes/places/room.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/places/furniture.h"

namespace dualpixel::scenes {
namespace {

using glm::vec2;
using glm::vec3;

constexpr float kRight = 1.5707963f;

Surface wall_surface(RandomStream& rng) {
  const float kind = rng.uniform();
  const vec3 color = glm::mix(vec3(0.6f, 0.58f, 0.54f), glm::max(paint_color(rng), vec3(0.08f)), rng.uniform(0, 0.7f));
  if (kind < 0.5f) return rough_surface(rng.substream(70), color, rng.uniform(0.02f, 0.06f), 2, 1.5f);  // bare
  if (kind < 0.65f) return brick_surface(rng.substream(70), vec3(0.36f, 0.15f, 0.09f) * rng.uniform(0.7f, 1.6f));
  if (kind < 0.82f)
    return tile_surface(rng.substream(70), glm::mix(color, vec3(0.65f), 0.5f), vec3(0.4f),
                        vec2(rng.uniform(0.08f, 0.2f)), 0.05f);
  // wallpaper: a motif that repeats
  const vec3 print = glm::mix(color, paint_color(rng), 0.4f);
  const int repeats = 3 + rng.below(8);
  const PinkNoise motif(rng.seed(), 2, 16, 1.6f), paper(rng.seed(), 4, 512, 1.3f);
  Surface surface;
  surface.repeat_m = 1.2f;
  surface.texture = paint(1024, [&](float u, float v) {
    const float n = static_cast<float>(repeats), x = 2 * std::abs(u * n - std::floor(u * n) - 0.5f);
    const bool inside = motif(0.5f * x, v * n - std::floor(v * n)) > 0.35f;
    return shaded(inside ? print : color, 0.03f, paper(u, v));
  });
  return surface;
}

/// The opening to the room beyond, in the back wall: its sides and its top.
struct Opening {
  float left, right, top;
};

Opening opening_of(const RoomOptions& room) {
  const float half = 0.5f * std::clamp(0.4f * room.wide_m, 0.9f, 2.0f);
  return {-half, half, 2.1f};
}

void add_back_wall(Mesh& wall, const RoomOptions& room) {
  const auto add = [&](float left, float right, float bottom) {
    const vec2 size(right - left, room.high_m - bottom);
    wall.add_quad({left, bottom, -room.deep_m}, {size.x, 0, 0}, {0, size.y, 0}, size);
  };
  const float half = 0.5f * room.wide_m;
  if (room.beyond_m == 0) return add(-half, half, 0);
  const Opening opening = opening_of(room);
  add(-half, opening.left, 0);
  add(opening.right, half, 0);
  add(opening.left, opening.right, opening.top);
}

void add_shell(SceneBuilder& build, RandomStream rng, const RoomOptions& room) {
  const float half = 0.5f * room.wide_m, length = room.deep_m + kRoomBehind_m;
  Mesh back, sides, floor, ceiling, boards;
  add_back_wall(back, room);
  sides.add_quad({-half, 0, kRoomBehind_m}, {0, 0, -length}, {0, room.high_m, 0}, {length, room.high_m});
  sides.add_quad({half, 0, -room.deep_m}, {0, 0, length}, {0, room.high_m, 0}, {length, room.high_m});
  sides.add_quad({half, 0, kRoomBehind_m}, {-2 * half, 0, 0}, {0, room.high_m, 0}, {2 * half, room.high_m});
  floor.add_quad({-half, 0, kRoomBehind_m}, {2 * half, 0, 0}, {0, 0, -length}, {2 * half, length});
  ceiling.add_quad({-half, room.high_m, -room.deep_m}, {2 * half, 0, 0}, {0, 0, length}, {2 * half, length});
  if (room.beyond_m == 0) add_solid_box(boards, {0, 0.05f, -room.deep_m + 0.008f}, {half, 0.05f, 0.008f}, 0.003f);
  for (const float s : {-1.0f, 1.0f})
    add_solid_box(boards, {s * (half - 0.008f), 0.05f, 0.5f * (kRoomBehind_m - room.deep_m)},
                  {0.008f, 0.05f, 0.5f * length}, 0.003f);
  const Surface accent = wall_surface(rng);
  build.add("back wall", back, accent);
  RandomStream other = rng.substream(9);
  build.add("walls", sides, rng.chance(0.6f) ? accent : rough_surface(other, vec3(0.6f, 0.58f, 0.54f), 0.03f, 2, 1.5f));
  build.add("floor", floor,
            rng.chance(0.65f) ? wood_surface(rng.substream(3), wood_color(rng), rng.uniform(0.08f, 0.18f), 1.4f)
                              : tile_surface(rng.substream(3), vec3(0.4f, 0.36f, 0.3f) * rng.uniform(0.6f, 1.4f),
                                             vec3(0.15f), vec2(rng.uniform(0.2f, 0.4f)), 0.12f));
  build.add("ceiling", ceiling, rough_surface(rng.substream(4), vec3(0.68f), 0.02f, 2, 1.4f));
  build.add("skirting", boards, plain_surface(rng.substream(5), vec3(0.6f), 0.5f));
  if (rng.chance(0.7f)) {
    const float w = rng.uniform(0.8f, 1.4f), d = rng.uniform(0.6f, 1.1f), z = -0.5f * room.deep_m;
    Mesh rug;
    add_sheet(rug, 40, 40, {2 * w, 2 * d},
              [&](float u, float v) { return vec3((2 * u - 1) * w, 0.008f, z + (2 * v - 1) * d); });
    build.add("rug", rug,
              woven_surface(rng.substream(6), paint_color(rng), paint_color(rng), rng.uniform(0.004f, 0.01f)));
  }
}

/// A window as a sheet of daylight with bars before it; `pose`: its middle, the room at +z.
void add_window_at(SceneBuilder& build, RandomStream rng, const glm::mat4& pose, vec2 half, float nits) {
  Mesh pane, frame;
  pane.add_quad({-half.x, -half.y, 0.004f}, {2 * half.x, 0, 0}, {0, 2 * half.y, 0});
  for (const float s : {-1.0f, 1.0f}) {
    add_solid_box(frame, {s * half.x, 0, 0.03f}, {0.04f, half.y + 0.04f, 0.03f}, 0.006f);
    add_solid_box(frame, {0, s * half.y, 0.03f}, {half.x, 0.04f, 0.03f}, 0.006f);
  }
  const int columns = 1 + rng.below(3);
  for (int i = 1; i < columns; ++i)
    add_solid_box(frame, {(2 * static_cast<float>(i) / static_cast<float>(columns) - 1) * half.x, 0, 0.025f},
                  {0.02f, half.y, 0.02f}, 0.004f);
  if (rng.chance(0.5f)) add_solid_box(frame, {0, 0.2f * half.y, 0.025f}, {half.x, 0.02f, 0.02f}, 0.004f);
  add_solid_box(frame, {0, -half.y - 0.06f, 0.1f}, {half.x + 0.08f, 0.015f, 0.1f}, 0.004f);
  build.add(
      "window", placed_mesh(pane, pose),
      nits > 0 ? glowing_surface(nits * vec3(0.9f, 1, 1.14f)) : plain_surface(rng.substream(1), vec3(0.02f), 0.05f));
  build.add("window frame", placed_mesh(frame, pose), plain_surface(rng.substream(2), vec3(0.62f), 0.5f));
  const int dress = rng.below(3);
  if (dress == 0)
    add_blinds(build, rng.substream(3), pose * glm::translate(glm::mat4(1), vec3(-half.x, half.y, 0.09f)), 2 * half.x,
               2 * half.y * rng.uniform(0.4f, 1));
  if (dress == 1) {
    for (const float s : {-1.0f, 1.0f}) {
      const float wide = 0.45f * half.x + 0.15f;
      add_curtain(
          build, rng.substream(4),
          pose * glm::translate(glm::mat4(1), vec3(s > 0 ? half.x - 0.2f * half.x : -half.x - wide + 0.2f * half.x,
                                                   half.y + 0.12f, 0.14f)),
          wide, 2 * half.y + 0.5f);
    }
  }
}

struct Spot {
  glm::mat4 pose;
  bool against_wall;
};

/// Places along the walls, the farthest first, and in the middle.
std::vector<Spot> spots(RandomStream& rng, const RoomOptions& room) {
  const float half = 0.5f * room.wide_m;
  std::vector<Spot> all;
  const int across = std::max(static_cast<int>(room.wide_m / 1.6f), 1);
  for (int i = 0; i < across; ++i) {
    const float x = ((static_cast<float>(i) + 0.5f) / static_cast<float>(across) * 2 - 1) * (half - 0.3f);
    if (room.beyond_m > 0 && std::abs(x) < opening_of(room).right + 0.6f) continue;
    all.push_back({standing({x, 0, -room.deep_m + 0.32f}, 0.03f * rng.normal()), true});
  }
  for (float z = -room.deep_m + 1.6f; z < -1.2f; z += 1.5f) {
    for (const float s : {-1.0f, 1.0f}) all.push_back({standing({s * (half - 0.32f), 0, z}, -s * kRight), true});
  }
  if (!room.clear_middle)
    all.push_back({standing({0.3f * half * rng.normal(), 0, -0.55f * room.deep_m}, rng.uniform(-0.4f, 0.4f)), false});
  return all;
}

void add_piece(SceneBuilder& build, RandomStream rng, const Spot& spot, float nits) {
  if (!spot.against_wall) {
    add_dining_table(build, rng.substream(1), spot.pose);
    for (int i = 0; i < 4; ++i) {
      if (!rng.chance(0.75f)) continue;
      const float side = i % 2 == 0 ? 1.0f : -1.0f, x = i < 2 ? -0.35f : 0.35f;
      add_chair(build, rng.substream(9),
                spot.pose * standing({x, 0, side * 0.55f}, (side > 0 ? 2 * kRight : 0.0f) + 0.2f * rng.normal()));
    }
    return;
  }
  const glm::mat4 close = spot.pose * glm::translate(glm::mat4(1), vec3(0, 0, -0.14f));
  switch (rng.below(6)) {
    case 0:
    case 1:
      return add_bookcase(build, rng.substream(1), close);
    case 2:
      return add_sofa(build, rng.substream(1), spot.pose * glm::translate(glm::mat4(1), vec3(0, 0, 0.18f)));
    case 3:
      add_cupboard(build, rng.substream(1), close);
      return add_wall_picture(build, rng.substream(2), spot.pose * glm::translate(glm::mat4(1), vec3(0, 1.6f, -0.31f)));
    case 4:
      return rng.chance(0.5f) ? add_floor_plant(build, rng.substream(1), spot.pose)
                              : add_floor_lamp(build, rng.substream(1), spot.pose, nits);
    default:
      add_chair(build, rng.substream(1), spot.pose * glm::translate(glm::mat4(1), vec3(0, 0, 0.1f)));
      return add_wall_picture(build, rng.substream(2),
                              spot.pose * glm::translate(glm::mat4(1), vec3(0, 1.55f, -0.31f)));
  }
}

/// The second room: its walls, the jambs of the opening, a window of its own or a lamp, something at its end.
void add_room_beyond(SceneBuilder& build, RandomStream rng, const RoomOptions& room, float lamp_nits, float day_nits) {
  const float half = 0.5f * room.wide_m, from = -room.deep_m - 0.12f, length = room.beyond_m;
  const Opening opening = opening_of(room);
  Mesh walls, floor, ceiling, jambs;
  walls.add_quad({-half, 0, from - length}, {2 * half, 0, 0}, {0, room.high_m, 0}, {2 * half, room.high_m});
  walls.add_quad({-half, 0, from}, {0, 0, -length}, {0, room.high_m, 0}, {length, room.high_m});
  walls.add_quad({half, 0, from - length}, {0, 0, length}, {0, room.high_m, 0}, {length, room.high_m});
  walls.add_quad({opening.right, 0, from}, {half - opening.right, 0, 0}, {0, room.high_m, 0}, {1, room.high_m});
  walls.add_quad({-half, 0, from}, {half + opening.left, 0, 0}, {0, room.high_m, 0}, {1, room.high_m});
  walls.add_quad({opening.left, opening.top, from}, {opening.right - opening.left, 0, 0},
                 {0, room.high_m - opening.top, 0}, {1, 0.5f});
  floor.add_quad({-half, 0, from + 0.12f}, {2 * half, 0, 0}, {0, 0, -length - 0.12f}, {2 * half, length});
  ceiling.add_quad({-half, room.high_m, from - length}, {2 * half, 0, 0}, {0, 0, length}, {2 * half, length});
  for (const float x : {opening.left, opening.right})
    add_solid_box(jambs, {x, 0.5f * opening.top, from + 0.06f}, {0.03f, 0.5f * opening.top, 0.08f}, 0.004f);
  add_solid_box(jambs, {0, opening.top, from + 0.06f}, {opening.right + 0.03f, 0.03f, 0.08f}, 0.004f);
  build.add("walls beyond", walls, wall_surface(rng));
  build.add("floor beyond", floor, wood_surface(rng.substream(1), wood_color(rng), rng.uniform(0.08f, 0.18f), 1.4f));
  build.add("ceiling", ceiling, rough_surface(rng.substream(2), vec3(0.68f), 0.02f, 2, 1.4f));
  build.add("jambs", jambs, plain_surface(rng.substream(3), vec3(0.62f), 0.5f));
  const float side = rng.sign();
  add_window_at(build, rng.substream(4),
                standing({side * (half - 0.002f), 1.45f, from - 0.5f * length}, -side * kRight),
                {std::min(0.6f, 0.3f * length), 0.65f}, day_nits);
  if (lamp_nits > 0) add_pendant(build, rng.substream(5), {0, 1.9f, from - 0.5f * length}, room.high_m, lamp_nits);
  const float at = opening.right * rng.uniform(-0.7f, 0.7f);
  add_piece(build, rng.substream(6), {standing({at, 0, from - length + 0.32f}, 0.03f * rng.normal()), true}, lamp_nits);
}

}  // namespace

void furnish_room(SceneBuilder& build, RandomStream rng, const RoomOptions& room) {
  const bool lamps = room.light == "lamps";
  const float nits = lamps ? room.lamp_strength * rng.uniform(9000, 22000) : 0.0f,
              day = lamps ? 0.0f : rng.uniform(2500, 7000);
  build.ambient(lamps ? vec3(0.6f * room.lamp_strength) : vec3(0.004f * day));
  build.scene["render"]["max_bounces"] = 2;
  build.scene["render"]["light_samples"] = 256;
  add_shell(build, rng.substream(1), room);
  RandomStream at = rng.substream(2);
  const float half = 0.5f * room.wide_m, side = at.sign();
  const int windows = 1 + at.below(2);
  for (int i = 0; i < windows; ++i) {
    const float z = -room.deep_m * (0.25f + 0.5f * static_cast<float>(i)) + 0.3f * at.normal();
    add_window_at(build, rng.substream(10 + i), standing({side * (half - 0.002f), 1.45f, z}, -side * kRight),
                  {at.uniform(0.4f, 0.7f), at.uniform(0.5f, 0.75f)}, day);
  }
  add_window_at(build, rng.substream(13),
                standing({side * (half - 0.002f), 1.5f, at.uniform(0.6f, 1.2f)}, -side * kRight),
                {at.uniform(0.5f, 0.8f), at.uniform(0.6f, 0.8f)}, day);  // beside or behind the camera
  if (lamps)
    add_pendant(build, rng.substream(24), {-0.4f * side * half, 1.95f, at.uniform(0.4f, 1.2f)}, room.high_m, nits);
  if (room.beyond_m > 0) {
    add_room_beyond(build, rng.substream(25), room, nits, day);
  } else if (at.chance(0.35f)) {
    add_window_at(build, rng.substream(12), standing({half * at.uniform(-0.4f, 0.4f), 1.45f, -room.deep_m + 0.002f}, 0),
                  {at.uniform(0.4f, 0.7f), at.uniform(0.5f, 0.7f)}, day);
  }
  std::vector<Spot> places = spots(at, room);
  std::vector<std::size_t> order(places.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  for (std::size_t i = order.size(); i > 1; --i)
    std::swap(order[i - 1], order[static_cast<std::size_t>(at.below(static_cast<int>(i)))]);
  for (std::size_t i = 0; i < order.size() && static_cast<int>(i) < room.furniture; ++i)
    add_piece(build, rng.substream(30 + order[i]), places[order[i]], nits);
  if (lamps || at.chance(0.5f))
    add_pendant(build, rng.substream(20), {0.2f * half * at.normal(), at.uniform(1.7f, 2.0f), -0.55f * room.deep_m},
                room.high_m, nits);
  if (lamps)
    add_floor_lamp(build, rng.substream(21), standing({-side * (half - 0.35f), 0, -room.deep_m + 0.45f}, 0), nits);
  if (room.mirror) {
    add_mirror(build, rng.substream(22), standing({0, 1.4f, -room.deep_m + 0.003f}, 0), {0.55f, 0.75f});
    add_glass_screen(build, rng.substream(23), standing({0.35f, 0, -0.55f * room.deep_m}, 0), {0.4f, 0.65f});
  }
  build.shooting.key = lamps ? 0.09f : 0.14f;
  build.shooting.most_clipped = 0.15f;  // windows
}

void add_near_furniture(SceneBuilder& build, RandomStream rng, const RoomOptions& room, vec3 eye, vec3 target) {
  constexpr float kHalfView = 0.43f;  // of the picture's width over the distance
  const vec2 ahead = glm::normalize(vec2(target.x - eye.x, target.z - eye.z)), right(-ahead.y, ahead.x);
  const float nits = room.light == "lamps" ? 9000 * room.lamp_strength : 0.0f, first = rng.sign();
  const int pieces = 1 + rng.below(2);
  for (int i = 0; i < pieces; ++i) {
    RandomStream own = rng.substream(i);
    const float kind = own.uniform(), side = i == 0 ? first : -first;
    const bool low = kind < 0.5f;  // tables and chairs: seen farther away, under the horizon
    const float away = low ? own.uniform(1.3f, 2.0f) : own.uniform(0.9f, 1.4f);
    const vec2 at = vec2(eye.x, eye.z) + away * ahead + side * away * kHalfView * own.uniform(0.55f, 0.9f) * right;
    if (std::abs(at.x) > 0.5f * room.wide_m - 0.3f || -at.y > room.deep_m - 0.7f) continue;
    const glm::mat4 pose = standing({at.x, 0, at.y}, own.uniform(-0.6f, 0.6f));
    if (kind < 0.3f) {
      add_dining_table(build, own.substream(1), pose);
    } else if (low) {
      add_chair(build, own.substream(1), pose * standing(vec3(0), own.uniform(0, 6)));
    } else if (kind < 0.85f) {
      add_floor_plant(build, own.substream(1), pose);
    } else {
      add_floor_lamp(build, own.substream(1), pose, 0.3f * nits);
    }
  }
}

}  // namespace dualpixel::scenes
