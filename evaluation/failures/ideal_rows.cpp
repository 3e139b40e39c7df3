#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <random>

#include "evaluation/failures/failure_row.h"

namespace dualpixel::evaluation {
namespace {

constexpr double kMean = 0.25, kElectrons = 811;  // of the views at 100 lux
constexpr double kContrast = 0.2;                 // root mean square over mean
constexpr double kPi = std::numbers::pi;
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

/// A point of the pupil, the unit disc, and its share of what a view sees; the shares of a view's points add up to 1.
struct PupilPoint {
  double x, y, share;
};

/// What one view sees through.
struct Kernel {
  std::vector<PupilPoint> points;

  double centroid() const {
    double sum = 0;
    for (const PupilPoint& point : points) sum += point.share * point.x;
    return sum;
  }
};

Kernel pinhole() { return {{{0, 0, 1}}}; }

Kernel normalized(Kernel kernel) {
  double sum = 0;
  for (const PupilPoint& point : kernel.points) sum += point.share;
  for (PupilPoint& point : kernel.points) point.share /= sum;
  return kernel;
}

/// The half with side * (x - split) > 0 of the disc, cut by a second disc of the same size, `cut` further right.
Kernel half_disc(int side, double split = 0, double cut = 0, int steps = 24) {
  Kernel kernel;
  for (int j = 0; j < steps; ++j) {
    for (int i = 0; i < steps; ++i) {
      const double x = (2 * i + 1.0) / steps - 1, y = (2 * j + 1.0) / steps - 1;
      if (x * x + y * y > 1 || (x - cut) * (x - cut) + y * y > 1 || side * (x - split) <= 0) continue;
      kernel.points.push_back({x, y, 1});
    }
  }
  return normalized(std::move(kernel));
}

/// The whole disc through a soft split: weight 1 + side x / k with k = 1 / (4 alpha), whose centroid is alpha.
Kernel soft_half(int side, double alpha, int steps = 24) {
  Kernel kernel = half_disc(1, -2, 0, steps);
  for (PupilPoint& point : kernel.points) point.share *= 1 + side * 4 * alpha * point.x;
  return normalized(std::move(kernel));
}

/// A sum of cosines, mean 0, variance 1: any of its frequencies can be blurred and shifted exactly.
class Waves {
 public:
  /// Log-uniform in frequency, from 1/64 cycles a pixel to `highest`; directions within `spread` of `angle`.
  Waves(unsigned seed, double highest = 0.4, double angle = 0, double spread = kPi, int count = 64) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int i = 0; i < count; ++i) {
      const double frequency = std::exp(std::log(1.0 / 64) + (i + uniform(random)) / count * std::log(64 * highest));
      add(frequency, angle + spread * uniform(random), 2 * kPi * uniform(random));
    }
  }
  /// One wave along x.
  static Waves grating(double period_px) {
    Waves waves(0, 0.4, 0, 0, 0);
    waves.add(1 / period_px, 0, 0);
    return waves;
  }

  /// Through a pupil whose image is `blur_px` wide, signed: point p of the kernel moves the picture by
  /// blur_px / 2 * p to the right.
  Image seen(const Kernel& kernel, double blur_px, double shift_px) const {
    std::vector<double> sums(static_cast<std::size_t>(kIdealWidth) * kIdealHeight);
    std::vector<std::complex<double>> across(kIdealWidth);
    for (const Wave& wave : waves_) {
      std::complex<double> gain = 0;
      for (const PupilPoint& p : kernel.points) {
        gain += std::polar(p.share, -0.5 * blur_px * (wave.x * p.x + wave.y * p.y));
      }
      gain *= std::polar(1.0, wave.phase - wave.x * shift_px);
      for (int x = 0; x < kIdealWidth; ++x) across[x] = std::polar(1.0, wave.x * x) * gain;
      for (int y = 0; y < kIdealHeight; ++y) {
        const std::complex<double> down = std::polar(1.0, wave.y * y);
        double* row = sums.data() + static_cast<std::size_t>(y) * kIdealWidth;
        for (int x = 0; x < kIdealWidth; ++x) row[x] += across[x].real() * down.real() - across[x].imag() * down.imag();
      }
    }
    Image image(kIdealWidth, kIdealHeight);
    const double scale = std::sqrt(2.0 / static_cast<double>(waves_.size()));
    for (std::size_t i = 0; i < sums.size(); ++i) image.data[i] = static_cast<float>(scale * sums[i]);
    return image;
  }

 private:
  struct Wave {
    double x, y, phase;  // radians a pixel
  };
  std::vector<Wave> waves_;

