#include "simulator/render/shading/environment_light.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "simulator/render/shading/pick.h"
#include "simulator/render/shading/radiometry.h"

namespace dualpixel::simulator {
namespace {

constexpr int kNormals = 48;  // cells a side of the octahedral map of normals, up to 4.2 degrees each

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

float share_of(const float* sums, std::size_t i) { return sums[i] - (i > 0 ? sums[i - 1] : 0); }

float share_of(const EnvironmentLight::Table& table, std::size_t row, std::size_t column) {
  return share_of(table.rows.data(), row) * share_of(table.cells[row].data(), column);
}

}  // namespace

glm::vec3 environment_radiance(const Environment& environment, glm::vec3 d) {
  if (environment.radiance_nits.empty()) return glm::vec3(0);
  const float u = std::atan2(d.x, -d.z) / (2 * kPi) + 0.5f;
  const float v = std::acos(std::clamp(d.y, -1.0f, 1.0f)) / kPi;
  return radiance_at(environment, u, v);
}

const std::array<float, EnvironmentLight::kRows + 1> EnvironmentLight::kRowCosine = [] {
  std::array<float, kRows + 1> cosine;
  for (int row = 0; row <= kRows; ++row) cosine[row] = std::cos(kPi * row / kRows);
  return cosine;
}();

const std::array<float, EnvironmentLight::kRows> EnvironmentLight::kCellsPerSteradian = [] {
  std::array<float, kRows> cells;
  for (int row = 0; row < kRows; ++row) cells[row] = kColumns / (2 * kPi * (kRowCosine[row] - kRowCosine[row + 1]));
  return cells;
}();

EnvironmentLight::EnvironmentLight(const Environment& environment) : environment_(environment) {
  if (environment.radiance_nits.empty()) return;
  make_bins();
  const std::vector<Probe> probes = make_probes();
  double power = 0;
  for (std::size_t i = 0; i < probes.size(); ++i) {
    const std::size_t row = i / (std::size_t{kProbes} * kProbes * kColumns);
    power += probes[i].nits / (kCellsPerSteradian[row] * kProbes * kProbes);
  }
  if (!(power > 0)) return;
  tables_.resize(std::size_t{kNormals} * kNormals);
  lux_.resize(tables_.size());
  const auto mean_nits = static_cast<float>(power / (4 * kPi));
  for (std::size_t i = 0; i < probes.size(); ++i) {
    constexpr int kOfCell = kProbes * kProbes;
    cell_nits_[i / kOfCell / kColumns][i / kOfCell % kColumns] += (probes[i].nits + 0.001f * mean_nits) / kOfCell;
  }
  tbb::parallel_for(0, kNormals * kNormals, [&](int normal) { fill_table(probes, mean_nits, normal); });
  tbb::parallel_for(0, kRows * kColumns, [&](int cell) { sum_up_bins(cell); });
}

void EnvironmentLight::make_bins() {
  const auto bins = [](int pixels, int cells) { return (pixels + kProbes * cells - 1) / (kProbes * cells) * kProbes; };
  bin_rows_ = bins(environment_.height, kRows);
  bin_columns_ = bins(environment_.width, kColumns);
  bins_.resize(std::size_t{kRows} * kColumns * bin_rows_ * bin_columns_);
  bin_row_sums_.resize(std::size_t{kRows} * kColumns * bin_rows_);
  // A bin's mean by the trapezoid rule: its corners count, so light that reaches into it from the sun in the next pixel
  // is not missed. By points within bins alone, the deviation of a sample was up to ten times as large. Bins at the
  // poles are many pixels high, of which none may be stepped over.
  tbb::parallel_for(0, kRows * kColumns, [&](int cell) {
    const int row = cell / kColumns, column = cell % kColumns;
    float* bin = &bins_[static_cast<std::size_t>(cell) * bin_rows_ * bin_columns_];
    const auto v_at = [&](int bin_row) {
      const float down = static_cast<float>(bin_row) / static_cast<float>(bin_rows_);
      return half_turns_of_cosine(kRowCosine[row] + down * (kRowCosine[row + 1] - kRowCosine[row]));
    };
    for (int i = 0; i < bin_rows_; ++i) {
      const float top = v_at(i), bottom = v_at(i + 1);
      const int steps = 2 * std::max(static_cast<int>(std::ceil((bottom - top) * environment_.height)), 1);
      for (int j = 0; j < bin_columns_; ++j, ++bin) {
        float sum = 0;
        for (int k = 0; k <= steps; ++k) {
          const float v = top + (bottom - top) * static_cast<float>(k) / static_cast<float>(steps);
          const float of_row = std::sin(kPi * v) * (k % steps == 0 ? 0.5f : 1.0f);
          sum += of_row;
          for (int half = 0; half <= 2; ++half) {
            const float u =
                (column + static_cast<float>(2 * j + half) / static_cast<float>(2 * bin_columns_)) / kColumns;
            *bin += of_row * (half == 1 ? 0.5f : 0.25f) * luminance(radiance_at(environment_, u, v));
          }
        }
        *bin /= sum;
      }
    }
  });
}

std::vector<EnvironmentLight::Probe> EnvironmentLight::make_probes() const {
  std::vector<Probe> probes(std::size_t{kRows} * kColumns * kProbes * kProbes);
  const int rows = bin_rows_ / kProbes, columns = bin_columns_ / kProbes;  // bins of a probe
  tbb::parallel_for(0, kRows * kColumns, [&](int cell) {
    const int row = cell / kColumns, column = cell % kColumns;
    for (int k = 0; k < kProbes * kProbes; ++k) {
      const int probe_row = k / kProbes, probe_column = k % kProbes;
      const int first_row = probe_row * rows, first_column = probe_column * columns;
      double sum = 0;
      for (int i = first_row; i < first_row + rows; ++i) {
        for (int j = first_column; j < first_column + columns; ++j)
          sum += bins_[(static_cast<std::size_t>(cell) * bin_rows_ + i) * bin_columns_ + j];
      }
      const float down = (static_cast<float>(probe_row) + 0.5f) / kProbes;
      const float y = kRowCosine[row] + down * (kRowCosine[row + 1] - kRowCosine[row]);
      const float phi = 2 * kPi * ((column + (static_cast<float>(probe_column) + 0.5f) / kProbes) / kColumns - 0.5f);
      const float r = std::sqrt(std::max(1 - y * y, 0.0f));
      probes[static_cast<std::size_t>(cell) * kProbes * kProbes + k] = {static_cast<float>(sum / (rows * columns)),
                                                                        {r * std::sin(phi), y, -r * std::cos(phi)}};
    }
  });
  return probes;
}

void EnvironmentLight::fill_table(const std::vector<Probe>& probes, float mean_nits, int normal) {
  // No direction that light could come from may be left out. Normals lie up to 5.0 degrees from their cell's middle,
  // whose cosines are lifted by the sine of that; positions lie up to a few degrees beyond the outermost probes of
  // their own cell, and the constant gives those just above the horizon some probability.
  constexpr float kLift = 0.09f, kLeast = 0.002f;
  const float least_nits = 0.001f * mean_nits;
  Table& table = tables_[normal];
  const glm::vec3 n = cell_normal(normal);
  float lux = 0;
  for (int row = 0; row < kRows; ++row) {
    float nits = 0;
    for (int column = 0; column < kColumns; ++column) {
      constexpr int kOfCell = kProbes * kProbes;
      const Probe* probe = &probes[static_cast<std::size_t>(row * kColumns + column) * kOfCell];
      for (int i = 0; i < kOfCell; ++i) {
        const float cosine = std::max(glm::dot(n, probe[i].towards) + kLift, 0.0f) + kLeast;
        nits += (probe[i].nits + least_nits) * cosine / kOfCell;
      }
      table.cells[row][column] = nits;
    }
    lux += nits / kCellsPerSteradian[row];
    table.rows[row] = lux;
    normalize_sums(table.cells[row].begin(), table.cells[row].end());
  }
  lux_[normal] = lux;
  normalize_sums(table.rows.begin(), table.rows.end());
}

void EnvironmentLight::sum_up_bins(int cell) {
  // As for cells, no bin may be left out: a pixel's light reaches half a pixel beyond it.
  constexpr float kLeastShare = 1e-3f;
  float* bins = &bins_[static_cast<std::size_t>(cell) * bin_rows_ * bin_columns_];
  const int count = bin_rows_ * bin_columns_;
  double all = 0;
  for (int i = 0; i < count; ++i) all += bins[i];
  const auto least = static_cast<float>(kLeastShare * all / count);
  float* row_sums = &bin_row_sums_[static_cast<std::size_t>(cell) * bin_rows_];
  double below = 0;
  for (int row = 0; row < bin_rows_; ++row) {
    float* first = bins + static_cast<std::size_t>(row) * bin_columns_;
    double sum = 0;
    for (int column = 0; column < bin_columns_; ++column)
      first[column] = static_cast<float>(sum += first[column] + least);
    below += sum;
    row_sums[row] = static_cast<float>(below);
    normalize_sums(first, first + bin_columns_);
  }
  normalize_sums(row_sums, row_sums + bin_rows_);
}

int EnvironmentLight::table_of(float x, float y, float z) const { return normal_cell(x, y, z); }

EnvironmentLight::Cell EnvironmentLight::cell_of(glm::vec3 direction) {
  const float u = std::atan2(direction.x, -direction.z) / (2 * kPi) + 0.5f;
  const float v = std::acos(std::clamp(direction.y, -1.0f, 1.0f)) / kPi;
  return {std::clamp(static_cast<int>(v * kRows), 0, kRows - 1),
          std::clamp(static_cast<int>(u * kColumns), 0, kColumns - 1)};
}

glm::vec3 EnvironmentLight::middle_of(Cell cell) {
  const float theta = kPi * (static_cast<float>(cell.row) + 0.5f) / kRows;
  const float phi = 2 * kPi * ((static_cast<float>(cell.column) + 0.5f) / kColumns - 0.5f);
  return {std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi)};
}

