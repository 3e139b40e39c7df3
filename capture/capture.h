#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture/image/image.h"
#include "capture/matrix3.h"

/// A capture is what a dual-pixel camera delivers for one press of the shutter, rendered or real: the only data that
/// passes from the simulator to the pipeline. docs/capture.md defines its folder on disk, field by field.
///
/// Camera axes are OpenCV's: x right, y down, z forward. All images are upright. The left view is the light that
/// crossed the pupil at x < 0 (the left viewpoint, as in a stereo pair), so that with
///     right(x + d) = left(x)
/// the disparity d is negative in front of the focus plane, 0 on it, and positive behind it:
///     d = alpha * b,   b = L f / (1 - f/z) * (1/z - 1/D)          (Wadhwa et al. 2018, Eq. 3 and supplement)
/// with pupil diameter L, focal length f, focus distance z and planar depth D, both from the entrance pupil.
namespace dualpixel {

/// Row-major 4x4; points are columns.
using Matrix4 = std::array<double, 16>;
inline constexpr Matrix4 kIdentity4 = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

struct Camera {
  std::string name = "unnamed";
  int width_px = 0;           ///< photosites of the full sensor; even
  int height_px = 0;          ///< multiple of 4
  double pixel_pitch_um = 0;  ///< of one photosite
  std::string cfa = "RGGB";   ///< colors of the top-left 2x2 photosites, row by row
  int dp_downsample_x = 2;    ///< photosites per DP pixel, horizontally
  int dp_downsample_y = 4;    ///< ... and vertically; green photosites only, but where it is 1 x 1
  double focal_length_mm = 0;
  double f_number = 0;
  double focus_distance_m = 0;                 ///< z, from the entrance pupil; infinity is allowed
  std::array<double, 2> principal_point_px{};  ///< continuous full-sensor coordinates
  std::string split = "unknown";               ///< a name of kSplitKinds (capture/split_kinds.h), or "unknown"
  double alpha = 0;  ///< centroid disparity over signed blur diameter, both in DP px; 0: unknown
  /// Lens shading: light of an undivided photosite before an even scene, over that of one on the axis behind the whole
  /// pupil. Nodes of an even grid, at least 2 x 2, whose outer ones lie in the middle of the outermost photosites;
  /// linear in between (capture/shading.h). Empty: not known, or 1 all over.
  Image relative_light;

  int bayer_plane_width() const { return width_px / 2; }
  int bayer_plane_height() const { return height_px / 2; }
  int dp_width() const { return width_px / dp_downsample_x; }
  int dp_height() const { return height_px / dp_downsample_y; }
  double dp_pitch_um() const { return pixel_pitch_um * dp_downsample_x; }
};

/// Variance of a digital number whose mean is x above black: shot * x + read. Units DN and DN^2.
struct NoiseProfile {
  double shot_dn = 0;
  double read_dn2 = 0;
};

struct Exposure {
  double time_s = 0;
  double iso = 0;
  int bits = 10;
  double black_level_dn = 0;                    ///< of a mosaic photosite and of a DP half-pixel alike
  double white_level_dn = 0;                    ///< of the normalized signal 1
  std::optional<double> mosaic_white_level_dn;  ///< at which the mosaic clips; empty: at white_level_dn
  std::optional<double> dp_white_level_dn;      ///< likewise a DP view
  NoiseProfile mosaic_noise;                    ///< of one photosite
  NoiseProfile dp_noise;  ///< of one pixel of one DP view; where views are correlated, half that of their difference
  /// Gains of R, G, B, green 1, that make a neutral gray read the same in all three: "as shot" white balance.
  std::array<double, 3> white_balance = {1, 1, 1};
  /// From balanced camera colors to linear sRGB, white to white; empty: they are the same.
  std::optional<Matrix3> color_matrix;
  double lux_s_per_unit =
      0;  ///< luminous exposure on the sensor that the normalized signal 1.0 corresponds to; 0: unknown
};

/// Raw digital numbers. The signal normalized as (DN - black) / (white - black) runs from 0 to mosaic_white() where the
/// mosaic clips, and to view_white() where a view does. A DP view's pixel is the mean of the green half-photosites that
/// it covers, so that the normalized left + right is the normalized signal of undivided green photosites.
struct Frame {
  ImageU16 mosaic;  ///< width_px x height_px; may be empty in a capture of DP views alone
  ImageU16 left;    ///< dp_width x dp_height
  ImageU16 right;
  std::uint64_t seed = 0;                  ///< of this frame's noise
  Matrix4 camera_from_world = kIdentity4;  ///< pose, meters
};

/// Raw digital numbers as the normalized signal.
inline Image normalized(const ImageU16& raw, const Exposure& exposure) {
  const double black = exposure.black_level_dn, range = exposure.white_level_dn - black;
  Image signal(raw.width, raw.height);
  for (std::size_t i = 0; i < raw.data.size(); ++i) signal.data[i] = static_cast<float>((raw.data[i] - black) / range);
  return signal;
}

/// A level as the normalized signal; an empty one is 1.
inline double normalized_level(std::optional<double> level_dn, const Exposure& exposure) {
  return (level_dn.value_or(exposure.white_level_dn) - exposure.black_level_dn) /
         (exposure.white_level_dn - exposure.black_level_dn);
}

/// The normalized signal at which the mosaic clips: below 1 where wells are full before the digital range is.
inline double mosaic_white(const Exposure& exposure) {
  return normalized_level(exposure.mosaic_white_level_dn, exposure);
}

/// The normalized signal at which a DP view clips: 1/2 where each half of a photosite has a well of its own.
inline double view_white(const Exposure& exposure) { return normalized_level(exposure.dp_white_level_dn, exposure); }

/// RMS over the picture of the standard error that rendering leaves, normalized signal.
struct TruthNoise {
  double views = 0;  ///< of half a photosite
  double all_in_focus = 0, photograph = 0;

