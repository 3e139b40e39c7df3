#include "simulator/render/shading/lights.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "simulator/render/shading/surface.h"

namespace dualpixel::simulator {
namespace {

constexpr float kPi = 3.14159265358979f;
constexpr int kNormals = 48;  // cells a side of the octahedral map of normals, up to 4.2 degrees each

float luminance(glm::vec3 rgb) { return 0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z; }

/// u runs once around from +z over -x, -z (the middle), +x; v from straight up to straight down.
glm::vec3 radiance_at(const Environment& e, float u, float v) {
  const float x = u * e.width - 0.5f;  // 0 <= u <= 1: at most half a column beyond either edge
  const float y = v * e.height - 0.5f;
  const float left = std::floor(x);
  const float top = std::floor(y);
  const float fx = x - left;
  const float fy = y - top;
  const int column_left = static_cast<int>(left), row_above = static_cast<int>(top);
  const int x0 = column_left < 0 ? e.width - 1 : std::min(column_left, e.width - 1);
  const int x1 = column_left + 1 >= e.width ? 0 : column_left + 1;
  const int y0 = std::clamp(row_above, 0, e.height - 1);
  const int y1 = std::clamp(row_above + 1, 0, e.height - 1);
  const auto at = [&](int column, int row) {
    return e.radiance_nits[static_cast<std::size_t>(row) * e.width + column];
  };
  return (at(x0, y0) * (1 - fx) + at(x1, y0) * fx) * (1 - fy) + (at(x0, y1) * (1 - fx) + at(x1, y1) * fx) * fy;
}

/// First of `size` entries of an increasing sum that exceeds u; u becomes the position inside that entry, probability
/// its share. Without branches: where light comes from cannot be predicted.
inline std::size_t pick_from(const float* cumulative, std::size_t size, float& u, float& probability) {
  std::size_t entry = 0;
  for (std::size_t left = size; left > 1;) {
    const std::size_t half = left / 2;
    entry += cumulative[entry + half - 1] <= u ? half : 0;
    left -= half;
  }
  const float below = entry == 0 ? 0 : cumulative[entry - 1];
  probability = cumulative[entry] - below;
  u = std::clamp((u - below) / probability, 0.0f, 0x1.fffffep-1f);
  return entry;
}

/// Scales an accumulated sum so that it ends at exactly 1.
template <typename Iterator>
void normalize(Iterator begin, Iterator end) {
  const float total = *(end - 1);
  for (auto it = begin; it != end; ++it) *it = total > 0 ? *it / total : float(it - begin + 1) / float(end - begin);
  *(end - 1) = 1;
}

/// Cell of the octahedral map that a unit normal falls into. Without branches.
inline int normal_cell(float nx, float ny, float nz) {
  const float scale = 1 / (std::abs(nx) + std::abs(ny) + std::abs(nz));
  const float x = nx * scale, z = nz * scale;
  const float folded_x = std::copysign(1 - std::abs(z), x), folded_z = std::copysign(1 - std::abs(x), z);
  const float u = ny < 0 ? folded_x : x, v = ny < 0 ? folded_z : z;
  const auto cell = [](float c) {
    const int i = static_cast<int>((c * 0.5f + 0.5f) * kNormals);
    return i < 0 ? 0 : i < kNormals ? i : kNormals - 1;  // for any number
  };
  return cell(v) * kNormals + cell(u);
}

/// The normal in the middle of a cell.
glm::vec3 cell_normal(int cell) {
  const float x = (cell % kNormals + 0.5f) / kNormals * 2 - 1;
  const int row = cell / kNormals;
  const float z = (row + 0.5f) / kNormals * 2 - 1;
  const float y = 1 - std::abs(x) - std::abs(z);
  if (y >= 0) return glm::normalize(glm::vec3(x, y, z));
  return glm::normalize(glm::vec3(std::copysign(1 - std::abs(z), x), y, std::copysign(1 - std::abs(x), z)));
}

/// Sine and cosine of 2 pi `turns`, |turns| <= 1/2, to 1e-6: Taylor's polynomials about the nearest quarter.
void sine_cosine_of_turns(float turns, float& sine, float& cosine) {
  const float quarter = std::floor(4 * turns + 0.5f);
  const float t = 2 * kPi * (turns - 0.25f * quarter), t2 = t * t;
  const float s = t * (1 + t2 * (-1.66666667e-1f + t2 * (8.33333333e-3f + t2 * -1.98412698e-4f)));
  const float c = 1 + t2 * (-0.5f + t2 * (4.16666667e-2f + t2 * (-1.38888889e-3f + t2 * 2.48016e-5f)));
  const bool swapped = quarter == 1 || quarter == -1;
  const float along = swapped ? s : c, across = swapped ? c : s;
  sine = quarter == -1 || quarter == 2 || quarter == -2 ? -across : across;
  cosine = quarter == 1 || quarter == 2 || quarter == -2 ? -along : along;
}

/// acos(x) / pi to 1e-7 (Abramowitz & Stegun, 4.4.46).
float half_turns_of_cosine(float x) {
  const float a = std::abs(x);
  const float p =
      1.5707963050f +
      a * (-0.2145988016f +
           a * (0.0889789874f +
                a * (-0.0501743046f +
                     a * (0.0308918810f + a * (-0.0170881256f + a * (0.0066700901f - a * 0.0012624911f))))));
  const float angle = std::sqrt(std::max(1 - a, 0.0f)) * p;
  return (x < 0 ? kPi - angle : angle) / kPi;
}

}  // namespace

glm::vec3 environment_radiance(const Environment& environment, glm::vec3 d) {
  if (environment.radiance_nits.empty()) return glm::vec3(0);
  const float u = std::atan2(d.x, -d.z) / (2 * kPi) + 0.5f;
  const float v = std::acos(std::clamp(d.y, -1.0f, 1.0f)) / kPi;
  return radiance_at(environment, u, v);
}

const std::array<float, Lights::kRows + 1> Lights::kRowCosine = [] {
  std::array<float, kRows + 1> cosine;
  for (int row = 0; row <= kRows; ++row) cosine[row] = std::cos(kPi * row / kRows);
  return cosine;
}();

const std::array<float, Lights::kRows> Lights::kCellsPerSteradian = [] {
  std::array<float, kRows> cells;
  for (int row = 0; row < kRows; ++row) cells[row] = kColumns / (2 * kPi * (kRowCosine[row] - kRowCosine[row + 1]));
  return cells;
}();

struct Lights::EnvironmentProbes {
  static constexpr int kSide = 4, kOfCell = kSide * kSide;  ///< of one cell
  std::vector<float> nits;
  std::vector<glm::vec3> towards;
  float power = 0;  ///< nits times the sphere's steradians

