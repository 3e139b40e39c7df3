#pragma once
#include "capture/capture.h"

/// Pictures as people look at them, and as data sets of photographs hold them.
namespace dualpixel::datasets {

/// A mosaic as linear RGB, white balanced.
Image developed(const Image& mosaic, const Capture& capture);

/// Linear RGB of truth as balanced camera colors.
Image camera_colors(const Image& rgb, const Exposure& exposure);

/// 0..1 as 0..65535, clipped.
ImageU16 levels(const Image& image);

/// Linear values under the sRGB curve, 0..1.
Image srgb(Image linear);

/// Channel `c` in all three color channels.
Image gray(const Image& image, int c = 0);

Image scaled(Image image, float factor);

/// What the DPDD data set (Abuolaim & Brown 2020) has of one scene; linear RGB.
struct DpddPictures {
  Image left, right;  ///< times 2, as bright as the undivided picture
  Image combined;
  Image target;  ///< all in focus
};

/// Dense views are demosaicked to full size. Others are green alone: gray, at the Bayer planes' size, where their
/// pixels are square. Highlights of the target are clipped as the sources' are. Needs truth.
DpddPictures dpdd_pictures(const Capture& capture);

}  // namespace dualpixel::datasets
