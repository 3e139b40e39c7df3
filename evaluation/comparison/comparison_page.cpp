#include <fmt/format.h>

#include <algorithm>

#include "evaluation/comparison/comparison_table.h"
#include "evaluation/report/page.h"
#include "evaluation/report/report_images.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {
namespace {

constexpr const char* kIntroduction = R"html(
<h1>Methods of synthetic defocus against true photographs</h1>
<p>Drawn scenes, each with the photograph that a lens with a pupil five times as wide takes. Three modes of the pipeline,
and the two methods that Wadhwa et al. 2018 compare with. No method sees truth, but one weight of Barron et al.'s was
chosen on these scenes with truth in view. Crops: the three parts of 128 x 128 px in
which the five pictures differ most, on the person's outline where there is a person. Brackets hold 95 % of the means of
scenes drawn again by chance (bootstrap); leads are those of dp+seg, scene by scene.</p>
)html";

std::string interval_text(const MeanInterval& interval, int decimals) {
  return fmt::format("{} [{}, {}]", cell_of(interval.mean, decimals), cell_of(interval.low, decimals),
                     cell_of(interval.high, decimals));
}

std::string group_section(const ComparedGroup& group) {
  const std::vector<std::string> names = figure_names();
  std::string html = fmt::format("<h2>{}: {} scenes</h2>", escape_html(group.name), group.scenes);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const int decimals = i % 3 == 0 ? 2 : 4;
    Table table{{names[i], "mean", "lead of dp+seg", "wins"}, {}};
    for (const ComparedMethod& method : group.methods) {
      const ComparedFigure& figure = method.figures[i];
      table.rows.push_back({method.method, interval_text(figure.mean, decimals), interval_text(figure.lead, decimals),
                            cell_of(figure.wins, 1)});
    }
    html += html_table(table);
  }
  return html;
}

}  // namespace

std::string scene_section(const ComparedPictures& scene) {
  const SceneComparison& figures = scene.figures;
  std::string html = fmt::format("<h2>{}</h2>", escape_name(figures.scene));
  if (figures.shows_people) {
    html += figures.found_people
                ? fmt::format("<p>IoU of the mask that was found{}: {:.3f}</p>",
                              figures.by_stated_face ? " at the face that the capture states" : "", figures.mask_iou)
                : "<p>No person was found.</p>";
  }
  html += "<div class=\"pictures\">";
  const auto picture = [&](const std::string& title, const std::string& caption, const Image& srgb) {
    const Image small = resized(srgb, std::max(1, srgb.width / 3), std::max(1, srgb.height / 3));
    html += html_figure({title, caption, jpeg_data_uri(small, 85)});
    if (!figures.crops.empty()) html += html_figure({"", "", jpeg_data_uri(cropped(srgb, figures.crops[0]), 92)});
  };
  picture("photograph", "", scene.photograph_srgb);
  for (std::size_t i = 0; i < figures.methods.size(); ++i) {
    const MethodFigures& method = figures.methods[i];
    picture(method.method,
            fmt::format("{:.2f} dB, FLIP {:.4f}; crops {:.2f} dB, {:.4f}", method.whole.psnr_db, method.whole.flip,
                        method.crops.psnr_db, method.crops.flip),
            scene.pictures_srgb[i]);
  }
  return html + "</div>";
}

std::string to_page(const std::vector<ComparedGroup>& groups, const std::string& scene_sections) {
  std::string body = kIntroduction;
  for (const ComparedGroup& group : groups) body += group_section(group);
  return html_page("Methods of synthetic defocus", body + scene_sections);
}

}  // namespace dualpixel::evaluation
