#include "pipeline/portrait/options.h"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "capture/error.h"
#include "pipeline/defocus/aperture.h"
#include "pipeline/defocus/highlights.h"
#include "pipeline/defocus/layers.h"
#include "pipeline/defocus/mask_blur.h"

namespace dualpixel::pipeline {

PortraitOptions default_options(std::string_view matcher) {
  PortraitOptions options;
  options.matcher = matcher;
  if (matcher_named(matcher).wide_windows) {
    // chosen on six gray pairs of a phone, which do not tell about chroma: docs/disparity.md
    options.smooth.solver.lambda = 32;
    options.smooth.solver.robust_rounds = 4;
    options.smooth.solver.robust_scale = 1.2f;  // DP px
    options.smooth.grid.cell_luma = 4;
  }
  return options;
}

OptionFields fields(PortraitOptions& options) {
  OptionFields all;
  const auto add = [&](const std::string& group, OptionFields fields) {
    for (OptionField& field : fields) {
      if (!group.empty()) field.name = group + "." + field.name;
      all.push_back(std::move(field));
    }
  };
  add("merge", fields(options.merge));
  add("seed_faces", fields(options.seed_faces));
  add("", fields(options.matching));
  add("tile_upsample", fields(options.tile_upsample));
  add("merge_mask", fields(options.merge_mask));
  add("smooth", fields(options.smooth));
  add("filter_mask", fields(options.filter_mask));
  add("", {{"face_in_focus_dp_px", &options.face_in_focus_dp_px, 0, 64, "DP px", "ours (5.1: close to zero)"}});
  add("blur_radius", fields(options.blur_radius));
  add("layers", fields(options.defocus.layers));
  add("mask_blur", fields(options.defocus.mask_blur));
  add("highlights", fields(options.defocus.bokeh.highlights));
  add("noise", fields(options.noise));
  add("display", {{"exposure_ev", &options.display.exposure_ev, -20, 20, "stops", "ours"}});
  return all;
}

void check(const PortraitOptions& options) {
  check_options("", options);
  check(options.matching.normalize);  // of windows, more than a range
  check(options.matching.split_match);
  require_valid(options.defocus.bokeh.aperture);
  matcher_named(options.matcher);
}

nlohmann::ordered_json changed_fields(const PortraitOptions& options) {
  PortraitOptions defaults = default_options(options.matcher);
  const OptionFields usual = fields(defaults), own = fields(const_cast<PortraitOptions&>(options));  // only read
  nlohmann::ordered_json changed = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < own.size(); ++i) {
    const std::string value = value_text(own[i]);
    if (value != value_text(usual[i])) changed[own[i].name] = nlohmann::ordered_json::parse(value);
  }
  return changed;
}

std::string describe_fields(std::string_view matcher) {
  PortraitOptions defaults = default_options(matcher);
  const std::string line = "{:<42}{:>10}  {:<20}{:<24}{}\n";
  std::string text = fmt::format(fmt::runtime(line), "option", "default", "range", "unit", "source");
  for (const OptionField& field : fields(defaults)) {
    const std::string value =
        std::visit([](const auto* v) { return fmt::format("{:.6g}", static_cast<double>(*v)); }, field.value);
    text += fmt::format(fmt::runtime(line), field.name, value, fmt::format("{:g} .. {:g}", field.low, field.high),
                        field.unit, field.source);
  }
  return text + "Source: a section of Wadhwa et al. 2018 with its value (S: its supplement), or ours.\n";
}

}  // namespace dualpixel::pipeline
