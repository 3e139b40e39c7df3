#include "evaluation/metrics/flip.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "capture/error.h"
#include "capture/image/image_io.h"
#include "capture/image/rows.h"

namespace dualpixel::evaluation {
namespace {

using Triple = std::array<float, 3>;

// IEC 61966-2-1, as the authors' program rounds it
constexpr float kXyzFromRgb[3][3] = {{0.41238656f, 0.35759149f, 0.18045049f},
                                     {0.21263682f, 0.71518298f, 0.07218020f},
                                     {0.01933062f, 0.11919716f, 0.95037259f}};
constexpr float kRgbFromXyz[3][3] = {{3.24100326f, -1.53739899f, -0.49861587f},
                                     {-0.96922426f, 1.87592999f, 0.04155422f},
                                     {0.05563942f, -0.20401120f, 1.05714897f}};

Triple product(const float (&matrix)[3][3], const Triple& v) {
  Triple out{};
  for (int i = 0; i < 3; ++i) out[i] = matrix[i][0] * v[0] + matrix[i][1] * v[1] + matrix[i][2] * v[2];
  return out;
}

const Triple kWhite = product(kXyzFromRgb, {1, 1, 1});

/// Linear opponent space: luminance, red against green, blue against yellow.
Triple opponent(const Triple& linear_rgb) {
  Triple xyz = product(kXyzFromRgb, linear_rgb);
  for (int i = 0; i < 3; ++i) xyz[i] /= kWhite[i];
  return {116 * xyz[1] - 16, 500 * (xyz[0] - xyz[1]), 200 * (xyz[1] - xyz[2])};
}

Triple linear_rgb_of(const Triple& opponent) {
  const float y = (opponent[0] + 16) / 116;
  Triple rgb =
      product(kRgbFromXyz, {(opponent[1] / 500 + y) * kWhite[0], y * kWhite[1], (y - opponent[2] / 200) * kWhite[2]});
  for (float& value : rgb) value = std::clamp(value, 0.0f, 1.0f);
  return rgb;
}

/// L*, and a*, b* as strong as they seem at that lightness (Hunt).
Triple hunt_lab(const Triple& linear_rgb) {
  const Triple xyz = product(kXyzFromRgb, linear_rgb);
  const auto f = [](float t) {
    constexpr float kDelta = 6.0f / 29;
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0f / 29;
  };
  const float x = f(xyz[0] / kWhite[0]), y = f(xyz[1] / kWhite[1]), z = f(xyz[2] / kWhite[2]);
  const float lightness = 116 * y - 16;
  return {lightness, 0.01f * lightness * 500 * (x - y), 0.01f * lightness * 200 * (y - z)};
}

/// HyAB (Abasi et al. 2020) to the power of .7.
float color_distance(const Triple& a, const Triple& b) {
  return std::pow(std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]), 0.7f);
}

/// 0 to 1, almost all of it for distances up to .4 of the largest, blue to green.
float redistributed(float distance) {
  static const float most = color_distance(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1}));
  constexpr float kKnee = 0.4f, kValue = 0.95f;
  const float share = distance / most;
  return share < kKnee ? kValue / kKnee * share : kValue + (share - kKnee) / (1 - kKnee) * (1 - kValue);
}

using Weights = std::vector<float>;  // of odd length, about its middle

/// One channel of `image`, along x by the one kernel and along y by the other; added, times `share`, to `sum`.
void add_filtered(const Image& image, int channel, const Weights& along_x, const Weights& along_y, float share,
                  Image& sum) {
  const int reach_x = static_cast<int>(along_x.size() / 2), reach_y = static_cast<int>(along_y.size() / 2);
  Image rows(image.width, image.height);
  for_rows(image.height, [&](int y) {
    for (int x = 0; x < image.width; ++x) {
      float value = 0;
      for (int k = -reach_x; k <= reach_x; ++k) {
        value += along_x[k + reach_x] * image.at(std::clamp(x + k, 0, image.width - 1), y, channel);
      }
      rows.row(y)[x] = value;
    }
  });
  for_rows(image.height, [&](int y) {
    for (int k = -reach_y; k <= reach_y; ++k) {
      const float* from = rows.row(std::clamp(y + k, 0, image.height - 1));
      const float weight = share * along_y[k + reach_y];
      for (int x = 0; x < image.width; ++x) sum.at(x, y, channel % sum.channels) += weight * from[x];
    }
  });
}

/// Contrast sensitivity as a sum of Gaussians a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees.
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr Sensitivity kSensitivities[] = {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}};

Weights gaussian(double b, int reach, double pixels_per_degree) {
  Weights kernel;
  for (int k = -reach; k <= reach; ++k) {
    const double degrees = k / pixels_per_degree;
    kernel.push_back(static_cast<float>(std::exp(-std::numbers::pi * std::numbers::pi * degrees * degrees / b)));
  }
  return kernel;
}

