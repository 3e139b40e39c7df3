#pragma once
#include <functional>
#include <string>

#include "capture/capture.h"

/// The layout of Google's dual-pixel data (Garg et al. 2019, "Learning Single Camera Depth Estimation using
/// Dual-Pixels", as released): FOLDER/NAME/FILE for each scene, pictures turned clockwise by a quarter.
namespace dualpixel::datasets {

struct GoogleFile {
  const char* folder;
  const char* file;
};
inline constexpr GoogleFile kGoogleFiles[] = {
    {"raw_left_pd", "result_pd_left_center.png"},  ///< green, 10 bits times 16, black and white as the capture's
    {"raw_right_pd", "result_pd_right_center.png"},
    {"scaled_images", "result_scaled_image_center.jpg"},
    {"merged_depth", "result_merged_depth_center.png"},  ///< 8 bits d: 20 / (100 - 99.8 d / 255) m
    {"merged_conf", "result_merged_conf_center.npy"},    ///< 1 where the depth is known; EXR for programs, NumPy for
                                                         ///< people
    {"merged_conf", "result_merged_conf_center.exr"},
};

/// Throws InputError, which begins with `where`, where the camera's views are dense: the layout holds green ones.
void require_google(const Camera& camera, const std::string& where);

/// Writes the first frame's files, each to `path` of it. Needs mosaic and truth.
void write_google(const Capture& capture, const std::function<std::string(const GoogleFile&)>& path);

}  // namespace dualpixel::datasets
