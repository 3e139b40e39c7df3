#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "capture/error.h"
#include "capture/image/read_mask.h"
#include "capture/views.h"
#include "pipeline/burst/merge.h"
#include "pipeline/disparity/match_pixels.h"
#include "pipeline/disparity/matchers.h"
#include "pipeline/disparity/tile_disparity.h"
#include "pipeline/disparity/upsample.h"
#include "pipeline/portrait/describe_run.h"
#include "pipeline/portrait/result_io.h"
#include "pipeline/portrait/run_portrait.h"
#include "pipeline/segmentation/network.h"
#include "python/binding/arrays.h"
#include "python/binding/bind.h"

namespace dualpixel::python {
namespace {

using pipeline::PortraitOptions;
using pipeline::PortraitResult;
using Assignments = std::vector<std::string>;

/// A result that Python holds, and how it was made.
struct HeldResult {
  PortraitResult result;
  nlohmann::ordered_json provenance;
};

py::tuple arrays_of(pipeline::PixelDisparity found) {
  return py::make_tuple(moved_to_array(std::move(found.disparity_dp_px)), moved_to_array(std::move(found.confidence)),
                        moved_to_array(std::move(found.sigma_dp_px)));
}

/// `matcher`: that reads them; none, where disparity is given.
template <typename Options>
void set_fields(Options& options, const Assignments& assignments, const pipeline::Matcher* matcher) {
  for (const std::string& assignment : assignments) {
    try {
      set_field(pipeline::fields(options), assignment);
      pipeline::require_read_by(matcher, assignment.substr(0, assignment.find('=')));
    } catch (const InputError& error) {
      throw InputError(std::string("options: ") + error.what());
    }
  }
}

pipeline::MatcherOptions matcher_options(const Assignments& assignments, const pipeline::Matcher& matcher) {
  pipeline::MatcherOptions options;
  set_fields(options, assignments, &matcher);
  return options;
}

py::tuple match_arrays(const py::object& left, const py::object& right, const std::string& matcher,
                       const Assignments& assignments, const std::optional<std::pair<float, float>>& noise,
                       float white) {
  const Image left_view = image_of(left, "left"), right_view = image_of(right, "right");
  pipeline::ViewSensor sensor{{}, white};
  if (noise) sensor.noise = {noise->first, noise->second};
  pipeline::PixelDisparity found;
  {
    const py::gil_scoped_release released;
    const pipeline::Matcher& chosen = pipeline::matcher_named(matcher);
    const pipeline::TileDisparity tiles =
        chosen.match(left_view, right_view, sensor, matcher_options(assignments, chosen));
    found = pipeline::upsample_tiles(tiles, left_view.width, left_view.height);
  }
  return arrays_of(std::move(found));
}

/// As the portrait does: of the merged burst.
py::tuple match_capture(const HeldCapture& held, const std::string& matcher, const Assignments& assignments) {
  pipeline::PixelDisparity found;
  {
    const py::gil_scoped_release released;
    const Capture& capture = held.capture;
    require_views(capture, held.folder.empty() ? "capture" : held.folder);
    const pipeline::MergedBurst burst = pipeline::align_and_merge(capture.frames, capture.exposure);
    const double noise_left = pipeline::merged_view_variance(static_cast<int>(capture.frames.size()));
    const pipeline::Matcher& chosen = pipeline::matcher_named(matcher);
    found =
        pipeline::match_pixels(capture, burst.left, burst.right, pipeline::view_sensor(capture.exposure, noise_left),
                               chosen, matcher_options(assignments, chosen));
  }
  return arrays_of(std::move(found));
}

/// As the program has it.
void require_mask_fits(const Image& mask, pipeline::Mode mode, const Camera& camera) {
  if (mode == pipeline::Mode::dp) {
    throw InputError("mode dp: uses no person mask; leave out mask, or choose dp+seg or seg");
  }
  require_shape(mask, camera.width_px, camera.height_px, "mask");
}

/// As the program's, of a capture that may lie nowhere and of arrays without names.
nlohmann::ordered_json provenance_of(const HeldCapture& held, const PortraitOptions& options,
                                     const std::string& matcher, bool mask_given, const PortraitResult& result) {
  nlohmann::ordered_json provenance = {{"program", "dualpixel " DUALPIXEL_VERSION}};
  const std::string source = held.photograph ? "picture" : "capture";
  if (!held.folder.empty()) provenance[source] = held.folder, provenance[source + "_hash"] = held.hash;
  if (options.disparity) {
    provenance["disparity"] = "array";
  } else if (!held.photograph) {
    provenance["matcher"] = matcher;
  }
  provenance.update(describe_run(held.capture, options, result));
  if (mask_given) provenance["mask"] = "array";
  if (!held.assumed.empty()) provenance["assumed"] = held.assumed;
  return provenance;
}

/// Mode automatic goes without people where this build cannot find them, as the program does.
bool seeks_people(const HeldCapture& held, pipeline::Mode mode) {
  const bool must = mode != pipeline::Mode::automatic || held.photograph;
  return mode != pipeline::Mode::dp && (must || pipeline::has_person_network());
}

std::shared_ptr<HeldResult> make_portrait(const HeldCapture& held, const std::string& mode, const std::string& matcher,
                                          const Assignments& assignments, const py::object& mask,
                                          const std::vector<std::array<double, 4>>& faces, bool zoom,
                                          std::uint64_t seed, const py::object& disparity, const py::object& confidence,
                                          const py::object& sigma) {
  std::optional<Image> person;
  if (!mask.is_none()) person = image_of(mask, "mask");
  std::optional<pipeline::GivenDisparity> found;
  if (!disparity.is_none()) {
    found = {image_of(disparity, "disparity"), image_of(confidence, "confidence"), image_of(sigma, "sigma")};
  }
  const py::gil_scoped_release released;
  const pipeline::Matcher* chosen = found ? nullptr : &pipeline::matcher_named(matcher);
  PortraitOptions options = chosen ? pipeline::default_options(chosen->name) : PortraitOptions();
  set_fields(options, assignments, chosen);
  options.mode = value_named(pipeline::kModes, mode, "mode");
  options.seed = seed;
  options.zoom = zoom;
  if (person) require_mask_fits(*person, options.mode, held.capture.camera);
  if (found && options.mode == pipeline::Mode::seg) {
    throw InputError("mode seg: uses no disparity; leave out disparity, or choose dp or dp+seg");
  }
  for (const auto& [x, y, width, height] : faces) options.faces.push_back({x, y, width, height});
  options.disparity = std::move(found);
  options.picture = held.photograph;
  std::optional<pipeline::PersonNetwork> network;
  if (!person && seeks_people(held, options.mode)) {
    network.emplace(pipeline::built_in_weights());
    options.find_people = [&](const Image& picture, const std::vector<pipeline::Face>& seeds) {
      return pipeline::find_people(picture, seeds, *network, options.seed_faces);
    };
  }
  auto result = std::make_shared<HeldResult>();
  try {
    result->result = pipeline::run_portrait(held.capture, options, person);
  } catch (const pipeline::NobodyFound& error) {
    throw InputError(held.folder.empty() ? error.what() : printable(held.folder) + ": " + error.what());
  }
  result->provenance = provenance_of(held, options, matcher, person.has_value(), result->result);
  return result;
}

void bind_result(py::module_& module) {
  py::class_<HeldResult, std::shared_ptr<HeldResult>> type(module, "PortraitResult");
  using R = PortraitResult;
  constexpr std::pair<const char*, Image R::*> kImages[] = {{"input", &R::input},
                                                            {"portrait", &R::portrait},
                                                            {"portrait_srgb", &R::portrait_srgb},
                                                            {"disparity", &R::disparity_dp_px},
                                                            {"confidence", &R::confidence},
                                                            {"matched_disparity", &R::matched_disparity_dp_px},
                                                            {"matched_confidence", &R::matched_confidence},
                                                            {"matched_sigma", &R::matched_sigma_dp_px},
                                                            {"mask", &R::mask},
                                                            {"blur_radius", &R::blur_radius_px}};
  for (const auto& [name, image] : kImages) {
    type.def_property_readonly(name, [image = image](const py::object& self) {
      return view_of(self.cast<const HeldResult&>().result.*image, self, true);
    });
  }
  type.def_property_readonly("focus_disparity",
                             [](const HeldResult& self) { return self.result.focus_disparity_dp_px; });
  type.def_property_readonly("warnings", [](const HeldResult& self) { return self.result.warnings; });
  type.def_property_readonly("json",
                             [](const HeldResult& self) { return to_python(to_json(self.result, self.provenance)); });
  type.def_property_readonly("provenance", [](const HeldResult& self) { return to_python(self.provenance); });
  type.def(
      "write",
      [](const HeldResult& self, const std::filesystem::path& path) {
        pipeline::write_result(self.result, self.provenance, path.string());
      },
      py::arg("path"), py::call_guard<py::gil_scoped_release>());
}

}  // namespace

void bind_pipeline(py::module_& module) {
  bind_result(module);
  module.def("match_arrays", match_arrays, py::arg("left"), py::arg("right"), py::arg("matcher"), py::arg("options"),
             py::arg("noise"), py::arg("white"));
  module.def("match_capture", match_capture, py::arg("capture"), py::arg("matcher"), py::arg("options"));
  module.def("portrait", make_portrait, py::arg("capture"), py::arg("mode"), py::arg("matcher"), py::arg("options"),
             py::arg("mask"), py::arg("faces"), py::arg("zoom"), py::arg("seed"), py::arg("disparity"),
             py::arg("confidence"), py::arg("sigma"));
}

}  // namespace dualpixel::python
