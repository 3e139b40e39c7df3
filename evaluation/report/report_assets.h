#pragma once

/// Style and script of the report page.
namespace dualpixel::evaluation {

extern const char* const kReportStyle;
extern const char* const kReportScript;

}  // namespace dualpixel::evaluation
