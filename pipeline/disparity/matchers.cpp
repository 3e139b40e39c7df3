#include "pipeline/disparity/matchers.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string>

#include "capture/error.h"
#include "capture/image/rows.h"
#include "capture/names.h"
#include "pipeline/disparity/likelihood/likelihood_match.h"
#include "pipeline/disparity/split/split_match.h"
#include "pipeline/disparity/tile_disparity.h"

namespace dualpixel::pipeline {
namespace {

/// What clips has an edge like everything else, and the paper matches it; it is only trusted less.
void distrust_clipped(const Image& left, const Image& right, float level, TileDisparity& tiles) {
  const int tile = tiles.tile_px;
  for_rows(tiles.confidence.height, [&](int row) {
    for (int column = 0; column < tiles.confidence.width; ++column) {
      int all = 0, clipped = 0;
      for (int y = row * tile; y < std::min((row + 1) * tile, left.height); ++y) {
        for (int x = column * tile; x < std::min((column + 1) * tile, left.width); ++x) {
          ++all;
          clipped += left.at(x, y) >= level || right.at(x, y) >= level ? 1 : 0;
        }
      }
      if (clipped > 0) tiles.confidence.at(column, row) *= 1 - static_cast<float>(clipped) / static_cast<float>(all);
    }
  });
}

TileDisparity match_as_in_paper(const Image& left, const Image& right, const ViewSensor& sensor,
                                const MatcherOptions& options) {
  require_views(left, right);  // before normalization makes one channel of them
  TileDisparity tiles = match_tiles(normalize_locally(left, options.normalize),
                                    normalize_locally(right, options.normalize), options.match);
  distrust_clipped(left, right, options.normalize.clipped * sensor.white, tiles);
  return tiles;
}

LikelihoodMatchOptions of_sensor(LikelihoodMatchOptions options, const ViewSensor& sensor, float alpha) {
  options.noise = sensor.noise;
  options.white = sensor.white;
  options.skew = sensor.skew;
  if (options.skew.nodes.empty() && alpha > 0) options.skew = {1, 1, {skew_of_split(alpha, sensor.pixel_height)}};
  return options;
}

TileDisparity match_likeliest(const Image& left, const Image& right, const ViewSensor& sensor,
                              const MatcherOptions& options) {
  return match_by_likelihood(left, right, of_sensor(options.likelihood_match, sensor, alpha_of_camera(sensor.alpha)));
}

TileDisparity match_knowing_split(const Image& left, const Image& right, const ViewSensor& sensor,
                                  const MatcherOptions& options) {
  SplitMatchOptions split = options.split_match;
  split.white = sensor.white;
  split.pixel_height = sensor.pixel_height;
  if (split.alpha == 0) split.alpha = alpha_of_camera(sensor.alpha);
  return match_by_split(left, right, split, of_sensor(options.likelihood_match, sensor, split.alpha));
}

constexpr std::string_view kPaperGroups[] = {"normalize", "match"}, kLikelihoodGroups[] = {"likelihood_match"},
                           kSplitGroups[] = {"split_match", "likelihood_match"};

constexpr Matcher kMatchers[] = {
    {"paper", "normalized views, sums of squared differences, a parabola, as in Wadhwa et al. 2018", kPaperGroups,
     [](const MatcherOptions& options) { return options.match.range_px; }, match_as_in_paper, false},
    {"likelihood", "linear views and their noise, maximum likelihood, a predicted error", kLikelihoodGroups,
     [](const MatcherOptions& options) { return options.likelihood_match.range_px; }, match_likeliest, false},
    {"split", "low frequencies through the kernels of the sensor's split, maximum likelihood near the focus",
     kSplitGroups, [](const MatcherOptions& options) { return options.split_match.range_px; }, match_knowing_split,
     true},
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

void check(const MatcherOptions& options) {
  check(options.normalize);
  check(options.match);
  check(options.likelihood_match);
  check(options.split_match);
}

std::span<const Matcher> matchers() { return kMatchers; }

const Matcher& matcher_named(std::string_view name) {
  if (const Matcher* matcher = find_named(kMatchers, name)) return *matcher;
  refuse_name("matcher", std::string(name), names_of(kMatchers));
}

void require_read_by(const Matcher* matcher, std::string_view field) {
  const std::string_view group = field.substr(0, field.find('.'));
  const auto reads = [&](const Matcher& each) {
    return std::ranges::find(each.option_groups, group) != each.option_groups.end();
  };
  const auto* const reader = std::find_if(std::begin(kMatchers), std::end(kMatchers), reads);
  if ((matcher && reads(*matcher)) || reader == std::end(kMatchers)) return;
  if (!matcher) throw InputError(fmt::format("{}: disparity is given, not matched; leave it out", field));
  throw InputError(fmt::format("{}: matcher {} does not use it; its options begin with {}.; matcher {} does", field,
                               matcher->name, fmt::join(matcher->option_groups, "., "), reader->name));
}

}  // namespace dualpixel::pipeline
