#pragma once
#include <cstdint>

/// What a picture that is read may have at most.
namespace dualpixel {

inline constexpr int kLongestPictureSide = 65536;
inline constexpr std::int64_t kMostPictureValues = 500'000'000;  ///< pixels times channels
inline constexpr int kMostPictureChannels = 1024;

}  // namespace dualpixel
