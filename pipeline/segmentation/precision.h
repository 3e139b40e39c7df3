#pragma once

namespace dualpixel::pipeline {

/// Of a network at work.
enum class Precision {
  f32,  ///< with instructions up to AVX2 alone, so that every processor gives the same bytes
  bf16  ///< with whatever the processor has, AVX-512 at least; much faster where that is AMX
};

}  // namespace dualpixel::pipeline
