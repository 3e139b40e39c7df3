#pragma once
#include <algorithm>
#include <array>
#include <cstdint>

#include "capture/capture.h"
#include "capture/image/image.h"
#include "capture/matrix3.h"
#include "capture/names.h"
#include "capture/option_ranges.h"
#include "simulator/sampling/sensor_grid.h"

/// From light to digital numbers. Each half of a photosite counts photons and holds them in a well of its own, half of
/// the photosite's; the photosite's electrons are the sum of its halves, so mosaic and DP views share their shot noise
/// as on a real sensor, and each read-out adds its own read noise. A DP pixel is the mean of the green half-photosites
/// of its block, read one by one and digitized together; of a block of one, the half-photosite under its own filter.
/// Charge that comes without light is counted as light is; its mean is taken off, as the mean of optically black rows
/// is in a camera.
namespace dualpixel::simulator {

/// Which read-outs a pair of halves takes.
enum class Readout {
  independent,  ///< the sum, left, and right
  sum_and_left  ///< the sum and left; right = sum - left, after both were digitized
};
inline constexpr Named<Readout> kReadouts[] = {
    {"independent", Readout::independent, "each view is read out by itself"},
    {"sum_and_left", Readout::sum_and_left, "sum and left view are read out, right = sum - left"},
};

/// A sensor: its geometry, from which the renderer's SensorGrid and a capture's Camera are derived, and what turns
/// light into digital numbers.
struct SensorOptions {
  int width_px = 2688;   ///< even
  int height_px = 2016;  ///< multiple of 4
  double pixel_pitch_um = 1.4;
  /// Electrons that 1 lx s of a neutral light on one undivided photosite frees under its R, G, B filter. At 555 nm one
  /// lx s is 4.1e15 photons/m^2, 8000 on 1.4 um square; filter and quantum efficiency leave about half.
  std::array<double, 3> electrons_per_lux_s = {3600, 4000, 3200};
  double full_well_e = 6000;            ///< of the undivided photosite; the white level at ISO 100
  double well_spill = 0;                ///< share of the overflow of a half's well that the other half's takes
  double read_noise_e = 2.0;            ///< standard deviation of one read-out, ahead of the gain
  double read_noise_after_gain_dn = 0;  ///< likewise, behind it
  double row_noise_dn = 0;  ///< standard deviation of what all photosites of a row have in common in one read-out
  Readout readout = Readout::independent;
  // Charge without light, electrons a second of an undivided photosite at 25 C; it doubles every so many degrees.
  double dark_current_e_per_s = 0;
  double hot_pixel_share = 0;    ///< of all photosites, that have one leaky half: the same in every frame
  double hot_pixel_e_per_s = 0;  ///< mean of what those leak; it varies between them as an exponential
  double temperature_c = 25;
  double dark_current_doubling_c = 8;
  double row_time_us = 0;  ///< from a row's exposure to the next one's; 0: all rows are exposed together
  // Fixed pattern, the same in every frame of one camera and no part of its noise profile; normal.
  double prnu = 0;            ///< standard deviation of a photosite's sensitivity over its mean; its halves vary apart
  double dark_offset_dn = 0;  ///< ... of a read-out's offset; a photosite and each of its halves have their own
  std::uint64_t fixed_pattern_seed = 1;  ///< which camera
  /// What each filter sees of the scene's linear R, G, B, row by row; electrons_per_lux_s is that of a row that sums
  /// to 1.
  Matrix3 color_matrix = kIdentity3;
  /// Linear R, G, B of what is white in the scene's light, green being 1: the white balance and truth's pictures make
  /// it neutral.
  std::array<double, 3> illuminant = {1, 1, 1};
  int bits = 10;
  double black_level_dn = 64;
  int dp_downsample_x = 2;  ///< photosites per DP pixel: 2 x 4, 2 x 2, or 1 x 1 (dense, all colors)
  int dp_downsample_y = 4;
};

inline constexpr OptionRange<SensorOptions> kSensorRanges[] = {
    {"width_px", &SensorOptions::width_px, 2, 32768},
    {"height_px", &SensorOptions::height_px, 4, 32768},
    {"pixel_pitch_um", &SensorOptions::pixel_pitch_um, 0.1, 100},
    {"full_well_e", &SensorOptions::full_well_e, 1, 1e7},
    {"well_spill", &SensorOptions::well_spill, 0, 1},
    {"read_noise_e", &SensorOptions::read_noise_e, 0, 1e4},
    {"read_noise_after_gain_dn", &SensorOptions::read_noise_after_gain_dn, 0, 1e4},
    {"row_noise_dn", &SensorOptions::row_noise_dn, 0, 1e4},
    {"dark_current_e_per_s", &SensorOptions::dark_current_e_per_s, 0, 1e6},
    {"hot_pixel_share", &SensorOptions::hot_pixel_share, 0, 1},
    {"hot_pixel_e_per_s", &SensorOptions::hot_pixel_e_per_s, 0, 1e9},
    {"temperature_c", &SensorOptions::temperature_c, -273, 200},
    {"dark_current_doubling_c", &SensorOptions::dark_current_doubling_c, 1, 100},
    {"row_time_us", &SensorOptions::row_time_us, 0, 1000},
    {"prnu", &SensorOptions::prnu, 0, 0.5},
    {"dark_offset_dn", &SensorOptions::dark_offset_dn, 0, 1e4},
    {"dp_downsample_x", &SensorOptions::dp_downsample_x, 1, 2},
    {"dp_downsample_y", &SensorOptions::dp_downsample_y, 1, 4},
    {"bits", &SensorOptions::bits, 8, 16},
    {"black_level_dn", &SensorOptions::black_level_dn, 0, 32768},
};

std::optional<OptionProblem> check(const SensorOptions& sensor);

/// The photosites for rendering, the optical axis in the middle.
SensorGrid sensor_grid(const SensorOptions& sensor);

/// Fills what a capture's camera says of its sensor: photosites, color filters, DP pixels, principal point.
void describe_sensor(const SensorOptions& sensor, Camera& camera);

struct ExposureOptions {
  double time_s = 0.01;
  double iso = 100;
};

inline constexpr OptionRange<ExposureOptions> kExposureRanges[] = {
    {"time_s", &ExposureOptions::time_s, 1e-7, 1e4},
    {"iso", &ExposureOptions::iso, 1, 1e6},
};

inline std::optional<OptionProblem> check(const ExposureOptions& exposure) {
  return check_ranges(exposure, kExposureRanges);
}

/// Whether the charge that gathers without light leaves a fiftieth of the well.
std::optional<OptionProblem> check_dark(const SensorOptions& sensor, const ExposureOptions& exposure);

/// The electrons that the wells of a photosite's halves keep of `left` and `right`.
inline void fill_wells(const SensorOptions& sensor, double& left, double& right) {
  const double well = 0.5 * sensor.full_well_e;
  if (left <= well && right <= well) return;
  const double from_left = sensor.well_spill * std::max(left - well, 0.0);
  const double from_right = sensor.well_spill * std::max(right - well, 0.0);
  left = std::min(left + from_right, well);
  right = std::min(right + from_left, well);
}

/// Digital numbers per electron: the full well reaches the white level at ISO 100.
double gain_dn_per_electron(const SensorOptions& sensor, double iso);

/// Mean number of electrons that an undivided photosite which is not hot gathers without light.
double dark_electrons(const SensorOptions& sensor, const ExposureOptions& exposure);

/// Variance without light, DN^2, quantization aside: of a whole photosite's read-out, or of a half's in a view, which
/// is half of that of left - right (as Exposure's).
double read_noise_dn2(const SensorOptions& sensor, const ExposureOptions& exposure, bool whole);

/// Levels, colors, and the noise profiles that follow from shot noise, read noise and quantization (variance 1/12
/// DN^2). That of the views is half that of their difference: of one of them, where both are read out by themselves.
/// They hold where the noise ahead of quantization exceeds half a DN and the mean lies three standard deviations from 0
/// and from white; fixed pattern, hot pixels among it, is not part of them.
Exposure describe_exposure(const SensorOptions& sensor, const ExposureOptions& exposure);

/// Mean electrons of each half-photosite under its color filter; two channels: left, right. `left` and `right` are
/// radiance in nits as render_views() gives it.
Image expected_electrons(const Image& left, const Image& right, const SensorOptions& sensor,
                         const ExposureOptions& exposure, double lux_per_nit);

/// One frame's digital numbers. The same bytes for any number of threads.
Frame expose(const Image& electrons, const SensorOptions& sensor, const ExposureOptions& exposure, std::uint64_t seed);

}  // namespace dualpixel::simulator
