#include "capture/image/jpeg.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <stdexcept>
#include <vector>

namespace dualpixel {

std::string jpeg(const Image& srgb, int quality) {
  OIIO::ImageSpec spec(srgb.width, srgb.height, srgb.channels, OIIO::TypeDesc::UINT8);
  spec["compression"] = fmt::format("jpeg:{}", quality);
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  const auto output = OIIO::ImageOutput::create("jpeg");
  if (!output || !output->set_ioproxy(&memory) || !output->open("picture.jpg", spec) ||
      !output->write_image(OIIO::TypeDesc::FLOAT, srgb.data.data()) || !output->close()) {
    throw std::runtime_error("this build of OpenImageIO cannot write JPEG");
  }
  return {bytes.begin(), bytes.end()};
}

}  // namespace dualpixel