  explicit EnvironmentProbes(const Environment& environment) {
    for (int i = 0; i < kRows * kColumns * kOfCell; ++i) {
      const int cell = i / kOfCell, row = cell / kColumns, column = cell % kColumns;
      const int probe_column = i % kSide, probe_row = i % kOfCell / kSide;
      const float u = (column + (probe_column + 0.5f) / kSide) / kColumns;
      const float v = (row + (probe_row + 0.5f) / kSide) / kRows;
      nits.push_back(luminance(radiance_at(environment, u, v)));
      power += nits.back() / (kCellsPerSteradian[row] * kOfCell);
      const float theta = kPi * v, phi = 2 * kPi * (u - 0.5f);
      towards.emplace_back(std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi));
    }
  }
};

Lights::Lights(const Scene& scene, glm::vec3 low, glm::vec3 high) : scene_(scene) {
  make_environment_tables();
  for (const PunctualLight& light : scene.lights) {
    const bool far = light.kind == PunctualLight::Kind::directional;
    if (far && luminance(light.intensity) > 0) directional_.push_back({light, luminance(light.intensity)});
  }
  make_near_lights(std::max(0.25f * glm::dot(high - low, high - low), 1e-12f));
}

void Lights::fill_environment_table(const EnvironmentProbes& probes, int normal) {
  constexpr int kOfCell = EnvironmentProbes::kOfCell;
  // No direction that light could come from may be left out. Normals lie up to 5.0 degrees from their cell's middle,
  // whose cosines are lifted by the sine of that; positions lie up to 1.4 degrees beyond the outermost probes of their
  // own cell, and the constant gives those just above the horizon some probability.
  constexpr float kLift = 0.09f, kLeast = 0.002f;
  const float least_nits = 0.01f * probes.power / (4 * kPi);  // a probe may have missed a small light in its cell
  EnvironmentTable& table = environment_tables_[normal];
  const glm::vec3 n = cell_normal(normal);
  float lux = 0;
  for (int row = 0; row < kRows; ++row) {
    float nits = 0;
    for (int column = 0; column < kColumns; ++column) {
      const int cell = row * kColumns + column;
      for (int i = cell * kOfCell; i < (cell + 1) * kOfCell; ++i) {
        const float cosine = std::max(glm::dot(n, probes.towards[i]) + kLift, 0.0f) + kLeast;
        nits += (probes.nits[i] + least_nits) * cosine / kOfCell;
      }
      table.cells[row][column] = nits;
    }
    lux += nits / kCellsPerSteradian[row];
    table.rows[row] = lux;
    normalize(table.cells[row].begin(), table.cells[row].end());
  }
  environment_lux_[normal] = lux;
  normalize(table.rows.begin(), table.rows.end());
}

