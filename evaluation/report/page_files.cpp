#include "evaluation/report/page_files.h"

// The files, unchanged, in the library's read-only data.
#define DUALPIXEL_PAGE_FILE(name, file)                                                                           \
  asm(".pushsection .rodata\n.globl dualpixel_" #name "_begin, dualpixel_" #name "_end\n.hidden dualpixel_" #name \
      "_begin, dualpixel_" #name "_end\ndualpixel_" #name "_begin:\n.incbin \"" DUALPIXEL_PAGE_FILES "/" file     \
      "\"\ndualpixel_" #name "_end:\n.popsection\n");                                                             \
  extern "C" {                                                                                                    \
  [[gnu::visibility("hidden")]] extern const char dualpixel_##name##_begin[];                                     \
  [[gnu::visibility("hidden")]] extern const char dualpixel_##name##_end[];                                       \
  }
DUALPIXEL_PAGE_FILE(page_style, "page.css")
DUALPIXEL_PAGE_FILE(page_script, "page.js")
#undef DUALPIXEL_PAGE_FILE

namespace dualpixel::evaluation {

std::string_view page_style() { return {dualpixel_page_style_begin, dualpixel_page_style_end}; }
std::string_view page_script() { return {dualpixel_page_script_begin, dualpixel_page_script_end}; }

}  // namespace dualpixel::evaluation
