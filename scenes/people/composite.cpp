#include "scenes/people/composite.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scenes/people/photo/process_photo.h"

namespace dualpixel::scenes {

Image composite_of(const Rendering& rendering, Image background, RandomStream rng) {
  const Image& people = rendering.people_light;
  Image out = people;
  set_mean_luminance(out, rendering.coverage, rng.uniform(0.7f, 1.4f));
  set_mean_luminance(background, {}, rng.uniform(0.4f, 1.6f));
  const float zoom = rng.uniform(0.5f, 0.99f);
  const bool flip = rng.chance(0.5f);
  const float room_x = static_cast<float>(background.width) - zoom * static_cast<float>(out.width) - 1;
  const float room_y = static_cast<float>(background.height) - zoom * static_cast<float>(out.height) - 1;
  const float left = std::max(room_x, 0.0f) * rng.uniform(), top = std::max(room_y, 0.0f) * rng.uniform();
  const vec3 tint = 1.0f + 0.12f * vec3(rng.normal(), rng.normal(), rng.normal());
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      float alpha = 0;
      for (int p = 0; p < rendering.coverage.channels; ++p) alpha += rendering.coverage.at(x, y, p);
      if (alpha > 0.999f) continue;
      const float u = left + zoom * static_cast<float>(flip ? out.width - 1 - x : x),
                  v = top + zoom * static_cast<float>(y);
      const int i = std::clamp(static_cast<int>(u), 0, background.width - 2),
                j = std::clamp(static_cast<int>(v), 0, background.height - 2);
      const float a = std::clamp(u - static_cast<float>(i), 0.0f, 1.0f),
                  b = std::clamp(v - static_cast<float>(j), 0.0f, 1.0f);
      for (int c = 0; c < 3; ++c) {
        const float upper = background.at(i, j, c) * (1 - a) + background.at(i + 1, j, c) * a;
        const float lower = background.at(i, j + 1, c) * (1 - a) + background.at(i + 1, j + 1, c) * a;
        out.at(x, y, c) += (1 - alpha) * tint[c] * (upper * (1 - b) + lower * b);
      }
    }
  }
  return out;
}

std::vector<std::uint8_t> photograph_of(Image light, const Image& coverage, RandomStream rng) {
  // automatic exposure, for the people as much as for the picture, with its errors
  Image weight(light.width, light.height, 1);
  for (std::size_t i = 0; i < weight.data.size(); ++i) {
    float shown = 0.3f;
    for (int p = 0; p < coverage.channels; ++p) shown += coverage.data[i * coverage.channels + p];
    weight.data[i] = shown;
  }
  set_mean_luminance(light, weight, 0.19f * std::exp2(0.6f * rng.normal()));
  return process_photo(std::move(light), rng.substream(1));
}

void add_samples(const PeoplePicture& picture, const std::vector<Subject>& subjects, Image light, RandomStream rng,
                 std::vector<PeopleSample>& out) {
  const Image& coverage = picture.rendering.coverage;
  const std::vector<std::uint8_t> photograph = photograph_of(std::move(light), coverage, rng);
  const int left = (kPictureSide_px - coverage.width) / 2, top = (kPictureSide_px - coverage.height) / 2;
  for (const auto& [truth, person] : subjects) {
    PeopleSample sample = truth;
    sample.picture.assign(static_cast<std::size_t>(kPictureSide_px) * kPictureSide_px * 3, 0);
    sample.mask.assign(static_cast<std::size_t>(kPictureSide_px) * kPictureSide_px, 0);
    for (int y = 0; y < coverage.height; ++y) {
      const std::size_t to = static_cast<std::size_t>(y + top) * kPictureSide_px + left;
      std::copy_n(photograph.begin() + static_cast<std::ptrdiff_t>(y) * coverage.width * 3, coverage.width * 3,
                  sample.picture.begin() + static_cast<std::ptrdiff_t>(to) * 3);
      for (int x = 0; x < coverage.width; ++x) {
        sample.mask[to + x] = static_cast<std::uint8_t>(std::lround(coverage.at(x, y, person) * 255));
      }
    }
    for (vec3& k : sample.keypoints) k += vec3(left, top, 0);
    sample.face += glm::vec4(left, top, 0, 0);
    out.push_back(std::move(sample));
  }
}

}  // namespace dualpixel::scenes
