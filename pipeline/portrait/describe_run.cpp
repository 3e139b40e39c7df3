#include "pipeline/portrait/describe_run.h"

#include <nlohmann/json.hpp>
#include <vector>

#include "pipeline/portrait/subject.h"
#include "pipeline/portrait/zoom.h"
#include "pipeline/segmentation/network.h"

namespace dualpixel::pipeline {
namespace {

/// What the run knew: not the capture's face where the zoom cut its center away.
KnownSubject subject_seen(const Capture& capture, const PortraitOptions& options, const PortraitResult& result) {
  KnownSubject known = known_subject(capture, options);
  if (known.source != "capture" || !result.window_px) return known;
  const auto& [x, y, width, height] = *result.window_px;
  return holds_center({x, y, width, height}, known.faces[0]) ? known : KnownSubject{};
}

/// Whose faces the run began from, in pixels of the user's picture.
void describe_faces(const KnownSubject& known, const PortraitResult& result, nlohmann::ordered_json& provenance) {
  std::vector<Face> faces = result.faces;
  if (faces.empty()) {
    faces = known.faces;
    if (known.tap) faces.push_back(*known.tap);
  }
  for (const Face& face : faces) provenance["faces_px"].push_back({face.x, face.y, face.width, face.height});
  if (!faces.empty()) provenance["faces"] = known.source.empty() ? (known.tap ? "tapped" : "detected") : known.source;
}

}  // namespace

nlohmann::ordered_json describe_run(const Capture& capture, const PortraitOptions& options,
                                    const PortraitResult& result) {
  nlohmann::ordered_json provenance = {{"mode", name_of(kModes, result.mode)}};
  if (result.mode != options.mode) provenance["requested_mode"] = name_of(kModes, options.mode);
  if (!result.mode_reason.empty()) provenance["mode_reason"] = result.mode_reason;
  if (result.window_px) provenance["window_px"] = *result.window_px;
  provenance["seed"] = options.seed;
  const Aperture& aperture = options.defocus.bokeh.aperture;
  if (aperture.blades > 0) provenance["blades"] = aperture.blades;
  if (aperture.cats_eye > 0) provenance["cats_eye"] = aperture.cats_eye;
  if (options.defocus.bokeh.recover_highlights) provenance["recover_highlights"] = true;
  if (!options.synthetic_noise) provenance["synthetic_noise"] = false;
  const nlohmann::ordered_json changed = changed_fields(options);
  if (!changed.empty()) provenance["options"] = changed;
  if (!result.warnings.empty()) provenance["warnings"] = result.warnings;
  describe_faces(subject_seen(capture, options, result), result, provenance);
  if (!result.faces.empty()) {
    provenance["mask"] = "found";
    provenance["person_weights_hash"] = built_in_weights().file_hash;
  }
  return provenance;
}

}  // namespace dualpixel::pipeline
