#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>

#include "scenes/people/dice.h"
#include "simulator/scene/scene.h"

/// Solid textures: the color of a surface as a function of where a point lies on it at rest, in meters. No texture
/// memory, no seams, and every one different.
namespace dualpixel::scenes {

struct Material {
  enum class Kind : std::uint8_t {
    // of cloth and of anything
    plain,
    stripes_across,
    stripes_along,
    checks,
    dots,
    floral,
    knit,
    denim,
    heather,
    print,
    medley,  ///< patterns of many kinds, turned and mixed as the seed says: stands for all that are not here
    argyle,
    zigzag,
    camouflage,
    // of people
    skin,
    face,
    eye,
    hair,
    // of surroundings
    rough,
    bricks,
    planks,
    tiles,
    facade,
    books,
    collage,
    foliage,
    grass,
    paving,
    crowd,
    stones,
    herringbone,
    graffiti,
    textured  ///< `texture` at rest's x, y as glTF's u, v, times a
  } kind = Kind::plain;
  glm::vec3 a{0.5f}, b{0.2f}, c{0.1f};  ///< linear reflectances: ground, pattern, accent
  float scale_m = 0.05f;                ///< of one repeat
  std::uint32_t seed = 1;
  float gloss = 0;         ///< strength of the highlight, 0..1
  float gloss_power = 20;  ///< its sharpness
  float softness = 0;      ///< how far light wraps around, as under skin: 0..1
  glm::vec3 emission{0};   ///< radiance per reflectance, in the dome's units
  std::shared_ptr<const simulator::Texture> texture;
  bool cut_out = false;      ///< where the texture's alpha is under 1/2 there is nothing
  std::array<float, 6> v{};  ///< of a face or a garment: see FaceDetail, kPlacket
};

/// Look::v of a face.
enum FaceDetail : std::uint8_t { kStubble, kBrowThickness, kMouthOpen, kBlush, kScalpHair, kEyeLine };

/// Look::v of a garment: how strongly a line of buttons shows down its front.
inline constexpr int kPlacket = 0;

/// Reflectance, about 0 .. 1, at a rest place.
glm::vec3 reflectance(const Material& material, glm::vec3 rest);

/// A color of cloth or paint: dark, pale, gray, muted or bright, over the whole gamut.
glm::vec3 random_color(RandomStream& rng);
/// Reflectance of skin from the darkest to the palest: a path through measured means (Fitzpatrick VI to I) with spread
/// in redness.
glm::vec3 skin_color(RandomStream& rng);
/// Black, brown, red, blond, gray, white and, rarely, dyed.
glm::vec3 hair_color(RandomStream& rng, bool old);

/// Kinds that cloth and walls may have; the last `reserved` entries are drawn for held-out sets only.
struct MaterialPool {
  const Material::Kind* kinds;
  int count, reserved;
};
MaterialPool cloth_pool();
MaterialPool wall_pool();
Material cloth_material(RandomStream& rng);
Material wall_material(RandomStream& rng);

}  // namespace dualpixel::scenes
