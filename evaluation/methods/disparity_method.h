#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "capture/image/image.h"
#include "pipeline/disparity/matchers.h"
#include "pipeline/disparity/upsample.h"

namespace dualpixel::evaluation {

/// What a method found in a pair of views, and what that took.
struct MethodRun {
  pipeline::PixelDisparity found;  ///< of the views' size; confidence and sigma empty where there are none
  double wall_s = 0, cpu_s = 0;
  /// The most that one process of another program held, looked up every 10 ms; none where it ended before that, and for
  /// a matcher of the pipeline, which shares ours.
  std::optional<double> peak_rss_mb;
};

/// A way of finding disparity: a matcher of the pipeline, or another program.
struct DisparityMethod {
  std::string name;
  /// Linear views of one size, 0 black. Throws InputError where the method fails.
  std::function<MethodRun(const Image& left, const Image& right, const pipeline::ViewSensor& sensor)> run;
};

DisparityMethod method_of(const pipeline::Matcher& matcher, const pipeline::MatcherOptions& options = {});

/// Whether method_named() takes `text` for a matcher of the pipeline and not for another program.
bool names_matcher(const std::string& text);

/// A matcher of the pipeline, "split"; the same with other options, "split:split_match.window_px=9,...", which is the
/// method's name, too; or another program, "NAME=COMMAND". COMMAND is run by /bin/sh for each pair, in the current
/// folder, with an empty standard input, and with quoted paths in place of
///   {left} {right}          16-bit gray PNG, linear, 0 black and 65535 where the view clips
///   {left.npy} {right.npy}  float32 NumPy arrays of the same, not clipped
///   {out}                   where it has to write its disparity, DP px: NPY, PFM or EXR (capture/image/map_file.h);
///   there, or at
///                           {out}.npy, {out}.pfm or {out}.exr
///   {sigma}, {confidence}   likewise, where it has them
/// Quotes around a placeholder would end those of its path.
/// Throws InputError where it names no views or no {out}, the name is taken by a matcher, or the matcher has no such
/// option or does not take its value.
DisparityMethod method_named(const std::string& text);

/// `methods`, then those of method_named(). Throws InputError also where a name is there twice.
std::vector<DisparityMethod> methods_named(const std::vector<std::string>& texts,
                                           std::vector<DisparityMethod> methods = {});

}  // namespace dualpixel::evaluation
