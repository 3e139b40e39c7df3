#include "scenes/textures/lettering.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace dualpixel::scenes {
namespace {

using glm::vec2;
using glm::vec3;

/// Each letter's strokes on a grid of 3 columns (a b c) by 5 rows (0 .. 4, from the top): pairs of points that a line
/// joins, such as "a4b0" from the lower left to the top's middle.
const char* strokes_of(char letter) {
  switch (letter) {
    case 'A':
      return "a4b0b0c4a3c3";
    case 'B':
      return "a0a4a0b0b0c1c1b2a2b2b2c3c3b4b4a4";
    case 'C':
      return "c0b0b0a1a1a3a3b4b4c4";
    case 'D':
      return "a0a4a0b0b0c1c1c3c3b4b4a4";
    case 'E':
      return "a0a4a0c0a2b2a4c4";
    case 'F':
      return "a0a4a0c0a2b2";
    case 'G':
      return "c0b0b0a1a1a3a3b4b4c4c4c2c2b2";
    case 'H':
      return "a0a4c0c4a2c2";
    case 'I':
      return "b0b4a0c0a4c4";
    case 'J':
      return "c0c3c3b4b4a3";
    case 'K':
      return "a0a4a2c0a2c4";
    case 'L':
      return "a0a4a4c4";
    case 'M':
      return "a4a0a0b2b2c0c0c4";
    case 'N':
      return "a4a0a0c4c4c0";
    case 'O':
      return "b0a1a1a3a3b4b4c3c3c1c1b0";
    case 'P':
      return "a0a4a0b0b0c1c1b2b2a2";
    case 'Q':
      return "b0a1a1a3a3b4b4c3c3c1c1b0b3c4";
    case 'R':
      return "a0a4a0b0b0c1c1b2b2a2b2c4";
    case 'S':
      return "c0b0b0a1a1c3c3b4b4a4";
    case 'T':
      return "a0c0b0b4";
    case 'U':
      return "a0a3a3b4b4c3c3c0";
    case 'V':
      return "a0b4b4c0";
    case 'W':
      return "a0a4a4b2b2c4c4c0";
    case 'X':
      return "a0c4c0a4";
    case 'Y':
      return "a0b2c0b2b2b4";
    case 'Z':
      return "a0c0c0a4a4c4";
    case '0':
      return "b0a1a1a3a3b4b4c3c3c1c1b0";
    case '1':
      return "a1b0b0b4a4c4";
    case '2':
      return "a1b0b0c1c1a4a4c4";
    case '3':
      return "a0c0c0b2b2c3c3b4b4a4";
    case '4':
      return "b0a3a3c3b0b4";
    case '5':
      return "c0a0a0a2a2b2b2c3c3b4b4a4";
    case '6':
      return "c0a2a2a3a3b4b4c3c3b2b2a2";
    case '7':
      return "a0c0c0a4";
    case '8':
      return "b0a1a1b2b2c3c3b4b4a3a3b2b2c1c1b0";
    case '9':
      return "c2b2b2a1a1b0b0c1c1c2c2b4";
    default:
      return "";
  }
}

constexpr float kAdvance = 0.82f;  ///< from one letter to the next, in heights of a capital

vec2 grid_point(const char* at) {
  return {0.28f * static_cast<float>(at[0] - 'a') + 0.07f, 0.25f * static_cast<float>(at[1] - '0')};
}

float distance_to_segment(vec2 p, vec2 a, vec2 b) {
  const vec2 ab = b - a;
  const float t = std::clamp(glm::dot(p - a, ab) / std::max(glm::dot(ab, ab), 1e-9f), 0.0f, 1.0f);
  return glm::length(p - a - t * ab);
}

std::string random_word(RandomStream& rng) {
  static const char* const kHeads[] = {"B", "C", "D", "F", "G", "H", "L",  "M",  "N",
                                       "P", "R", "S", "T", "V", "W", "ST", "TR", "CH"};
  static const char* const kMiddles[] = {"A", "E", "I", "O", "U", "EA", "OU", "AR", "ER", "IN", "ON"};
  std::string word;
  const int syllables = 1 + rng.below(3);
  for (int i = 0; i < syllables; ++i) {
    word += kHeads[rng.below(std::size(kHeads))];
    word += kMiddles[rng.below(std::size(kMiddles))];
  }
  if (rng.chance(0.4f)) word += "NSTDLK"[rng.below(6)];
  return word;
}

/// A line of text in a picture: top left corner and height of a capital, in u, v.
struct Line {
  std::string text;
  vec2 at;
  float height;
};

/// The darkest of the lines at a point. Lines lie in order from the top.
float ink_of(const std::vector<Line>& lines, float u, float v, float stroke) {
  float ink = 0;
  for (const Line& line : lines) {
    const float x = (u - line.at.x) / line.height, y = (v - line.at.y) / line.height;
    if (y < -0.2f || y > 1.2f || x < -0.2f || x > line_width(line.text) + 0.2f) continue;
    ink = std::max(ink, ink_at(line.text, x, y, stroke));
  }
  return ink;
}

}  // namespace

float line_width(const std::string& text) { return kAdvance * static_cast<float>(text.size()); }