/// The picture as it is seen: hunt_lab of the filtered opponent space.
Image seen(const Image& opponents, double pixels_per_degree) {
  constexpr double kWidest = 0.04;
  const int reach = static_cast<int>(
      std::ceil(3 * std::sqrt(kWidest / (2 * std::numbers::pi * std::numbers::pi)) * pixels_per_degree));
  Image filtered(opponents.width, opponents.height, 3);
  for (int c = 0; c < 3; ++c) {
    const Sensitivity& s = kSensitivities[c];
    const Weights first = gaussian(s.b1, reach, pixels_per_degree), second = gaussian(s.b2, reach, pixels_per_degree);
    const auto mass = [](const Weights& k) { return std::pow(std::accumulate(k.begin(), k.end(), 0.0), 2); };
    const double w1 = s.a1 * std::sqrt(std::numbers::pi / s.b1), w2 = s.a2 * std::sqrt(std::numbers::pi / s.b2);
    const double sum = w1 * mass(first) + w2 * mass(second);
    add_filtered(opponents, c, first, first, static_cast<float>(w1 / sum), filtered);
    if (w2 > 0) add_filtered(opponents, c, second, second, static_cast<float>(w2 / sum), filtered);
  }
  for (std::size_t i = 0; i < filtered.data.size(); i += 3) {
    float* value = &filtered.data[i];
    const Triple lab = hunt_lab(linear_rgb_of({value[0], value[1], value[2]}));
    std::copy(lab.begin(), lab.end(), value);
  }
  return filtered;
}

/// First or second derivative of a Gaussian whose positive and whose negative weights add up to 1 and -1, and the
/// Gaussian itself.
struct FeatureFilter {
  Weights across, along;
};

FeatureFilter feature_filter(bool edges, double pixels_per_degree) {
  const double sigma = 0.5 * 0.082 * pixels_per_degree;
  const int reach = static_cast<int>(std::ceil(3 * sigma));
  FeatureFilter filter;
  double positive = 0, negative = 0, sum = 0;
  for (int k = -reach; k <= reach; ++k) {
    const double g = std::exp(-k * k / (2 * sigma * sigma));
    const double weight = edges ? -k * g : (k * k / (sigma * sigma) - 1) * g;
    (weight > 0 ? positive : negative) += std::abs(weight);
    sum += g;
    filter.across.push_back(static_cast<float>(weight));
    filter.along.push_back(static_cast<float>(g));
  }
  for (float& weight : filter.across) weight /= static_cast<float>(weight > 0 ? positive : negative);
  for (float& weight : filter.along) weight /= static_cast<float>(sum);
  return filter;
}

/// Magnitude of the feature in luminance, 0..1.
Image feature(const Image& luminance, const FeatureFilter& filter) {
  Image x(luminance.width, luminance.height), y = x;
  add_filtered(luminance, 0, filter.across, filter.along, 1, x);
  add_filtered(luminance, 0, filter.along, filter.across, 1, y);
  for (std::size_t i = 0; i < x.data.size(); ++i) x.data[i] = std::hypot(x.data[i], y.data[i]);
  return x;
}

struct Prepared {
  Image lab, edges, points;
};

Prepared prepared(const Image& srgb, double pixels_per_degree) {
  Image opponents = srgb, luminance(srgb.width, srgb.height);
  for (std::size_t i = 0; i < srgb.pixel_count(); ++i) {
    float* const value = &opponents.data[3 * i];
    const Triple color = opponent({linear_from_srgb(value[0]), linear_from_srgb(value[1]), linear_from_srgb(value[2])});
    std::copy(color.begin(), color.end(), value);
    luminance.data[i] = (color[0] + 16) / 116;
  }
  return {seen(opponents, pixels_per_degree), feature(luminance, feature_filter(true, pixels_per_degree)),
          feature(luminance, feature_filter(false, pixels_per_degree))};
}

}  // namespace

Image flip_map(const Image& reference, const Image& test, double pixels_per_degree) {
  if (!reference.same_size(test) || reference.channels != 3 || test.channels != 3) {
    throw InputError(fmt::format("FLIP: {} x {} and {} x {}: must be one size, of three channels", reference.width,
                                 reference.height, test.width, test.height));
  }
  const Prepared a = prepared(reference, pixels_per_degree), b = prepared(test, pixels_per_degree);
  Image difference(reference.width, reference.height);
  for (std::size_t i = 0; i < difference.data.size(); ++i) {
    const float *p = &a.lab.data[3 * i], *q = &b.lab.data[3 * i];
    const float color = redistributed(color_distance({p[0], p[1], p[2]}, {q[0], q[1], q[2]}));
    const float features =
        std::max(std::abs(a.edges.data[i] - b.edges.data[i]), std::abs(a.points.data[i] - b.points.data[i]));
    difference.data[i] = std::pow(color, 1 - std::sqrt(features / std::numbers::sqrt2_v<float>));
  }
  return difference;
}

double mean_flip(const Image& reference, const Image& test, double pixels_per_degree) {
  const Image map = flip_map(reference, test, pixels_per_degree);
  return std::accumulate(map.data.begin(), map.data.end(), 0.0) / static_cast<double>(map.data.size());
}

}  // namespace dualpixel::evaluation
