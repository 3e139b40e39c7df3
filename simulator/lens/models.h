#pragma once
#include <concepts>
#include <cstddef>
#include <iterator>
#include <string>
#include <type_traits>
#include <variant>

#include "capture/names.h"
#include "simulator/lens/aberrated/aberrated_sampler.h"
#include "simulator/lens/lens_model.h"
#include "simulator/lens/prescription/prescription_sampler.h"
#include "simulator/lens/thin/thin_sampler.h"

/// The lens models. A model turns a sample (a position on a photosite and one in the pupil) into a ray in front of the
/// lens, and says how much light that ray carries.
///
/// Conventions, for all models:
///   sensor   positions are upright, as the picture shows them: x right, y down, meters from the optical axis; the
///            center of photosite (i, j) is at (i + 0.5, j + 0.5) - principal_point_px, times the pixel pitch
///   camera   x right, y down, z forward; the origin is the center of the entrance pupil; depth is planar z, meters
///   ray      crosses z = 0 at (origin_x, origin_y), meters, with direction (slope_x, slope_y, 1)
///   pupil    p is in pupil radii, right positive: light at p > 0 belongs to the right view
///   signs    signed blur and disparity are negative in front of the focus plane and positive behind it; a focus
///            surface behind the sensor has a positive sign
///   units    lengths are meters unless the name says _mm or _um; in lens files they are millimeters
///
/// To add a model:
///   1. Write a struct with the model's parameters and its sampler, each in a header of its own, in a folder of their
///      own under simulator/lens/. They must satisfy LensModelType below; thin/ is the shortest example.
///   2. Add the struct to the variant LensModel in lens_model.h, and the sampler's header to the includes above.
///   3. Add its row to kLensModels: the name in lens files, a description, the function that reads it.
///   4. Describe its fields in lens_models/README.md and lens_models/lens.schema.json, and test it against closed forms
///      (tests/simulator/lens/lens_physics_test.cpp).
/// Reading, writing, refusals, the renderer, truth, `dualpixel lens` and `dualpixel plan` then know it.
namespace dualpixel::simulator {

/// What a model must offer. Its Sampler is made once per lens and sensor, and then draws rays from many threads.
template <class Model>
concept LensModelType =
    std::constructible_from<typename Model::Sampler, const Model&, const ThinLens&, const SensorGrid&> &&
    requires(Model changed, const Model& model, ThinLens& thin, double distance_m) {
  /// Radius of the image circle focused on infinity; 0: not limited.
  { model.radius_of_image_mm() } -> std::same_as<double>;
  /// Focuses on a distance from the entrance pupil, and updates `thin`'s focal length, f-number and magnification
  /// where focusing changes them. Throws InputError where it cannot.
  changed.refocus(distance_m, thin);
} && requires(const typename Model::Sampler& sampler, const PixelFrame& frame, int color, const float (*s)[kPacket],
              LensPacket& rays, PupilPacket& pupil, double radius_m) {
  /// Rays of sixteen points s of the unit 4-cube: two coordinates on the photosite, two in the pupil. Fills origins
  /// and slopes of `rays`, and `pupil`.
  sampler.sample(frame, color, s, rays, pupil);
  /// Slope in front of the lens of the green chief ray over the distance from the axis where it meets the sensor.
  { sampler.chief_slope_per_m(radius_m) } -> std::same_as<double>;
  /// Illuminance on the axis of the sensor, lux, per nit.
  { sampler.lux_per_nit() } -> std::same_as<double>;
  /// Whether R, G and B take different paths.
  { sampler.has_color() } -> std::same_as<bool>;
};

struct LensModelRow {
  const char* name;   ///< in lens files
  std::size_t value;  ///< index in LensModel
  const char* description;
  /// Reads the model's fields of a lens that stands in `file`, and the first-order figures, focused on a distance.
  LensModel (*read)(Fields& lens, const std::string& file, double focus_distance_m, ThinLens& thin);
};

template <class Model>
LensModel read_lens_model(Fields& lens, const std::string& file, double focus_distance_m, ThinLens& thin) {
  return Model::read(lens, file, focus_distance_m, thin);
}

template <class Model, class... Models>
constexpr std::size_t index_of(const std::variant<Models...>*) {
  std::size_t index = 0;
  for (const bool same : {std::is_same_v<Model, Models>...}) {
    if (same) break;
    ++index;
  }
  return index;
}

template <class Model>
constexpr LensModelRow lens_model_row(const char* name, const char* description) {
  static_assert(LensModelType<Model>);
  return {name, index_of<Model>(static_cast<const LensModel*>(nullptr)), description, read_lens_model<Model>};
}

inline constexpr LensModelRow kLensModels[] = {
    lens_model_row<ThinModel>("thin", "ideal lens: perfect focus, no distortion"),
    lens_model_row<Aberrations>("aberrated", "ideal lens with independent aberrations, each with a closed form"),
    lens_model_row<PrescriptionModel>("prescription", "the designer's surfaces and glasses, ray traced"),
};
static_assert(std::size(kLensModels) == std::variant_size_v<LensModel>, "each model of LensModel has its row");

namespace detail {
template <class Variant>
struct SamplerOf;
template <class... Models>
struct SamplerOf<std::variant<Models...>> {
  using type = std::variant<typename Models::Sampler...>;
};
}  // namespace detail

/// The sampler of the model that a lens has.
using LensModelSampler = detail::SamplerOf<LensModel>::type;

}  // namespace dualpixel::simulator
