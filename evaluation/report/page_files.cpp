#include "evaluation/report/page_files.h"

#include "capture/embedded_file.h"

DUALPIXEL_EMBEDDED_FILE(embedded_style, DUALPIXEL_PAGE_FILES "/page.css")
DUALPIXEL_EMBEDDED_FILE(embedded_script, DUALPIXEL_PAGE_FILES "/page.js")
DUALPIXEL_EMBEDDED_FILE(embedded_study_script, DUALPIXEL_PAGE_FILES "/study.js")

namespace dualpixel::evaluation {

std::string_view page_style() { return embedded_style(); }
std::string_view page_script() { return embedded_script(); }
std::string_view study_script() { return embedded_study_script(); }

}  // namespace dualpixel::evaluation
