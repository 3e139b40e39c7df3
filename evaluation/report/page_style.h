#pragma once

/// Style of all pages, and the script of the page about results.
namespace dualpixel::evaluation {

extern const char* const kPageStyle;
extern const char* const kReportScript;

}  // namespace dualpixel::evaluation
