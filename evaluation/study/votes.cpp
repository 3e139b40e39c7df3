#include "evaluation/study/votes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "capture/error.h"
#include "capture/json_fields.h"

namespace dualpixel::evaluation {
namespace {

/// The winner meets a picture that was not shown yet, until all were.
void require_sequence(const Fields& fields, const Votes::Scene& scene, std::size_t pictures) {
  if (scene.comparisons.size() != pictures - 1) {
    fields.fail("comparisons",
                fmt::format("{}: must be {}, one less than there are methods", scene.comparisons.size(), pictures - 1));
  }
  std::set<int> shown;
  int best = -1;
  for (std::size_t i = 0; i < scene.comparisons.size(); ++i) {
    const std::vector<int>& pair = scene.comparisons[i];
    const int left = pair[0], right = pair[1], preferred = pair[2];
    const std::string here = fmt::format("comparisons/{}", i);
    if (left == right || (preferred != left && preferred != right)) {
      fields.fail(here, fmt::format("[{}, {}, {}]: must be two pictures and the preferred one of them", left, right,
                                    preferred));
    }
    if (i > 0 && left != best && right != best) {
      fields.fail(here, fmt::format("[{}, {}, {}]: must show picture {}, which was preferred before", left, right,
                                    preferred, best));
    }
    const std::size_t before = shown.size();
    shown.insert({left, right});
    if (i > 0 && shown.size() != before + 1) {
      fields.fail(here,
                  fmt::format("[{}, {}, {}]: must show a picture that was not shown yet", left, right, preferred));
    }
    best = preferred;
  }
}

Votes::Scene read_scene(Fields& fields, const Study& study) {
  const auto pictures = static_cast<int>(study.methods.size());
  Votes::Scene scene;
  fields.required("scene").integer("scene", scene.scene, 0, static_cast<std::int64_t>(study.scenes.size()) - 1);
  const nlohmann::json& comparisons = fields.required("comparisons").raw("comparisons");
  if (!comparisons.is_array()) fields.fail("comparisons", "must be an array");
  for (const nlohmann::json& pair : comparisons) {
    const auto whole = [&](const nlohmann::json& value) {
      return value.is_number_integer() && value >= 0 && value < pictures;
    };
    if (!pair.is_array() || pair.size() != 3 || !std::all_of(pair.begin(), pair.end(), whole)) {
      fields.fail("comparisons", fmt::format("{}: must be three integers in [0, {}]: left, right, preferred",
                                             printable(pair.dump()), pictures - 1));
    }
    scene.comparisons.push_back(pair.get<std::vector<int>>());
  }
  require_sequence(fields, scene, study.methods.size());
  fields.done();
  return scene;
}

}  // namespace

Votes read_votes(const std::string& path, const Study& study) {
  const nlohmann::json json = read_json_file(path);
  Fields fields(json, path);
  Votes votes;
  std::string format, id;
  int version = 0;
  fields.required("format").choice("format", format, {"dualpixel votes"});
  fields.required("version").integer("version", version, 1, 1);
  fields.required("study").text("study", id);
  if (id != study.id) {
    fields.fail("study", fmt::format("\"{}\": must be \"{}\", the study's own", printable(id), printable(study.id)));
  }
  fields.required("participant").text("participant", votes.participant);
  if (votes.participant.empty()) fields.fail("participant", "must be a name");
  std::set<int> scenes;
  for (Fields& scene : fields.required("scenes").objects("scenes")) {
    votes.scenes.push_back(read_scene(scene, study));
    if (!scenes.insert(votes.scenes.back().scene).second) {
      scene.fail("scene", fmt::format("{}: is there twice", votes.scenes.back().scene));
    }
  }
  if (votes.scenes.size() != study.scenes.size()) {
    fields.fail("scenes", fmt::format("{}: must be {}, all of the study's", votes.scenes.size(), study.scenes.size()));
  }
  fields.done();
  return votes;
}

VoteTable count_votes(const Study& study, const std::vector<Votes>& votes) {
  VoteTable table;
  for (const std::string& method : study.methods) table.rows.push_back({method, std::vector<int>(votes.size(), 0)});
  for (std::size_t i = 0; i < votes.size(); ++i) {
    table.participants.push_back(votes[i].participant);
    for (const Votes::Scene& scene : votes[i].scenes) {
      const auto row = [&](int picture) -> VoteTable::Row& {
        return table.rows[study.scenes[scene.scene].method_of_picture[picture]];
      };
      for (const std::vector<int>& pair : scene.comparisons) {
        ++row(pair[0]).shown, ++row(pair[1]).shown, ++row(pair[2]).preferred;
      }
      ++row(scene.comparisons.back()[2]).votes[i];
    }
  }
  for (VoteTable::Row& row : table.rows) {
    const auto n = static_cast<double>(row.votes.size());
    double squares = 0;
    for (const int count : row.votes) row.mean += count / n;
    for (const int count : row.votes) squares += (count - row.mean) * (count - row.mean);
    row.deviation = n > 1 ? std::sqrt(squares / (n - 1)) : 0;
  }
  return table;
}

nlohmann::ordered_json to_json(const VoteTable& table) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const VoteTable::Row& row : table.rows) {
    rows.push_back({{"method", row.method},
                    {"votes", row.votes},
                    {"mean", row.mean},
                    {"deviation", row.deviation},
                    {"comparisons", row.shown},
                    {"preferred", row.preferred}});
  }
  return {{"participants", table.participants}, {"methods", rows}};
}

std::string to_text(const VoteTable& table) {
  std::vector<VoteTable::Row> rows = table.rows;
  std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.mean < b.mean; });
  std::string text = fmt::format("{:<24}", "scenes won");
  for (const std::string& participant : table.participants) text += fmt::format("{:>8}", printable(participant, 7));
  text += fmt::format("{:>8}{:>8}{:>12}\n", "mean", "std.", "preferred");
  for (const VoteTable::Row& row : rows) {
    text += fmt::format("{:<24}", printable(row.method, 23));
    for (const int count : row.votes) text += fmt::format("{:>8}", count);
    const std::string share = row.shown > 0 ? fmt::format("{:.0f} %", 100.0 * row.preferred / row.shown) : "-";
    text += fmt::format("{:>8.1f}{:>8.1f}{:>12}\n", row.mean, row.deviation, share);
  }
  return text;
}

}  // namespace dualpixel::evaluation
