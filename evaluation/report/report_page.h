#pragma once
#include <optional>
#include <string>
#include <vector>

#include "evaluation/metrics/scoring.h"
#include "evaluation/report/viewer.h"
#include "pipeline/portrait/run_portrait.h"

/// The page of `dualpixel report`: for each capture, a viewer of its views, truth and results, and the results' scores.
/// Whatever text goes in is escaped here.
namespace dualpixel::evaluation {

struct ResultSection {
  std::string name;
  std::string mode;
  std::string disparity_from;  ///< "matcher paper", or the file that the user gave; empty where it is unknown or none
  std::optional<Score> score;  ///< none where there is no truth
  std::vector<pipeline::StageTime> stages;
  std::string provenance;  ///< how the result was made, as text
};

struct CaptureSection {
  std::string name;
  std::string facts;       ///< one line: size, lens, exposure
  std::string provenance;  ///< how the capture was made, as text
  Viewer viewer;           ///< its results are those below
  std::vector<ResultSection> results;
};

std::string report_page(const std::vector<CaptureSection>& captures);

}  // namespace dualpixel::evaluation
