#pragma once
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace dualpixel {

/// A scene, lens, capture or option from the user that cannot be used. `what()` is one line that names the
/// file, the field, the value and what is allowed; the program prints it and exits with status 2.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// `text` with control characters escaped and cut to a length that stays one readable line, so that hostile names
/// and values can be quoted in a message.
std::string printable(const std::string& text, std::size_t longest_bytes = 200);

/// "; did you mean 'NEAREST'?" for the entry of `known` that is closest to `name`, or "" where none is close.
std::string did_you_mean(const std::string& name, const std::vector<std::string>& known);

}  // namespace dualpixel
