#pragma once
#include <variant>

#include "simulator/lens/aberrated/aberrated_model.h"
#include "simulator/lens/prescription/prescription_model.h"
#include "simulator/lens/thin/thin_model.h"

namespace dualpixel::simulator {

/// The parameters of a lens of any model; models.h says what a model is and how to add one.
using LensModel = std::variant<ThinModel, Aberrations, PrescriptionModel>;

}  // namespace dualpixel::simulator
