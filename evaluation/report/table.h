#pragma once
#include <optional>
#include <string>
#include <vector>

/// The one way in which our pages show a table.
namespace dualpixel::evaluation {

/// Plain text. The first column names the rows and is aligned to the left, figures to the right.
struct Table {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;  ///< as many cells as the header has
};

/// HTML that scrolls sideways where the page is too narrow. Cells are made printable and escaped.
std::string html_table(const Table& table);

/// A figure with so many decimals; "–" where there is none, or where it is not finite.
std::string cell_of(const std::optional<double>& value, int decimals);

}  // namespace dualpixel::evaluation