void Lights::make_environment_tables() {
  if (scene_.environment.radiance_nits.empty()) return;
  const EnvironmentProbes probes(scene_.environment);
  if (!(probes.power > 0)) return;
  environment_tables_.resize(kNormals * kNormals);
  environment_lux_.resize(kNormals * kNormals);
  tbb::parallel_for(0, kNormals * kNormals, [&](int normal) { fill_environment_table(probes, normal); });
}

void Lights::make_near_lights(float radius_squared) {
  std::vector<float> powers;
  for (const PunctualLight& light : scene_.lights) {
    const bool far = light.kind == PunctualLight::Kind::directional;
    powers.push_back(far ? 0 : luminance(light.intensity) / (4 * radius_squared));
  }
  first_triangle_of_mesh_.assign(scene_.meshes.size(), -1);
  for (unsigned m = 0; m < scene_.meshes.size(); ++m) {
    const Mesh& mesh = scene_.meshes[m];
    const Material& material = scene_.materials[mesh.material];
    if (luminance(material.emission_nits) <= 0 || material.unlit) continue;
    first_triangle_of_mesh_[m] = static_cast<int>(triangles_.size());
    for (unsigned t = 0; t < mesh.triangles.size(); ++t) {
      const glm::uvec3& corners = mesh.triangles[t];
      const glm::vec3 p = mesh.positions[corners.x];
      const glm::vec3 first_edge = mesh.positions[corners.y] - p, second_edge = mesh.positions[corners.z] - p;
      const glm::vec3 normal = glm::cross(first_edge, second_edge);
      const float area = 0.5f * glm::length(normal);
      triangles_.push_back({m, t, area, p, first_edge, second_edge, glm::normalize(normal)});
      powers.push_back(luminance(material.emission_nits) * area / (4 * radius_squared));
    }
  }
  double sum = 0;
  for (float power : powers) {
    sum += power;
    near_.push_back(static_cast<float>(sum));
  }
  near_lux_ = static_cast<float>(sum);
  if (near_lux_ > 0) normalize(near_.begin(), near_.end());
}

Lights::Choice Lights::choice_at(glm::vec3 normal) const {
  Choice choice;
  if (!environment_tables_.empty()) {
    choice.cell = normal_cell(normal.x, normal.y, normal.z);
    choice.environment_lux = environment_lux_[choice.cell];
  }
  choice.all_lux = choice.environment_lux + near_lux_;
  for (const Directional& d : directional_) {
    choice.all_lux += d.lux * std::max(-glm::dot(d.light.direction, normal), 0.0f);
  }
  return choice;
}

void Lights::sample(const int lanes[kPacket], const Vec3Packet& point, const Vec3Packet& normal, const float u[kPacket],
                    const float v[kPacket], LightPacket& out) const {
  // `below`: the light of the lights before those in question; u * all_lux lies in one of these stretches
  alignas(64) int cell[kPacket], from_environment[kPacket], waiting[kPacket];
  alignas(64) float below[kPacket], all_lux[kPacket], within[kPacket];
  const bool environment = !environment_tables_.empty();
  for (int i = 0; i < kPacket; ++i) {
    // an inactive lane may hold NaN: it gets the cell of the +z normal
    const bool wanted = lanes[i] != 0;
    const float x = wanted ? normal.x[i] : 0.0f, y = wanted ? normal.y[i] : 0.0f, z = wanted ? normal.z[i] : 1.0f;
    cell[i] = normal_cell(x, y, z);
  }
  for (int i = 0; i < kPacket; ++i) below[i] = environment ? environment_lux_[cell[i]] : 0.0f;
  for (int i = 0; i < kPacket; ++i) all_lux[i] = below[i] + near_lux_;
  const auto own_lux = [&](const Directional& d, int i) {
    const glm::vec3 l = d.light.direction;
    const float lux = -d.lux * (l.x * normal.x[i] + l.y * normal.y[i] + l.z * normal.z[i]);
    return lux > 0 ? lux : 0.0f;
  };
  for (const Directional& d : directional_) {
    for (int i = 0; i < kPacket; ++i) all_lux[i] += own_lux(d, i);
  }
  int any_environment = 0, any_waiting = 0;
  for (int i = 0; i < kPacket; ++i) {
    const float at = u[i] * all_lux[i];
    from_environment[i] = at < below[i] ? lanes[i] : 0;
    waiting[i] = at < below[i] ? 0 : lanes[i];
    within[i] = at / below[i];
    any_environment |= from_environment[i];
    any_waiting |= waiting[i];
  }
  if (any_environment) sample_environment(from_environment, cell, within, v, all_lux, out);
  for (std::size_t k = 0; any_waiting && k < directional_.size(); ++k) {
    const Directional& d = directional_[k];
    for (int i = 0; i < kPacket; ++i) {
      if (!waiting[i]) continue;
      const float lux = own_lux(d, i);
      if (u[i] * all_lux[i] - below[i] < lux) {
        LightSample sample = sample_punctual(d.light, point.at(i));
        sample.radiance *= all_lux[i] / lux;
        out.set(i, sample);
        waiting[i] = 0;
      }
      below[i] += lux;
    }
  }
  if (!any_waiting) return;
  for (int i = 0; i < kPacket; ++i) within[i] = (u[i] * all_lux[i] - below[i]) / near_lux_;
  sample_near(waiting, point, within, v, all_lux, out);
}

