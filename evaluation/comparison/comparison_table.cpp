#include "evaluation/comparison/comparison_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace dualpixel::evaluation {
namespace {

using Json = nlohmann::ordered_json;

/// One of the figures that are compared, and whether more of it is better.
struct Figure {
  const char* name;
  PictureFigures MethodFigures::*part;
  double PictureFigures::*value;
  bool more_is_better;

  double of(const MethodFigures& method) const { return method.*part.*value; }
};

constexpr Figure kFigures[] = {
    {"PSNR, dB", &MethodFigures::whole, &PictureFigures::psnr_db, true},
    {"SSIM", &MethodFigures::whole, &PictureFigures::ssim, true},
    {"FLIP", &MethodFigures::whole, &PictureFigures::flip, false},
    {"PSNR of crops, dB", &MethodFigures::crops, &PictureFigures::psnr_db, true},
    {"SSIM of crops", &MethodFigures::crops, &PictureFigures::ssim, true},
    {"FLIP of crops", &MethodFigures::crops, &PictureFigures::flip, false},
};

/// The share of a win that each of the methods has in one scene.
std::vector<double> shares_of_win(const SceneComparison& scene, const Figure& figure) {
  const std::size_t five = compared_methods().size();
  std::vector<double> values, shares(scene.methods.size());
  for (std::size_t m = 0; m < five; ++m) {
    values.push_back((figure.more_is_better ? 1 : -1) * figure.of(scene.methods[m]));
  }
  const double best = *std::max_element(values.begin(), values.end());
  const auto tied = static_cast<double>(std::count(values.begin(), values.end(), best));
  for (std::size_t m = 0; m < five; ++m) shares[m] = values[m] == best ? 1 / tied : 0;
  return shares;
}

ComparedFigure compared(const std::vector<const SceneComparison*>& scenes, const Figure& figure, std::size_t method) {
  std::vector<double> values, leads;
  ComparedFigure result;
  for (const SceneComparison* scene : scenes) {
    const double own = figure.of(scene->methods[method]);
    values.push_back(own);
    leads.push_back((figure.more_is_better ? 1 : -1) * (figure.of(scene->methods[0]) - own));
    result.wins += shares_of_win(*scene, figure)[method];
  }
  result.mean = bootstrap_mean(values);
  result.lead = bootstrap_mean(leads);
  return result;
}

ComparedGroup group_of(const std::string& name, const std::vector<const SceneComparison*>& scenes) {
  ComparedGroup group{name, scenes.size(), {}};
  for (std::size_t m = 0; m < scenes[0]->methods.size(); ++m) {
    ComparedMethod& method = group.methods.emplace_back(ComparedMethod{scenes[0]->methods[m].method, {}});
    for (const Figure& figure : kFigures) method.figures.push_back(compared(scenes, figure, m));
  }
  return group;
}

Json to_json(const MeanInterval& interval) {
  return {{"mean", interval.mean}, {"low", interval.low}, {"high", interval.high}};
}

}  // namespace

std::vector<std::string> figure_names() {
  std::vector<std::string> names;
  for (const Figure& figure : kFigures) names.emplace_back(figure.name);
  return names;
}

std::vector<ComparedGroup> compare_scenes(const std::vector<SceneComparison>& scenes) {
  std::vector<const SceneComparison*> all, people, things;
  for (const SceneComparison& scene : scenes) {
    all.push_back(&scene);
    (scene.shows_people ? people : things).push_back(&scene);
  }
  std::vector<ComparedGroup> groups;
  for (const auto& [name, members] : {std::pair{"all", &all}, {"people", &people}, {"things", &things}}) {
    if (!members->empty()) groups.push_back(group_of(name, *members));
  }
  return groups;
}

Json to_json(const std::vector<ComparedGroup>& groups, const std::vector<SceneComparison>& scenes) {
  Json json = {{"experiment", "methods"}, {"groups", Json::array()}, {"scenes", Json::array()}};
  const std::vector<std::string> names = figure_names();
  for (const ComparedGroup& group : groups) {
    Json methods = Json::array();
    for (const ComparedMethod& method : group.methods) {
      Json row = {{"method", method.method}};
      for (std::size_t i = 0; i < names.size(); ++i) {
        const ComparedFigure& figure = method.figures[i];
        row[names[i]] = {{"mean", to_json(figure.mean)}, {"lead", to_json(figure.lead)}, {"wins", figure.wins}};
      }
      methods.push_back(row);
    }
    json["groups"].push_back({{"group", group.name}, {"scenes", group.scenes}, {"methods", methods}});
  }
  for (const SceneComparison& scene : scenes) json["scenes"].push_back(to_json(scene));
  return json;
}

std::string to_text(const std::vector<ComparedGroup>& groups) {
  std::string text;
  for (const ComparedGroup& group : groups) {
    for (const int part : {3, 0}) {
      text += fmt::format("{}{}, {} scenes: mean [95 %], wins\n{:<16}", text.empty() ? "" : "\n",
                          part == 3 ? group.name + ", crops" : group.name + ", whole pictures", group.scenes, "");
      for (const char* name : {"PSNR, dB", "SSIM", "FLIP"}) text += fmt::format("{:<30}", name);
      text += "\n";
      for (const ComparedMethod& method : group.methods) {
        text += fmt::format("{:<16}", method.method);
        for (int i = part; i < part + 3; ++i) {
          const ComparedFigure& figure = method.figures[i];
          const int decimals = i == part ? 2 : 4;
          text +=
              fmt::format("{:<30}", fmt::format("{:.{}f} [{:.{}f}, {:.{}f}] {:.3g}", figure.mean.mean, decimals,
                                                figure.mean.low, decimals, figure.mean.high, decimals, figure.wins));
        }
        while (text.back() == ' ') text.pop_back();
        text += "\n";
      }
    }
  }
  return text;
}

}  // namespace dualpixel::evaluation
