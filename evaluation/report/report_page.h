#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

/// The report as one HTML page that needs no network: pictures are data URIs, style and script are inline, and the
/// page's content policy forbids everything else. Whatever text goes in is escaped here.
namespace dualpixel::evaluation {

struct Picture {
  std::string title;
  std::string caption;
  std::string data_uri;
  std::string bar_uri;  ///< colour bar from low to high; empty: none
  std::string bar_low;  ///< what its ends stand for
  std::string bar_high;
};

struct ResultSection {
  std::string name;
  std::string mode;
  std::vector<Picture> photographs;  ///< of one size, laid over each other behind a divider that can be dragged
  std::vector<Picture> maps;
  nlohmann::ordered_json score;  ///< of scoring.h; null where there is no truth
  nlohmann::json stages;         ///< [{name, ms, peak_rss_mb}]
  nlohmann::json provenance;
};

struct CaptureSection {
  std::string name;
  std::string facts;             ///< one line: size, lens, exposure
  std::vector<Picture> flicker;  ///< left and right view
  nlohmann::json provenance;
  std::vector<ResultSection> results;
};

std::string report_page(const std::vector<CaptureSection>& captures);

/// A whole page that loads nothing: `body` is HTML, `style` and `script` are inlined under a content policy that
/// forbids all others (and style attributes).
std::string html_page(const std::string& title, const std::string& style, const std::string& body,
                      const std::string& script = "");

/// `text` with the characters that mean something in HTML replaced.
std::string escape_html(const std::string& text);

}  // namespace dualpixel::evaluation
