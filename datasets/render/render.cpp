#include "datasets/render/render.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <mutex>
#include <new>
#include <optional>
#include <thread>
#include <utility>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "capture/path_beside.h"
#include "datasets/plan/plan.h"
#include "datasets/render/relations.h"
#include "scenes/drawn/face_box.h"
#include "scenes/framing/scene_document.h"
#include "scenes/kinds/kinds.h"
#include "simulator/scene_file_names.h"
#include "simulator/simulate.h"

namespace dualpixel::datasets {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A scene that is drawn for a data set.
struct DrawnScene {
  scenes::SceneOrder order;
  std::string folder;  ///< in the data set
};

DrawnScene drawn_scene_of(const json& scene) {
  const scenes::SceneOrder order = order_of(scene);
  (void)scenes::scene_kind(order.kind);  // refuses others before a folder of their name is made
  return {order, fmt::format("scenes/{}_{}_{}", order.kind, order.seed, hash_of(scene.dump()).substr(0, 8))};
}

/// Beside the scene: what draw_scene() found wrong with it, a list of lines. Absent where that is nothing.
constexpr const char* kWarningsFile = "warnings.json";

/// What draw_scene() said of the sample's scene, but for an exposure or a place of the camera that the sample does not
/// have.
std::vector<std::string> warnings_of(const SampleLine& line, const std::string& folder) {
  const std::string path = folder + "/" + kWarningsFile;
  std::error_code error;
  if (!fs::exists(path, error)) return {};
  std::vector<std::string> warnings;
  const json kept = read_json_file(path);
  for (const json& text : kept) {
    if (!text.is_string()) throw InputError(printable(path) + ": must be a list of lines");
    warnings.push_back(text.get<std::string>());
  }
  const bool exposed_anew = line.relations.contains("exposure_mean") || line.set.contains("exposure") ||
                            line.set.contains("exposure.time_s") || line.set.contains("exposure.iso");
  const bool placed_anew = line.relations.contains("camera_shell") || line.set.contains("model_size_m") ||
                           line.set.contains("camera.position_m") || line.set.contains("camera.look_at_m");
  std::erase_if(warnings, [&](const std::string& text) {
    return text.starts_with("exposure: ") ? exposed_anew : placed_anew;  // all others are of what the camera sees
  });
  return warnings;
}

/// Draws the scene unless it is there. Two processes that do so at once write the same bytes.
std::string draw_once(const DrawnScene& scene, const std::string& dataset) {
  const std::string folder = dataset + "/" + scene.folder;
  std::string path = folder + "/scene.json";
  std::error_code error;
  if (fs::exists(path, error)) return path;
  NewFolder out(folder, "scene.json");
  const std::vector<std::string> warnings =
      scenes::draw_scene(scenes::scene_kind(scene.order.kind), scene.order, out.path());
  if (!warnings.empty()) write_file(out.path() + "/" + kWarningsFile, json(warnings).dump(2) + "\n");
  try {
    out.commit();
  } catch (const InputError&) {  // another process was first
    if (!fs::exists(path, error)) throw;
  }
  return path;
}

/// In single quotes for a shell.
std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? "'\\''" : std::string(1, c);
  return out + "'";
}

/// What draws the scene again, given in the data set's folder.
std::string command_of(const DrawnScene& scene) {
  std::string command = fmt::format("dualpixel scene {} --seed {}", scene.order.kind, scene.order.seed);
  for (const std::string& assignment : scene.order.assignments) command += " --set " + quoted(assignment);
  return command + " -o " + scene.folder;
}

/// The scene file `text` of a sample, its names of files such that it can lie in the sample's folder, wherever the data
/// set is: files of drawn scenes are the data set's own, others have absolute paths.
std::string beside_sample(const std::string& text, const std::string& path, const std::optional<DrawnScene>& drawn) {
  json scene = json::parse(text);
  const std::string beside = drawn ? "../../" + drawn->folder + "/scene.json" : path;
  simulator::each_file_name(scene, [&](std::string& name) { name = path_beside(beside, name); });
  return scene.dump();
}

/// The drawn scene's face is that of its own lens, sensor and place of the camera: follows those of the sample, or
/// goes.
void follow_face(const SampleLine& line, const json& as_read, const std::string& path, json& scene_file) {
  if (!as_read.contains("face_px") || line.set.contains("face_px")) return;
  const json box =
      scenes::face_box_after(simulator::read_simulation(as_read, path), simulator::read_simulation(scene_file, path));
  if (box.is_null()) {
    scene_file.erase("face_px");
  } else {
    scene_file["face_px"] = box;
  }
}

bool keeps(const SampleLine& line, const char* picture) {
  return std::find(line.keep.begin(), line.keep.end(), picture) != line.keep.end();
}

void require_planned_scene(const SampleLine& line, const std::string& path, const json& scene_file) {
  if (!line.scene.contains("xxh64") || line.scene.at("xxh64") == scene_hash(path, scene_file)) return;
  throw InputError(printable(path) + ": it or its glTF file was changed since the plan was made");
}

