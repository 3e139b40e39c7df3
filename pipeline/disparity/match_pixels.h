#pragma once
#include <string>

#include "capture/capture.h"
#include "pipeline/disparity/matchers.h"
#include "pipeline/disparity/upsample.h"

/// From two views to a disparity for each of their pixels.
namespace dualpixel::pipeline {

/// Dense views (dp_downsample 1 x 1) lie under the mosaic's colors, so that neighbors differ where nothing moves: they
/// are matched as a sensor with DP pixels of 2 x 2 photosites would have read them, the mean of the two green ones.
bool is_dense_mosaic(const Capture& capture);

/// Means of the two green photosites of each 2 x 2 under the filters `cfa`: half as wide and high. A last odd row or
/// column is left out.
Image green_means(const Image& dense, const std::string& cfa);

/// What is known of such means where `dense` is known of the views.
ViewSensor sensor_of_green_means(const ViewSensor& dense);

/// The disparity of `views` of the capture, in their own size and DP pixels, by `matcher`. Pixel height and
/// split factor are the capture's, whatever `sensor` says. Where views are dense, each is found at half the size: the
/// matcher's options, its range among them, are in pixels of two photosites there.
PixelDisparity match_pixels(const Capture& capture, const Image& left, const Image& right, const ViewSensor& sensor,
                            const Matcher& matcher, const MatcherOptions& options,
                            const UpsampleOptions& upsampling = {});

}  // namespace dualpixel::pipeline