  void add(double frequency, double angle, double phase) {
    waves_.push_back({2 * kPi * frequency * std::cos(angle), 2 * kPi * frequency * std::sin(angle), phase});
  }
};

pipeline::ViewNoise noise_at(double lux) {
  const double electron = kMean / (kElectrons * lux / 100);  // signal of one; four half-photosites of 2.4 read
  return {static_cast<float>(electron), static_cast<float>(4 * 2.4 * 2.4 * electron * electron)};
}

using Draw = unsigned;  // which textures and which noise

Waves waves_of(unsigned texture, Draw draw) { return Waves(texture + 100 * draw); }

ViewSample with_noise(Image left, Image right, Image truth, Draw draw, double lux = 100) {
  const pipeline::ViewNoise noise = noise_at(lux);
  ViewSample result{"", std::move(left), std::move(right), std::move(truth), {noise}};
  std::mt19937 random(1 + draw);
  std::normal_distribution<float> normal;
  for (Image* view : {&result.left, &result.right}) {
    for (float& value : view->data) {
      value += normal(random) * std::sqrt(noise.shot * std::max(value, 0.0f) + noise.read);
      value = std::min(value, 1.0f);
    }
  }
  return result;
}

Image exposed(Image texture, double contrast = kContrast) {
  for (float& value : texture.data) value = static_cast<float>(kMean * std::max(1 + contrast * value, 0.0));
  return texture;
}

Image uniform_image(double value) { return Image(kIdealWidth, kIdealHeight, 1, static_cast<float>(value)); }

/// In focus, shifted by d.
ViewSample shifted(const Waves& waves, double d, Draw draw, double contrast = kContrast, double lux = 100) {
  return with_noise(exposed(waves.seen(pinhole(), 0, 0), contrast), exposed(waves.seen(pinhole(), 0, d), contrast),
                    uniform_image(d), draw, lux);
}

/// Out of focus. A point of the pupil at x moves the picture by b x / 2 to the right; the right view looks through the
/// half that moves it by d / 2 and thus right(x + d) = left(x).
ViewSample defocused(const Waves& waves, double blur_px, const Kernel& left, const Kernel& right, Draw draw) {
  const double alpha = 0.5 * (right.centroid() - left.centroid());
  ViewSample views = with_noise(exposed(waves.seen(left, blur_px, 0)), exposed(waves.seen(right, blur_px, 0)),
                                uniform_image(blur_px * alpha), draw);
  views.sensor.alpha = static_cast<float>(alpha);
  return views;
}

/// Through a hard split `split` beside the middle, and a pupil that vignetting cuts.
ViewSample defocused(const Waves& waves, double blur_px, Draw draw, double split = 0, double cut = 0) {
  return defocused(waves, blur_px, half_disc(-1, split, cut), half_disc(1, split, cut), draw);
}

/// Through the soft split of a phone: alpha = .21, as measured on a Pixel 4 (docs/disparity.md).
ViewSample softly_defocused(const Waves& waves, double blur_px, Draw draw) {
  constexpr double kPhoneAlpha = 0.21;
  return defocused(waves, blur_px, soft_half(-1, kPhoneAlpha), soft_half(1, kPhoneAlpha), draw);
}

/// Opaque bars of one blur in front of a background of another: each point of the pupil sees both, shifted, with the
/// bars on top. A pixel belongs to a surface where all points of both halves show it; the truth is NaN elsewhere.
ViewSample layered(double front_blur_px, double back_blur_px, double bar_px, double period_px, Draw draw) {
  const Waves front(3 + 100 * draw, 0.25), back(4 + 100 * draw, 0.25);
  Image views[2];
  Image front_count(kIdealWidth, kIdealHeight);
  double points = 0;
  double centroids[2];
  for (int side = 0; side < 2; ++side) {
    const Kernel kernel = half_disc(2 * side - 1, 0, 0, 10);
    centroids[side] = kernel.centroid();
    Image& view = views[side] = Image(kIdealWidth, kIdealHeight);
    for (const PupilPoint& point : kernel.points) {
      const Kernel one{{{point.x, point.y, 1}}};
      const Image f = exposed(front.seen(one, front_blur_px, 0)), b = exposed(back.seen(one, back_blur_px, 0));
      for (int x = 0; x < kIdealWidth; ++x) {
        const double at = std::fmod(x + 0.5 - 0.5 * front_blur_px * point.x + 16 * period_px, period_px);
        const bool covered = at < bar_px;
        for (int y = 0; y < kIdealHeight; ++y) {
          view.at(x, y) += (covered ? f : b).at(x, y) * static_cast<float>(point.share);
          front_count.at(x, y) += covered;
        }
      }
    }
    points += static_cast<double>(kernel.points.size());
  }
  const double apart = 0.5 * (centroids[1] - centroids[0]);
  Image truth = uniform_image(kUnknown);
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    if (front_count.data[i] == 0) truth.data[i] = static_cast<float>(apart * back_blur_px);
    if (front_count.data[i] == static_cast<float>(points)) truth.data[i] = static_cast<float>(apart * front_blur_px);
  }
  ViewSample sample = with_noise(std::move(views[0]), std::move(views[1]), std::move(truth), draw);
  sample.sensor.alpha = static_cast<float>(apart);
  return sample;
}