/// One write of a short line to a file opened for appending is not mixed with another process's.
void append_failure(const std::string& dataset, const SampleLine& line, const std::string& reason) {
  const nlohmann::ordered_json entry = {
      {"name", line.name}, {"index", line.index}, {"reason", printable(reason, 2000)}};
  const std::string text = entry.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
  const std::string path = dataset + "/" + kFailuresFile;
  const int file = open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
  const bool written = file >= 0 && write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  if (file >= 0) close(file);
  if (!written) throw InputError(printable(path) + ": cannot be written");
}

/// Why the sample could not be rendered; empty where it was.
std::string try_sample(const SampleLine& line, const std::string& dataset,
                       std::unique_ptr<simulator::ReadyScene>& ready) {
  try {
    write_sample(line, render_line(line, dataset, ready), dataset);
    return "";
  } catch (const std::bad_alloc&) {
    ready.reset();
    return "there was not enough memory";
  } catch (const std::exception& error) {
    ready.reset();
    return error.what();
  }
}

/// What the jobs share: the lines that are left, counts, and what they report to.
struct Board {
  const RenderTask& task;
  LineQueue queue;
  RenderCounts counts;
  std::mutex mutex = {};
  std::exception_ptr fault = nullptr;

  std::optional<SampleLine> next(int job) {
    const std::lock_guard lock(mutex);
    if (fault != nullptr || (task.stopped != nullptr && *task.stopped != 0)) return std::nullopt;
    return queue.next(job);
  }

  void add(const SampleLine& line, const std::string& reason) {
    const std::lock_guard lock(mutex);
    if (!reason.empty()) append_failure(task.dataset, line, reason);
    ++(reason.empty() ? counts.rendered : counts.failed);
    if (task.progress) task.progress(counts);
  }
};

void work(Board& board, int job) {
  try {
    std::unique_ptr<simulator::ReadyScene> ready;
    while (const std::optional<SampleLine> line = board.next(job)) {
      board.add(*line, try_sample(*line, board.task.dataset, ready));
    }
  } catch (...) {
    const std::lock_guard lock(board.mutex);
    board.fault = std::current_exception();
  }
}

}  // namespace

RenderedSample render_line(const SampleLine& line, const std::string& dataset,
                           std::unique_ptr<simulator::ReadyScene>& ready) {
  std::optional<DrawnScene> drawn;
  if (line.scene.contains("kind")) drawn = drawn_scene_of(line.scene);
  const std::string path = drawn ? draw_once(*drawn, dataset) : line.scene.at("file").get<std::string>();
  const json as_read = scenes::read_scene_document(path);
  json scene_file = with_set(as_read, line);
  const auto focus = focus_place(line, scene_file);
  stand_in_for_relations(line, scene_file);
  if (simulator::make_ready(simulator::read_simulation(scene_file, path), ready)) {
    require_planned_scene(line, path, as_read);
  }
  resolve_geometry(line, focus, *ready, path, scene_file);
  if (drawn) follow_face(line, as_read, path, scene_file);
  simulator::Simulation simulation = simulator::read_simulation(scene_file, path);
  const simulator::CameraView camera = simulator::place_camera(simulation, ready->scene);
  std::optional<scenes::MissedExposure> missed_exposure;
  if (line.relations.contains("exposure_mean")) {
    missed_exposure =
        resolve_exposure(line.relations.at("exposure_mean"), line.set, simulation, *ready, camera, scene_file);
    simulation = simulator::read_simulation(scene_file, path);
  }
  // each picture has random numbers of its own: what is left out changes nothing in the others
  simulation.with_all_in_focus = keeps(line, "all_in_focus") || line.layout == Layout::dpdd;
  simulation.with_photograph = keeps(line, "photograph");
  Capture capture = simulator::simulate(simulation, ready->world, camera);
  capture.provenance.program = "dualpixel " DUALPIXEL_VERSION;
  capture.provenance.scene_file = fs::path(path).filename().string();
  capture.provenance.gltf_xxh64 = ready->gltf_xxh64;
  capture.provenance.scene = beside_sample(capture.provenance.scene, path, drawn);
  if (drawn) capture.provenance.other["scene_command"] = json(command_of(*drawn)).dump();
  return {std::move(capture), missed_exposure,
          drawn ? warnings_of(line, fs::path(path).parent_path().string()) : std::vector<std::string>()};
}

RenderCounts render_shard(const RenderTask& task) {
  std::vector<SampleLine> lines = lines_of(read_plan(task.dataset), task.shard);
  for (const char* part : {"scenes", kSamplesFolder}) require_no_link(task.dataset + "/" + part);
  require_writable(task.dataset + "/" + kSamplesFolder + "/" + kSampleFile);
  RenderCounts counts{.planned = static_cast<int>(lines.size())};
  counts.there =
      static_cast<int>(std::erase_if(lines, [&](const SampleLine& line) { return is_there(task.dataset, line); }));

  const int jobs = std::clamp(task.jobs, 1, std::max(1, static_cast<int>(lines.size())));
  const int threads = std::max(1, tbb::this_task_arena::max_concurrency() / jobs);
  Board board{task, LineQueue(std::move(lines), jobs), counts};
  std::vector<std::thread> workers;
  for (int job = 0; job < jobs; ++job) {
    workers.emplace_back([&, job] { tbb::task_arena(threads).execute([&] { work(board, job); }); });
  }
  for (std::thread& worker : workers) worker.join();
  if (board.fault) std::rethrow_exception(board.fault);
  return board.counts;
}

}  // namespace dualpixel::datasets
