#pragma once
#include <cstdint>

#include "scenes/people/body/body.h"

/// Hair styles and the shape of a head of hair.
namespace dualpixel::scenes {

enum class HairStyle : std::uint8_t {
  bald,
  cropped,
  short_cap,
  parted,
  curly,
  afro,
  bob,
  long_straight,
  long_wavy,
  bun,
  ponytail,
  braids
};

/// Shape of a head of hair in the head's frame at scale 1.
struct HairShape {
  float thick_m = 0.012f;     ///< over the skull
  float top_m = 0;            ///< additional thickness on top
  float hairline_m = 0.078f;  ///< its height over the middle between the eyes
  float nape_m = -0.05f;      ///< nothing below it
  float ear_cut = 1;          ///< 1: ears are uncovered
  float rough_m = 0.004f, rough_per_m = 60;
  float fall_m = 0;      ///< hangs down this far below the chin's height
  float fall_front = 0;  ///< 0 behind the shoulders .. 1 in front of them
  float fall_thick = 0.03f;
  float part_x = 0;
  bool bun = false, tail = false, braids = false;
  vec3 bun_at{0, 0.1f, -0.09f};
  float bun_m = 0.04f, tail_m = 0.25f;
  std::uint32_t seed = 1;

  /// Signed distance, head frame at scale 1.
  float operator()(vec3 p) const;
};

struct Hair {
  HairStyle style = HairStyle::bald;
  HairShape shape;
  int strands = 500;                                  ///< thin ribbons on its surface
  float strand_m = 0.03f, lift = 0.25f, curl = 0.1f;  ///< their length, how far they stand off, how much they bend
};
/// The style's part of the tag "hair:...".
const char* name_of(HairStyle style);
Hair draw_hair(const Body& body, RandomStream& rng);

}  // namespace dualpixel::scenes
