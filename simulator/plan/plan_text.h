#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "simulator/plan/plan.h"

namespace dualpixel::simulator {

/// Everything a program may want. Without times it is the same at every run, as what goes into a capture must be.
nlohmann::ordered_json plan_json(const Plan& plan, bool with_times);

/// A table, and one sentence to conclude.
std::string plan_text(const Plan& plan);

}  // namespace dualpixel::simulator
