#include "evaluation/report/bar.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evaluation/report/page.h"

namespace dualpixel::evaluation {
namespace {

constexpr double kWidth = 900, kHeight = 34;

double length_of(double value) { return std::isfinite(value) ? std::max(value, 0.0) : 0; }

}  // namespace

std::string svg_bar(const Bar& bar) {
  double drawn = 0, sum = 0;
  for (const auto& [name, value] : bar.parts) drawn += length_of(value), sum += value;
  std::string svg = fmt::format("<figure class=\"plot\"><svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">",
                                kWidth, kHeight, escape_html(bar.title));
  std::string legend;
  double x = 0;
  for (std::size_t i = 0; i < bar.parts.size(); ++i) {
    const auto& [name, value] = bar.parts[i];
    const double width = drawn > 0 ? kWidth * length_of(value) / drawn : 0;
    const std::string text = fmt::format("{} {:.3g} {} ({:.0f} %)", escape_name(name), value, escape_html(bar.unit),
                                         sum != 0 ? 100 * value / sum : 0);
    svg += fmt::format(
        "<rect class=\"part c{}\" x=\"{:.1f}\" y=\"2\" width=\"{:.1f}\" height=\"{}\"><title>{}</title></rect>",
        i % kSeriesColors, x, std::max(width - 1, 0.0), kHeight - 4, text);
    x += width;
    legend += fmt::format(
        " <span class=\"name\"><svg class=\"legend\" viewBox=\"0 0 22 9\"><line class=\"key c{}\" x1=\"0\" x2=\"22\" "
        "y1=\"5\" y2=\"5\" stroke-width=\"6\"/></svg> {}</span>",
        i % kSeriesColors, text);
  }
  return svg + "</svg><figcaption><b>" + escape_html(bar.title) + fmt::format("</b>, {:.4g} ", sum) +
         escape_html(bar.unit) + ":" + legend + "</figcaption></figure>\n";
}

}  // namespace dualpixel::evaluation
