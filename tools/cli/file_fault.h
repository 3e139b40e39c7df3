#pragma once
#include <filesystem>
#include <string>

#include "capture/error.h"

namespace dualpixel::tools {

/// What to say of a path that the system refuses to look at: too long, or in a folder that may not be read. Such a path
/// was given by who called, so that it is bad input.
inline std::string file_fault(const std::filesystem::filesystem_error& error) {
  return printable(error.path1().string()) + ": " + error.code().message();
}

}  // namespace dualpixel::tools
