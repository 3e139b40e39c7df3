#include "scenes/drawn/phone_lenses.h"

#include <map>
#include <string_view>

// The files, unchanged, in the library's read-only data.
#define DUALPIXEL_LENS(name, file)                                                                                \
  asm(".pushsection .rodata\n.globl dualpixel_" #name "_begin, dualpixel_" #name "_end\n.hidden dualpixel_" #name \
      "_begin, dualpixel_" #name "_end\ndualpixel_" #name "_begin:\n.incbin \"" DUALPIXEL_LENS_MODELS "/" file    \
      "\"\ndualpixel_" #name "_end:\n.popsection\n");                                                             \
  extern "C" {                                                                                                    \
  [[gnu::visibility("hidden")]] extern const char dualpixel_##name##_begin[];                                     \
  [[gnu::visibility("hidden")]] extern const char dualpixel_##name##_end[];                                       \
  }
DUALPIXEL_LENS(phone_6p, "phone_6p_4.2mm_f1.8.json")
DUALPIXEL_LENS(phone_7p, "phone_7p_4.9mm_f1.85.json")
DUALPIXEL_LENS(phone_aberrated, "phone_aberrated_4.4mm_f1.8.json")
DUALPIXEL_LENS(phone_thin, "phone_thin_4.4mm_f1.8.json")
#undef DUALPIXEL_LENS

namespace dualpixel::scenes {

nlohmann::json phone_lens(const std::string& name) {
  const auto text = [](const char* begin, const char* end) {
    return std::string_view(begin, static_cast<std::size_t>(end - begin));
  };
  const std::map<std::string, std::string_view> files = {
      {"phone_6p", text(dualpixel_phone_6p_begin, dualpixel_phone_6p_end)},
      {"phone_7p", text(dualpixel_phone_7p_begin, dualpixel_phone_7p_end)},
      {"phone_aberrated", text(dualpixel_phone_aberrated_begin, dualpixel_phone_aberrated_end)},
      {"phone_thin", text(dualpixel_phone_thin_begin, dualpixel_phone_thin_end)}};
  return nlohmann::json::parse(files.at(name));
}

}  // namespace dualpixel::scenes
