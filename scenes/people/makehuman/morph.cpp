#include "scenes/people/makehuman/morph.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "capture/error.h"
#include "scenes/people/makehuman/pick.h"

namespace dualpixel::scenes {
namespace {

constexpr const char* kOrigins[] = {"african", "asian", "caucasian"};

bool is_man(const Body& sizes) { return sizes.woman < 0.5f; }

const MakeHumanAssets::Skin* draw_skin(const MakeHumanAssets& assets, const Body& sizes, RandomStream& skin_rng) {
  const auto sex_and_age = [](bool woman, bool old) { return (woman ? 1 : 0) + (old ? 2 : 0); };
  return pick(
      skin_rng, assets.skins,
      [&](const MakeHumanAssets::Skin& one) {
        return sex_and_age(is_for_women(one.name), one.name.starts_with("old"));
      },
      sex_and_age(!is_man(sizes), sizes.old));
}

void apply_target(const MakeHumanAssets& assets, MorphedBody& body, const std::string& name, float weight) {
  if (std::abs(weight) < 1e-3f) return;
  const MorphTarget& target = assets.target(name);
  for (std::size_t i = 0; i < target.vertex.size(); ++i)
    body.rest[static_cast<std::size_t>(target.vertex[i])] += weight * target.offset[i];
}

/// Macro targets: two origins, an age, and muscle and weight of that age.
void apply_macro_targets(const MakeHumanAssets& assets, MorphedBody& body, const Body& sizes, int origin,
                         RandomStream& body_rng) {
  const std::string gender = is_man(sizes) ? "male" : "female";
  const int second = body_rng.below(3);
  const float mixed = body_rng.uniform(0, 0.4f);
  const float older = sizes.old ? body_rng.uniform(0.4f, 0.9f) : body_rng.uniform(0, 0.25f);
  const float younger = sizes.child ? body_rng.uniform(0.4f, 1) : 0;
  const float muscle = body_rng.uniform(-0.6f, 0.8f), heavy = std::clamp(sizes.girth, -1.0f, 1.0f);
  const std::pair<const char*, float> ages[] = {
      {"young", (1 - older) * (1 - younger)}, {"old", older * (1 - younger)}, {"child", younger}};
  const std::pair<const char*, float> muscles[] = {{"averagemuscle", 1 - std::abs(muscle)},
                                                   {muscle > 0 ? "maxmuscle" : "minmuscle", std::abs(muscle)}};
  const std::pair<const char*, float> fats[] = {{"averageweight", 1 - std::abs(heavy)},
                                                {heavy > 0 ? "maxweight" : "minweight", std::abs(heavy)}};
  for (const auto& [age, a] : ages) {
    apply_target(assets, body, fmt::format("macrodetails/{}-{}-{}", kOrigins[origin], gender, age), a * (1 - mixed));
    apply_target(assets, body, fmt::format("macrodetails/{}-{}-{}", kOrigins[second], gender, age), a * mixed);
    for (const auto& [m, b] : muscles) {
      for (const auto& [f, c] : fats)
        apply_target(assets, body, fmt::format("macrodetails/universal-{}-{}-{}-{}", gender, age, m, f), a * b * c);
    }
  }
}

void apply_details(const MakeHumanAssets& assets, MorphedBody& body, int origin, RandomStream& body_rng) {
  for (const std::string& detail : assets.details) {
    const float amount = 0.28f * body_rng.normal();
    apply_target(assets, body, detail + (amount > 0 ? "-incr" : "-decr"), std::abs(amount));
  }
  if (body_rng.chance(0.45f))
    apply_target(assets, body, fmt::format("expression/units/{}/mouth-corner-puller", kOrigins[origin]),
                 body_rng.uniform(0.2f, 0.9f));
}

}  // namespace

Morph draw_morph(const MakeHumanAssets& assets, const Body& sizes, RandomStream& body_rng, RandomStream& skin_rng) {
  Morph morph{{assets.base.positions, &assets.base}, draw_skin(assets, sizes, skin_rng)};
  morph.origin = body_rng.below(3);
  for (int i = 0; i < 3; ++i) {
    if (morph.skin && morph.skin->name.find(kOrigins[i]) != std::string::npos) morph.origin = i;
  }
  apply_macro_targets(assets, morph.body, sizes, morph.origin, body_rng);
  apply_details(assets, morph.body, morph.origin, body_rng);
  return morph;
}

float scale_to_stature(MorphedBody& morphed, const Body& sizes, const std::string& whose) {
  require_human_sizes(morphed, whose);
  float low = 1e9f, high = -1e9f;
  for (const int v : morphed.base->body.vertex) {
    low = std::min(low, morphed.rest[static_cast<std::size_t>(v)].y);
    high = std::max(high, morphed.rest[static_cast<std::size_t>(v)].y);
  }
  if (!(high - low >= 0.4f && high - low <= 3)) {
    throw InputError(fmt::format("{}: the height is {:.2f} m; 0.4 to 3 m is allowed", whose, high - low));
  }
  require_limbs(morphed, whose);
  const float grow = sizes.child ? 1 : std::clamp(sizes.stature_m / (high - low), 0.93f, 1.07f);
  for (vec3& p : morphed.rest) p = grow * (p - vec3(0, low, 0));
  return grow * (high - low);
}

}  // namespace dualpixel::scenes
