#pragma once
#include <string>

#include "capture/capture.h"
#include "evaluation/chart/chart.h"
#include "evaluation/chart/chart_input.h"
#include "pipeline/portrait/disparity_settings.h"

/// What `portrait --auto` promises, measured.
namespace dualpixel::evaluation {

/// How many scenes it is measured on: portraits and still lifes, .18 to 1.2 m away, in focus for the most part, and two
/// still lifes that lie wholly behind and before the focus, at 2.7 to 3.9 and -3.5 to -1.7 DP px.
int auto_scene_count();

/// Draws one of them into `scratch`, a folder that exists, and simulates the middle of it: 672 x 504 of 1344 x 1008
/// photosites (2688 x 2016 of those out of focus) behind a thin lens, a burst of three at rest, the noise of a phone's
/// small photosites. Throws InputError.
Capture simulate_auto_scene(int index, const std::string& scratch);

/// Root mean square error of mode dp's disparity over all pixels with valid truth, DP px.
double disparity_error(const Capture& capture, const pipeline::DisparitySetting& setting);

/// CPU time of matching, smoothing and upsampling, ms: the least of three runs.
double disparity_cpu_ms(const Capture& capture, const pipeline::DisparitySetting& setting);

/// Every setting's root mean square of errors over the scenes, and its time on one capture of 2688 x 2016.
ChartPart measure_auto(const ChartInput& input);

}  // namespace dualpixel::evaluation
