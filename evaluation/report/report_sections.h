#pragma once
#include <string>

#include "capture/capture.h"
#include "evaluation/report/report_page.h"
#include "pipeline/portrait/result_io.h"

/// What the page of `dualpixel report` shows of captures and results, as pictures and figures.
namespace dualpixel::evaluation {

/// `path` as a page in `folder` shows it: relative to the page; its last name alone where that would lead further up
/// than to the folder's neighbors, since a page travels and says nothing about the machine.
std::string path_from_page(const std::string& path, const std::string& folder);

/// Without results. `path` is the capture's, `page_folder` that of the page.
CaptureSection make_capture_section(const Capture& capture, const std::string& path, const std::string& page_folder);

/// Adds a result to the capture that it was made of; with a score and errors where the capture holds truth. Throws
/// InputError where the result does not fit the capture.
void add_result(CaptureSection& section, const Capture& capture, const std::string& capture_path,
                const pipeline::StoredResult& stored, const std::string& result_path, const std::string& page_folder);

}  // namespace dualpixel::evaluation
