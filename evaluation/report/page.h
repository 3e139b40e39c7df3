#pragma once
#include <string>

/// One HTML page that loads nothing from the network, and the small parts that all pages share. Parameters named html
/// are HTML; every other text is escaped here.
namespace dualpixel::evaluation {

/// Colors for series, classes c0, c1, ... of page.css.
inline constexpr int kSeriesColors = 6;

/// `text` with the characters that mean something in HTML replaced.
std::string escape_html(const std::string& text);

/// What a name from outside (a path, a scene) may show as: one line of valid UTF-8, escaped.
std::string escape_name(const std::string& name);

/// A whole page with the style and the script that all pages share (evaluation/report/web): plots, tables that sort,
/// viewers. `style` and `script` are added. Both are inlined under a content policy that forbids all others (and style
/// attributes).
std::string html_page(const std::string& title, const std::string& body_html, const std::string& style = "",
                      const std::string& script = "");

/// Throws InputError where a page cannot be written to `path`, or something is there that is not an HTML page: it is
/// not overwritten. To be asked before the work, too.
void require_page_path(const std::string& path);

/// require_page_path, then the whole page in one step.
void write_page(const std::string& path, const std::string& html);

struct Picture {
  std::string title;  ///< in bold; may be empty, as the caption
  std::string caption;
  std::string data_uri;
  std::string bar_uri = {};  ///< color bar from low to high; empty: none
  std::string bar_low = {};  ///< labels of its ends
  std::string bar_high = {};
};

/// A `<figure>`: the picture, its color bar, title and caption.
std::string html_figure(const Picture& picture);

/// `<img>` alone.
std::string html_image(const Picture& picture);

}  // namespace dualpixel::evaluation
