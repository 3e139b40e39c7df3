#pragma once
#include <string>

/// What a picture's file says about its values and pixels, for photographs of any origin; read with the checks of
/// image_io.h, in image_io.cpp.
namespace dualpixel {

struct PictureEncoding {
  int orientation = 1;   ///< TIFF's and EXIF's tag 274, 1 to 8; 1: upright, or what the file says is none of these
  bool linear = false;   ///< the file declares linear light
  bool profile = false;  ///< it brings an ICC profile
  bool dng = false;      ///< it is raw data, for read_dng() of dng_picture.h; of the rest only orientation is filled in
};
PictureEncoding picture_encoding(const std::string& path);

}  // namespace dualpixel
