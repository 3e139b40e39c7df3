#include "simulator/plan/effects.h"

#include <memory>
#include <utility>

#include "simulator/lens/prescription/prescription.h"

namespace dualpixel::simulator {
namespace {

constexpr int kBandSamples = 5, kPoses = 8;

bool has_color(const Lens& lens) { return prescription_of(lens) && prescription_of(lens)->has_color(); }

void set_band_samples(Lens& lens, int samples) {
  if (!has_color(lens)) return;
  auto* model = std::get_if<PrescriptionModel>(&lens.model);
  Prescription prescription = *model->prescription;
  prescription.band_samples = samples;
  model->prescription = std::make_shared<const Prescription>(std::move(prescription));
}

}  // namespace

std::vector<Effect> effects_of(const Simulation& s) {
  std::vector<Effect> effects;
  if (s.lens.split.kind != SplitKind::hard || s.lens.diffraction) effects.push_back(Effect::diffraction);
  if (has_color(s.lens)) effects.push_back(Effect::filter_bands);
  if (s.hand_shake > 0 && !s.animation) effects.push_back(Effect::motion_blur);
  return effects;
}

bool knows(const Lens& lens, Effect effect) { return effect != Effect::filter_bands || has_color(lens); }

bool has(const Simulation& s, Effect effect) {
  switch (effect) {
    case Effect::diffraction:
      return s.lens.diffraction;
    case Effect::filter_bands:
      return prescription_of(s.lens) && prescription_of(s.lens)->band_samples > 1;
    case Effect::motion_blur:
      return s.hand_shake > 0 && s.exposure_poses > 1;
  }
  return false;
}

Simulation without_effects(Simulation s) {
  s.lens.diffraction = false;
  set_band_samples(s.lens, 1);
  if (!s.animation) s.exposure_poses = 1;
  return s;
}

void add(Effect effect, const Simulation& file, Simulation& s) {
  switch (effect) {
    case Effect::diffraction:
      s.lens.diffraction = true;
      break;
    case Effect::filter_bands:
      set_band_samples(s.lens, has(file, effect) ? prescription_of(file.lens)->band_samples : kBandSamples);
      break;
    case Effect::motion_blur:
      s.exposure_poses = has(file, effect) ? file.exposure_poses : kPoses;
      break;
  }
}

}  // namespace dualpixel::simulator
