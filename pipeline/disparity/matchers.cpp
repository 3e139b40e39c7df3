#include "pipeline/disparity/matchers.h"

#include <string>

#include "capture/names.h"
#include "pipeline/disparity/likelihood/likelihood_match.h"
#include "pipeline/disparity/split/split_match.h"
#include "pipeline/disparity/tile_disparity.h"

namespace dualpixel::pipeline {
namespace {

TileDisparity match_as_in_paper(const Image& left, const Image& right, const std::optional<ViewNoise>& /*noise*/,
                                const MatcherOptions& options) {
  return match_tiles(normalize_locally(left, options.normalize), normalize_locally(right, options.normalize),
                     options.match);
}

TileDisparity match_likeliest(const Image& left, const Image& right, const std::optional<ViewNoise>& noise,
                              const MatcherOptions& options) {
  LikelihoodMatchOptions likelihood = options.likelihood_match;
  likelihood.noise = noise;
  return match_by_likelihood(left, right, likelihood);
}

TileDisparity match_knowing_split(const Image& left, const Image& right, const std::optional<ViewNoise>& noise,
                                  const MatcherOptions& options) {
  LikelihoodMatchOptions likelihood = options.likelihood_match;
  likelihood.noise = noise;
  return match_by_split(left, right, options.split_match, likelihood);
}

constexpr Matcher kMatchers[] = {
    {"paper", "normalized views, sums of squared differences, a parabola, as in Wadhwa et al. 2018",
     [](const MatcherOptions& options) { return options.match.range_px; }, match_as_in_paper},
    {"likelihood", "linear views and their noise, maximum likelihood, a predicted error",
     [](const MatcherOptions& options) { return options.likelihood_match.range_px; }, match_likeliest},
    {"split", "low frequencies through the kernels of a soft split, maximum likelihood near the focus",
     [](const MatcherOptions& options) { return options.split_match.range_px; }, match_knowing_split},
};

}  // namespace

OptionFields fields(MatcherOptions& options) {
  OptionFields all = grouped("normalize", fields(options.normalize));
  for (const OptionFields& group :
       {grouped("match", fields(options.match)), grouped("likelihood_match", fields(options.likelihood_match)),
        grouped("split_match", fields(options.split_match))}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

std::span<const Matcher> matchers() { return kMatchers; }

const Matcher& matcher_named(std::string_view name) {
  if (const Matcher* matcher = find_named(kMatchers, name)) return *matcher;
  refuse_name("matcher", std::string(name), names_of(kMatchers));
}

}  // namespace dualpixel::pipeline
