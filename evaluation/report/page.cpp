#include "evaluation/report/page.h"

#include <fmt/format.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <array>
#include <fstream>
#include <string_view>

#include "capture/error.h"
#include "capture/files.h"
#include "evaluation/report/page_files.h"

namespace dualpixel::evaluation {
namespace {

constexpr std::string_view kPageBegin = "<!DOCTYPE html>\n";

}  // namespace

std::string escape_html(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string escape_name(const std::string& name) { return escape_html(printable(name)); }

std::string html_page(const std::string& title, const std::string& body_html, const std::string& style,
                      const std::string& script) {
  // Only the style and the script that carry this nonce are run; whoever chooses a name in the page cannot know it.
  const std::string nonce = fmt::format("{:016x}", XXH64(body_html.data(), body_html.size(), 0));
  return fmt::format(
      "{7}<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
      "style-src 'nonce-{0}'; script-src 'nonce-{0}'; base-uri 'none'; form-action 'none'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{1}</title>\n"
      "<style nonce=\"{0}\">{2}{3}</style>\n</head>\n<body>\n{4}<script "
      "nonce=\"{0}\">{5}{6}</script>\n</body>\n</html>\n",
      nonce, escape_html(title), page_style(), style, body_html, page_script(), script, kPageBegin);
}

void require_page_path(const std::string& path) {
  require_writable(path);
  std::array<char, kPageBegin.size()> begin{};
  std::ifstream file(path, std::ios::binary);
  const bool is_empty = !file.read(begin.data(), begin.size()) && file.gcount() == 0;  // or is not there
  if (!is_empty && std::string_view(begin.data(), begin.size()) != kPageBegin) {
    throw InputError(printable(path) + ": exists and is not a page of this program's: it will not be overwritten");
  }
}

void write_page(const std::string& path, const std::string& html) {
  require_page_path(path);
  replace_file(path, html);
}

std::string html_image(const Picture& picture) {
  return fmt::format("<img src=\"{}\" alt=\"{}\">", picture.data_uri, escape_html(picture.title));
}

std::string html_figure(const Picture& picture) {
  std::string html = "<figure>" + html_image(picture);
  if (!picture.bar_uri.empty()) {
    html += fmt::format("<div class=\"bar soft\"><span>{}</span><img src=\"{}\" alt=\"\"><span>{}</span></div>",
                        escape_html(picture.bar_low), picture.bar_uri, escape_html(picture.bar_high));
  }
  html += "<figcaption>";
  if (!picture.title.empty()) html += "<b>" + escape_html(picture.title) + "</b> ";
  return html + escape_html(picture.caption) + "</figcaption></figure>\n";
}

}  // namespace dualpixel::evaluation
