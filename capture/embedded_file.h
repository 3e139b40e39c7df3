#pragma once
#include <string_view>

/// Defines name(), the bytes of the file at `path` (a string literal): unchanged, in the read-only data of the library
/// that is compiled with it. At global scope of a .cpp file.
#define DUALPIXEL_EMBEDDED_FILE(name, path)                                                                       \
  asm(".pushsection .rodata\n.globl dualpixel_" #name "_begin, dualpixel_" #name "_end\n.hidden dualpixel_" #name \
      "_begin, dualpixel_" #name "_end\ndualpixel_" #name "_begin:\n.incbin \"" path "\"\ndualpixel_" #name       \
      "_end:\n.popsection\n");                                                                                    \
  extern "C" {                                                                                                    \
  [[gnu::visibility("hidden")]] extern const char dualpixel_##name##_begin[];                                     \
  [[gnu::visibility("hidden")]] extern const char dualpixel_##name##_end[];                                       \
  }                                                                                                               \
  static std::string_view name() { return {dualpixel_##name##_begin, dualpixel_##name##_end}; }
