#pragma once
#include <glm/glm.hpp>

/// The face of the default scene's person. Meters, from the middle between the ears: y up, z out of the face.
namespace dualpixel::scenes {

/// The middle of the eye on the side of positive x; the other is its mirror image.
inline constexpr glm::vec3 kEye{0.0310f, 0.0148f, 0.0698f};
/// Of the ball without its cornea, which stands out by 1.2 mm and must stay behind the lids, and of the lids.
inline constexpr float kEyeRadius_m = 0.0138f, kLidRadius_m = 0.0151f;

/// Half of the width of the almond between the lids.
inline constexpr float kEyeHalfWidth_m = 0.0152f;

/// Heights over the eye's middle between which it is open, `x` from its middle, away from the nose: an almond.
float upper_lid_m(float x);
float lower_lid_m(float x);

/// Signed distance of head and neck without hair.
float portrait_head(glm::vec3 p);

/// What the skin's color at a point is multiplied by, linear R, G, B, at most 1: lips, cheeks, lids.
glm::vec3 skin_tint(glm::vec3 p);

/// The point of the face in front of (x, y).
glm::vec3 on_face(float x, float y);

}  // namespace dualpixel::scenes
