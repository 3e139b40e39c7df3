#include "scenes/drawn/phone_lenses.h"

#include <map>
#include <string_view>

#include "capture/embedded_file.h"

DUALPIXEL_EMBEDDED_FILE(phone_6p, DUALPIXEL_LENS_MODELS "/phone_6p_4.2mm_f1.8.json")
DUALPIXEL_EMBEDDED_FILE(phone_7p, DUALPIXEL_LENS_MODELS "/phone_7p_4.9mm_f1.85.json")
DUALPIXEL_EMBEDDED_FILE(phone_aberrated, DUALPIXEL_LENS_MODELS "/phone_aberrated_4.4mm_f1.8.json")
DUALPIXEL_EMBEDDED_FILE(phone_thin, DUALPIXEL_LENS_MODELS "/phone_thin_4.4mm_f1.8.json")

namespace dualpixel::scenes {

nlohmann::json phone_lens(const std::string& name) {
  const std::map<std::string, std::string_view> files = {{"phone_6p", phone_6p()},
                                                         {"phone_7p", phone_7p()},
                                                         {"phone_aberrated", phone_aberrated()},
                                                         {"phone_thin", phone_thin()}};
  return nlohmann::json::parse(files.at(name));
}

}  // namespace dualpixel::scenes
