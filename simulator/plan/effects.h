#pragma once
#include <vector>

#include "capture/names.h"
#include "simulator/scene_file.h"

/// What a simulation can have or leave out beside its lens model, bounces, light and samples.
namespace dualpixel::simulator {

enum class Effect { diffraction, filter_bands, motion_blur };

inline constexpr Named<Effect> kEffects[] = {
    {"diffraction", Effect::diffraction, "rays bend at the stop"},
    {"filter bands", Effect::filter_bands, "five wavelengths of each filter's band, not one"},
    {"motion blur", Effect::motion_blur, "the hand moves the camera while a frame is exposed: eight poses, not one"},
};

/// Those that the simulation can have: diffraction, but behind a hard split only where the file has it, since bent rays
/// are no model of it there (docs/camera_effects.md); filter bands through a prescription with wavelengths; motion blur
/// in a hand that shakes, where nothing is animated. What costs nothing, as a shutter that rolls, stays as it is.
std::vector<Effect> effects_of(const Simulation& simulation);

bool has(const Simulation& simulation, Effect effect);

/// Whether an effect changes anything behind this lens.
bool knows(const Lens& lens, Effect effect);

Simulation without_effects(Simulation simulation);

/// Adds an effect of effects_of(file) to what without_effects(file) left: as the file has it, else as kEffects says. A
/// lens that does not know it stays as it is.
void add(Effect effect, const Simulation& file, Simulation& simulation);

}  // namespace dualpixel::simulator
