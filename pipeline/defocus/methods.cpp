#include "pipeline/defocus/methods.h"

#include <string>
#include <utility>

#include "capture/names.h"
#include "pipeline/defocus/defocused.h"
#include "pipeline/defocus/mask_blur.h"
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
    {"layers", "bands of disparity, blurred and laid from front to back", false, blur_layers},
    {"mask", "the background of a person mask, by one radius", true, blur_by_mask},
};

}  // namespace

std::span<const DefocusMethod> defocus_methods() { return kMethods; }

const DefocusMethod& defocus_method_named(std::string_view name) {
  if (const DefocusMethod* method = find_named(kMethods, name)) return *method;
  refuse_name("defocus method", std::string(name), names_of(kMethods));
}

}  // namespace dualpixel::pipeline
