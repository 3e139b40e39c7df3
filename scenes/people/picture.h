#pragma once
#include <string>
#include <vector>

#include "scenes/people/makehuman/assets.h"
#include "scenes/people/photo/render.h"
#include "scenes/people/sample.h"

namespace dualpixel::scenes {

inline constexpr int kMostPeople = 5;

/// One of the people in a picture.
struct Subject {
  PeopleSample truth;  ///< without picture and mask, in the rendering's pixels
  int person = 0;      ///< channel of the rendering's coverage
};

/// A rendered picture of people, before it is processed to sRGB.
struct PeoplePicture {
  Rendering rendering;
  std::vector<Subject> subjects;  ///< those whose face a detector would find
  bool can_cut_out = true;        ///< nothing is in front of the people and no seat is visible
  bool domain_randomized = false;
  std::vector<std::string> tags;
};

/// Draws people, an environment, light and a camera, and renders them. `makehuman`: may be null.
PeoplePicture render_people(RandomStream rng, const MakeHumanAssets* makehuman);

/// An environment without people, square, linear.
Image render_background(RandomStream rng);

}  // namespace dualpixel::scenes
