#pragma once
#include <span>
#include <string_view>

#include "pipeline/disparity/likelihood/options.h"
#include "pipeline/disparity/noise_model.h"
#include "pipeline/disparity/paper/match.h"
#include "pipeline/disparity/paper/normalize.h"
#include "pipeline/disparity/split/options.h"

/// Every way of finding disparity between the two DP views, as one table. To add a matcher:
///   1. write it in its own folder beside paper/, likelihood/ and split/, with an options struct that has fields() and
///   check();
///   2. add that struct to MatcherOptions and its fields to fields(MatcherOptions&);
///   3. add one row to the table in matchers.cpp;
///   4. describe it in docs/disparity.md.
/// The command line, run_portrait, benchmarks and experiments read the table.
namespace dualpixel::pipeline {

struct TileDisparity;

/// Options of all matchers; each reads its own. What they say of the sensor is replaced by what the matcher is given.
struct MatcherOptions {
  NormalizeOptions normalize;               ///< paper
  MatchOptions match;                       ///< paper
  LikelihoodMatchOptions likelihood_match;  ///< likelihood, and split near the focus
  SplitMatchOptions split_match;            ///< split
};

/// All but what describes the sensor, as "normalize.window_px", "match.range_px", "likelihood_match.range_px", ...
OptionFields fields(MatcherOptions& options);

/// Throws InputError where a value of any group is out of its range.
void check(const MatcherOptions& options);

struct Matcher {
  std::string_view name;         ///< on the command line and in a result's provenance
  std::string_view description;  ///< one phrase, for help and tables
  /// Groups of MatcherOptions that it reads.
  std::span<const std::string_view> option_groups;
  /// Largest |disparity| that can be found, DP px.
  int (*range_dp_px)(const MatcherOptions& options);
  /// `left` and `right` are linear views of one size, one channel, normalized signal, of `sensor`; matchers that need
  /// its noise estimate it from the views where it is not known. Throws InputError where the views or an option cannot
  /// be used.
  TileDisparity (*match)(const Image& left, const Image& right, const ViewSensor& sensor,
                         const MatcherOptions& options);
  /// Windows of tens of pixels reach over depth edges and answer for the wrong side there, with confidence.
  bool wide_windows;
};

/// In the order in which tables list them; the first is the paper's.
std::span<const Matcher> matchers();

/// What portraits are made with where nobody asks for another: the least error on a real phone's pairs, and less
/// disparity error than the paper's on rendered scenes (docs/disparity.md).
inline constexpr std::string_view kDefaultMatcher = "split";

/// Throws InputError for a name that the table lacks, with the nearest one that it has.
const Matcher& matcher_named(std::string_view name);

/// Throws InputError where `field` ("match.range_px") is an option of other matchers alone; of any, where `matcher` is
/// none, as disparity is given.
void require_read_by(const Matcher* matcher, std::string_view field);

}  // namespace dualpixel::pipeline
