#include "simulator/jobs_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "simulator/lens/lens_file.h"

namespace dualpixel::simulator {
namespace {

/// Whether `name` is a folder's name on any system, and no other folder's.
bool is_folder_name(const std::string& name) {
  constexpr std::size_t kLongest = 200;
  constexpr const char* kAllowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
  return !name.empty() && name.size() <= kLongest && name[0] != '.' && name[0] != '-' &&
         name.find_first_not_of(kAllowed) == std::string::npos;
}

SimulationJob read_job(const std::string& line, const std::string& where, const nlohmann::json& scene,
                       const std::string& scene_path, const ResolveJob& resolve) {
  const nlohmann::json json = parse_json(line, where);
  Fields fields(json, where);
  SimulationJob job;
  fields.required("name").text("name", job.name);
  if (!is_folder_name(job.name)) {
    fields.fail("name", fmt::format("'{}': must be 1 to 200 letters, digits, '.', '_' or '-', the first no '.' or '-'",
                                    printable(job.name)));
  }
  const nlohmann::json& set = fields.raw("set");
  if (!set.is_null() && !set.is_object()) {
    fields.fail("set", "must be an object such as {\"camera.focus_distance_m\": 0.9}");
  }
  fields.done();
  nlohmann::json changed = scene;
  try {
    std::vector<std::string> assignments;
    for (const auto& [field, value] : set.items()) {
      if (field.find('=') != std::string::npos) fields.fail("set", "'" + printable(field) + "': a field has no '='");
      assignments.push_back(field + "=" + value.dump());
    }
    apply_overrides(changed, assignments);
    if (resolve) changed = resolve(job.name, std::move(changed));
    job.simulation = read_simulation(changed, scene_path);
  } catch (const InputError& error) {
    const std::string what = error.what();
    throw InputError(what.starts_with(printable(where)) ? what : printable(where) + ": " + what);
  }
  return job;
}

}  // namespace

std::vector<SimulationJob> read_jobs(const std::string& path, const nlohmann::json& scene,
                                     const std::string& scene_path, const ResolveJob& resolve) {
  const std::string text = read_file(path);
  std::vector<SimulationJob> jobs;
  std::map<std::string, int> lines;  // of each name
  int number = 0;
  for (std::size_t begin = 0; begin < text.size(); ++begin) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    begin = end;
    ++number;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::string where = fmt::format("{}: line {}", path, number);
    jobs.push_back(read_job(line, where, scene, scene_path, resolve));
    const auto [other, fresh] = lines.emplace(jobs.back().name, number);
    if (fresh) continue;
    throw InputError(fmt::format("{}: /name: '{}': is that of line {}, too: must be the job's own", printable(where),
                                 jobs.back().name, other->second));
  }
  if (jobs.empty()) throw InputError(printable(path) + ": has no line: each must be an object with `name` and `set`");
  return jobs;
}

}  // namespace dualpixel::simulator
