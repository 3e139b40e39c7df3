#pragma once
#include <optional>
#include <string>
#include <vector>

#include "evaluation/metrics/scoring.h"
#include "evaluation/report/page.h"
#include "pipeline/portrait/run_portrait.h"

/// The page of `dualpixel report`: portrait results beside each other, with pictures, maps and scores. Pictures are
/// data URIs. Whatever text goes in is escaped here.
namespace dualpixel::evaluation {

struct ResultSection {
  std::string name;
  std::string mode;
  std::string disparity_from;  ///< "matcher paper", or the file that the user gave; empty where it is unknown or none
  std::vector<Picture> photographs;  ///< of one size, laid over each other behind a divider that can be dragged
  std::vector<Picture> maps;
  std::optional<Score> score;  ///< none where there is no truth
  std::vector<pipeline::StageTime> stages;
  std::string provenance;  ///< how the result was made, as text
};

struct CaptureSection {
  std::string name;
  std::string facts;             ///< one line: size, lens, exposure
  std::vector<Picture> flicker;  ///< left and right view
  std::string provenance;        ///< how the capture was made, as text
  std::vector<ResultSection> results;
};

std::string report_page(const std::vector<CaptureSection>& captures);

}  // namespace dualpixel::evaluation
