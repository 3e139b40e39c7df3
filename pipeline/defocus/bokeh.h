#pragma once
#include "pipeline/defocus/aperture.h"
#include "pipeline/defocus/highlights.h"

namespace dualpixel::pipeline {

/// How what is out of focus looks, beyond how large its blur is.
struct Bokeh {
  Aperture aperture;
  /// Clipped pixels are blurred as bright as they may have been; where the blurred picture shows, it is then cut off at
  /// white. What is sharp is never touched.
  bool recover_highlights = false;
  HighlightOptions highlights;
  double white = 1;  ///< the linear picture's clipping level
};

}  // namespace dualpixel::pipeline