void Lights::sample_environment(const int lanes[kPacket], const int cell[kPacket], const float u[kPacket],
                                const float v[kPacket], const float all_lux[kPacket], LightPacket& out) const {
  alignas(64) float height[kPacket], around[kPacket], density[kPacket];  // height: cosine from straight up
  for (int i = 0; i < kPacket; ++i) {
    height[i] = around[i] = density[i] = 0;
    if (!lanes[i]) continue;
    const EnvironmentTable& table = environment_tables_[cell[i]];
    float row_share, cell_share, place_u = std::min(u[i], 0x1.fffffep-1f), place_v = v[i];
    const std::size_t row = pick_from(table.rows.data(), kRows, place_v, row_share);
    const std::size_t column = pick_from(table.cells[row].data(), kColumns, place_u, cell_share);
    height[i] = kRowCosine[row] + place_v * (kRowCosine[row + 1] - kRowCosine[row]);
    around[i] = (static_cast<float>(column) + place_u) / kColumns;
    density[i] = environment_lux_[cell[i]] / all_lux[i] * row_share * cell_share * kCellsPerSteradian[row];
  }
  alignas(64) float sine[kPacket], cosine[kPacket], down[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    sine_cosine_of_turns(around[i] - 0.5f, sine[i], cosine[i]);
    const float r = std::sqrt(std::max(1 - height[i] * height[i], 0.0f));
    sine[i] *= r;
    cosine[i] *= -r;
    down[i] = half_turns_of_cosine(height[i]);
  }
  for (int i = 0; i < kPacket; ++i) {
    if (!lanes[i]) continue;
    out.direction.set(i, {sine[i], height[i], cosine[i]});
    out.radiance.set(i, radiance_at(scene_.environment, around[i], down[i]) / density[i]);
    out.distance_m[i] = std::numeric_limits<float>::infinity();
    out.pdf[i] = density[i];
  }
}

LightSample Lights::sample_punctual(const PunctualLight& light, glm::vec3 point) const {
  LightSample s;
  if (light.kind == PunctualLight::Kind::directional) {
    s.direction = -light.direction;
    s.distance_m = std::numeric_limits<float>::infinity();
    s.radiance = light.intensity;
    return s;
  }
  const glm::vec3 to_light = light.position - point;
  const float squared = glm::dot(to_light, to_light);
  if (!(squared > 0)) return s;
  s.distance_m = std::sqrt(squared);
  s.direction = to_light / s.distance_m;
  s.radiance = light.intensity / squared;
  // KHR_lights_punctual: recommended range window and cone fall-off
  if (light.range_m > 0) {
    const float ratio = s.distance_m / light.range_m;
    s.radiance *= std::max(std::min(1 - ratio * ratio * ratio * ratio, 1.0f), 0.0f);
  }
  if (light.kind == PunctualLight::Kind::spot) {
    const float width = std::max(light.cos_inner_cone - light.cos_outer_cone, 1e-3f);
    const float a = std::clamp((-glm::dot(light.direction, s.direction) - light.cos_outer_cone) / width, 0.0f, 1.0f);
    s.radiance *= a * a;
  }
  return s;
}

