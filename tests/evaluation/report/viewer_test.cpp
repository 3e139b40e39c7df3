#include "evaluation/report/viewer.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

namespace dualpixel::evaluation {
namespace {

/// The codes that pack_map() deflated, by the rule of its header; a second way to write what page.js reads.
std::vector<int> unpack(const std::string& deflated, int width, int height) {
  const std::size_t count = static_cast<std::size_t>(width) * height;
  std::vector<Bytef> bytes(2 * count);
  uLongf size = bytes.size();
  EXPECT_EQ(uncompress(bytes.data(), &size, reinterpret_cast<const Bytef*>(deflated.data()), deflated.size()), Z_OK);
  EXPECT_EQ(size, bytes.size());
  std::vector<int> codes(count);
  const auto at = [&](int x, int y) { return codes[static_cast<std::size_t>(y) * width + x]; };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * width + x;
      int predicted = 0;
      if (x > 0 && y > 0) {
        std::array<int, 3> three = {at(x - 1, y), at(x, y - 1), at(x - 1, y) + at(x, y - 1) - at(x - 1, y - 1)};
        std::sort(three.begin(), three.end());
        predicted = three[1];
      } else if (x > 0 || y > 0) {
        predicted = x > 0 ? at(x - 1, y) : at(x, y - 1);
      }
      const int folded = bytes[i] + 256 * bytes[count + i];
      codes[i] = static_cast<std::int16_t>(predicted + (folded % 2 == 0 ? folded / 2 : -(folded + 1) / 2));
    }
  }
  return codes;
}

TEST(PackMap, KeepsEveryValueToHalfAStep) {
  Image map(37, 23);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) map.at(x, y) = 3 * std::sin(0.7f * x + y * y) + (x * y % 5 == 0 ? 20.0f : 0.0f);
  }
  map.at(3, 4) = NAN;
  map.at(0, 0) = INFINITY;
  map.at(36, 22) = -31.9f;  // far from its neighbors
  const double step = 1.0 / 1024;
  const std::vector<int> codes = unpack(pack_map(map, step), map.width, map.height);
  for (std::size_t i = 0; i < codes.size(); ++i) {
    if (std::isfinite(map.data[i])) {
      EXPECT_LE(std::abs(codes[i] * step - static_cast<double>(map.data[i])), step / 2 + 1e-12) << i;
    } else {
      EXPECT_EQ(codes[i], -32768) << i;
    }
  }
}

TEST(Viewer, TakesALargerStepForValuesThatWouldNotFit) {
  Viewer viewer{4, 4, {"one"}, {{"Map", "", "", LayerColors::gray}}};
  viewer.layers[0].images = {Image(4, 4, 1, 100.0f)};
  const std::string html = html_viewer(viewer), open = "<script type=\"application/json\">";
  const std::size_t begin = html.find(open) + open.size();
  const auto json = nlohmann::json::parse(html.substr(begin, html.find("</script>") - begin));
  EXPECT_EQ(json.at("layers").at(0).at("step"), 1.0 / 256);  // 100 * 256 < 2^15 < 100 * 512
}

}  // namespace
}  // namespace dualpixel::evaluation
