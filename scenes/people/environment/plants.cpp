#include "scenes/people/environment/plants.h"

namespace dualpixel::scenes {

Material leaves_material(RandomStream& rng) {
  Material material;
  material.kind = Material::Kind::foliage;
  material.scale_m = rng.uniform(0.03f, 0.12f);
  material.seed = rng.seed();
  material.a = {rng.uniform(0.04f, 0.2f), rng.uniform(0.12f, 0.35f), rng.uniform(0.02f, 0.1f)};
  if (rng.chance(0.12f)) material.a = {rng.uniform(0.3f, 0.5f), rng.uniform(0.12f, 0.25f), 0.04f};  // autumn
  material.c = material.a * vec3(rng.uniform(0.6f, 2), rng.uniform(0.6f, 1.4f), rng.uniform(0.4f, 1.3f));
  material.softness = 0.4f;
  return material;
}

void add_leaves(SceneObject& object, RandomStream& rng, vec3 center, vec3 radii, int count, float leaf_m) {
  for (int i = 0; i < count; ++i) {
    const vec3 random = rng.uniform3(-1, 1);
    const vec3 out = glm::normalize(random + 0.001f);
    const vec3 p = center + radii * out * (0.6f + 0.45f * rng.uniform());
    const vec3 along = glm::normalize(out + 0.9f * rng.uniform3(-1, 1) - vec3(0, 0.3f, 0));
    const vec3 across = glm::normalize(glm::cross(along, out + 0.5f * rng.uniform3(-1, 1)) + 0.001f);
    const float length = leaf_m * rng.uniform(0.6f, 1.4f), half = 0.3f * length;
    const auto first = static_cast<unsigned>(object.positions.size());
    for (const vec3& q : {p, p + 0.5f * length * along + half * across, p + length * along,
                          p + 0.5f * length * along - half * across}) {
      object.positions.push_back(q);
      object.rest.push_back(vec3(q.x, q.y, q.z) + 0.7f * random);
      object.normals.push_back(glm::normalize(glm::cross(along, across) + 0.6f * out));
    }
    object.triangles.emplace_back(first, first + 1, first + 2);
    object.triangles.emplace_back(first, first + 2, first + 3);
  }
}

void add_tree(EnvironmentBuilder& build, RandomStream& rng, vec3 foot, float tall) {
  Material bark;
  bark.kind = Material::Kind::rough;
  bark.scale_m = 0.1f;
  bark.seed = rng.seed();
  bark.a = vec3(0.2f, 0.14f, 0.1f) * rng.uniform(0.4f, 1.6f);
  bark.b = 0.3f * bark.a;
  const vec3 top = foot + vec3(rng.uniform(-0.5f, 0.5f), tall, 0);
  add_tube(build.object(bark), {foot, glm::mix(foot, top, 0.5f) + rng.uniform3(-0.15f, 0.15f), top},
           {0.045f * tall, 0.03f * tall, 0.01f * tall}, 8);
  SceneObject& leaves = build.object(leaves_material(rng));
  for (int i = 0; i < 4; ++i) {
    add_leaves(leaves, rng, top + tall * 0.25f * rng.uniform3(-1, 1), tall * vec3(0.28f, 0.2f, 0.28f), 220,
               0.06f * tall);
  }
}

void add_plant(EnvironmentBuilder& build, RandomStream& rng, vec3 foot) {
  const float tall = rng.uniform(0.4f, 1.4f);
  add_tube(build.object(plain_material(random_color(rng))),
           {foot, foot, foot + vec3(0, 0.25f, 0), foot + vec3(0, 0.25f, 0)}, {0, 0.1f, 0.14f, 0}, 10);
  add_leaves(build.object(leaves_material(rng)), rng, foot + vec3(0, 0.25f + 0.5f * tall, 0),
             vec3(0.3f, 0.5f * tall, 0.3f), 120, rng.uniform(0.1f, 0.25f));
}

}  // namespace dualpixel::scenes
