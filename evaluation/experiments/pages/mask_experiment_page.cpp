#include <fmt/format.h>

#include "capture/error.h"
#include "evaluation/experiments/mask_experiment.h"
#include "evaluation/report/page.h"
#include "evaluation/report/report_images.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {
namespace {

std::string masks_page(const std::string& summary_html, const std::vector<WorstMask>& worst) {
  std::string body = "<h1>Person masks against true ones</h1>" + summary_html +
                     "<h2>The worst</h2><p>After edge-aware filtering. Orange: too much; blue: missing.</p><div "
                     "class=\"pictures\">";
  for (const WorstMask& mask : worst) {
    body += html_figure({printable(mask.name), mask.caption, jpeg_data_uri(mask.errors_srgb)});
  }
  return html_page("Person masks", body + "</div>");
}

}  // namespace

std::string to_page(const PictureMasks& masks) {
  const MaskMeans means = means_of(masks.pictures);
  std::string summary =
      fmt::format("<p>{} pictures, {} without a face. Mean IoU {:.4f}, {:.4f} after edge-aware filtering", means.count,
                  means.count - means.with_face, means.iou, means.filtered_iou);
  if (means.with_face > 0) {
    summary +=
        fmt::format("; {:.4f} and {:.4f} where a face was found. Gradient error there {:.6f}, {:.6f} filtered",
                    means.iou_found, means.filtered_iou_found, means.gradient_error, means.filtered_gradient_error);
  }
  return masks_page(summary + ".</p>", masks.worst);
}

std::string to_page(const PeopleMasks& masks) {
  Table table{{"", "samples", "IoU", "standard error", "filtered", "no face channel", "gradient error", "filtered"},
              {}};
  for (const PeopleRow& row : masks.scores.samples) {
    table.rows.push_back({row.name, std::to_string(row.samples), cell_of(row.iou, 4), cell_of(row.iou_error, 4),
                          cell_of(row.filtered_iou, 4), cell_of(row.iou_without_face, 4),
                          cell_of(row.gradient_error, 6), cell_of(row.filtered_gradient_error, 6)});
  }
  for (const PeopleRow& row : masks.scores.regions) {
    table.rows.push_back({"near " + row.name, std::to_string(row.samples), "", "", "", "",
                          cell_of(row.gradient_error, 6), cell_of(row.filtered_gradient_error, 6)});
  }
  return masks_page(html_table(table), masks.worst);
}

}  // namespace dualpixel::evaluation