void Lights::sample_near(const int lanes[kPacket], const Vec3Packet& point, const float u[kPacket],
                         const float v[kPacket], const float all_lux[kPacket], LightPacket& out) const {
  struct Lane {
    int triangle = -1;  // index into triangles_
    float b1 = 0, b2 = 0;
  };
  std::array<Lane, kPacket> chosen;
  Vec3Packet to_light, normal;
  alignas(64) float area[kPacket], probability[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    to_light.set(i, glm::vec3(0));
    normal.set(i, glm::vec3(0));
    area[i] = probability[i] = 1;
    if (!lanes[i]) continue;
    if (!(near_lux_ > 0)) {
      out.set(i, {});
      continue;
    }
    float along = std::min(u[i], 0x1.fffffep-1f), share;
    const std::size_t entry = pick_from(near_.data(), near_.size(), along, share);
    probability[i] = share * near_lux_ / all_lux[i];
    if (entry < scene_.lights.size()) {
      LightSample sample = sample_punctual(scene_.lights[entry], point.at(i));
      sample.radiance /= probability[i];
      out.set(i, sample);
      continue;
    }
    Lane& lane = chosen[i];
    lane.triangle = static_cast<int>(entry - scene_.lights.size());
    // uniform over the triangle (Heitz 2019, low distortion)
    const float half = 0.5f * std::min(along, v[i]);
    lane.b1 = along - half, lane.b2 = v[i] - half;
    const EmissiveTriangle& light = triangles_[lane.triangle];
    to_light.set(i, light.corner + lane.b1 * light.first_edge + lane.b2 * light.second_edge - point.at(i));
    normal.set(i, light.normal);
    area[i] = light.area_m2;
  }
  alignas(64) float distance[kPacket], pdf[kPacket];
  for (int i = 0; i < kPacket; ++i) {
    const float x = to_light.x[i], y = to_light.y[i], z = to_light.z[i];
    const float squared = x * x + y * y + z * z, length = std::sqrt(squared), scale = 1 / length;
    const float cosine = std::abs(normal.x[i] * x + normal.y[i] * y + normal.z[i] * z) * scale;
    to_light.x[i] = x * scale, to_light.y[i] = y * scale, to_light.z[i] = z * scale;
    distance[i] = length;
    pdf[i] = cosine > 1e-6f ? squared / (cosine * area[i]) : 0.0f;  // 0 where a light is seen edge-on
  }
  for (int i = 0; i < kPacket; ++i) {
    if (chosen[i].triangle < 0) continue;
    LightSample sample;
    if (pdf[i] > 0) {
      const EmissiveTriangle& light = triangles_[chosen[i].triangle];
      const glm::vec3 nits = emission_at(scene_, scene_.meshes[light.mesh], light.triangle, chosen[i].b1, chosen[i].b2);
      sample = {to_light.at(i), distance[i], nits / (pdf[i] * probability[i]), pdf[i] * probability[i]};
    }
    out.set(i, sample);
  }
}

float Lights::environment_pdf(glm::vec3 normal, glm::vec3 direction) const {
  if (environment_tables_.empty()) return 0;
  const float u = std::atan2(direction.x, -direction.z) / (2 * kPi) + 0.5f;
  const float v = std::acos(std::clamp(direction.y, -1.0f, 1.0f)) / kPi;
  const int row = std::clamp(static_cast<int>(v * kRows), 0, kRows - 1);
  const int column = std::clamp(static_cast<int>(u * kColumns), 0, kColumns - 1);
  const Choice choice = choice_at(normal);
  const EnvironmentTable& table = environment_tables_[choice.cell];
  const float row_share = table.rows[row] - (row > 0 ? table.rows[row - 1] : 0);
  const float cell_share = table.cells[row][column] - (column > 0 ? table.cells[row][column - 1] : 0);
  return choice.environment_lux / choice.all_lux * row_share * cell_share * kCellsPerSteradian[row];
}

float Lights::triangle_pdf(glm::vec3 normal, unsigned mesh, unsigned triangle, float distance_m,
                           float abs_cos_at_light) const {
  const int first = first_triangle_of_mesh_[mesh];
  if (first < 0 || !(abs_cos_at_light > 1e-6f)) return 0;
  const std::size_t index = static_cast<std::size_t>(first) + triangle;
  const std::size_t entry = scene_.lights.size() + index;
  const float share = near_[entry] - (entry > 0 ? near_[entry - 1] : 0);
  const float probability = share * near_lux_ / choice_at(normal).all_lux;
  return probability * distance_m * distance_m / (abs_cos_at_light * triangles_[index].area_m2);
}

}  // namespace dualpixel::simulator