EnvironmentLight::Table EnvironmentLight::table_of(const Cells& values) {
  Table table;
  float sum = 0;
  for (int row = 0; row < kRows; ++row) {
    float of_row = 0;
    for (int column = 0; column < kColumns; ++column) table.cells[row][column] = of_row += values[row][column];
    table.rows[row] = sum += of_row / kCellsPerSteradian[row];
    normalize_sums(table.cells[row].begin(), table.cells[row].end());
  }
  normalize_sums(table.rows.begin(), table.rows.end());
  return table;
}

void EnvironmentLight::sample(const int lanes[kPacket], const Choice choice[kPacket], const float u[kPacket],
                              const float v[kPacket], Samples& out) const {
  alignas(64) float height[kPacket], around[kPacket];  // height: cosine from straight up
  for (int i = 0; i < kPacket; ++i) {
    height[i] = around[i] = out.pdf[i] = 0;
    if (!lanes[i]) continue;
    float row_share, column_share, bin_row_share, bin_share, at_u = std::min(u[i], 0x1.fffffep-1f), at_v = v[i];
    const Table *from = &tables_[choice[i].table], *other = choice[i].other;
    float share = 1 - choice[i].other_share;
    if (at_v >= share) {
      std::swap(from, other);
      at_v -= share, share = 1 - share;
    }
    at_v = std::min(at_v / share, 0x1.fffffep-1f);
    const std::size_t row = pick_from(from->rows.data(), kRows, at_v, row_share);
    const std::size_t column = pick_from(from->cells[row].data(), kColumns, at_u, column_share);
    float cell_share = share * row_share * column_share;
    if (share < 1) cell_share += (1 - share) * share_of(*other, row, column);
    const std::size_t cell = row * kColumns + column;
    const std::size_t bin_row = pick_from(&bin_row_sums_[cell * bin_rows_], bin_rows_, at_v, bin_row_share);
    const float* bins = &bins_[(cell * bin_rows_ + bin_row) * bin_columns_];
    const std::size_t bin = pick_from(bins, bin_columns_, at_u, bin_share);
    const float down = (static_cast<float>(bin_row) + at_v) / static_cast<float>(bin_rows_);
    height[i] = kRowCosine[row] + down * (kRowCosine[row + 1] - kRowCosine[row]);
    around[i] =
        (static_cast<float>(column) + (static_cast<float>(bin) + at_u) / static_cast<float>(bin_columns_)) / kColumns;
    out.pdf[i] =
        cell_share * kCellsPerSteradian[row] * bin_row_share * bin_share * static_cast<float>(bin_rows_ * bin_columns_);
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
    out.nits.set(i, radiance_at(environment_, around[i], down[i]));
  }
}

