#include <cmath>
#include <random>

#include "evaluation/calibration_sweep/plane_disparity.h"
#include "evaluation/experiments/calibration_cost.h"
#include "evaluation/report/report_images.h"
#include "evaluation/stage_failures/stage_row.h"
#include "scenes/drawn/phone_lenses.h"
#include "simulator/sampling/hash.h"
#include "simulator/scene_file.h"

namespace dualpixel::evaluation {
namespace {

/// How targets are photographed, and by how much the photographer's figures are wrong.
struct Photographs {
  SweepOptions sweep;
  double all_distances = 0;   ///< of every target's distance, share
  double each_distance = 0;   ///< of each target's own, standard deviation as a share
  double focus_distance = 0;  ///< of the later capture's focus distance, share
  bool all_focuses = false;   ///< not only the two around kCostFocus_m, which are all that is used where it is right
};

/// A phone whose field curves, and the disparity that it really has at kCostFocus_m.
struct CurvedPhone {
  simulator::Simulation simulation;
  simulator::DisparityField field;
  double uncorrected_dp_px;
};

const CurvedPhone& curved_phone() {
  static const CurvedPhone phone = [] {
    simulator::Simulation simulation;
    simulation.lens = simulator::read_lens_of(scenes::phone_lens("phone_aberrated"), "phone_aberrated", 1).lens;
    const simulator::DisparityField field(focused_lens(simulation, kCostFocus_m));
    const double before = field_deviation_dp_px(field, describe_camera(simulation), nullptr);
    return CurvedPhone{simulation, field, before};
  }();
  return phone;
}

/// Calibrates by these photographs and corrects a capture: what is left over what there was.
StageOutcome after_correction(Photographs photographs, unsigned draw) {
  const auto& [simulation, field, before] = curved_phone();
  photographs.sweep.seed = draw + 1;
  std::vector<pipeline::TargetMeasurement> measurements =
      photographs.all_focuses ? run_sweep(simulation, photographs.sweep)
                              : measure_around(simulation, kCostFocus_m, photographs.sweep);
  std::mt19937_64 random(simulator::hash(draw));
  std::normal_distribution<double> normal;
  for (pipeline::TargetMeasurement& measured : measurements) {
    measured.target_distance_m *=
        (1 + photographs.all_distances) * std::exp(photographs.each_distance * normal(random));
  }
  Camera camera = describe_camera(simulation);
  const pipeline::Calibration calibration = fit_calibration(camera, measurements);
  camera.focus_distance_m = kCostFocus_m * (1 + photographs.focus_distance);
  const pipeline::Correction correction = make_correction(calibration, camera);
  Image error = plane_disparity(field, camera, kCostDepths_m[1], &correction);
  const float middle = error.at(error.width / 2, error.height / 2);
  for (float& value : error.data) value -= middle;
  return {field_deviation_dp_px(field, camera, &correction) / before,
          diverging_colors(error, static_cast<float>(before))};
}

/// A row that changes one thing of the photographs.
StageRow calibration_row(StageRow row, void (*change)(Photographs&, double)) {
  row.stage = "calibration";
  row.figure = "deviation of a plane's disparity over the field, over that before correction";
  row.limit = 0.5;
  row.reason = "Half of what there was to correct remains.";
  row.make = [change](double value, unsigned draw) {
    Photographs photographs;
    change(photographs, value);
    return after_correction(photographs, draw);
  };
  return row;
}

}  // namespace

std::vector<StageRow> calibration_rows() {
  const auto row = [](const std::string& name, const std::string& title, const std::string& sweep,
                      const std::string& key, const std::vector<double>& values, const std::string& note,
                      void (*change)(Photographs&, double)) {
    StageRow all;
    all.name = name, all.title = title, all.sweep = sweep, all.key = key, all.values = values, all.note = note;
    return calibration_row(all, change);
  };
  return {
      row("tilt", "A tilted target", "tilt, degrees", "tilt_deg", {0, 2, 5, 10, 20},
          "One side of the target is farther than is stated. `calibrate` warns from .7 degrees on.",
          [](Photographs& p, double tilt) { p.sweep.tilt_x_deg = tilt; }),
      row("coarse_texture", "Coarse texture", "finest cells of the print, photosites", "finest_px",
          {32, 64, 128, 256, 512}, "The coarser the print, the fewer cells a node of the field averages over.",
          [](Photographs& p, double px) { p.sweep.finest_px = static_cast<int>(px); }),
      row("noisy_targets", "Noisy photographs", "ISO", "iso", {100, 400, 1600, 6400, 25600},
          "One frame of a phone's sensor for each photograph.",
          [](Photographs& p, double iso) { p.sweep.noise = frame_noise(curved_phone().simulation.sensor, iso); }),
      row("wrong_distance", "A ruler of wrong scale", "error of all distances, share", "share", {0, 0.3, 1},
          "No value breaks it: a line through the wrong inverse depths is the same line with another scale at every "
          "point of the field, and the correction takes ratios.",
          [](Photographs& p, double share) { p.all_distances = share; }),
      row("uneven_distances", "Distances read badly", "error of each distance, standard deviation, share", "share",
          {0, 0.1, 0.5},
          "Each photograph's own error; all points of the field share it, so that it cancels from their ratios.",
          [](Photographs& p, double share) { p.each_distance = share; }),
      row("wrong_focus", "Another focus than stated", "how much farther the capture's focus is stated, share", "share",
          {0, 0.1, 0.3, 1},
          "As where a phone's lens is not where its motor was sent. Seven focus distances, three targets at each.",
          [](Photographs& p, double share) {
            p.focus_distance = share;
            p.all_focuses = true;
            p.sweep.focuses = 7, p.sweep.targets = 3;
          }),
      row("by_hand", "Few photographs, by hand", "focus distances, three targets at each", "focus_distances",
          {20, 7, 4, 3, 2}, "With a printed sheet and a ruler, at ISO 400: tilted by a degree, distances read to 2 %.",
          [](Photographs& p, double focuses) {
            p.each_distance = 0.02;
            p.sweep.tilt_x_deg = 1;
            p.sweep.noise = frame_noise(curved_phone().simulation.sensor, 400);
            p.sweep.focuses = static_cast<int>(focuses), p.sweep.targets = 3;
          }),
  };
}

}  // namespace dualpixel::evaluation
