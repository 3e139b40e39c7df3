#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "evaluation/study/study.h"

/// What participants of a study chose (Wadhwa et al. 2018, Table 3).
namespace dualpixel::evaluation {

/// One file that the study's page saved:
///   {"format": "dualpixel votes", "version": 1, "study": "0123456789abcdef", "participant": "A",
///    "scenes": [{"scene": 0, "comparisons": [[2, 0, 0], [0, 1, 1]]}]}
/// A comparison holds the numbers of the left picture, the right one and the preferred one; the preferred one meets the
/// next, and the last one that is preferred has the participant's vote.
struct Votes {
  std::string participant;
  struct Scene {
    int scene = 0;
    std::vector<std::vector<int>> comparisons;
  };
  std::vector<Scene> scenes;
};

/// Throws InputError where the file is not of this study, or its comparisons are not such a sequence.
Votes read_votes(const std::string& path, const Study& study);

struct VoteTable {
  std::vector<std::string> participants;
  struct Row {
    std::string method;
    std::vector<int> votes;          ///< one for each participant: scenes that it won
    double mean = 0, deviation = 0;  ///< over participants; with n - 1, as in the paper's Table 3
    int shown = 0, preferred = 0;    ///< single comparisons, of all participants
  };
  std::vector<Row> rows;  ///< in the order of the study's methods
};

/// Throws InputError where two files are of one participant.
VoteTable count_votes(const Study& study, const std::vector<Votes>& votes);

nlohmann::ordered_json to_json(const VoteTable& table);

/// The table as text, the most preferred method last, as in the paper.
std::string to_text(const VoteTable& table);

}  // namespace dualpixel::evaluation
