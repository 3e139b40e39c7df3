#pragma once
#include <cstdint>
#include <string>

/// What a picture that is read may have at most.
namespace dualpixel {

inline constexpr int kLongestPictureSide = 65536;
inline constexpr std::int64_t kMostPictureValues = 500'000'000;  ///< pixels times channels
inline constexpr int kMostPictureChannels = 1024;

/// Throws InputError, which names the file, where a picture has more, or no pixels.
void require_allowed_size(const std::string& path, std::int64_t width, std::int64_t height, std::int64_t channels);

}  // namespace dualpixel
