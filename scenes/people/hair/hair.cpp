#include "scenes/people/hair/hair.h"

#include <algorithm>
#include <string>
#include <utility>

#include "scenes/people/hair/beard_and_glasses.h"
#include "scenes/people/hair/hair_shape.h"
#include "scenes/people/hair/hats.h"
#include "scenes/people/hair/strands.h"
#include "scenes/people/shape/primitives.h"

namespace dualpixel::scenes {
namespace {

void add_hair_mesh(SceneModel& scene, const Figure& figure, const Hair& hair, RandomStream& rng) {
  const float low =
      -0.16f - hair.shape.fall_m - (hair.shape.tail ? hair.shape.tail_m : 0) - (hair.shape.braids ? 0.25f : 0);
  const float r = 0.14f + hair.shape.thick_m + hair.shape.fall_thick;
  const float cell = std::max(figure.head_cell_m * 1.25f, 0.005f) / figure.body.head_scale;
  SceneObject object =
      polygonize(hair.shape, {-r, low, -r - 0.06f}, {r, 0.2f + hair.shape.thick_m + hair.shape.top_m, r}, cell);
  let_hang(figure, object);
  object.hair_m = std::max(1.5f * hair.strand_m, 0.012f);
  const float width = 0.00075f + 0.00012f * static_cast<float>(rng.below(6));
  SceneObject soft = strands(figure, object, rng, hair.strands, hair.strand_m, hair.lift, width, hair.curl);
  add_object(scene, figure, std::move(object), figure.hair);
  if (figure.head_cell_m < 0.009f) add_object(scene, figure, std::move(soft), figure.hair);
}

}  // namespace

void add_hair_and_hat(SceneModel& scene, Figure& figure, RandomStream rng) {
  const Body& body = figure.body;
  Hair hair = draw_hair(body, rng);
  figure.tags.push_back(std::string("hair:") + name_of(hair.style));
  const bool hat = rng.chance(0.17f);
  const bool hidden = hat && add_hat(scene, figure, rng, hair.shape);
  if (hair.style == HairStyle::bald) figure.face.v[kScalpHair] = rng.uniform(0, 0.35f);
  if (hair.style != HairStyle::bald && !hidden) add_hair_mesh(scene, figure, hair, rng);
  if (body.woman < 0.5f && !body.child && rng.chance(0.3f)) add_beard(scene, figure, rng);
  if (rng.chance(0.22f)) add_glasses(scene, figure, rng);
}

}  // namespace dualpixel::scenes
