#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "evaluation/experiments/defocus_experiment.h"
#include "evaluation/metrics/image_metrics.h"
#include "evaluation/report/report_assets.h"
#include "evaluation/report/report_images.h"
#include "evaluation/report/report_page.h"
#include "evaluation/report/svg_plot.h"
#include "simulator/simulate.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct ExperimentDefocusOptions {
  std::string folder;
  std::vector<std::string> scenes = {"build/release/scenes/portrait.json", "build/release/scenes/slanted_planes.json",
                                     "build/release/scenes/occlusion_edges.json"};
};

constexpr float kHaloRadii[] = {3, 6, 10, 15, 20, 30};

/// A quarter of a full sensor's photosites, and a photograph whose rendering noise lies well below what is measured.
Capture render(const std::string& scene_file) {
  nlohmann::json document = read_json_file(scene_file);
  for (const char* assignment :
       {"sensor.width_px=1344", "sensor.height_px=1008", "sensor.pixel_pitch_um=2.8", "render.samples_per_pixel=64",
        "render.photograph_samples_per_pixel=256", "render.all_in_focus_samples_per_pixel=64"}) {
    apply_override(document, assignment);
  }
  const simulator::Simulation s = simulator::read_simulation(document, scene_file);
  return simulator::simulate(s, simulator::load_scene(s));
}

nlohmann::ordered_json to_json(const evaluation::Closeness& closeness) {
  return {{"psnr_db", closeness.all_db},
          {"psnr_edges_db", closeness.edges_db},
          {"psnr_elsewhere_db", closeness.elsewhere_db}};
}

nlohmann::ordered_json to_json(const evaluation::SceneDefocus& scene) {
  nlohmann::ordered_json json = {{"scene", scene.name},
                                 {"not_blurred", to_json(scene.untouched)},
                                 {"highlights_recovered", to_json(scene.recovered.closeness)}};
  double before = 0;
  for (const evaluation::Rung& rung : scene.rungs) {
    json["rungs"][rung.name] = to_json(rung.closeness);
    if (before > 0) json["rungs"][rung.name]["loss_db"] = before - rung.closeness.all_db;
    before = rung.closeness.all_db;
  }
  for (const evaluation::Preference& p : scene.preferred) {
    json["preference"].push_back(
        {{"method", p.name}, {"psnr_rim_db", p.rim_db}, {"psnr_subject_db", p.subject_db}, {"psnr_db", p.all_db}});
  }
  return json;
}

/// The rungs as steps down: a level line for each, as far as the next one's loss.
std::string waterfall(const evaluation::SceneDefocus& scene) {
  evaluation::Plot plot;
  plot.title = "Waterfall: " + printable(scene.name);
  plot.x_label = "rung of the table below";
  plot.y_label = "PSNR against the photograph, dB";
  plot.series = {{"everywhere", {}, false, false}, {"near depth edges", {}, true, false}};
  for (std::size_t i = 0; i < scene.rungs.size(); ++i) {
    const evaluation::Closeness& closeness = scene.rungs[i].closeness;
    for (const double x : {i + 0.5, i + 1.5}) {
      plot.series[0].points.emplace_back(x, closeness.all_db);
      plot.series[1].points.emplace_back(x, closeness.edges_db);
    }
  }
  return evaluation::svg_plot(plot);
}

std::string row(const std::string& name, const evaluation::Closeness& c, const std::string& loss) {
  return fmt::format("<tr><td>{}</td><td>{:.2f}</td><td>{}</td><td>{:.2f}</td><td>{:.2f}</td></tr>", name, c.all_db,
                     loss, c.edges_db, c.elsewhere_db);
}

std::string figure(const Image& linear, const std::string& caption) {
  return fmt::format("<figure><img src=\"{}\" alt=\"\"><figcaption>{}</figcaption></figure>",
                     evaluation::jpeg_data_uri(evaluation::displayed(evaluation::clipped(linear)), 85),
                     evaluation::escape_html(caption));
}

std::string scene_html(const evaluation::SceneDefocus& scene) {
  std::string html = "<h2>" + evaluation::escape_html(printable(scene.name)) + "</h2><div class=\"plots\">" +
                     waterfall(scene) +
                     "</div><div class=\"scroll\"><table><tr><th>adding the error of</th><th>dB</th><th>loss</th>"
                     "<th>near depth edges</th><th>elsewhere</th></tr>";
  double before = 0;
  int number = 1;
  for (const evaluation::Rung& rung : scene.rungs) {
    const double now = rung.closeness.all_db;
    html += row(fmt::format("{} {}", number++, rung.name), rung.closeness,
                before > 0 ? fmt::format("{:.2f}", before - now) : "");
    before = now;
  }
  html += row(scene.recovered.name, scene.recovered.closeness, "") + row("not blurred", scene.untouched, "") +
          "</table></div>";
  if (!scene.preferred.empty()) {
    html +=
        "<h3>Preferred at the subject</h3><div class=\"scroll\"><table><tr><th></th><th>at the outline, dB</th>"
        "<th>on the person</th><th>everywhere</th></tr>";
    for (const evaluation::Preference& p : scene.preferred) {
      html += fmt::format("<tr><td>{}</td><td>{:.2f}</td><td>{:.2f}</td><td>{:.2f}</td></tr>",
                          evaluation::escape_html(p.name), p.rim_db, p.subject_db, p.all_db);
    }
    html += "</table></div>";
  }
  const auto small = [](const Image& image) { return evaluation::resized(image, 448, 336); };
  html += "<div class=\"pictures\">" + figure(small(scene.photograph), "the photograph");
  for (const evaluation::Rung& rung : scene.rungs) html += figure(small(rung.picture), rung.name);
  html += figure(small(scene.recovered.picture), scene.recovered.name);
  return html + "</div>";
}

