#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "capture/capture.h"

/// The drawn scenes over which methods of synthetic defocus are compared: people, groups and things, near and far, by
/// day and by night. Each comes with the photograph that a lens with a pupil five times as wide would take.
namespace dualpixel::evaluation {

struct ComparisonScene {
  const char* name;  ///< also of its folders
  const char* kind;  ///< of scenes/kinds/
  std::uint64_t seed;
  std::vector<std::string> assignments;  ///< as SceneOrder has them
};

/// Kinds alternate, so that the first few are a mixture, too.
std::span<const ComparisonScene> comparison_scenes();

/// Draws the scene into `scratch`, a folder that exists, and simulates it: 672 x 504 photosites behind a thin lens, a
/// burst of nine at rest, the noise of a phone's small photosites; 16 samples a photosite for the views, 48 for the
/// photograph, 16 a point of light. Throws InputError.
Capture simulate_comparison_scene(const ComparisonScene& scene, const std::string& scratch);

}  // namespace dualpixel::evaluation
