#pragma once

/// Style and script of the report page.
namespace dualpixel::tools {

extern const char* const kReportStyle;
extern const char* const kReportScript;

}  // namespace dualpixel::tools
