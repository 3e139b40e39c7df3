#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "evaluation/comparison/compare_methods.h"
#include "evaluation/metrics/bootstrap.h"

/// What many scenes say together.
namespace dualpixel::evaluation {

/// One figure of one method over scenes.
struct ComparedFigure {
  MeanInterval mean;
  MeanInterval lead;  ///< of the first method over this one, scene by scene, positive where the first is better
  double wins = 0;    ///< scenes in which it is the best of the five; methods that tie share one
};

struct ComparedMethod {
  std::string method;
  std::vector<ComparedFigure> figures;  ///< as figure_names()
};

struct ComparedGroup {
  std::string name;  ///< "all", "people", "things"
  std::size_t scenes = 0;
  std::vector<ComparedMethod> methods;  ///< the five, and the two references, which cannot win
};

/// "PSNR, dB", "SSIM", "FLIP" of the whole picture, then of the crops.
std::vector<std::string> figure_names();

/// All scenes, those that show people, and the others; a group without scenes is left out.
std::vector<ComparedGroup> compare_scenes(const std::vector<SceneComparison>& scenes);

nlohmann::ordered_json to_json(const std::vector<ComparedGroup>& groups, const std::vector<SceneComparison>& scenes);
/// For a terminal: a table for each group, of the crops and of whole pictures.
std::string to_text(const std::vector<ComparedGroup>& groups);

/// HTML of one scene, its pictures small and its first crop in full.
std::string scene_section(const ComparedPictures& scene);

/// `scene_sections`: one after the other.
std::string to_page(const std::vector<ComparedGroup>& groups, const std::string& scene_sections);

}  // namespace dualpixel::evaluation