std::string halo_html(const std::vector<std::vector<evaluation::Halo>>& sweep) {
  evaluation::Plot inside, outside;
  inside.title = "Halo on what is in focus";
  outside.title = "Halo beside it";
  inside.y_label = "mean |B - I|";
  outside.y_label = "mean |B - truth|";
  for (evaluation::Plot* plot : {&inside, &outside}) plot->x_label = "radius behind, px";
  std::string pictures;
  for (std::size_t k = 0; k < sweep[0].size(); ++k) {
    inside.series.push_back({sweep[0][k].method, {}});
    outside.series.push_back({sweep[0][k].method, {}});
    for (std::size_t i = 0; i < sweep.size(); ++i) {
      inside.series[k].points.emplace_back(kHaloRadii[i], sweep[i][k].inside);
      outside.series[k].points.emplace_back(kHaloRadii[i], sweep[i][k].outside);
    }
    const evaluation::Halo& halo = sweep[4][k];
    pictures += figure(halo.picture, halo.method + ", radius 20 px") + figure(halo.difference, "|B - I|");
  }
  return "<h2>Halos</h2><p>A disc in focus before a wall with lights, within the wall's blur radius of the disc's rim. "
         "A gather lets the disc's colour into the wall; a single pass lays the wall over the disc.</p><div "
         "class=\"plots\">" +
         evaluation::svg_plot(inside) + evaluation::svg_plot(outside) + "</div><div class=\"pictures\">" + pictures +
         "</div>";
}

constexpr const char* kStyle =
    ".pictures{display:grid;grid-template-columns:repeat(auto-fill,minmax(260px,1fr));gap:12px}"
    ".pictures figure{margin:0}.pictures img{width:100%}";

constexpr const char* kIntroduction = R"html(
<h1>Synthetic defocus against a real photograph</h1>
<p>The simulator took the same scene through a wider pupil, focused at the same distance. The pipeline's picture, blurred
as by that lens, is compared with it: PSNR of pictures clipped and encoded for display. Each rung adds one cause of
error to those before it. Near depth edges: within the true blur radius of a jump of 0.1 DP px. No synthetic noise.</p>
)html";

void run(const ExperimentDefocusOptions& options) {
  NewFolder out(options.folder, "defocus.json");
  Progress bar("defocus");
  nlohmann::ordered_json json = {{"experiment", "defocus"}, {"scenes", nlohmann::ordered_json::array()}};
  std::string scenes_html;
  double done = 0;
  const auto advance = [&] { bar(++done / static_cast<double>(options.scenes.size() + 1)); };
  for (const std::string& file : options.scenes) {
    const evaluation::SceneDefocus scene = evaluation::measure_defocus(render(file), file);
    json["scenes"].push_back(to_json(scene));
    scenes_html += scene_html(scene);
    advance();
  }
  std::vector<std::vector<evaluation::Halo>> sweep;
  for (const float radius_px : kHaloRadii) {
    sweep.push_back(evaluation::measure_halos(radius_px));
    for (const evaluation::Halo& halo : sweep.back()) {
      json["halos"].push_back(
          {{"radius_px", radius_px}, {"method", halo.method}, {"inside", halo.inside}, {"outside", halo.outside}});
    }
  }
  advance();
  write_file(out.path() + "/defocus.json", json.dump(2) + "\n");
  write_file(out.path() + "/defocus.html",
             evaluation::html_page("Synthetic defocus",
                                   std::string(evaluation::kReportStyle) + evaluation::kPlotStyle + kStyle,
                                   kIntroduction + scenes_html + halo_html(sweep)));
  out.commit();
}

}  // namespace

void add_experiment_defocus(CLI::App& experiment) {
  auto options = std::make_shared<ExperimentDefocusOptions>();
  CLI::App* command = experiment.add_subcommand(
      "defocus", "Synthetic defocus against the wide lens's photograph: loss by cause, order of methods, halos");
  command->add_option("scene", options->scenes, "Scene JSON files (default: the shipped ones that have depth)")
      ->type_name("SCENE.json");
  command->add_option("-o,--output", options->folder, "Folder to write defocus.json and defocus.html into")
      ->required()
      ->type_name("DIR");
  add_threads_option(*command);
  command->footer("Example:\n  dualpixel experiment defocus -o out/defocus");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
