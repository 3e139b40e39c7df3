#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <charconv>
#include <cstdint>
#include <iostream>
#include <limits>
#include <memory>

#include "capture/error.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {

CLI::Validator any_seed() {
  const auto check = [](const std::string& text) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool whole = error == std::errc() && end == text.data() + text.size();
    return whole ? std::string()
                 : fmt::format("{}: must be an integer in [0, {}]", printable(text),
                               std::numeric_limits<std::uint64_t>::max());
  };
  return {check, ""};
}

void print_warnings(const std::vector<std::string>& warnings, const std::string& about) {
  for (const std::string& warning : warnings) {
    std::cerr << "dualpixel: warning: " << (about.empty() ? "" : about + ": ") << warning << '\n';
  }
}

void print_written(const std::string& page) { std::cerr << "Wrote " << printable(page) << '\n'; }

void add_threads_option(CLI::App& command) {
  command
      .add_option_function<int>(
          "--threads",
          [](int threads) {
            if (threads == 0) return;
            static std::unique_ptr<tbb::global_control> limit;
            limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, threads);
            OIIO::attribute("threads", threads);
            OIIO::attribute("exr_threads", threads);
          },
          "How many threads to compute with; 0: one for each core. The result does not depend on it")
      ->check(CLI::Range(0, 1024))
      ->type_name("N");
}

void add_overrides_option(CLI::App& command, std::vector<std::string>& overrides, const std::string& example) {
  command.add_option("--set", overrides, "Override a field of the file, e.g. " + example)
      ->type_name("FIELD=VALUE")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
}

}  // namespace dualpixel::tools
