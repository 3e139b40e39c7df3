#pragma once
#include <string>

#include "capture/capture.h"
#include "evaluation/report/report_page.h"
#include "pipeline/portrait/result_io.h"

/// What the page of `dualpixel report` shows of captures and results, as pictures and figures.
namespace dualpixel::evaluation {

/// `path` is the capture's name on the page.
CaptureSection make_capture_section(const Capture& capture, const std::string& path);

/// With a score and maps of errors where the capture holds truth. Throws InputError where the result does not fit the
/// capture.
ResultSection make_result_section(const Capture& capture, const std::string& capture_path,
                                  const pipeline::StoredResult& stored, const std::string& result_path);

}  // namespace dualpixel::evaluation
