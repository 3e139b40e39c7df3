#include "evaluation/report/report_page.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "capture/error.h"
#include "evaluation/metrics/scoring.h"
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
  const evaluation::Picture picture{kHostile, kHostile, "data:image/jpeg;base64,AAAA", "data:image/jpeg;base64,AAAA",
                                    kHostile, kHostile};
  const Capture capture = pipeline::synthetic_capture();
  pipeline::StoredResult stored = pipeline::synthetic_stored(capture);
  stored.result.stages[0].name = kHostile;
  stored.mode = kHostile;
  evaluation::ResultSection result{kHostile, kHostile, kHostile, {picture, picture}, {picture}, {}, {}, {}};
  result.score = evaluation::score_result(capture, kHostile, stored, kHostile);
  result.score->notes.push_back(kHostile);
  result.stages = {{kHostile, 1, 2}};
  result.provenance = kHostile;
  return {{kHostile, kHostile, {picture, picture}, kHostile, {result}}};
}

TEST(ReportPage, EscapesEveryName) {
  const std::string page = evaluation::report_page(hostile_sections());
  EXPECT_EQ(count(page, "<script"), 1);
  EXPECT_EQ(count(page, "</script>"), 1);
  EXPECT_EQ(count(page, "onerror=alert(2)>"), 0);
  // Each picture that is meant to be there: two views, two photographs, a map and its color bar.
  EXPECT_EQ(count(page, "<img "), 6);
  EXPECT_EQ(count(page, "<pre>"), count(page, "</pre>"));
  EXPECT_EQ(count(page, "alert(1)&lt;/script&gt;"), count(page, "alert(1)"));
}

TEST(ReportPage, ForbidsWhateverItDoesNotBring) {
  const std::string page = evaluation::report_page(hostile_sections());
  const std::string policy = between(page, "Content-Security-Policy\" content=\"", "\"");
  const std::string nonce = between(page, "<script nonce=\"", "\"");
  EXPECT_EQ(nonce.size(), 16u);
  EXPECT_EQ(policy, "default-src 'none'; img-src data:; style-src 'nonce-" + nonce + "'; script-src 'nonce-" + nonce +
                        "'; base-uri 'none'; form-action 'none'");
  EXPECT_EQ(between(page, "<style nonce=\"", "\""), nonce);
  EXPECT_EQ(page.find("http:"), std::string::npos);
  EXPECT_EQ(page.find("https:"), std::string::npos);
  EXPECT_EQ(count(page, " style="), 0);  // the policy would drop them
  EXPECT_EQ(count(page, "src="), count(page, "src=\"data:image/jpeg;base64,") + count(page, "img src=x onerror"));
}

TEST(ReportPage, ShowsTheFigures) {
  const std::string page = evaluation::report_page(hostile_sections());
  EXPECT_NE(page.find("<td>20.00</td>"), std::string::npos);  // PSNR of a difference of 0.1, linear
  for (const char* region : {"everything", "confident", "depth_edges", "person"}) {
    EXPECT_NE(page.find(std::string("<td>") + region + "</td>"), std::string::npos) << region;
  }
  EXPECT_NE(page.find("AIWE(1)"), std::string::npos);
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
  EXPECT_EQ(count(page, "<script"), 1);
  EXPECT_EQ(count(page, "<img src=x"), 0);
  // Two views, three photographs, estimate, truth, two errors, confidence and blur radius with a bar each.
  EXPECT_EQ(count(page, "<img "), 2 + 3 + 6 * 2);
}

TEST(Report, OfRealDataHasNoTruth) {
  const TemporaryFolder folder;
  Capture capture = pipeline::synthetic_capture();
  const pipeline::PortraitResult result = pipeline::synthetic_result(capture);
  capture.truth.reset();
  write_capture(capture, folder / "c");
  pipeline::write_result(result, {{"mode", "dp"}}, folder / "r");
  run_report({folder / "r", "-o", folder / "report.html", "--capture", folder / "c"});
  const std::string page = read_bytes(folder / "report.html");
  EXPECT_EQ(count(page, "<img "), 2 + 2 + 3 * 2);
  EXPECT_EQ(page.find("true photograph<"), std::string::npos);
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

}  // namespace
}  // namespace dualpixel::tools
