#pragma once
#include <memory>
#include <string>

#include "simulator/lens/lens_packet.h"
#include "simulator/lens/prescription/prescription.h"
#include "simulator/lens/thin/thin_model.h"

namespace dualpixel::simulator {

class PrescriptionSampler;

/// A lens by its surfaces and glasses, stopped down and focused. Rendering uses polynomials that are fitted to its
/// traced rays, or, on request, traces every surface for every sample.
struct PrescriptionModel {
  std::shared_ptr<const Prescription> prescription;
  bool exact_trace = false;

  static constexpr double kWork = 1.4;  ///< by polynomials
  static constexpr double kExactTraceWork = 5.5;
  using Sampler = PrescriptionSampler;

  static PrescriptionModel read(Fields& lens, const std::string& file, double focus_distance_m, ThinLens& thin);
  double radius_of_image_mm() const { return prescription->image_radius_mm; }
  void refocus(double focus_distance_m, ThinLens& thin);
};

class PrescriptionSampler {
 public:
  /// Searches the pupils and fits the polynomials: up to a second. Throws InputError where no light passes the lens on
  /// its axis.
  PrescriptionSampler(const PrescriptionModel& model, const ThinLens& thin, const SensorGrid& sensor);
  void sample(const PixelFrame& f, int color, const float s[4][kPacket], LensPacket& rays, PupilPacket& pupil) const;
  double chief_slope_per_m(double radius_m) const;
  double lux_per_nit() const;
  bool has_color() const;

 private:
  struct Tables;
  void sample_polynomials(const PixelFrame& f, int color, const float s[4][kPacket], LensPacket& rays,
                          PupilPacket& pupil) const;
  void sample_traced(const PixelFrame& f, int color, const float s[4][kPacket], LensPacket& rays,
                     PupilPacket& pupil) const;

  std::shared_ptr<const Tables> tables_;  ///< shared by copies
};

}  // namespace dualpixel::simulator
