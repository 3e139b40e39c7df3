#include <fmt/format.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/kinds/kinds.h"
#include "scenes/math.h"
#include "scenes/shapes/solids.h"
#include "scenes/test_targets/test_targets.h"
#include "scenes/textures/lettering.h"

/// Test charts: they glow by themselves, so that what is measured at them is the camera.
namespace dualpixel::scenes {
namespace {

using glm::vec2;
using glm::vec3;
using Type = Parameter::Type;

/// Half of what the widest view shows at 1 m, and some more: 5.64 mm behind 4.2 mm.
constexpr float kHalfView = 0.75f;

Surface ink(vec3 color) { return {.color = color, .unlit = true}; }

/// A white card that fills the picture at distance z, and marks in front of it on the same plane.
void add_card(SceneBuilder& build, float z, vec3 color) {
  const float half = kHalfView * z;
  Mesh card;
  card.add_quad({-half, -half, -z * 1.0001f}, {2 * half, 0, 0}, {0, 2 * half, 0});
  build.add("card", card, ink(color));
}

void add_star(SceneBuilder& build, float z, int cycles, float contrast) {
  const float dark = 0.8f * (1 - contrast) / (1 + contrast);
  add_card(build, z, vec3(0.8f));
  Mesh spokes;
  const float radius = 0.3f * z;
  for (const vec2 middle : {vec2(0), vec2(-1, -1), vec2(1, -1), vec2(-1, 1), vec2(1, 1)}) {
    const float r = middle == vec2(0) ? radius : 0.4f * radius;
    const vec3 center(0.38f * z * middle.x, 0.27f * z * middle.y, -z);
    for (int i = 0; i < cycles; ++i) {
      const float a = 2 * kPi * static_cast<float>(i) / static_cast<float>(cycles),
                  b = a + kPi / static_cast<float>(cycles);
      const auto first = static_cast<unsigned>(spokes.positions.size());
      for (const vec3 p :
           {center, center + r * vec3(std::cos(a), std::sin(a), 0), center + r * vec3(std::cos(b), std::sin(b), 0)})
        spokes.positions.push_back(p);
      spokes.triangles.push_back({first, first + 1, first + 2});
    }
  }
  build.add("spokes", spokes, ink(vec3(dark)));
}

/// Squares turned by 5 degrees, as ISO 12233's edge chart has them, at a contrast of `contrast` (Michelson).
void add_slanted_squares(SceneBuilder& build, float z, float contrast) {
  const float dark = 0.6f * (1 - contrast) / (1 + contrast);
  add_card(build, z, vec3(0.6f));
  Mesh squares;
  const float step = 0.2f * z, half = 0.28f * step, turn = 5 * kPi / 180;
  const vec3 a = half * vec3(std::cos(turn), std::sin(turn), 0), b = half * vec3(-std::sin(turn), std::cos(turn), 0);
  for (int row = -3; row <= 3; ++row) {
    for (int column = -3; column <= 3; ++column) {
      const vec3 middle(step * static_cast<float>(column), step * static_cast<float>(row), -z);
      squares.add_quad(middle - a - b, 2.0f * a, 2.0f * b);
    }
  }
  squares.uvs.clear();
  build.add("squares", squares, ink(vec3(dark)));
}

/// Four rows of six: hues at two strengths, and grays from .9 to .03 in equal ratios.
void add_color_patches(SceneBuilder& build, float z) {
  add_card(build, z, vec3(0.04f));
  const float step = 0.14f * z, half = 0.44f * step;
  for (int i = 0; i < 24; ++i) {
    const int row = i / 6, column = i % 6;
    const vec3 middle(step * (static_cast<float>(column) - 2.5f), step * (1.5f - static_cast<float>(row)), -z);
    vec3 color = vec3(0.9f * std::pow(0.033f, static_cast<float>(column) / 5));
    if (row < 3) {
      const float phase = 2 * kPi * (static_cast<float>(column) / 6 + 0.08f * static_cast<float>(row));
      const float strength = row == 0   ? 0.85f
                             : row == 1 ? 0.5f
                                        : 0.3f,
                  value = row == 0   ? 0.3f
                          : row == 1 ? 0.35f
                                     : 0.15f;
      for (int c = 0; c < 3; ++c)
        color[c] = value * (1 + strength * std::cos(phase - 2 * kPi * static_cast<float>(c) / 3));
    }
    Mesh patch;
    patch.add_quad(middle - vec3(half, half, 0), {2 * half, 0, 0}, {0, 2 * half, 0});
    build.add("patch", patch, ink(color));
  }
}

/// Cards side by side, each farther by the same ratio, from half to three times the distance.
void add_ladder(SceneBuilder& build, RandomStream rng, float z) {
  constexpr int kCards = 12;
  for (int i = 0; i < kCards; ++i) {
    const float at = 0.5f * z * std::pow(6.0f, static_cast<float>(i) / (kCards - 1));
    const float left = (static_cast<float>(i) / kCards - 0.5f) * 0.8f * at, wide = 0.8f * at / kCards * 1.02f;
    const PinkNoise grain(rng.seed(), 2, 128, 1.0f, 1, 8);
    const std::string label = fmt::format("{:.0f}", 100 * at);
    Surface print{.repeat_m = 1, .unlit = true};
    print.texture = paint(512, [&](float u, float v) {
      // a card is ten times as high as wide; its label stands in the middle, and its tone differs from its neighbors'
      const float height = 0.7f / line_width(label), x = (u - 0.15f) / height, y = (v - 0.5f) * 10 / height;
      return glm::mix(shaded(vec3(i % 2 == 0 ? 0.34f : 0.22f), 0.35f, grain(u, v)), vec3(0.02f),
                      ink_at(label, x, y, 0.18f));
    });
    Mesh card;
    card.add_quad({left, -5 * wide, -at}, {wide, 0, 0}, {0, 10 * wide, 0});
    build.add("card", card, print);
  }
  add_card(build, 4 * z, vec3(0.12f));
}

void build_chart(SceneBuilder& build, const Parameters& p, RandomStream rng) {
  const std::string& pattern = p.choice("pattern");
  const float z = p.real("distance_m"), contrast = p.real("contrast");
  build.scene["unlit_white_nits"] = 500;
  build.scene["render"]["max_bounces"] = 0;
  build.shooting.focus_m = z;
  build.shooting.clear_m = 0.3f * z;
  if (pattern == "target" || pattern == "planes" || pattern == "edges") {
    if (pattern == "target") add_calibration_target(build.glb);
    if (pattern == "planes") add_slanted_planes(build.glb);
    if (pattern == "edges") add_occlusion_edges(build.glb);
    build.shooting.focus_m = pattern == "target" ? 0.95f : 0.8f;
    build.shooting.clear_m = 0.1f;
    return;
  }
  if (pattern == "siemens_star") add_star(build, z, p.integer("cycles"), contrast);
  if (pattern == "slanted_edge") add_slanted_squares(build, z, contrast);
  if (pattern == "color_chart") add_color_patches(build, z);
  if (pattern == "focus_ladder") add_ladder(build, rng.substream(1), z);
  build.camera({0, 0, 0}, {0, 0, -1});
}

}  // namespace

SceneKind chart_kind() {
  return {
      "chart",
      "test charts that glow evenly, square to the camera",
      {{"pattern",
        "",
        Type::number,
        0,
        0,
        0,
        0,
        "target, planes and edges are the shipped scenes' (at their own distances)",
        {"siemens_star", "slanted_edge", "color_chart", "focus_ladder", "target", "planes", "edges"}},
       {"distance_m", "m", Type::logarithmic, 0.1, 20, 0.4, 2, "to the chart; of focus_ladder: to the card in focus"},
       {"contrast", "", Type::number, 0.05, 0.98, 0.6, 0.95,
        "Michelson contrast of siemens_star and slanted_edge; 0.6: ISO 12233's 4 : 1"},
       {"cycles", "", Type::integer, 4, 288, 72, 72, "of siemens_star"}},
      build_chart,
      [](const Parameters&) { return simulator::EnvironmentModel::none; },
      {"pattern", {"target", "planes", "edges"}}};
}

}  // namespace dualpixel::scenes
