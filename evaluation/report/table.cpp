#include "evaluation/report/table.h"

#include <fmt/format.h>

#include <cmath>

#include "evaluation/report/page.h"

namespace dualpixel::evaluation {
namespace {

std::string row_html(const std::vector<std::string>& cells, const char* tag) {
  std::string html = "<tr>";
  for (const std::string& cell : cells) html += fmt::format("<{0}>{1}</{0}>", tag, escape_name(cell));
  return html + "</tr>\n";
}

}  // namespace

std::string html_table(const Table& table) {
  std::string html = "<div class=\"scroll\"><table>" + row_html(table.header, "th");
  for (const std::vector<std::string>& row : table.rows) html += row_html(row, "td");
  return html + "</table></div>\n";
}

std::string cell_of(const std::optional<double>& value, int decimals) {
  return value && std::isfinite(*value) ? fmt::format("{:.{}f}", *value, decimals) : "–";
}

}  // namespace dualpixel::evaluation
