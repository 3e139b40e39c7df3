#pragma once
#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "simulator/render/vec3_packet.h"
#include "simulator/scene/scene.h"

/// Choosing directions in which an environment shines on a surface: cells of the sphere in proportion to their light
/// times the surface's cosine, and within a cell bins about as large as the picture's pixels, in proportion to their
/// light.
namespace dualpixel::simulator {

/// Radiance of the environment in direction `d` (unit), bilinear.
glm::vec3 environment_radiance(const Environment& environment, glm::vec3 d);

class EnvironmentLight {
 public:
  /// Keeps a pointer to `environment`.
  explicit EnvironmentLight(const Environment& environment);

  /// No light comes from it.
  bool dark() const { return tables_.empty(); }

  /// A normal's entry in the tables; any numbers will do.
  int table_of(float x, float y, float z) const;
  /// Illuminance on a surface with a normal of this table if nothing is in the way; not dark().
  float lux(int table) const { return lux_[table]; }

  static constexpr int kRows = 16, kColumns = 32;  ///< cells of the sphere; rows equal in angle
  /// How samples are shared out among the cells: running sums.
  struct Table {
    std::array<float, kRows> rows{};
    std::array<std::array<float, kColumns>, kRows> cells{};  ///< of each row by itself
  };
  using Cells = std::array<std::array<float, kColumns>, kRows>;
  /// Mean luminance of each cell, nits; a thousandth of the mean of all at least.
  const Cells& cell_nits() const { return cell_nits_; }
  struct Cell {
    int row, column;
  };
  static Cell cell_of(glm::vec3 direction);  ///< unit
  static glm::vec3 middle_of(Cell cell);
  /// Shares samples out by these values times the cells' solid angles.
  static Table table_of(const Cells& values);

  /// How one lane's samples are shared out: by the table of its normal, and a share of them by another.
  struct Choice {
    int table = 0;
    float other_share = 0;
    const Table* other = nullptr;
  };
  struct Samples {
    Vec3Packet direction, nits;
    alignas(64) float pdf[kPacket];  ///< per steradian
  };
  /// For each lane with lanes[i] != 0; 0 <= u, v < 1; not dark().
  void sample(const int lanes[kPacket], const Choice choice[kPacket], const float u[kPacket], const float v[kPacket],
              Samples& out) const;
  /// The density with which sample() finds this direction (unit); not dark().
  float pdf(const Choice& choice, glm::vec3 direction) const;

 private:
  static constexpr int kProbes = 4;  ///< directions a side of a cell for which cosines are computed
  struct Probe {
    float nits;         ///< mean of its part of the cell
    glm::vec3 towards;  ///< the middle of it
  };
  void make_bins();
  std::vector<Probe> make_probes() const;
  void sum_up_bins(int cell);
  void fill_table(const std::vector<Probe>& probes, float mean_nits, int normal);

  // Of one cell of a row: cosine from straight up at its top (the last: at the bottom of all), and how many such cells
  // make a steradian.
  static const std::array<float, kRows + 1> kRowCosine;
  static const std::array<float, kRows> kCellsPerSteradian;

  const Environment& environment_;
  int bin_rows_ = 0, bin_columns_ = 0;  ///< of a cell, equal in solid angle; multiples of kProbes
  std::vector<float> bins_;             ///< nits, then running sums along each row of a cell
  std::vector<float> bin_row_sums_;     ///< running sums over the rows of a cell
  Cells cell_nits_{};
  std::vector<Table> tables_;  ///< one for each cell of an octahedral map of normals: radiance times cosine
  std::vector<float> lux_;     ///< ... in all
};

}  // namespace dualpixel::simulator
