#include "capture/names.h"

#include <fmt/format.h>

#include "capture/error.h"

namespace dualpixel {

std::string must_be_one_of(const std::vector<std::string>& names, const std::string& name) {
  return fmt::format("must be one of '{}'{}", fmt::join(names, "', '"), did_you_mean(name, names));
}

void refuse_name(const std::string& field, const std::string& name, const std::vector<std::string>& names) {
  throw InputError(fmt::format("{}: {}: {}", field, printable(name), must_be_one_of(names, name)));
}

}  // namespace dualpixel