ViewSample saturated(double clipped_share, Draw draw) {
  const Waves waves = waves_of(5, draw);
  Image left = waves.seen(pinhole(), 0, 0), right = waves.seen(pinhole(), 0, 0.4);
  std::vector<float> sorted = left.data;
  const auto rank = sorted.begin() + static_cast<std::ptrdiff_t>((1 - clipped_share) * (sorted.size() - 1));
  std::nth_element(sorted.begin(), rank, sorted.end());
  const float gain = 1 / (1 + 0.4f * *rank);  // contrast 0.4: the quantile is exposed to 1
  for (Image* view : {&left, &right}) {
    for (float& value : view->data) value = gain * std::max(1 + 0.4f * value, 0.0f);
  }
  return with_noise(std::move(left), std::move(right), uniform_image(0.4), draw);
}

ViewSample shaded(double ramp, Draw draw) {
  const Waves waves = waves_of(6, draw);
  Image left = exposed(waves.seen(pinhole(), 0, 0)), right = exposed(waves.seen(pinhole(), 0, 0.4));
  for (int y = 0; y < kIdealHeight; ++y) {
    for (int x = 0; x < kIdealWidth; ++x) {
      const double t = 2 * (x + 0.5) / kIdealWidth - 1;
      left.at(x, y) *= static_cast<float>(1 + ramp * t);
      right.at(x, y) *= static_cast<float>(1 - ramp * t);
    }
  }
  return with_noise(std::move(left), std::move(right), uniform_image(0.4), draw);
}

/// Small highlights, mirrored by the surface: mirror images of their sources, they have twice the surface's blur.
ViewSample highlights(double brightness, Draw draw) {
  constexpr double kBlur = 4, kRadius = 1.2;
  const Waves waves = waves_of(7, draw);
  Image views[2];
  std::mt19937 random(2 + draw);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<std::array<double, 2>> sources(60);
  for (auto& source : sources) source = {kIdealWidth * uniform(random), kIdealHeight * uniform(random)};
  double centroids[2];
  for (int side = 0; side < 2; ++side) {
    const Kernel kernel = half_disc(2 * side - 1);
    centroids[side] = kernel.centroid();
    views[side] = exposed(waves.seen(kernel, kBlur, 0));
    for (const auto& source : sources) {
      for (const PupilPoint& p : kernel.points) {
        const double cx = source[0] + kBlur * p.x, cy = source[1] + kBlur * p.y;
        const double each = brightness * kMean * p.share;
        for (int y = static_cast<int>(cy) - 4; y <= cy + 4; ++y) {
          for (int x = static_cast<int>(cx) - 4; x <= cx + 4; ++x) {
            if (x < 0 || y < 0 || x >= kIdealWidth || y >= kIdealHeight) continue;
            const double square = (x + 0.5 - cx) * (x + 0.5 - cx) + (y + 0.5 - cy) * (y + 0.5 - cy);
            views[side].at(x, y) += static_cast<float>(each * std::exp(-0.5 * square / (kRadius * kRadius)));
          }
        }
      }
    }
  }
  const double alpha = 0.5 * (centroids[1] - centroids[0]);
  ViewSample sample = with_noise(std::move(views[0]), std::move(views[1]), uniform_image(kBlur * alpha), draw);
  sample.sensor.alpha = static_cast<float>(alpha);
  return sample;
}

