#include "simulator/render/shading/visible_sky.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "simulator/sampling/hash.h"
#include "simulator/sampling/sobol.h"

namespace dualpixel::simulator {
namespace {

constexpr int kCubes = 32;    // along the longest side of the scene
constexpr int kRays = 1024;   // that look at the sky
constexpr int kOrigins = 64;  // where they start, at most
using Cells = EnvironmentLight::Cells;

/// Which way a surface faces: -x, +x, -y, ...
int side_of(glm::vec3 normal) {
  const glm::vec3 size = glm::abs(normal);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  return 2 * axis + (normal[axis] > 0 ? 1 : 0);
}

glm::vec3 normal_of(int side) {
  glm::vec3 normal(0);
  normal[side / 2] = side % 2 == 1 ? 1.0f : -1.0f;
  return normal;
}

/// Rays to the sky from one cube, by cells: how many there were, and how many nothing hid.
struct Looked {
  Cells rays{}, seen{};
  float all_rays = 0, all_seen = 0;
};

/// Sum over a cell and its neighbors.
float around(const Cells& cells, int row, int column) {
  constexpr int kRows = EnvironmentLight::kRows, kColumns = EnvironmentLight::kColumns;
  float sum = 0;
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, kRows - 1); ++r) {
    for (int c = -1; c <= 1; ++c) sum += cells[r][(column + c + kColumns) % kColumns];
  }
  return sum;
}

/// Light of each cell times the cosine, for normals on this side, times the share of it that is seen.
Cells seen_light(const Looked& looked, const Cells& nits, glm::vec3 normal) {
  constexpr float kPrior = 2;                  // rays' worth of what is seen on average
  constexpr float kLift = 0.3f, kLow = 0.05f;  // the side's normals differ by up to 55 degrees
  Cells light;
  for (int row = 0; row < EnvironmentLight::kRows; ++row) {
    for (int column = 0; column < EnvironmentLight::kColumns; ++column) {
      const float mean = looked.all_seen / looked.all_rays;
      const float seen =
          (around(looked.seen, row, column) + kPrior * mean) / (around(looked.rays, row, column) + kPrior);
      const float cosine = glm::dot(normal, EnvironmentLight::middle_of({row, column}));
      light[row][column] = nits[row][column] * seen * std::max(cosine + kLift, kLow);
    }
  }
  return light;
}

}  // namespace

std::uint64_t VisibleSky::Place::key() const {
  const auto bits = [](int c) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(c)); };
  return hash(bits(cube.x) << 32 | bits(cube.y), bits(cube.z) << 3 | static_cast<std::uint64_t>(side));
}

VisibleSky::VisibleSky(const EnvironmentLight& environment, const Intersector& intersector)
    : environment_(environment), intersector_(intersector) {
  if (environment.dark()) return;
  const Intersector::Bounds bounds = intersector.bounds();
  const glm::vec3 size = bounds.high - bounds.low;
  const float longest = std::max({size.x, size.y, size.z});
  if (longest >= 0 && longest < 1e18f) {  // else there is nothing in the scene, and one cube will do
    const glm::vec3 far = glm::max(glm::abs(bounds.low), glm::abs(bounds.high));
    const float least_m = 1e-6f * std::max({far.x, far.y, far.z, 1.0f});  // so that cubes can be counted
    cube_m_ = std::exp2(std::ceil(std::log2(std::max(longest / kCubes, least_m))));
    first_ = glm::ivec3(glm::floor(bounds.low / cube_m_));
    cubes_ = glm::ivec3(glm::floor(bounds.high / cube_m_)) - first_ + 1;
  }
  views_ = std::vector<std::atomic<View*>>(std::size_t{6} * cubes_.x * cubes_.y * cubes_.z);
}

VisibleSky::~VisibleSky() {
  for (std::atomic<View*>& view : views_) delete view.load();
}

