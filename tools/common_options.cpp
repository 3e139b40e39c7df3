#include <OpenImageIO/imageio.h>
#include <oneapi/tbb/global_control.h>

#include <memory>

#include "tools/commands.h"

namespace dualpixel::tools {

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
