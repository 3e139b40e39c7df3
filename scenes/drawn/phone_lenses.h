#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace dualpixel::scenes {

/// Names of the phone lenses of lens_models/ that every build holds, so that a drawn scene file needs no other file.
inline constexpr const char* kPhoneLenses[] = {"phone_6p", "phone_7p", "phone_aberrated", "phone_thin"};

/// The lens file of that name.
nlohmann::json phone_lens(const std::string& name);

}  // namespace dualpixel::scenes