float ink_at(const std::string& text, float x, float y, float stroke) {
  const int index = static_cast<int>(std::floor(x / kAdvance));
  if (index < 0 || index >= static_cast<int>(text.size())) return 0;
  const vec2 p(x - kAdvance * static_cast<float>(index), y);
  float nearest = 1;
  for (const char* s = strokes_of(text[static_cast<std::size_t>(index)]); *s != '\0'; s += 4) {
    nearest = std::min(nearest, distance_to_segment(p, grid_point(s), grid_point(s + 2)));
  }
  return std::clamp((0.5f * stroke - nearest) / 0.05f + 0.5f, 0.0f, 1.0f);
}

std::vector<std::string> random_text(RandomStream& rng, int lines, int letters) {
  std::vector<std::string> text;
  for (int i = 0; i < lines; ++i) {
    std::string line = random_word(rng);
    for (;;) {
      const std::string word = random_word(rng);
      if (static_cast<int>(line.size() + word.size()) + 1 > letters) break;
      line += ' ' + word;
    }
    text.push_back(line.substr(0, static_cast<std::size_t>(letters)));
  }
  return text;
}

Surface page_surface(RandomStream rng, float width_m) {
  const int columns = 1 + rng.below(3);
  const float margin = 0.07f, gap = 0.04f;
  const float column = (1 - 2 * margin - gap * static_cast<float>(columns - 1)) / static_cast<float>(columns);
  const float height = std::clamp(column / (kAdvance * static_cast<float>(16 + rng.below(16))), 0.006f, 0.03f);
  std::vector<Line> large, small;
  large.push_back({random_text(rng, 1, 14).front(), {margin, 0.06f}, 0.0f});
  large.back().height = std::min(0.09f, (1 - 2 * margin) / line_width(large.back().text));
  const float top = 0.1f + large.back().height;
  const float picture_height = rng.chance(0.6f) ? rng.uniform(0.15f, 0.35f) : 0;
  const int in_column = rng.below(columns);
  for (int c = 0; c < columns; ++c) {
    const float x = margin + static_cast<float>(c) * (column + gap);
    const float from = top + (c == in_column && picture_height > 0 ? picture_height + 0.03f : 0);
    const int lines = static_cast<int>((0.94f - from) / (1.7f * height));
    const std::vector<std::string> text =
        random_text(rng, std::max(lines, 1), static_cast<int>(column / (kAdvance * height)));
    for (std::size_t i = 0; i < text.size(); ++i) {
      small.push_back({text[i], {x, from + 1.7f * height * static_cast<float>(i)}, height});
    }
  }
  const vec3 paper = vec3(0.78f, 0.76f, 0.7f) * rng.uniform(0.8f, 1.02f), tone = paint_color(rng);
  const PinkNoise fiber(rng.seed(), 4, 512, 1.2f), photo(rng.seed(), 2, 256, 1.2f);
  const float left = margin + static_cast<float>(in_column) * (column + gap);
  Surface surface;
  surface.repeat_m = width_m;
  surface.texture = paint(1024, [&](float u, float v) {
    const vec3 blank = shaded(paper, 0.025f, fiber(u, v));
    if (picture_height > 0 && u > left && u < left + column && v > top && v < top + picture_height) {
      return glm::mix(vec3(0.03f), tone, std::clamp(0.5f + 0.22f * photo(u, v), 0.0f, 1.0f));
    }
    const float ink = std::max(ink_of(large, u, v, 0.17f), ink_of(small, u, v, 0.15f));
    return glm::mix(blank, vec3(0.035f), ink);
  });
  return surface;
}

Surface cover_surface(RandomStream rng, vec3 color, const std::string& title) {
  const vec3 second = paint_color(rng);
  const bool dark = glm::dot(color, vec3(0.33f)) < 0.22f;
  const vec3 ink = dark ? vec3(0.7f, 0.66f, 0.55f) : vec3(0.03f);
  const float height = std::min(0.16f, 0.84f / line_width(title)), band = rng.uniform(0.45f, 0.75f),
              wide = rng.uniform(0.03f, 0.3f);
  const std::vector<Line> lines = {{title, {0.08f, rng.uniform(0.1f, 0.3f)}, height},
                                   {random_text(rng, 1, 16).front(), {0.1f, 0.88f}, 0.045f}};
  const PinkNoise wear(rng.seed(), 2, 128, 1.3f), art(rng.seed(), 2, 128, 1.5f);
  Surface surface;
  surface.roughness = rng.uniform(0.4f, 0.9f);
  surface.texture = paint(256, [&](float u, float v) {
    vec3 paper = color;
    if (v > band && v < band + wide) paper = glm::mix(second, color, std::clamp(0.35f + 0.3f * art(u, v), 0.0f, 1.0f));
    return shaded(glm::mix(paper, ink, ink_of(lines, u, v, 0.16f)), 0.05f, wear(u, v));
  });
  return surface;
}

Surface letter_surface(RandomStream rng, vec3 color, char letter) {
  const vec3 ground = vec3(0.6f, 0.48f, 0.32f) * rng.uniform(0.8f, 1.15f);
  const PinkNoise fiber(rng.seed(), 4, 128, 1.2f, 4, 1);
  const std::string text(1, letter);
  Surface surface;
  surface.roughness = 0.6f;
  surface.texture = paint(256, [&](float u, float v) {
    const float rim = std::min(std::min(u, 1 - u), std::min(v, 1 - v));
    const float ink = ink_at(text, (u - 0.27f) / 0.56f - 0.02f, (v - 0.22f) / 0.56f, 0.2f);
    const float colored = std::max(ink, rim < 0.07f ? 1.0f : 0.0f);
    return shaded(glm::mix(ground, color, colored), 0.09f, fiber(u, v));
  });
  return surface;
}

}  // namespace dualpixel::scenes
