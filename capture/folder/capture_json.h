#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "capture/capture.h"
#include "capture/json_fields.h"

/// The parts of capture.json that hold no file names: docs/capture.md.
namespace dualpixel {

nlohmann::ordered_json to_json(const Camera& camera);
nlohmann::ordered_json to_json(const Exposure& exposure);

/// The fields by name in alphabetical order, absent where empty. Throws InputError where `scene`, `plan` or a value of
/// `other` is no JSON; `where` names the capture in the message.
nlohmann::json to_json(const Provenance& provenance, const std::string& where);

/// Throws InputError where reading would refuse what is written: values that no capture has.
void require_readable(const Camera& camera, const Exposure& exposure, const std::string& where);

Camera read_camera(Fields fields);
Exposure read_exposure(Fields fields);

/// Any object is accepted: a field that is not of its usual type goes to `other`, so that writing gives it back.
Provenance read_provenance(const nlohmann::json& object);

/// Fixed by this format's version; written so that a reader needs nothing else, and checked on reading.
nlohmann::ordered_json conventions();
void check_conventions(Fields fields);

}  // namespace dualpixel
