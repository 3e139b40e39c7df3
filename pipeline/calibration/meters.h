#pragma once
#include <fmt/format.h>

#include <string>

namespace dualpixel::pipeline {

/// A distance as messages give it.
inline std::string meters(double distance) { return fmt::format("{:g} m", distance); }

}  // namespace dualpixel::pipeline
