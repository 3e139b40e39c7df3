#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "simulator/jobs_file.h"
#include "simulator/ready_scene.h"
#include "tests/run_program.h"
#include "tests/simulator/test_scenes.h"
#include "tests/temporary_folder.h"

namespace dualpixel::simulator {
namespace {

using nlohmann::json;

const json kMinimal = {{"version", 1}, {"gltf", "none.glb"}};

std::vector<SimulationJob> jobs_in(const std::string& text) {
  const TemporaryFolder folder;
  write_bytes(folder / "jobs.jsonl", text);
  return read_jobs(folder / "jobs.jsonl", kMinimal, "scene.json");
}

TEST(Jobs, ReadsALineForEach) {
  const auto jobs = jobs_in(
      "{\"name\": \"near\", \"set\": {\"camera.focus_distance_m\": 0.5, \"lens\": {\"f_number\": 4}}}\n\n"
      "{\"name\": \"as_it_is\"}");
  ASSERT_EQ(jobs.size(), 2u);
  EXPECT_EQ(jobs[0].name, "near");
  EXPECT_EQ(jobs[0].simulation.lens.thin.focus_distance_m, 0.5);
  EXPECT_EQ(jobs[0].simulation.lens.thin.f_number, 4);
  EXPECT_EQ(jobs[1].simulation.lens.thin.focus_distance_m, 1);
}

// A line, a field, a value and what is allowed, for all that can be wrong.
TEST(Jobs, RefusesWithLineAndField) {
  const std::string good = "{\"name\": \"a\"}\n";
  const std::pair<std::string, std::string> wrong[] = {
      {"", "has no line"},
      {"\n \n", "has no line"},
      {"{", "line 1: "},
      {"3", "line 1: "},
      {"{\"set\": {}}", "line 1: /name: "},
      {"{\"name\": \"../a\"}", "line 1: /name: '../a': must be 1 to 200 letters"},
      {"{\"name\": \"\"}", "line 1: /name: '': must be"},
      {"{\"name\": \".\"}", "line 1: /name: '.': must be"},
      {"{\"name\": \"a b\"}", "line 1: /name: 'a b': must be"},
      {good + "{\"name\": \"a\"}", "line 2: /name: 'a': is that of line 1"},
      {good + "{\"name\": \"b\", \"seed\": 1}", "line 2: /seed: unknown field"},
      {good + "{\"name\": \"b\", \"set\": []}", "line 2: /set: must be an object"},
      {good + "{\"name\": \"b\", \"set\": {\"burst.frames\": 0}}", "line 2: scene.json: /burst/frames: 0: must be"},
      {good + "{\"name\": \"b\", \"set\": {\"burst.frame\": 1}}", "line 2: scene.json: /burst/frame: unknown field"},
      {good + "{\"name\": \"b\", \"set\": {\"a=b\": 1}}", "line 2: /set: 'a=b': a field has no '='"},
      {good + "{\"name\": \"b\", \"set\": {\"\": 1}}", "line 2: "},
      {good + "{\"name\": \"b\", \"name\": \"c\"}", "line 2: "}};
  for (const auto& [text, message] : wrong) {
    try {
      jobs_in(text);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("jobs.jsonl"), std::string::npos) << error.what();
    }
  }
}

TEST(Jobs, KnowWhetherTheirSceneIsTheSame) {
  const auto with = [](const char* field, const json& value) {
    json document = kMinimal;
    apply_override(document, std::string(field) + "=" + value.dump());
    return read_simulation(document, "scene.json");
  };
  const Simulation s = read_simulation(kMinimal, "scene.json");
  EXPECT_TRUE(same_scene(s, with("camera.focus_distance_m", 2)));
  EXPECT_TRUE(same_scene(s, with("render.light_spacing_px", 2)));
  EXPECT_FALSE(same_scene(s, with("gltf", "other.glb")));
  EXPECT_FALSE(same_scene(s, with("unlit_white_nits", 200)));
  EXPECT_FALSE(same_scene(s, with("burst.animation", true)));
  EXPECT_FALSE(same_scene(s, with("environment", {{"model", "sky"}, {"zenith_nits", 1}})));
  EXPECT_FALSE(same_scene(with("environment", {{"model", "sky"}, {"zenith_nits", 1}}),
                          with("environment", {{"model", "sky"}, {"zenith_nits", 2}})));
}

TEST(Jobs, KnowTheFieldsOfTheirScene) {
  const std::pair<const char*, json> fields[] = {{"gltf", "other.glb"},
                                                 {"unlit_white_nits", 200},
                                                 {"model_size_m", 2},
                                                 {"burst.animation", true},
                                                 {"burst", {{"animation", true}}},
                                                 {"environment.model", "sky"},
                                                 {"environment", {{"model", "sky"}}},
                                                 {"camera.focus_distance_m", 2},
                                                 {"render.light_spacing_px", 2},
                                                 {"exposure.iso", 200},
                                                 {"lens.f_number", 4},
                                                 {"burst.frames", 2}};
  const Simulation s = read_simulation(kMinimal, "scene.json");
  for (const auto& [field, value] : fields) {
    json document = kMinimal;
    apply_override(document, std::string(field) + "=" + value.dump());
    EXPECT_EQ(is_of_scene(field), !same_scene(s, read_simulation(document, "scene.json"))) << field;
  }
}

// Whatever came before it in the process, a job gives the bytes of a call of its own: other light samples, another
// spacing, a goal, another environment, and back again. capture.json holds the hashes of all files.
TEST(SlowJobs, GiveTheBytesOfSeparateCalls) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_program("scene still_life --seed 3 --set objects=2 -o '" + (folder / "drawn") + "'").status, 0);
  const std::string scene = "'" + (folder / "drawn/scene.json") + "' ";
  const std::string small =
      "--set sensor.width_px=96 --set sensor.height_px=64 --set sensor.pixel_pitch_um=40 --set burst.frames=2 "
      "--set render.samples_per_pixel=4 --set render.photograph_samples_per_pixel=4 "
      "--set render.all_in_focus_samples_per_pixel=4 ";
  const std::vector<std::pair<std::string, json>> jobs = {
      {"plain", json::object()},
      {"light", {{"render.light_samples", 32}, {"camera.focus_distance_m", 1.5}}},
      {"goal", {{"render.error", 0.1}, {"render.light_spacing_px", 0}}},
      {"sky", {{"environment", {{"model", "sky"}, {"zenith_nits", 9000}}}}},
      {"auto", {{"camera.focus_distance_m", "auto"}}},
      {"last", {{"render.seed", 2}, {"render.max_bounces", 1}, {"burst.hand_shake", 1}}}};
  std::string lines;
  for (const auto& [name, set] : jobs) lines += json{{"name", name}, {"set", set}}.dump() + "\n";
  write_bytes(folder / "jobs.jsonl", lines);
  const Outcome all = run_program("simulate " + scene + small + "--jobs '" + (folder / "jobs.jsonl") + "' -o '" +
                                  (folder / "all") + "'");
  ASSERT_EQ(all.status, 0) << all.err;
  for (const auto& [name, set] : jobs) {
    std::string own = small;
    for (const auto& [field, value] : set.items()) own += "--set '" + field + "=" + value.dump() + "' ";
    const std::string separate = folder / ("own_" + name);
    ASSERT_EQ(run_program("simulate " + scene + own + "-o '" + separate + "'").status, 0);
    EXPECT_TRUE(read_bytes(folder / ("all/" + name + "/capture.json")) == read_bytes(separate + "/capture.json"))
        << name;
  }
}

}  // namespace
}  // namespace dualpixel::simulator
