#pragma once
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>

#include "scenes/procedural/random_stream.h"
#include "simulator/scene/scene.h"

/// Materials with solid textures: color as a function of the rest position, in meters. They need no texture memory,
/// have no seams, and each differs.
namespace dualpixel::scenes {

struct Material {
  enum class Kind : std::uint8_t {
    // fabrics and anything else
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
    medley,  ///< random mixtures of patterns (domain randomization)
    argyle,
    zigzag,
    camouflage,
    // people
    skin,
    face,
    eye,
    hair,
    // environments
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
  glm::vec3 a{0.5f}, b{0.2f}, c{0.1f};  ///< linear reflectances: base, pattern, accent
  float scale_m = 0.05f;                ///< of one repeat
  std::uint32_t seed = 1;
  float gloss = 0;         ///< strength of the highlight, 0..1
  float gloss_power = 20;  ///< its sharpness
  float softness = 0;      ///< how far diffuse light wraps around the terminator, as in skin: 0..1
  glm::vec3 emission{0};   ///< emitted radiance over reflectance, in the dome light's units
  std::shared_ptr<const simulator::Texture> texture;
  bool cut_out = false;      ///< where the texture's alpha is below 1/2 rays pass through
  bool iris = false;         ///< the texture is that of an eye behind a clear cornea
  std::array<float, 6> v{};  ///< face or garment parameters: see FaceDetail, kPlacket
};

/// Material::v of a face.
enum FaceDetail : std::uint8_t { kStubble, kBrowThickness, kMouthOpen, kBlush, kScalpHair, kEyeLine };

/// Material::v of a garment: how visible a line of buttons down its front is.
inline constexpr int kPlacket = 0;

/// A color of cloth or paint: dark, pale, gray, muted or bright, over the whole gamut.
glm::vec3 random_color(RandomStream& rng);
/// Reflectance of skin from the darkest to the palest: a path through measured means (Fitzpatrick VI to I) with spread
/// in redness.
glm::vec3 skin_color(RandomStream& rng);
/// Black, brown, red, blond, gray, white and, rarely, dyed.
glm::vec3 hair_color(RandomStream& rng, bool old);

/// Kinds that fabrics and walls may have; the last `reserved` entries are drawn for held-out sets only.
struct MaterialPool {
  const Material::Kind* kinds;
  int count, reserved;
};
MaterialPool cloth_pool();
MaterialPool wall_pool();
Material cloth_material(RandomStream& rng);
Material wall_material(RandomStream& rng);
/// One color without a pattern.
Material plain_material(glm::vec3 color, float gloss = 0);

}  // namespace dualpixel::scenes
