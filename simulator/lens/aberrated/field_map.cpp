#include "simulator/lens/aberrated/field_map.h"

#include "capture/image/bilinear.h"

namespace dualpixel::simulator {

double FieldMap::operator()(double x, double y) const {
  double value = constant + gradient_x * x + gradient_y * y;
  if (!cells.empty()) {
    const BilinearTap u = bilinear_tap(0.5 * (x + 1) * columns - 0.5, columns);
    const BilinearTap v = bilinear_tap(0.5 * (y + 1) * rows - 0.5, rows);
    value += bilinear(u, v, [&](int column, int row) { return cells[row * columns + column]; });
  }
  return value;
}

}  // namespace dualpixel::simulator
