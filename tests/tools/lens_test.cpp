// `dualpixel lens` as its user meets it.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "capture/files.h"
#include "capture/json_fields.h"
#include "evaluation/report/plot.h"
#include "tests/tools/run_command.h"

namespace dualpixel::tools::testing {
namespace {

const std::string kLens = DUALPIXEL_SOURCE_DIR "/lens_models/double_gauss_100mm_f5.json";

TEST(SlowLensCommand, PrintsJsonWithFirstOrderFiguresAndCalibration) {
  const Outcome run = run_command("lens '" + kLens + "' --focus-distance-m 3 --json");
  ASSERT_EQ(run.status, 0) << run.err;
  const nlohmann::json json = nlohmann::json::parse(run.out);
  EXPECT_NEAR(json["paraxial"]["efl_mm"].get<double>(), 100.003748, 1e-3);
  EXPECT_NEAR(json["focus_distance_m"].get<double>(), 3, 1e-12);
  EXPECT_GT(json["fields"].size(), 10u);
  EXPECT_NEAR(json["fields"][0]["relative_illumination"].get<double>(), 1, 1e-9);
  EXPECT_LT(json["fast_form"][0]["ray_rms_px"].get<double>(), 0.1);
  const nlohmann::json& row = json["calibration"]["horizontal"];
  // disparity grows with depth: the slope in 1/D is below 0; left and right mirror each other
  EXPECT_LT(row[12]["slope_dp_px_m"].get<double>(), 0);
  EXPECT_NEAR(row.front()["left_light"].get<double>(), row.back()["right_light"].get<double>(), 0.01);
}

TEST(SlowLensCommand, WritesAPageThatLoadsNothingAndATwin) {
  const std::string page = ::testing::TempDir() + "/lens.html", twin = ::testing::TempDir() + "/twin.json";
  const Outcome run = run_command("lens '" + kLens + "' -o '" + page + "' --twin '" + twin + "'");
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.out.find("EFL 100.0037"), std::string::npos);
  const std::string html = read_file(page);
  EXPECT_EQ(html.find("http:"), std::string::npos);
  EXPECT_EQ(html.find("https:"), std::string::npos);
  EXPECT_EQ(html.find(" style=\""), std::string::npos) << "the content policy forbids style attributes";
  EXPECT_NE(html.find("Cross-section"), std::string::npos);
  const Outcome again = run_command("lens '" + twin + "' --json");
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out)["model"], "aberrated");
}

TEST(LensCommand, TakesCamerasAndScenes) {
  const auto report = [](const std::string& arguments) {
    const Outcome run = run_command("lens " + arguments + " --json");
    EXPECT_EQ(run.status, 0) << run.err;
    return nlohmann::json::parse(run.out);
  };
  const std::string camera = DUALPIXEL_SCENES_DIR "/cameras/phone_2019.json";
  const nlohmann::json file = read_json_file(camera), of_camera = report(camera);
  EXPECT_EQ(of_camera["name"], file["lens"]["name"]);
  EXPECT_EQ(of_camera["focus_distance_m"], 1);
  EXPECT_EQ(of_camera["sensor"]["width_px"], file["sensor"]["width_px"]);
  EXPECT_NEAR(of_camera["sensor"]["pixel_pitch_um"], file["sensor"]["pixel_pitch_um"].get<double>(), 1e-9);
  EXPECT_EQ(report(camera + " --set lens.f_number=2.5 --sensor-width-px 100")["sensor"]["width_px"], 100);
  // a scene has its own focus, lens and sensor; without them, looking through that camera is the same
  const std::string scene = DUALPIXEL_SCENES_DIR "/portrait.json";
  EXPECT_EQ(report(scene)["focus_distance_m"], 0.79);
  EXPECT_EQ(report(scene +
                   " --focus-distance-m 1 --set lens=null --set sensor=null --set camera.file=cameras/phone_2019.json"),
            of_camera);
  // alpha is the lens's, whatever the sensor's DP pixels are
  const nlohmann::json thin = {{"model", "thin"}, {"focal_length_mm", 4.442}, {"f_number", 1.8}};
  for (const int downsample : {1, 2}) {
    const TemporaryFolder folder;
    const nlohmann::json sensor = {{"dp_downsample_x", downsample}, {"dp_downsample_y", downsample}};
    const std::string camera_file = folder.write(
        "c.json", nlohmann::json{{"version", 1}, {"name", "c"}, {"lens", thin}, {"sensor", sensor}}.dump());
    const nlohmann::json of_file = report("'" + camera_file + "'");
    EXPECT_NEAR(of_file["calibration"]["horizontal"][12]["alpha"].get<double>(), of_file["alpha"].get<double>(), 2e-3);
  }
  const Outcome dark = run_command("lens '" + camera + "' --set lens.f_numbr=2");
  expect_one_line_refusal(dark);
  EXPECT_NE(dark.err.find("phone_2019.json: /lens/f_numbr"), std::string::npos) << dark.err;
}

