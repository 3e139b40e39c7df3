#pragma once
#include <string>
#include <vector>

#include "scenes/procedural/random_stream.h"
#include "scenes/textures/surfaces.h"

/// Print: letters as strokes, and what is printed with them.
namespace dualpixel::scenes {

/// How much of a line of text covers the point (x, y): y from 0 (top) to 1 (baseline) over a capital's height, x in the
/// same unit from the line's beginning. `stroke` is the pen's width.
float ink_at(const std::string& text, float x, float y, float stroke = 0.14f);
/// Width of the line in heights of a capital.
float line_width(const std::string& text);

/// Lines of words drawn from the stream, none of more than `letters` letters.
std::vector<std::string> random_text(RandomStream& rng, int lines, int letters);

/// A printed page of `width_m` x `height_m` meters, in the picture's full u and v: headline, columns, a picture.
Surface page_surface(RandomStream rng, float width_m);
/// A cover or label: a field of color, a band and large letters.
Surface cover_surface(RandomStream rng, glm::vec3 color, const std::string& title);
/// One capital on each side of a block.
Surface letter_surface(RandomStream rng, glm::vec3 color, char letter);

}  // namespace dualpixel::scenes
