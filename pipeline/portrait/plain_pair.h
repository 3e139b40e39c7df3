#pragma once
#include <string>
#include <vector>

#include "capture/capture.h"
#include "capture/image/image.h"
#include "pipeline/calibration/calibration.h"

/// A dual-pixel pair as public data sets store it: two pictures, and perhaps some metadata.
namespace dualpixel::pipeline {

struct PlainPair {
  std::string left, right;      ///< PNG, TIFF or JPEG, 8 or 16 bits, gray or RGB (alpha is ignored), of one size
  std::string metadata;         ///< JSON file, see below; none where empty
  bool vertical_split = false;  ///< stored on their side: disparity runs down the columns
};

struct PlainPairCapture {
  Capture capture;
  Image picture;              ///< linear RGB, the mean of the two, for the portrait to blur: see PortraitOptions
  int width = 0, height = 0;  ///< of the pictures as they are stored
  bool focus_stated = false;  ///< in the metadata
  std::vector<std::string> assumed = {};  ///< what neither metadata nor files say, as sentences without a full stop
};

/// One frame without mosaic or truth, each pixel of the pictures a DP pixel. A view is (R + 2 G + B) / 4 in linear
/// light, as Bayer photosites weigh it. A vertical split is transposed, so that right(x, y + d) = left(x, y) of the
/// pictures is right(x + d) = left(x) here: run_portrait takes it with PortraitOptions::transposed. Pictures with odd
/// sides get their last column or row twice.
///
/// The metadata's fields, all optional; others are refused:
///   encoding               "srgb" or "linear"; default: linear where a picture's file declares it, else sRGB
///   black_level            linear signal of darkness, of the file's full scale, [0, 1); default 0
///   white_level            linear signal at which pixels clip, (black_level, 1]; default 1
///   noise {shot, read}     variance shot * x + read of a view's pixel whose mean is x, 0 black and 1 clipped; default:
///                          estimated from the views, as shot noise
///   focus_distance_m       default 1; it sets how strongly the portrait is blurred, and which lines of a calibration
///                          hold, not the disparity
///   face_px                x, y, width, height of a face in the pictures
///   alpha                  disparity in pixels of the pictures over the diameter of the blur in them, (0, 10]: for the
///                          matchers `split` and `likelihood`, and to match a lens
///   focal_length_mm, f_number   of the lens; only needed to match a lens
/// Where the picture is blurred it gets as much noise as its green is estimated to have (noise_of() in photograph.h):
/// none where it is gray, in one channel or in three.
/// Throws InputError where a file cannot be used, sizes differ, or a pixel is not finite or beyond [0, 1].
PlainPairCapture read_plain_pair(const PlainPair& pair);

/// The calibration of the camera that took the pair, as one of the pair's own camera, which gets its principal point.
/// The pictures are the calibrated camera's whole views, a pixel for each DP pixel; of a vertical split, picture (x, y)
/// is (y, x) of those. Throws InputError where they have another size, DP pixels are not square, as those of pairs are,
/// or the metadata state no focus_distance_m, or a focal length or f-number that differs by over 1 %.
Calibration calibration_of(const PlainPair& files, PlainPairCapture& pair, Calibration calibration);

/// The pair's capture as its pictures are: views and camera of a vertical split are turned back.
Capture upright(PlainPairCapture pair, bool vertical_split);

/// With the last column or row twice where there is an odd number of them.
Image even_sided(const Image& image);

/// Columns as rows.
Image transposed(const Image& image);

}  // namespace dualpixel::pipeline