/// What the views show.
std::vector<FailureRow> texture_rows() {
  const double texture_noise = std::sqrt(noise_at(100).shot * kMean + noise_at(100).read) / kMean;
  return {
      {"parallel",
       "Structure parallel to the baseline",
       "angle of the lines to the baseline, degrees",
       "angle_deg",
       {90, 45, 20, 10, 5, 2, 1, 0},
       [](double angle, Draw draw) {
         return shifted(Waves(1 + 100 * draw, 0.4, (90 - angle) * kPi / 180, 0), 0.4, draw);
       }},
      {"texture",
       "No texture",
       "contrast over noise",
       "contrast_over_noise",
       {10, 5, 2, 1, 0.5, 0.2, 0.1, 0.01},
       [=](double ratio, Draw draw) { return shifted(waves_of(2, draw), 0.4, draw, ratio * texture_noise); },
       true},
      {"repetition",
       "Repetition",
       "period, DP px",
       "period_dp_px",
       {16, 12, 8, 7, 6, 5, 4, 3.5, 3},
       [](double period, Draw draw) { return shifted(Waves::grating(period), 0.6, draw); }},
      {"range",
       "Disparity beyond the range",
       "true disparity, DP px",
       "disparity_dp_px",
       {0, 2, 2.75, 3.25, 4, 8, 12, 15, 16.5, 18, 24},
       [](double d, Draw draw) { return shifted(waves_of(8, draw), d, draw); }},
  };
}

/// How the views are exposed and lit.
std::vector<FailureRow> signal_rows() {
  return {
      {"noise",
       "Noise",
       "illumination, lux",
       "illumination_lux",
       {400, 100, 30, 10, 3, 1, 0.3, 0.1},
       [](double lux, Draw draw) { return shifted(waves_of(9, draw), 0.4, draw, kContrast, lux); },
       true},
      {"saturation",
       "Saturation",
       "share of clipped pixels",
       "clipped_share",
       {0, 0.05, 0.1, 0.3, 0.5, 0.7, 0.8, 0.95},
       saturated},
      {"shading",
       "Shading that differs between the views",
       "gain ramp, +- over the picture",
       "ramp",
       {0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9},
       shaded},
      {"highlights",
       "Specular highlights",
       "brightness over the surface",
       "brightness_ratio",
       {0, 1, 3, 10, 30, 100, 300},
       highlights},
  };
}

/// More than one depth.
std::vector<FailureRow> edge_rows() {
  return {
      {"edges",
       "Depth edges",
       "blur of the front minus that of the back, DP px",
       "blur_step_dp_px",
       {0, 1, 2, 4, 6, 8, 12},
       [](double step, Draw draw) { return layered(-step / 2, step / 2, 64, 128, draw); }},
      {"thin",
       "Thin structures",
       "width of the bars in front, DP px",
       "width_dp_px",
       {48, 32, 24, 16, 12, 8, 4, 2, 1},
       [](double width, Draw draw) { return layered(0, 5, width, 64, draw); }},
  };
}

/// Blur, and the pupil that makes it.
std::vector<FailureRow> pupil_rows() {
  return {
      {"defocus",
       "Defocus",
       "blur diameter, DP px",
       "blur_dp_px",
       {0, 1, 2, 4, 6, 8, 12, 16, 24, 32, 40},
       [](double blur, Draw draw) { return defocused(waves_of(10, draw), blur, draw); }},
      {"near_defocus",
       "Defocus in front of the focus",
       "blur diameter, DP px",
       "blur_dp_px",
       {0, -2, -4, -8, -16, -24, -40},
       [](double blur, Draw draw) { return defocused(waves_of(11, draw), blur, draw); }},
      {"soft_defocus",
       "Defocus through a soft split",
       "blur diameter, DP px",
       "blur_dp_px",
       {0, 2, 4, 6, 8, 12, 16, 20, 30, 45, 60},
       [](double blur, Draw draw) { return softly_defocused(waves_of(14, draw), blur, draw); }},
      {"near_soft_defocus",
       "Defocus in front of the focus, through a soft split",
       "blur diameter, DP px",
       "blur_dp_px",
       {0, -2, -4, -6, -8, -12, -16, -20, -30, -45, -60},
       [](double blur, Draw draw) { return softly_defocused(waves_of(15, draw), blur, draw); }},
      {"split_offset",
       "Split beside the middle of the pixel",
       "offset, pupil radii",
       "offset_pupil_radii",
       {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
       [](double offset, Draw draw) { return defocused(waves_of(12, draw), 8, draw, offset); }},
      {"vignetting",
       "Pupil cut by vignetting",
       "offset of the cutting disc, pupil radii",
       "offset_pupil_radii",
       {0, 0.2, 0.4, 0.6, 0.8, 0.9},
       [](double cut, Draw draw) { return defocused(waves_of(13, draw), 8, draw, 0, cut); }},
  };
}

}  // namespace

std::vector<FailureRow> ideal_failure_rows() {
  std::vector<FailureRow> all;
  for (const auto& group : {texture_rows(), signal_rows(), edge_rows(), pupil_rows()}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

}  // namespace dualpixel::evaluation
