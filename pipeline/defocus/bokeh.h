#pragma once
#include "pipeline/defocus/aperture.h"
#include "pipeline/defocus/highlights.h"

namespace dualpixel::pipeline {

/// The look of blurred areas apart from their radius: aperture shape and clipped highlights.
struct Bokeh {
  Aperture aperture;
  /// Brighten clipped pixels before the blur (highlights.h). The blurred picture is clipped at white again; sharp
  /// pixels stay as they are.
  bool recover_highlights = false;
  HighlightOptions highlights;
  double white = 1;  ///< the linear picture's clipping level
};

}  // namespace dualpixel::pipeline
