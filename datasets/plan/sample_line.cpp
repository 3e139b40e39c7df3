#include "datasets/plan/sample_line.h"

#include <fmt/format.h>

#include <limits>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "simulator/lens/lens_file.h"

namespace dualpixel::datasets {

using nlohmann::json;

std::string sample_name(int index) { return fmt::format("{:06}", index); }

std::string to_text(const SampleLine& line) {
  nlohmann::ordered_json out = {{"index", line.index}, {"name", line.name}, {"split", name_of(kSplits, line.split)},
                                {"scene", line.scene}, {"seed", line.seed}, {"set", line.set}};
  if (!line.relations.empty()) out["relations"] = line.relations;
  out["layout"] = name_of(kLayouts, line.layout);
  if (!line.keep.empty()) out["keep"] = line.keep;
  return out.dump();
}

SampleLine read_sample_line(const std::string& text, const std::string& where) {
  const json document = parse_json(text, where);
  Fields fields(document, where);
  SampleLine line;
  fields.required("index").integer("index", line.index, 0, kMostSamples - 1);
  fields.required("name").text("name", line.name);
  const std::string folder = sample_name(line.index);  // no other may be written to, or removed
  if (line.name != folder) fields.fail("name", fmt::format("'{}': must be {}", printable(line.name), folder));
  fields.required("seed").integer("seed", line.seed, 0, std::numeric_limits<std::uint64_t>::max());
  read_named(fields.required("split"), "split", line.split, kSplits);
  read_named(fields.required("layout"), "layout", line.layout, kLayouts);
  for (const auto& [key, value] : {std::pair{"scene", &line.scene}, {"set", &line.set}}) {
    *value = fields.required(key).raw(key);
    if (!value->is_object()) fields.fail(key, "must be an object");
  }
  line.relations = fields.has("relations") ? fields.raw("relations") : json::object();
  const json& keep = fields.raw("keep");
  for (const json& name : keep.is_array() ? keep : json::array()) {
    if (!name.is_string() || !find_named(pictures(), name.get<std::string>())) {
      fields.fail("keep", printable(name.dump()) + ": is not a picture of this version");
    }
    line.keep.push_back(name);
  }
  fields.done();
  return line;
}

scenes::SceneOrder order_of(const json& scene) {
  return {scene.at("kind").get<std::string>(), scene.at("seed").get<std::uint64_t>(),
          scenes::assignments_of(scene.value("set", json::object()))};
}

json with_set(json scene, const SampleLine& line) {
  std::vector<std::string> assignments;
  for (const auto& [field, value] : line.set.items()) assignments.push_back(field + "=" + value.dump());
  assignments.push_back(fmt::format("render.seed={}", line.seed));
  simulator::apply_overrides(scene, assignments);
  return scene;
}

}  // namespace dualpixel::datasets
