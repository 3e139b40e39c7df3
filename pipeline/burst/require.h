#pragma once
#include <string>

#include "capture/error.h"

namespace dualpixel::pipeline {

/// Refuses a burst of which something does not hold.
inline void require(bool holds, const std::string& what) {
  if (!holds) throw InputError("burst: " + what);
}

}  // namespace dualpixel::pipeline
