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
  std::vector<Subject> subjects;  ///< those whose face a detector would find; or all whose face is in the picture
  bool can_cut_out = true;        ///< nothing is in front of the people and no seat is visible
  bool domain_randomized = false;
  std::vector<std::string> tags;
};

/// Draws people, an environment, light and a camera, and renders them. `makehuman`: may be null. `faces`: as
/// PeopleOptions has it; the subjects' tags then say how far each head is turned from the camera ("turn:30", in
/// degrees), and which faces cannot be seen ("face:hidden").
PeoplePicture render_people(RandomStream rng, const MakeHumanAssets* makehuman, bool faces = false);

/// An environment without people, square, linear.
Image render_background(RandomStream rng);

}  // namespace dualpixel::scenes