TEST(LensCommand, RefusesWhatItCannotDo) {
  const auto expect = [](const std::string& arguments, const std::string& says) {
    const Outcome run = run_command("lens " + arguments);
    expect_one_line_refusal(run);
    EXPECT_NE(run.err.find(says), std::string::npos) << run.err;
  };
  expect("none.json", "none.json");
  expect(kLens + " --focus-distance-m -1", "--focus-distance-m");
  expect(kLens + " --focus-distance-m nan", "--focus-distance-m: Value nan not in range");
  expect(kLens + " --pixel-pitch-um NaN", "--pixel-pitch-um: Value NaN not in range 0.1 to 1000");
  expect(kLens + " --focus-distance-m 0.15", "focus distance 0.15 m");
  expect(kLens + " --set f_number=2", "/f_number: 2: the lens opens to f/5");
  expect(kLens + " --set surfaces.3.thicknes_mm=2", "did you mean 'thickness_mm'");
  const std::string thin = DUALPIXEL_SOURCE_DIR "/lens_models/phone_thin_4.4mm_f1.8.json";
  expect(thin + " --twin " + ::testing::TempDir() + "/no.json", "--twin needs a prescription");
  EXPECT_FALSE(std::filesystem::exists(::testing::TempDir() + "/no.json"));
  const TemporaryFolder folder;
  const std::string lens = folder / "lens.json",
                    text = read_bytes(DUALPIXEL_SOURCE_DIR "/lens_models/phone_6p_4.2mm_f1.8.json");
  write_bytes(lens, text);
  expect(lens + " --twin " + lens, "is the lens itself: it will not be overwritten");
  expect(lens + " -o " + lens, "is not a page of this program's");
  EXPECT_EQ(read_bytes(lens), text);
}

TEST(SvgPlot, RoundingIsDrawnAsAFlatLineBetweenTicksThatDiffer) {
  evaluation::Plot plot;
  plot.series = {{"a", {{0, -0.82431}, {1, -0.82432}, {2, -0.82431}}, false, false}};
  const std::string svg = evaluation::svg_plot(plot);
  std::set<std::string> labels;
  const std::regex tick("text-anchor=\"end\">([^<]*)<");
  for (auto i = std::sregex_iterator(svg.begin(), svg.end(), tick); i != std::sregex_iterator(); ++i) {
    EXPECT_TRUE(labels.insert((*i)[1]).second) << "two ticks read " << (*i)[1];
  }
  EXPECT_GE(labels.size(), 3u);
  // the curve stays within a pixel: 242 pixels stand for 0.033
  std::smatch points;
  ASSERT_TRUE(std::regex_search(svg, points, std::regex("points=\"[^,]*,([^ ]*) [^,]*,([^ ]*) ")));
  EXPECT_NEAR(std::stod(points[1]), std::stod(points[2]), 1);
}

TEST(SvgPlot, LogarithmicAxesHaveRoundTicksWithinADecade) {
  evaluation::Plot plot;
  plot.log_x = plot.log_y = true;
  plot.series = {{"", {{0.11, 30}, {0.9, 38}}}};
  const std::string svg = evaluation::svg_plot(plot);
  for (const char* tick : {">0.2<", ">0.5<", ">30<"}) EXPECT_NE(svg.find(tick), std::string::npos) << tick;
  plot.series = {{"", {{0.01, 3}, {20, 2000}}}};
  const std::string decades = evaluation::svg_plot(plot);
  for (const char* tick : {">0.1<", ">1<", ">10<", ">100<"}) EXPECT_NE(decades.find(tick), std::string::npos) << tick;
  EXPECT_EQ(decades.find(">2<"), std::string::npos);
}

TEST(SvgPlot, TicksAreRoundAndPointsLandWhereTheyShould) {
  EXPECT_EQ(evaluation::round_ticks(0, 10, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(evaluation::round_ticks(-0.03, 0.04, 6).size(), 8u);
  EXPECT_EQ(evaluation::round_ticks(3, 3, 6).size(), 1u);
  evaluation::Plot plot;
  plot.title = "<b>";
  plot.series = {{"a", {{0, 0}, {1, 1}, {NAN, 1}, {2, 2}, {3, INFINITY}}, false, false}};
  const std::string svg = evaluation::svg_plot(plot);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_NE(svg.find("&lt;b&gt;"), std::string::npos);
}

}  // namespace
}  // namespace dualpixel::tools::testing
