#include "evaluation/report/report_page.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "capture/error.h"
#include "evaluation/metrics/scoring.h"
#include "evaluation/report/report_sections.h"
#include "tests/pipeline/portrait/synthetic.h"
#include "tests/temporary_folder.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

using pipeline::synthetic_capture;
using pipeline::synthetic_result;
using pipeline::synthetic_stored;

int count(const std::string& text, const std::string& part) {
  int found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

/// The text between the first `open` and the `close` after it.
std::string between(const std::string& text, const std::string& open, const std::string& close) {
  const std::size_t begin = text.find(open) + open.size();
  return text.substr(begin, text.find(close, begin) - begin);
}

const std::string kHostile = "a</pre><script>alert(1)</script>\n\"'><img src=x onerror=alert(2)>\xff&";

std::vector<evaluation::CaptureSection> hostile_sections() {
  const Capture capture = pipeline::synthetic_capture();
  pipeline::StoredResult stored = pipeline::synthetic_stored(capture);
  stored.result.stages[0].name = kHostile;
  stored.mode = kHostile;
  evaluation::ResultSection result{kHostile, kHostile, kHostile, {}, {}, {}};
  result.score = evaluation::score_result(capture, kHostile, stored, kHostile);
  result.score->notes.push_back(kHostile);
  result.stages = {{kHostile, 1, 2}};
  result.provenance = kHostile;
  evaluation::Viewer viewer{64, 48, {kHostile, kHostile}, {}};
  viewer.layers = {{kHostile, kHostile, kHostile, evaluation::LayerColors::picture},
                   {kHostile, kHostile, kHostile, evaluation::LayerColors::gray}};
  viewer.layers[0].images = {Image(64, 48, 3), Image(64, 48, 3, 0.5f)};
  viewer.layers[1].images = {Image(64, 48)};
  return {{kHostile, kHostile, kHostile, viewer, {result}}};
}

/// Whatever the program does not bring itself: the text of the page without its style and script.
std::string without_own_files(const std::string& page) {
  const std::size_t style = page.find("<style"), body = page.find("</style>");
  return page.substr(0, style) + page.substr(body, page.find("<script nonce") - body);
}

TEST(ReportPage, EscapesEveryName) {
  const std::string page = without_own_files(evaluation::report_page(hostile_sections()));
  EXPECT_EQ(count(page, "<script"), 1);  // the viewer's data, which is no script
  EXPECT_EQ(count(page, "<script type=\"application/json\">"), 1);
  EXPECT_EQ(count(page, "</script>"), 1);
  EXPECT_EQ(count(page, "onerror=alert(2)>"), count(page, "\\u003cimg src=x onerror=alert(2)>"));
  EXPECT_EQ(count(page, "<img "), 2);  // the two pictures that are meant to be there
  EXPECT_EQ(count(page, "<pre>"), count(page, "</pre>"));
  EXPECT_EQ(count(page, "alert(1)&lt;/script&gt;") + count(page, "alert(1)\\u003c/script>"), count(page, "alert(1)"));
}

TEST(ReportPage, ForbidsWhateverItDoesNotBring) {
  const std::string page = evaluation::report_page(hostile_sections());
  const std::string policy = between(page, "Content-Security-Policy\" content=\"", "\"");
  const std::string nonce = between(page, "<script nonce=\"", "\"");
  EXPECT_EQ(nonce.size(), 16u);
  EXPECT_EQ(policy, "default-src 'none'; img-src data:; style-src 'nonce-" + nonce + "'; script-src 'nonce-" + nonce +
                        "'; base-uri 'none'; form-action 'none'");
  EXPECT_EQ(between(page, "<style nonce=\"", "\""), nonce);
  EXPECT_EQ(count(page, "<script nonce"), 1);
  const std::string own = without_own_files(page);
  EXPECT_EQ(own.find("http:"), std::string::npos);
  EXPECT_EQ(own.find("https:"), std::string::npos);
  EXPECT_EQ(count(own, " style="), 0);  // the policy would drop them
  EXPECT_EQ(count(own, "src="), count(own, "src=\"data:image/jpeg;base64,") + count(own, "img src=x onerror"));
}

TEST(ReportPage, ShowsTheFigures) {
  const std::string page = evaluation::report_page(hostile_sections());
  EXPECT_NE(page.find("<td>20.00</td>"), std::string::npos);  // PSNR of a difference of 0.1, linear
  for (const char* region : {"everything", "confident", "depth_edges", "person"}) {
    EXPECT_NE(page.find(std::string("<td>") + region + "</td>"), std::string::npos) << region;
  }
  EXPECT_NE(page.find("AIWE(1)"), std::string::npos);
}

using Names = std::vector<std::string>;

/// Of the layers of the page's only viewer.
Names layer_names(const std::string& page) {
  const auto json = nlohmann::json::parse(between(page, "<script type=\"application/json\">", "</script>"));
  Names names;
  for (const nlohmann::json& layer : json.at("layers")) names.push_back(layer.at("name"));
  return names;
}

/// `dualpixel report ARGUMENTS...`, in this process.
void run_report(std::vector<std::string> arguments) {
  CLI::App program;
  add_report(program);
  arguments.insert(arguments.begin(), "report");
  std::reverse(arguments.begin(), arguments.end());
  program.parse(arguments);
}

TEST(Report, IsWrittenFromFoldersWithHostileNames) {
  const TemporaryFolder folder;
  const Capture capture = pipeline::synthetic_capture();
  const std::string capture_path = folder / "c\n<script>alert(1)",
                    result_path = folder / "r\xff<img src=x onerror=alert(2)>";
  write_capture(capture, capture_path);
  pipeline::write_result(pipeline::synthetic_result(capture), {{"mode", "dp"}, {"capture", capture_path}}, result_path);
  run_report({result_path, "-o", folder / "report.html"});
  const std::string page = read_bytes(folder / "report.html");
  EXPECT_EQ(count(page, "<script nonce"), 1);
  EXPECT_EQ(count(page, "<img src=x"), 0);
  EXPECT_EQ(page.find(folder.path), std::string::npos);  // paths are those from the page
  // The picture, the portrait and the true photograph; the rest are maps.
  EXPECT_EQ(count(page, "<img "), 3);
  EXPECT_EQ(layer_names(page), (Names{"Left view", "Right view", "Picture", "Portrait", "True photograph", "Disparity",
                                      "True disparity", "Error", "Confidence", "Blur radius", "Error after fit"}));
}

TEST(Report, OfRealDataHasNoTruth) {
  const TemporaryFolder folder;
  Capture capture = pipeline::synthetic_capture();
  const pipeline::PortraitResult result = pipeline::synthetic_result(capture);
  capture.truth.reset();
  write_capture(capture, folder / "c");
  pipeline::write_result(result, {{"mode", "dp"}}, folder / "r");
  run_report({folder / "r", "-o", folder / "report.html", "--capture", folder / "c"});
  EXPECT_EQ(layer_names(read_bytes(folder / "report.html")),
            (Names{"Left view", "Right view", "Picture", "Portrait", "Disparity", "Confidence", "Blur radius"}));
}

TEST(Report, ShowsPathsAsThePageSeesThem) {
  EXPECT_EQ(evaluation::path_from_page("/a/out/dp", "/a/out"), "dp");
  EXPECT_EQ(evaluation::path_from_page("/a/out/x/../dp/", "/a/out"), "dp/");
  EXPECT_EQ(evaluation::path_from_page("/a/capture", "/a/out"), "../capture");
  EXPECT_EQ(evaluation::path_from_page("/home/somebody/capture", "/a/out"), "capture");
  EXPECT_EQ(evaluation::path_from_page("/home/somebody/capture/", "/a/out"), "capture");
}

TEST(Report, NamesWhatIsMissing) {
  const TemporaryFolder folder;
  const auto message = [&](const std::vector<std::string>& arguments) {
    return message_of<InputError>([&] { run_report(arguments); });
  };
  EXPECT_EQ(message({folder / "r", "-o", folder / "x.html"}), folder / "r/result.json" + std::string(": no such file"));
  const Capture capture = pipeline::synthetic_capture();
  pipeline::write_result(pipeline::synthetic_result(capture), {{"mode", "dp"}}, folder / "r");
  EXPECT_NE(message({folder / "r", "-o", folder / "x.html"}).find("does not name the capture"), std::string::npos);
  pipeline::write_result(pipeline::synthetic_result(capture), {{"mode", "dp"}, {"capture", folder / "gone"}},
                         folder / "r");
  EXPECT_NE(message({folder / "r", "-o", folder / "x.html"}).find("gone: no such folder"), std::string::npos);
  write_capture(pipeline::synthetic_capture(32, 24), folder / "c");
  EXPECT_NE(message({folder / "r", "-o", folder / "x.html", "--capture", folder / "c"}).find("64 x 48 pixels"),
            std::string::npos);
  EXPECT_EQ(folder.names(), (std::set<std::string>{"c", "r"}));
}

TEST(Report, IsWrittenOverNothingButAPage) {
  const TemporaryFolder folder;
  const Capture capture = pipeline::synthetic_capture();
  write_capture(capture, folder / "c");
  pipeline::write_result(pipeline::synthetic_result(capture), {{"mode", "dp"}, {"capture", folder / "c"}},
                         folder / "r");
  folder.write("notes", "<!DOCTYPE");
  const auto refusal = [&](const std::string& page) {
    return message_of<InputError>([&] { run_report({folder / "r", "-o", page}); });
  };
  const std::string why = " exists and is not a page of this program's: it will not be overwritten";
  EXPECT_EQ(refusal(folder / "notes"), folder / "notes" + ":" + why);
  EXPECT_EQ(refusal(folder / "r/result.json"), folder / "r/result.json" + ":" + why);
  EXPECT_EQ(refusal(""), "the name of an output is empty");
  EXPECT_EQ(read_bytes(folder / "notes"), "<!DOCTYPE");
  folder.write("empty.html", "");
  for (const std::string page : {"new.html", "empty.html", "new.html"}) EXPECT_EQ(refusal(folder / page), "") << page;
}

}  // namespace
}  // namespace dualpixel::tools
