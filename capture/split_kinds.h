#pragma once
#include "capture/names.h"

namespace dualpixel {

/// How a photosite's two halves may share the light: a lens file says it of a simulated sensor, capture.json of any.
enum class SplitKind { hard, ramp, microlens, table };

inline constexpr Named<SplitKind> kSplitKinds[] = {
    {"hard", SplitKind::hard, "each half takes its half of the pupil"},
    {"ramp", SplitKind::ramp, "the share changes linearly over the pupil"},
    {"microlens", SplitKind::microlens, "a microlens of finite size and height over two photodiodes"},
    {"table", SplitKind::table, "measured shares over the pupil"},
};

}  // namespace dualpixel
