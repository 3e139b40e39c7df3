#pragma once
#include <string>

#include "simulator/plan/lens_report.h"

namespace dualpixel::evaluation {

/// The page of `dualpixel lens`: one self-contained HTML page with the plots of `report`.
std::string lens_page(const simulator::LensReport& report);

}  // namespace dualpixel::evaluation