  bool operator==(const TruthNoise&) const = default;
};

/// Ground truth of the first frame: what the simulator knows and a phone does not. All images have the full sensor's
/// size; geometry is that of the pinhole ray through the pixel's center, unfiltered. Pictures are linear RGB
/// in the frames' normalized signal after white balance (1.0 = green's white level), noiseless and unclipped. Where
/// `valid` is 0 (nothing was hit), depth is infinity and blur and disparity are those of an infinitely distant point.
struct Truth {
  Image depth_m;          ///< planar depth D
  Image blur_px;          ///< signed blur diameter on the sensor, photosites
  Image disparity_dp_px;  ///< centroid disparity alpha * b, DP pixels
  Image normal;           ///< 3 channels, camera axes, unit length, towards the camera; 0 where not valid
  ImageU32 object_id;     ///< 1-based index of the glTF node; 0 where not valid
  Image person_mask;      ///< the share of a photosite that a person covers
  Image valid;            ///< 1 where the ray hit geometry
  Image all_in_focus;     ///< RGB through a pinhole
  Image photograph;       ///< RGB through the wider aperture
  Image left, right;  ///< RGB: the views without the sensor's noise, whose sum is the undivided picture; may be empty
  double photograph_aperture_scale = 0;  ///< its pupil diameter over the capture's
  std::string photograph_lens;           ///< that it looks through: "ideal", or a lens's name; empty: unknown
  /// Of a burst in which something moved, for each frame but the first: x and y in photosites, such that the point that
  /// the first frame's pixel sees is at pixel + motion in that frame; infinite behind that frame's camera.
  std::vector<Image> motion;
  std::optional<TruthNoise> noise;  ///< where it is known
  // With adaptive sampling only; otherwise empty, and every photosite has the same number of samples. Errors are
  // expected standard errors in the color of each photosite's own filter, normalized signal.
  Image samples;       ///< of each photosite, in the first frame
  Image render_sigma;  ///< of a half photosite in the first frame
  Image views_sigma;   ///< of `left` and `right`
  Image all_in_focus_sigma, photograph_sigma;
};

/// How a capture was made, for the record; the pipeline never reads it. Empty fields are absent from capture.json.
struct Provenance {
  std::string program;                           ///< name and version of the program
  std::string scene_file;                        ///< name of the scene file, without its folder
  std::string gltf_xxh64;                        ///< hash of the scene's glTF file, see hash_of() in files.h
  std::optional<double> noise_fraction_reached;  ///< expected rendering error of the views over the sensor's noise
  std::string scene;                             ///< JSON text: the scene file with every override applied
  std::string plan;                              ///< JSON text: what `simulate --auto` measured and chose
  std::map<std::string, std::string> other;      ///< fields that other programs wrote: name -> JSON text

  bool operator==(const Provenance&) const = default;
};

struct Capture {
  Camera camera;
  Exposure exposure;
  std::vector<Frame> frames;
  std::optional<Truth> truth;
  std::optional<std::array<double, 4>> face_px;  ///< x, y, width, height in full-sensor pixels, where known
  Provenance provenance;
};

inline constexpr int kCaptureFormatVersion = 1;

/// Writes `capture` to the folder `path`: first to a temporary sibling, capture.json with a manifest of sizes and
/// hashes last, then a rename. Throws InputError where `path` exists and is not a capture, or cannot be written.
void write_capture(const Capture& capture, const std::string& path);

/// Reads and verifies a capture: version, manifest, sizes, finiteness. Throws InputError.
/// Truth is loaded only when asked for: the pipeline never sees it.
Capture read_capture(const std::string& path, bool with_truth);

}  // namespace dualpixel
