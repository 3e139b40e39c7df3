#pragma once

namespace dualpixel::tools {

/// Exit statuses, beside 0 and 128 + a signal's number.
constexpr int kInternalError = 1;
constexpr int kBadInput = 2;

}  // namespace dualpixel::tools
