#pragma once
#include <string_view>

/// The files of evaluation/report/web, which the program holds: pages inline them.
namespace dualpixel::evaluation {

std::string_view page_style();    ///< page.css
std::string_view page_script();   ///< page.js
std::string_view study_script();  ///< study.js, of the user study alone

}  // namespace dualpixel::evaluation
