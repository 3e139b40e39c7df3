#pragma once
#include <tiffio.h>

#include <cstdio>
#include <memory>
#include <string>

namespace dualpixel {

using TiffOptions = std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)>;

/// Options to open a file with, by which libtiff prints nothing. Its first error goes into `error`, which must outlive
/// the file.
inline TiffOptions quiet_tiff(std::string& error) {
  TiffOptions options(TIFFOpenOptionsAlloc(), TIFFOpenOptionsFree);
  const auto keep_first = [](TIFF*, void* first, const char*, const char* format, va_list arguments) {
    char text[256];
    std::vsnprintf(text, sizeof text, format, arguments);
    auto& kept = *static_cast<std::string*>(first);
    if (kept.empty()) kept = text;
    return 1;  // handled
  };
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_first, &error);
  TIFFOpenOptionsSetWarningHandlerExtR(
      options.get(), [](TIFF*, void*, const char*, const char*, va_list) { return 1; }, nullptr);
  return options;
}

}  // namespace dualpixel
