#pragma once
#include <string>

#include "scenes/people/makehuman/assets.h"
#include "scenes/people/makehuman/morphed_body.h"

namespace dualpixel::scenes {

/// What a body is mixed from: see draw_morph().
struct Morph {
  MorphedBody body;
  const MakeHumanAssets::Skin* skin = nullptr;  ///< null: the assets have none
  int origin = 0;                               ///< 0 African, 1 Asian, 2 Caucasian
};

/// Draws a skin and a body that fits it: a mixture of macro targets (origin, sex, age, muscle, weight), then details of
/// the face and body. `sizes` says sex, age and girth.
Morph draw_morph(const MakeHumanAssets& assets, const Body& sizes, RandomStream& body_rng, RandomStream& skin_rng);

/// Moves the body's soles to the floor and scales it towards `sizes.stature_m`: targets know no centimeters. Returns
/// its height, meters. Throws InputError where it is no human's, prefixed by `whose`.
float scale_to_stature(MorphedBody& morphed, const Body& sizes, const std::string& whose);

}  // namespace dualpixel::scenes
