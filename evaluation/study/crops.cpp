#include "evaluation/study/crops.h"

#include <algorithm>
#include <cstdlib>
#include <optional>

namespace dualpixel::evaluation {
namespace {

constexpr int kSide_px = 128;
constexpr std::size_t kMostCrops = 3;

/// Sums over squares of any map, in four additions (Crow 1984, "Summed-area tables for texture mapping").
class SquareSums {
 public:
  explicit SquareSums(const Image& map) : columns_(map.width + 1), sums_(columns_ * (map.height + 1), 0.0) {
    for (int y = 0; y < map.height; ++y) {
      double row = 0;
      for (int x = 0; x < map.width; ++x) {
        row += map.at(x, y);
        sums_[(y + 1) * columns_ + x + 1] = sums_[y * columns_ + x + 1] + row;
      }
    }
  }

  double of(int x, int y, int side) const {
    const auto at = [&](int column, int row) { return sums_[row * columns_ + column]; };
    return at(x + side, y + side) - at(x, y + side) - at(x + side, y) + at(x, y);
  }

 private:
  std::size_t columns_;
  std::vector<double> sums_;
};

/// Variance between the pictures, over their channels.
Image variance_between(const std::vector<Image>& pictures) {
  const Image& first = pictures.front();
  Image variance(first.width, first.height);
  const auto count = static_cast<double>(pictures.size());
  for (std::size_t i = 0; i < first.data.size(); ++i) {
    double sum = 0, squares = 0;
    for (const Image& picture : pictures) {
      sum += picture.data[i];
      squares += static_cast<double>(picture.data[i]) * picture.data[i];
    }
    variance.data[i / first.channels] += static_cast<float>(std::max(squares - sum * sum / count, 0.0) / (count - 1));
  }
  return variance;
}

/// 1 on the person.
Image person_of(const Image& mask) {
  Image person(mask.width, mask.height);
  for (std::size_t i = 0; i < mask.data.size(); ++i) person.data[i] = mask.data[i] >= 0.5f ? 1.0f : 0.0f;
  return person;
}

bool overlap(const Crop& a, const Crop& b) { return std::abs(a.x - b.x) < a.side && std::abs(a.y - b.y) < a.side; }

}  // namespace

std::vector<Crop> crops_that_differ(const std::vector<Image>& pictures, const Image& mask) {
  const int width = pictures.front().width, height = pictures.front().height;
  const int side = std::min({kSide_px, width, height});
  const SquareSums variance(variance_between(pictures));
  const SquareSums person(mask.data.empty() ? Image(width, height) : person_of(mask));
  const auto shows_outline = [&](int x, int y) {
    const double pixels = person.of(x, y, side);
    return pixels > 0.5 && pixels < side * side - 0.5;
  };
  const auto any_outline = [&] {
    for (int y = 0; y + side <= height; ++y) {
      for (int x = 0; x + side <= width; ++x) {
        if (shows_outline(x, y)) return true;
      }
    }
    return false;
  };
  const bool anywhere = !any_outline();
  std::vector<Crop> crops;
  while (crops.size() < kMostCrops) {
    std::optional<Crop> best;
    double most = -1;
    for (int y = 0; y + side <= height; ++y) {
      for (int x = 0; x + side <= width; ++x) {
        const Crop crop{x, y, side};
        const double differs = variance.of(x, y, side);
        if (differs <= most || !(anywhere || shows_outline(x, y))) continue;
        if (std::any_of(crops.begin(), crops.end(), [&](const Crop& other) { return overlap(crop, other); })) continue;
        best = crop, most = differs;
      }
    }
    if (!best) break;
    crops.push_back(*best);
  }
  return crops;
}

Image cropped(const Image& picture, const Crop& crop) {
  Image part(crop.side, crop.side, picture.channels);
  for (int y = 0; y < crop.side; ++y) {
    const float* from = picture.row(crop.y + y) + static_cast<std::ptrdiff_t>(crop.x) * picture.channels;
    std::copy_n(from, static_cast<std::ptrdiff_t>(crop.side) * picture.channels, part.row(y));
  }
  return part;
}

}  // namespace dualpixel::evaluation
