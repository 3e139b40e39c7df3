#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "scenes/kinds/kinds.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct SceneArguments {
  std::string kind;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> assignments;
  std::string folder;
};

/// The table of a kind's parameters.
std::string options_text(const scenes::SceneKind& kind) {
  std::vector<std::array<std::string, 5>> rows = {{"parameter", "allowed", "default", "unit", "meaning"}};
  for (const scenes::Parameter& p : scenes::parameters_of(kind)) {
    rows.push_back({p.name, allowed_text(p), drawn_text(p), p.unit, p.description});
  }
  std::array<std::size_t, 4> widths{};
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < widths.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  std::string text = fmt::format("{}: {}\n", kind.name, kind.description);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < widths.size(); ++i) text += fmt::format("{:<{}}  ", row[i], widths[i]);
    text += row.back() + "\n";
  }
  return text;
}

nlohmann::ordered_json options_json(const scenes::SceneKind& kind) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const scenes::Parameter& p : scenes::parameters_of(kind)) {
    nlohmann::ordered_json row = {{"name", p.name}, {"unit", p.unit}, {"description", p.description}};
    if (p.type == scenes::Parameter::Type::folder) {
      row["folder"] = true;
    } else if (p.choices.empty()) {
      row["range"] = {p.low, p.high};
      if (scenes::step_of(p) > 0) row["step"] = scenes::step_of(p);
      row["drawn"] = {p.drawn_low, p.drawn_high};
    } else {
      row["choices"] = p.choices;
      if (p.usual != nullptr) row["default"] = p.usual;
    }
    rows.push_back(row);
  }
  return {{"kind", kind.name}, {"description", kind.description}, {"parameters", rows}};
}

void list_options(const std::string& kind, bool json) {
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  std::string text;
  for (const scenes::SceneKind& each : scenes::scene_kinds()) {
    if (!kind.empty() && kind != each.name) continue;
    all.push_back(options_json(each));
    text += (text.empty() ? "" : "\n") + options_text(each);
  }
  std::cout << (json ? all.dump(2) + "\n" : text);
}

/// Calls act(), whose faults are those of `file`.
template <typename Act>
auto naming(const std::string& file, Act act) {
  try {
    return act();
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", printable(file), error.what()));
  }
}

/// A definition, tried at once, before the command line's own settings come after it.
scenes::SceneOrder order_in(const std::string& file) {
  scenes::SceneOrder order = scenes::read_scene_order(file);
  naming(file, [&] { return scenes::scene_file_start(scenes::scene_kind(order.kind), order); });
  return order;
}

/// The order as the command line gives it: a kind, or a file that names one; --seed and --set come after the file's.
scenes::SceneOrder order_of(const SceneArguments& arguments) {
  scenes::SceneOrder order;
  order.kind = arguments.kind;
  if (arguments.kind.ends_with(".json")) order = order_in(arguments.kind);
  if (arguments.seed) order.seed = *arguments.seed;
  order.assignments.insert(order.assignments.end(), arguments.assignments.begin(), arguments.assignments.end());
  return order;
}

void run(const SceneArguments& arguments) {
  const scenes::SceneOrder order = order_of(arguments);
  const scenes::SceneKind& kind = scenes::scene_kind(order.kind);
  if (arguments.folder.empty()) throw InputError("scene: give a folder to write by -o DIR");
  NewFolder out(arguments.folder, "scene.json");
  const auto draw = [&] { return draw_scene(kind, order, out.path()); };
  const bool by_file = arguments.kind.ends_with(".json") && arguments.assignments.empty();
  for (const std::string& fault : by_file ? naming(arguments.kind, draw) : draw())
    std::cerr << fmt::format("dualpixel: warning: scene {}, seed {}: {}\n", kind.name, order.seed, fault);
  out.commit();
}

}  // namespace

void add_scene(CLI::App& program) {
  auto arguments = std::make_shared<SceneArguments>();
  auto list = std::make_shared<bool>(false), json = std::make_shared<bool>(false);
  CLI::App* command = program.add_subcommand("scene", "Draw a scene from a seed: scene.json and scene.glb");
  std::string kinds;
  for (const scenes::SceneKind& kind : scenes::scene_kinds())
    kinds += (kinds.empty() ? "" : ", ") + std::string(kind.name);
  command->add_option("kind", arguments->kind, kinds + "; or a file that names one, as in scenes/gallery/")
      ->type_name("KIND");
  command->add_option("--seed", arguments->seed, "Which scene: the same seed gives the same bytes; 1 by default")
      ->check(any_seed())
      ->type_name("N");
  command
      ->add_option("--set", arguments->assignments,
                   "Set a parameter (--options lists them) or, with a dot, a field of the scene file")
      ->type_name("NAME=VALUE")
      ->take_all()
      ->expected(1)
      ->allow_extra_args(false);
  command->add_option("-o,--output", arguments->folder, "Folder to write")->type_name("DIR");
  command->add_flag("--options", *list, "List the parameters of KIND, or of all kinds, and do nothing else");
  command->add_flag("--json", *json, "List as JSON");
  add_threads_option(*command);
  command->footer(
      "Example:\n  dualpixel scene still_life --seed 7 -o out/still_life\n"
      "  dualpixel scene still_life --seed 7 --set objects=20 --set lens.f_number=2.4 -o out/stopped_down\n"
      "  dualpixel scene --options");
  command->callback([arguments, list, json] {
    if (*list) {
      if (!arguments->kind.empty()) scenes::scene_kind(arguments->kind);
      list_options(arguments->kind, *json);
      return;
    }
    if (arguments->kind.empty()) throw InputError("scene: name a KIND; --options lists them");
    run(*arguments);
  });
}

}  // namespace dualpixel::tools
