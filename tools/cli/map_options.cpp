#include "tools/cli/map_options.h"

#include <optional>

#include "capture/error.h"
#include "tools/cli/number_range.h"

namespace dualpixel::tools {

CLI::Option* add_map_options(CLI::App& command, MapFiles& files, const std::string& sizes) {
  const auto file_option = [&](const std::string& name, std::string& path, const std::string& meaning) {
    return command.add_option(name, path, meaning)->type_name("FILE");
  };
  CLI::Option* disparity = file_option("--disparity", files.disparity,
                                       "A disparity of any program's making, DP px, " + sizes +
                                           ": EXR, NPY, PFM, or PNG and TIFF of integers; not finite where not found");
  file_option("--confidence", files.confidence,
              "Its confidence, 0 to 1, in the same formats; integers are shares of their type's largest");
  file_option("--sigma", files.sigma, "Its predicted standard deviation, DP px, in the same formats");
  const auto scale_option = [&](const std::string& name, double& value, const std::string& meaning) {
    return command
        .add_option_function<double>(
            name, [&files, &value](double given) { value = given, files.scaled = true; }, meaning)
        ->check(number_range(-1e9, 1e9));
  };
  CLI::Option* scale = scale_option("--scale", files.integers.scale,
                                    "Value of one step of a disparity and sigma that are integers, e.g. 0.001");
  scale_option("--offset", files.integers.offset, "Value of their 0")->needs(scale);
  return disparity;
}

DisparityMaps read_maps(const MapFiles& files, std::vector<std::string>& problems) {
  const std::optional<IntegerScale> integers = files.scaled ? std::optional(files.integers) : std::nullopt;
  DisparityMaps maps;
  bool any_integers = false;
  const auto read_into = [&](Image& map, const std::string& path, const auto& read) {
    if (path.empty()) return;
    try {
      map = read(path);
    } catch (const InputError& error) {
      problems.emplace_back(error.what());
    }
  };
  const auto reader_of = [&](const char* channel) {
    return [&, channel](const std::string& path) {
      any_integers = any_integers || is_integer_picture(path);
      return read_map(path, channel, integers);
    };
  };
  read_into(maps.disparity_dp_px, files.disparity, reader_of("disparity_dp_px"));
  read_into(maps.sigma_dp_px, files.sigma, reader_of("sigma_dp_px"));
  read_into(maps.confidence, files.confidence, read_confidence);
  if (problems.empty() && files.scaled && !any_integers) {
    problems.emplace_back("--scale: neither disparity nor sigma is a picture of integers; leave it out");
  }
  return maps;
}

}  // namespace dualpixel::tools
