#include "simulator/lens/split/split_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/error.h"

namespace dualpixel::simulator {
namespace {

void read_microlens(Fields& fields, SplitPixel::Microlens& m) {
  fields.number("focal_length_px", m.focal_length, 0.05, 1e3);
  fields.number("height_px", m.height, 0, 1e3);
  fields.number("diode_width_px", m.diode_width, 0.01, 10);
  fields.number("radius_px", m.radius, 0.01, 10);
  fields.number("shift_px", m.shift, -10, 10);
  fields.number("design_exit_pupil_mm", m.design_exit_pupil_mm, 0, 1e6);
}

void read_table(Fields& fields, SplitPixel::Table& table) {
  fields.required("p").list("p", table.p, -4, 4, 4096);
  fields.required("left").list("left", table.left, 0, 1, 4096);
  fields.required("right").list("right", table.right, 0, 1, 4096);
  if (table.p.size() < 2 || table.p.front() > -1 || table.p.back() < 1 ||
      std::adjacent_find(table.p.begin(), table.p.end(), std::greater_equal<>()) != table.p.end()) {
    fields.fail("p", printable(fields.raw("p").dump()) + ": must ascend from -1 or less to 1 or more");
  }
  if (table.left.size() != table.p.size()) fields.fail("left", "must have as many numbers as p");
  if (table.right.size() != table.p.size()) fields.fail("right", "must have as many numbers as p");
  double left_sum = 0, right_sum = 0;
  for (std::size_t i = 0; i < table.p.size(); ++i) {
    if (table.left[i] + table.right[i] > 1 + 1e-9) fields.fail("right", "left + right must not exceed 1");
    left_sum += table.left[i];
    right_sum += table.right[i];
  }
  if (left_sum == 0) fields.fail("left", "must not be 0 throughout");
  if (right_sum == 0) fields.fail("right", "must not be 0 throughout");
}

/// The model may be a lens file's, and the field the user's.
void refuse_fields_of_other_models(Fields& fields, SplitKind kind) {
  constexpr std::pair<const char*, SplitKind> kOwners[] = {
      {"k", SplitKind::ramp},
      {"focal_length_px", SplitKind::microlens},
      {"height_px", SplitKind::microlens},
      {"diode_width_px", SplitKind::microlens},
      {"radius_px", SplitKind::microlens},
      {"shift_px", SplitKind::microlens},
      {"design_exit_pupil_mm", SplitKind::microlens},
      {"p", SplitKind::table},
      {"left", SplitKind::table},
      {"right", SplitKind::table},
  };
  for (const auto& [field, owner] : kOwners) {
    if (owner == kind || !fields.has(field)) continue;
    fields.fail(field, fmt::format("is a field of the model '{}'; the split's model is '{}'",
                                   name_of(kSplitKinds, owner), name_of(kSplitKinds, kind)));
  }
}

}  // namespace

SplitPixel read_split(Fields fields) {
  SplitPixel split;
  read_named(fields, "model", split.kind, kSplitKinds);
  refuse_fields_of_other_models(fields, split.kind);
  switch (split.kind) {
    case SplitKind::hard:
      break;
    case SplitKind::ramp:
      fields.number("k", split.k, 1, 1e6);
      break;
    case SplitKind::microlens:
      read_microlens(fields, split.microlens);
      break;
    case SplitKind::table:
      read_table(fields, split.table);
      break;
  }
  fields.number("crosstalk", split.crosstalk, 0, 0.5);
  fields.done();
  return split;
}

nlohmann::ordered_json split_json(const SplitPixel& s) {
  nlohmann::ordered_json j = {{"model", name_of(kSplitKinds, s.kind)}};
  switch (s.kind) {
    case SplitKind::hard:
      break;
    case SplitKind::ramp:
      j["k"] = s.k;
      break;
    case SplitKind::microlens:
      j["focal_length_px"] = s.microlens.focal_length;
      j["height_px"] = s.microlens.height;
      j["diode_width_px"] = s.microlens.diode_width;
      j["radius_px"] = s.microlens.radius;
      j["shift_px"] = s.microlens.shift;
      j["design_exit_pupil_mm"] = s.microlens.design_exit_pupil_mm;
      break;
    case SplitKind::table:
      j["p"] = s.table.p;
      j["left"] = s.table.left;
      j["right"] = s.table.right;
      break;
  }
  if (s.crosstalk != 0) j["crosstalk"] = s.crosstalk;
  return j;
}

}  // namespace dualpixel::simulator
