#pragma once
#include <nlohmann/json_fwd.hpp>

#include "capture/capture.h"
#include "pipeline/portrait/options.h"
#include "pipeline/portrait/result.h"

namespace dualpixel::pipeline {

/// What result.json's provenance says of a run, whoever asked for it: mode, seed, options, faces, warnings. The files
/// that it was made from are for the caller to add.
nlohmann::ordered_json describe_run(const Capture& capture, const PortraitOptions& options,
                                    const PortraitResult& result);

}  // namespace dualpixel::pipeline
