#include <nlohmann/json.hpp>
#include <utility>

#include "evaluation/failures/failure_atlas.h"

namespace dualpixel::evaluation {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::pair<const char*, std::optional<double> FailureFigures::*> kFigures[] = {
    {"rmse_dp_px", &FailureFigures::rmse_dp_px},
    {"mean_confidence", &FailureFigures::confidence},
    {"trusted_share", &FailureFigures::trusted},
    {"overconfident_error_share", &FailureFigures::overconfident},
    {"median_sigma_dp_px", &FailureFigures::sigma_dp_px},
    {"error_68_percent_dp_px", &FailureFigures::error_68_dp_px},
    {"within_one_sigma_share", &FailureFigures::within_one_sigma},
    {"within_two_sigma_share", &FailureFigures::within_two_sigma},
};
constexpr std::pair<const char*, std::string FailureSweep::*> kTexts[] = {{"name", &FailureSweep::name},
                                                                          {"title", &FailureSweep::title},
                                                                          {"sweep", &FailureSweep::sweep},
                                                                          {"key", &FailureSweep::key},
                                                                          {"note", &FailureSweep::note}};

Json to_json(const FailureFigures& figures) {
  Json json = {{"wrong_share", figures.wrong}};
  for (const auto& [name, figure] : kFigures) {
    if (figures.*figure) json[name] = *(figures.*figure);
  }
  return json;
}

FailureFigures figures_of(const Json& json) {
  FailureFigures figures;
  figures.wrong = json.at("wrong_share");
  for (const auto& [name, figure] : kFigures) {
    if (json.contains(name) && json[name].is_number()) figures.*figure = json[name].get<double>();
  }
  return figures;
}

}  // namespace

Json to_json(const FailureSweep& sweep, bool with_pictures) {
  Json json;
  for (const auto& [name, text] : kTexts) json[name] = sweep.*text;
  json["log"] = sweep.log;
  for (std::size_t m = 0; m < sweep.methods.size(); ++m) {
    const auto& [step, low, high] = sweep.breaks[m];
    json["methods"][sweep.methods[m]] = {{"breaks_at", sweep.value_at(step)},
                                         {"breaks_at_95_percent", {sweep.value_at(low), sweep.value_at(high)}},
                                         {"breaks_at_step", {step, low, high}}};
  }
  for (const FailureStep& step : sweep.steps) {
    Json of_step = {{"value", step.value}};
    for (const FailureFigures& figures : step.methods) of_step["methods"].push_back(to_json(figures));
    if (with_pictures) of_step["pictures"] = {step.view_uri, step.truth_uri, step.found_uris};
    json["steps"].push_back(of_step);
  }
  if (with_pictures) json["limit_dp_px"] = sweep.limit_dp_px;
  return json;
}

FailureSweep sweep_of_json(const Json& json) {
  FailureSweep sweep;
  for (const auto& [name, text] : kTexts) sweep.*text = json.at(name);
  sweep.log = json.at("log");
  sweep.limit_dp_px = json.at("limit_dp_px");
  for (const auto& [name, method] : json.at("methods").items()) {
    sweep.methods.push_back(name);
    const Json& steps = method.at("breaks_at_step");
    sweep.breaks.push_back({steps.at(0), steps.at(1), steps.at(2)});
  }
  for (const Json& of_step : json.at("steps")) {
    FailureStep& step = sweep.steps.emplace_back();
    step.value = of_step.at("value");
    for (const Json& figures : of_step.at("methods")) step.methods.push_back(figures_of(figures));
    const Json& pictures = of_step.at("pictures");
    step.view_uri = pictures.at(0), step.truth_uri = pictures.at(1);
    for (const Json& found : pictures.at(2)) step.found_uris.push_back(found);
  }
  return sweep;
}

}  // namespace dualpixel::evaluation
