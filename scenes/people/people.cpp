#include "scenes/people/people.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <utility>

#include "scenes/people/composite.h"
#include "scenes/people/picture.h"

namespace dualpixel::scenes {
namespace {

/// The backgrounds of a shard's composites, rendered at first use, so that a sample does not depend on how many there
/// are. In training sets those with an odd index are domain-randomized, for people who are.
class Backgrounds {
 public:
  explicit Backgrounds(const RandomStream& rng) : rng_(rng) {}

  const Image& pick(RandomStream& rng, bool domain_randomized) {
    auto i = static_cast<std::size_t>(rng.below(kCount));
    if (!rng.held_out()) i = i / 2 * 2 + (domain_randomized ? 1 : 0);
    std::call_once(made_[i], [&] {
      RandomStream own = rng_.substream(1'000'000 + i);
      if (domain_randomized) own.set_domain_randomized();
      // isolated, so that Embree's own tasks cannot make this thread wait for the flag that it holds
      tbb::this_task_arena::isolate([&] { images_[i] = render_background(own); });
    });
    return images_[i];
  }

 private:
  static constexpr int kCount = 32;
  RandomStream rng_;
  std::array<std::once_flag, kCount> made_;
  std::array<Image, kCount> images_;
};

/// Of the pictures of a set for a face detector, those without anybody.
constexpr float kNobodyShare = 0.4f;

PeopleSample sample_of_nobody(RandomStream rng, int picture_index) {
  PeopleSample sample;
  sample.seed = rng.substream(7).seed();
  sample.picture_index = picture_index;
  sample.people = 0;
  if (rng.substream(8).chance(0.5f)) rng.set_domain_randomized();
  sample.picture = photograph_of(render_background(rng), {}, rng.substream(50));
  sample.mask.assign(sample.picture.size() / 3, 0);
  return sample;
}

/// A rendered picture's samples and those of its composites.
std::vector<PeopleSample> make_samples(const PeopleOptions& options, const RandomStream& rng, int index,
                                       Backgrounds& backgrounds) {
  std::vector<PeopleSample> out;
  if (options.faces && rng.substream(9).chance(kNobodyShare)) {
    return {sample_of_nobody(rng, index * (1 + options.composites))};
  }
  const PeoplePicture picture = render_people(rng, options.makehuman.get(), options.faces);
  if (picture.subjects.empty()) return out;
  add_samples(picture, picture.subjects, picture.rendering.light, rng.substream(50), out);
  const int rendered = static_cast<int>(out.size());
  for (int k = 0; k < options.composites && picture.can_cut_out; ++k) {
    RandomStream mix = rng.substream(100 + k);
    const Image& background = backgrounds.pick(mix, picture.domain_randomized);
    // one of several people: the others are in the next
    const Subject& one = picture.subjects[static_cast<std::size_t>(k) % picture.subjects.size()];
    add_samples(picture, {one}, composite_of(picture.rendering, background, mix.substream(1)), mix.substream(2), out);
  }
  for (std::size_t k = 0; k < out.size(); ++k) {
    out[k].composite = static_cast<int>(k) >= rendered;
    out[k].picture_index = index * (1 + options.composites) + std::max(static_cast<int>(k) - rendered + 1, 0);
    RandomStream own = rng.substream(7);
    out[k].seed = own.seed();
    if (!out[k].composite) out[k].tags.insert(out[k].tags.end(), picture.tags.begin(), picture.tags.end());
    if (picture.domain_randomized) out[k].tags.emplace_back("domain_randomized");
  }
  return out;
}

}  // namespace

std::vector<PeopleSample> make_people_shard(const PeopleOptions& options, int shard, int count,
                                            const std::function<void(double)>& progress) {
  const RandomStream rng = RandomStream(options.seed, options.held_out).substream(static_cast<std::uint64_t>(shard));
  Backgrounds backgrounds(rng);
  std::atomic<int> done = 0;
  const int in_all = std::max(count / (1 + options.composites), 1);
  std::vector<PeopleSample> samples;
  int first = 0;
  while (static_cast<int>(samples.size()) < count) {
    // as many as fill the shard if each shows one person; the same for any number of threads
    const int round = std::max((count - static_cast<int>(samples.size())) / (1 + options.composites), 1);
    std::vector<std::vector<PeopleSample>> made(round);
    tbb::parallel_for(0, round, [&](int i) {
      const int index = first + i;
      made[i] = make_samples(options, rng.substream(static_cast<std::uint64_t>(index)), index, backgrounds);
      if (progress) progress(std::min(0.99, static_cast<double>(++done) / in_all));
    });
    for (auto& several : made) {
      // a picture is a face detector's truth with all its faces: one that does not fit is left out
      const auto rendered = std::count_if(several.begin(), several.end(), [](const auto& s) { return !s.composite; });
      if (options.faces && rendered > count - static_cast<std::ptrdiff_t>(samples.size())) continue;
      for (PeopleSample& sample : several) samples.push_back(std::move(sample));
    }
    first += round;
  }
  samples.resize(static_cast<std::size_t>(count));
  return samples;
}

}  // namespace dualpixel::scenes
