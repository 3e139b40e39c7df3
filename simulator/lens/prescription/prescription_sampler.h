#pragma once
#include <cstddef>
#include <memory>

#include "simulator/lens/lens_packet.h"
#include "simulator/lens/prescription/prescription_model.h"
#include "simulator/lens/prescription/pupil_reach.h"
#include "simulator/sampling/sensor_grid.h"

namespace dualpixel::simulator {

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
  void sample_polynomials(const PixelFrame& f, std::size_t index, const float s[2][kPacket], const PupilPositions& at,
                          LensPacket& rays, PupilPacket& pupil) const;
  void sample_traced(const PixelFrame& f, std::size_t index, const float s[2][kPacket], const PupilPositions& at,
                     LensPacket& rays, PupilPacket& pupil) const;
  PupilReaches reaches_of(std::size_t index) const;

  std::shared_ptr<const Tables> tables_;  ///< shared by copies
};

}  // namespace dualpixel::simulator
