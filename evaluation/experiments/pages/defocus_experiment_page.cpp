#include <fmt/format.h>

#include <utility>

#include "capture/error.h"
#include "evaluation/experiments/defocus_experiment.h"
#include "evaluation/metrics/image_metrics.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "evaluation/report/report_images.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {
namespace {

/// PSNR step by step: a level line for each.
Plot waterfall(const SceneDefocus& scene) {
  Plot plot;
  plot.title = "Loss step by step: " + printable(scene.name);
  plot.x_label = "step of the table below";
  plot.y_label = "PSNR against the photograph, dB";
  plot.series = {{"everywhere", {}, false, false}, {"near depth edges", {}, true, false}};
  for (std::size_t i = 0; i < scene.steps.size(); ++i) {
    const DefocusPsnr& psnr = scene.steps[i].psnr;
    for (const double x : {i + 0.5, i + 1.5}) {
      plot.series[0].points.emplace_back(x, psnr.all_db);
      plot.series[1].points.emplace_back(x, psnr.edges_db);
    }
  }
  return plot;
}

Table step_table(const SceneDefocus& scene) {
  Table table{{"adding the error of", "dB", "loss", "near depth edges", "elsewhere"}, {}};
  const auto add = [&](const std::string& name, const DefocusPsnr& psnr, const std::string& loss) {
    table.rows.push_back(
        {name, cell_of(psnr.all_db, 2), loss, cell_of(psnr.edges_db, 2), cell_of(psnr.elsewhere_db, 2)});
  };
  double before = 0;
  int number = 1;
  for (const AblationStep& step : scene.steps) {
    const double now = step.psnr.all_db;
    add(fmt::format("{} {}", number++, step.name), step.psnr, before > 0 ? cell_of(before - now, 2) : "");
    before = now;
  }
  add(scene.recovered.name, scene.recovered.psnr, "");
  add("not blurred", scene.not_blurred, "");
  return table;
}

std::string figure(const Image& linear, const std::string& caption) {
  return html_figure({"", caption, jpeg_data_uri(displayed(clipped(linear)), 85)});
}

std::string scene_section(const SceneDefocus& scene) {
  std::string html =
      "<h2>" + escape_name(scene.name) + "</h2>" + html_plots({waterfall(scene)}) + html_table(step_table(scene));
  if (!scene.ranked.empty()) {
    Table ranking{{"", "at the outline, dB", "on the person", "everywhere"}, {}};
    for (const RankedMethod& m : scene.ranked) {
      ranking.rows.push_back({m.name, cell_of(m.rim_db, 2), cell_of(m.subject_db, 2), cell_of(m.all_db, 2)});
    }
    html += "<h3>Methods ranked at the subject's outline</h3>" + html_table(ranking);
  }
  const auto small = [](const Image& image) { return resized(image, 448, 336); };
  html += "<div class=\"pictures\">" + figure(small(scene.photograph), "the photograph");
  for (const AblationStep& step : scene.steps) html += figure(small(step.picture), step.name);
  return html + figure(small(scene.recovered.picture), scene.recovered.name) + "</div>";
}

Plot halo_plot(const std::vector<HaloStep>& sweep, const char* title, const char* y_label, double Halo::*figure) {
  Plot plot;
  plot.title = title;
  plot.x_label = "blur radius of the background, px";
  plot.y_label = y_label;
  for (std::size_t k = 0; k < sweep[0].halos.size(); ++k) {
    Series& series = plot.series.emplace_back(Series{sweep[0].halos[k].method, {}});
    for (const HaloStep& step : sweep) series.points.emplace_back(step.radius_px, step.halos[k].*figure);
  }
  return plot;
}

std::string halo_section(const std::vector<HaloStep>& sweep) {
  const HaloStep& shown = sweep[sweep.size() - 2];
  std::string pictures;
  for (const Halo& halo : shown.halos) {
    pictures += figure(halo.picture, fmt::format("{}, radius {:g} px", halo.method, shown.radius_px)) +
                figure(halo.difference, "|blurred - sharp|");
  }
  return "<h2>Halos</h2><p>A disc in focus in front of a wall with lights, within the wall's blur radius of the disc's "
         "rim. A gather lets the disc's color bleed into the wall; a single pass spreads the wall over the disc.</p>" +
         html_plots({halo_plot(sweep, "Halo on the disc in focus", "mean |blurred - sharp|", &Halo::inside),
                     halo_plot(sweep, "Halo beside it", "mean |blurred - truth|", &Halo::outside)}) +
         "<div class=\"pictures\">" + pictures + "</div>";
}

constexpr const char* kDefocusIntroduction = R"html(
<h1>Synthetic defocus against a real photograph</h1>
<p>The simulator took the same scene through a wider pupil, focused at the same distance. The pipeline's picture, blurred
as by that lens, is compared with it: PSNR of pictures clipped and encoded for display. Each step adds one cause of
error to those before it. Near depth edges: within the true blur radius of a jump of 0.1 DP px. No synthetic noise.</p>
)html";

}  // namespace

std::string to_page(const std::vector<SceneDefocus>& scenes, const std::vector<HaloStep>& halos) {
  std::string body = kDefocusIntroduction;
  for (const SceneDefocus& scene : scenes) body += scene_section(scene);
  return html_page("Synthetic defocus", body + halo_section(halos));
}

}  // namespace dualpixel::evaluation
