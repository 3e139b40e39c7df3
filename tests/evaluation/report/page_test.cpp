#include "evaluation/report/page.h"

#include <gtest/gtest.h>

#include <limits>

#include "evaluation/report/plot.h"
#include "evaluation/report/table.h"

namespace dualpixel::evaluation {
namespace {

const std::string kHostile = "<script>\"&'";

TEST(Page, EscapesTextInEveryPart) {
  Plot plot;
  plot.title = plot.x_label = plot.y_label = kHostile;
  plot.series = {{kHostile, {{0, 0}, {1, 1}}}};
  for (const std::string& html :
       {html_table({{kHostile, "figure"}, {{kHostile, "1"}}}), html_plots({plot}),
        html_figure({kHostile, kHostile, "data:,", "data:,", kHostile, kHostile}), html_page(kHostile, "<p>")}) {
    EXPECT_NE(html.find("&lt;script&gt;&quot;&amp;&#39;"), std::string::npos) << html;
    EXPECT_EQ(html.find("<script>\""), std::string::npos) << html;
  }
}

TEST(Page, TablesHaveAHeaderAndShowMissingFigures) {
  EXPECT_EQ(html_table({{"", "ms"}, {{"row", cell_of(1.25, 1)}, {"none", cell_of(std::nullopt, 1)}}}),
            "<div class=\"scroll\"><table><tr><th></th><th>ms</th></tr>\n<tr><td>row</td><td>1.2</td></tr>\n"
            "<tr><td>none</td><td>–</td></tr>\n</table></div>\n");
  EXPECT_EQ(cell_of(std::numeric_limits<double>::quiet_NaN(), 2), "–");
}

}  // namespace
}  // namespace dualpixel::evaluation
