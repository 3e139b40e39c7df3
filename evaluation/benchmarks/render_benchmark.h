#pragma once
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/benchmarks/render_scaling.h"

/// The renderer's error against its time on shipped scenes, and how near it is to Embree's own speed. 24 patches of
/// 32 x 32 photosites spread over the frame represent the picture.
namespace dualpixel::evaluation {

/// What adaptive sampling was asked for: the error that mirrored pairs have at so many samples a photosite.
struct RenderTarget {
  double error = 0, samples = 0;
};

/// One render of all patches. Errors are RMS over the photosites, each over the noise that the scene's sensor adds to
/// it, against a converged reference whose own error is subtracted.
struct RenderRun {
  double samples = 0;  ///< a photosite, on average
  double time_s = 0;   ///< CPU time of all cores
  double error = 0;    ///< of both views
  double left = 0, right = 0, left_minus_right = 0;
  std::optional<RenderTarget> target;  ///< of adaptive sampling
};

/// One way of sampling, over growing sample counts.
struct RenderCurve {
  /// "random", "padded", "joint", "mirrored pairs", "adaptive": light sampled by every path; "light cache", "light
  /// cache, adaptive": light at points of surfaces, as `simulate` has it by default
  std::string name;
  std::vector<RenderRun> runs;
  /// Of measure_light_points(): at most, besides the scene and Embree's structure over it.
  std::optional<double> memory_mb = {};
};

/// The renderer and Embree alone, on the same rays and one thread.
struct EmbreeShare {
  static constexpr int kPacketWidths[] = {1, 8, 16};
  double rays_per_sample = 0;
  double samples_per_core_s = 0;
  double embree_samples_per_core_s[3] = {};  ///< by packet width
  double share_of_embree = 0;                ///< of the renderer's time, in Embree's fastest packets
};

/// At one error: time of independent samples over that of mirrored pairs.
struct TimeSaved {
  double error = 0, ratio = 0;
  bool extrapolated = false;  ///< the time of independent samples, as 1 / error^2
};

struct SceneRenderBenchmark {
  std::string scene;  ///< file
  EmbreeShare embree;
  double pair_over_undivided = 0;  ///< time of both views over that of a single undivided one
  std::vector<TimeSaved> time_saved;
  /// The last is "Embree alone": errors of mirrored pairs in the time that their rays take by themselves.
  std::vector<RenderCurve> curves;
};

struct RenderBenchmarkOptions {
  int reference_samples = 4096;  ///< of each of the reference's two renders
  int most_samples = 1024;
  /// Of all camera samples, the reference's too. Points of light are the scene's own: no seed changes them.
  std::uint64_t seed = 0;
};

SceneRenderBenchmark measure_rendering(const std::string& scene_file, const RenderBenchmarkOptions& options,
                                       const std::function<void(double fraction)>& progress);

/// The default sampling with light at points of surfaces so many photosites apart, as many light samples at each as
/// camera samples a photosite, over growing counts. 0: light sampled by every path. The last curve has the default
/// points and light samples. Making the points is in the time.
std::vector<RenderCurve> measure_light_points(const std::string& scene_file, const RenderBenchmarkOptions& options,
                                              const std::vector<double>& spacings_px);

nlohmann::ordered_json to_json(const SceneRenderBenchmark& benchmark);
std::string to_page(const std::vector<SceneRenderBenchmark>& scenes, const RenderScaling& scaling);

}  // namespace dualpixel::evaluation