const VisibleSky::View& VisibleSky::from(glm::vec3 point, glm::vec3 normal) const {
  Place place{{}, side_of(normal)};
  std::size_t index = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const float at = std::floor(point[axis] / cube_m_) - static_cast<float>(first_[axis]);
    const int along = at > 0 ? static_cast<int>(std::min(at, static_cast<float>(cubes_[axis] - 1))) : 0;
    place.cube[axis] = first_[axis] + along;
    index = index * cubes_[axis] + along;
  }
  std::atomic<View*>& view = views_[6 * index + place.side];
  if (const View* known = view.load(std::memory_order_acquire)) return *known;
  std::unique_ptr<View> found = look_from(place);
  View* before = nullptr;  // another thread may have found the same in the meantime
  if (view.compare_exchange_strong(before, found.get(), std::memory_order_acq_rel)) return *found.release();
  return *before;
}

/// Points on surfaces in the cube, or just outside, that face this side.
std::vector<glm::vec3> VisibleSky::origins_in(const Place& place) const {
  constexpr float kMargin = 0.25f;  // of the cube: surfaces may lie in its faces
  const glm::vec3 normal = normal_of(place.side), corner = cube_m_ * (glm::vec3(place.cube) - kMargin);
  constexpr float kSize = 1 + 2 * kMargin;
  std::vector<glm::vec3> origins;
  for (int first = 0; first < kOrigins; first += kPacket) {
    alignas(64) float at[4][kPacket];
    joint_samples(first, place.key(), at);
    for (int i = 0; i < kPacket; ++i) {
      const glm::vec3 point = corner + kSize * cube_m_ * glm::vec3(at[0][i], at[1][i], at[2][i]);
      const auto hit = intersector_.intersect(Ray{point, -normal});
      if (!hit) continue;
      const glm::vec3 origin = point - (hit->t - 1e-3f * cube_m_) * normal;
      const glm::vec3 within = (origin - corner) / cube_m_;
      if (glm::all(glm::greaterThanEqual(within, glm::vec3(0))) && glm::all(glm::lessThan(within, glm::vec3(kSize)))) {
        origins.push_back(origin);
      }
    }
  }
  return origins;
}

std::unique_ptr<VisibleSky::View> VisibleSky::look_from(const Place& place) const {
  auto view = std::make_unique<View>();
  const std::vector<glm::vec3> origins = origins_in(place);
  if (origins.empty()) return view;
  const glm::vec3 normal = normal_of(place.side);
  alignas(64) int all[kPacket];
  std::fill_n(all, kPacket, -1);
  EnvironmentLight::Choice choice[kPacket];
  for (auto& c : choice) c.table = environment_.table_of(normal.x, normal.y, normal.z);
  Looked looked;
  for (int first = 0; first < kRays; first += kPacket) {
    alignas(64) float numbers[4][kPacket];
    joint_samples(first, hash(place.key(), 1), numbers);
    EnvironmentLight::Samples samples;
    environment_.sample(all, choice, numbers[0], numbers[1], samples);
    alignas(64) RayPacket rays;
    for (int i = 0; i < kPacket; ++i) {
      const glm::vec3 origin = origins[(first + i) % origins.size()], direction = samples.direction.at(i);
      rays.origin_x[i] = origin.x, rays.origin_y[i] = origin.y, rays.origin_z[i] = origin.z;
      rays.direction_x[i] = direction.x, rays.direction_y[i] = direction.y, rays.direction_z[i] = direction.z;
      rays.far[i] = std::numeric_limits<float>::infinity();
    }
    alignas(64) int hidden[kPacket];
    intersector_.occluded(all, rays, false, hidden);
    for (int i = 0; i < kPacket; ++i) {
      const auto [row, column] = EnvironmentLight::cell_of(samples.direction.at(i));
      const float seen = hidden[i] ? 0.0f : 1.0f;
      looked.rays[row][column] += 1, looked.all_rays += 1;
      looked.seen[row][column] += seen, looked.all_seen += seen;
    }
  }
  constexpr float kMostShare = 0.8f, kSure = 4;  // seen rays from which what they found is worth half of that
  const float visible = looked.all_seen / looked.all_rays;
  view->visible = std::max(visible, kLeast);
  view->share = kMostShare * std::max(1 - 2 * visible, 0.0f) * looked.all_seen / (looked.all_seen + kSure);
  if (view->share > 0) {
    view->seen = std::make_unique<EnvironmentLight::Table>(
        EnvironmentLight::table_of(seen_light(looked, environment_.cell_nits(), normal)));
  }
  return view;
}

}  // namespace dualpixel::simulator
