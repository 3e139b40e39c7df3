#include "pipeline/defocus/methods.h"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "capture/error.h"
#include "pipeline/defocus/render.h"

namespace dualpixel::pipeline {
namespace {

Defocused blur_layers(const DefocusInput& input, const DefocusOptions& options) {
  Image radius_px = blur_radii(input.disparity_dp_px, input.mapping);
  Defocused defocused =
      render_defocus(input.rgb, input.disparity_dp_px, radius_px, input.mapping, options.layers, options.bokeh);
  defocused.radius_px = std::move(radius_px);
  return defocused;
}

Defocused blur_by_mask(const DefocusInput& input, const DefocusOptions& options) {
  return blur_background(input.rgb, input.person_mask, options.mask_blur, options.bokeh);
}

constexpr DefocusMethod kMethods[] = {
    {"layers", "bands of disparity, blurred from back to front", blur_layers},
    {"mask", "the background of a person mask, by one radius", blur_by_mask},
};

}  // namespace

std::span<const DefocusMethod> defocus_methods() { return kMethods; }

const DefocusMethod& defocus_method_named(std::string_view name) {
  std::vector<std::string> names;
  for (const DefocusMethod& method : kMethods) {
    if (method.name == name) return method;
    names.emplace_back(method.name);
  }
  throw InputError(fmt::format("defocus method: {}: must be {}{}", printable(std::string(name)),
                               fmt::join(names, " or "), did_you_mean(std::string(name), names)));
}

}  // namespace dualpixel::pipeline
