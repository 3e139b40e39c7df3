#include "scenes/people/procedural_figure.h"

#include <algorithm>

#include "scenes/people/body/body_mesh.h"
#include "scenes/people/body/head.h"
#include "scenes/people/body/seat.h"
#include "scenes/people/clothing/clothes.h"
#include "scenes/people/hair/hair.h"
#include "scenes/people/held/held_things.h"

namespace dualpixel::scenes {
namespace {

void draw_skin(Figure& figure, RandomStream& rng) {
  Material& skin = figure.skin;
  skin.kind = Material::Kind::skin;
  skin.a = skin_color(rng);
  skin.seed = rng.seed();
  skin.softness = rng.uniform(0.15f, 0.45f);
  skin.gloss = rng.uniform(0.05f, 0.3f);
  skin.gloss_power = rng.uniform(8, 30);
}

void draw_hair_color(Figure& figure, RandomStream& rng) {
  const Material& skin = figure.skin;
  Material& hair = figure.hair;
  hair.kind = Material::Kind::hair;
  const float pallor = skin.a.y;
  hair.a = hair_color(rng, figure.body.old);
  if (pallor < 0.15f && !figure.body.old && rng.chance(0.9f))
    hair.a = vec3(0.012f, 0.01f, 0.009f) * rng.uniform(0.5f, 2.5f);
  hair.b = hair.a * rng.uniform(1.0f, 2.2f);
  hair.seed = rng.seed();
  hair.gloss = rng.uniform(0.03f, 0.3f);
  hair.gloss_power = rng.uniform(5, 20);
  hair.softness = 0.2f;
}

void draw_face(Figure& figure, RandomStream& rng) {
  const Material &skin = figure.skin, &hair = figure.hair;
  Material& face = figure.face;
  face = skin;
  face.kind = Material::Kind::face;
  const bool made_up = figure.body.woman > 0.5f && rng.chance(0.5f);
  face.b = skin.a * vec3(0.86f, 0.52f, 0.53f);
  if (made_up) face.b = glm::mix(face.b, vec3(0.4f, 0.04f, 0.07f) * rng.uniform(0.6f, 1.4f), rng.uniform(0.3f, 1));
  face.c = figure.body.old ? glm::mix(hair.a, vec3(0.2f), 0.5f) : glm::min(hair.a, vec3(0.12f));
  face.v[kStubble] = figure.body.woman < 0.5f && !figure.body.child && rng.chance(0.6f) ? rng.uniform(0, 0.7f) : 0;
  face.v[kBrowThickness] = 1.05f - 0.3f * figure.body.woman + 0.25f * rng.normal();
  face.v[kMouthOpen] = rng.chance(0.35f) ? rng.uniform(0.35f, 1) : rng.uniform(0, 0.25f);
  face.v[kBlush] = rng.uniform(0.2f, 1);
  face.v[kEyeLine] = made_up ? rng.uniform(0.3f, 1) : rng.uniform(0, 0.3f);
  face.v[kScalpHair] = 0.6f;
}

}  // namespace

Figure add_figure(SceneModel& scene, RandomStream rng, const FigureOptions& options) {
  Figure figure = pose_figure(rng, options);
  if (figure.body.child) figure.tags.emplace_back("child");
  RandomStream material_rng = rng.substream(3);
  draw_skin(figure, material_rng);
  draw_hair_color(figure, material_rng);
  draw_face(figure, material_rng);
  add_body(scene, figure);
  add_clothes(scene, figure, rng.substream(5));
  add_hair_and_hat(scene, figure, rng.substream(6));
  add_head(scene, figure, rng.substream(7));
  add_held_thing(scene, figure, rng.substream(8));
  if (figure.pose.sitting) add_seat(scene, figure, rng.substream(9));
  return figure;
}

}  // namespace dualpixel::scenes