float EnvironmentLight::pdf(const Choice& choice, glm::vec3 direction) const {
  const float u = std::atan2(direction.x, -direction.z) / (2 * kPi) + 0.5f;
  const auto [row, column] = cell_of(direction);
  const std::size_t cell = static_cast<std::size_t>(row) * kColumns + column;
  const float down = (kRowCosine[row] - direction.y) / (kRowCosine[row] - kRowCosine[row + 1]);
  const int bin_row = std::clamp(static_cast<int>(down * static_cast<float>(bin_rows_)), 0, bin_rows_ - 1);
  const float along = u * kColumns - static_cast<float>(column);
  const int bin = std::clamp(static_cast<int>(along * static_cast<float>(bin_columns_)), 0, bin_columns_ - 1);
  float cell_share = (1 - choice.other_share) * share_of(tables_[choice.table], row, column);
  if (choice.other_share > 0) cell_share += choice.other_share * share_of(*choice.other, row, column);
  return cell_share * kCellsPerSteradian[row] * share_of(&bin_row_sums_[cell * bin_rows_], bin_row) *
         share_of(&bins_[(cell * bin_rows_ + bin_row) * bin_columns_], bin) *
         static_cast<float>(bin_rows_ * bin_columns_);
}

}  // namespace dualpixel::simulator
