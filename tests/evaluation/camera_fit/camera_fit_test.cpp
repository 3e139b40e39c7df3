// The fit of a camera to measured figures: it finds a camera that is known, refuses what is none, and the cameras that
// ship are as near to their measurements as docs/fit_camera.md says.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <random>

#include "capture/error.h"
#include "capture/json_fields.h"
#include "evaluation/camera_fit/camera_figures.h"
#include "evaluation/camera_fit/camera_fit.h"
#include "simulator/lens/lens_file.h"
#include "tests/shared_folder.h"

namespace dualpixel::evaluation {
namespace {

using nlohmann::json;

/// A small camera with one grid of each kind, its figures all zero.
json blank() {
  json zeros = json::array();
  for (int row = 0; row < 3; ++row) zeros.push_back(json(4, 0.0));
  const json x = {0.1, 0.4, 0.6, 0.9}, y = {0.2, 0.5, 0.8};
  json document = {{"version", 1},
                   {"name", "small"},
                   {"lens",
                    {{"model", "aberrated"},
                     {"focus_um", 0},
                     {"tangential_focus_um", {0}},
                     {"coma_um", {0}},
                     {"falloff", "cos4"},
                     {"rims", {{{"radius", 1.2}, {"shift", 0.5}}}},
                     {"split", {{"model", "ramp"}, {"k", 1.3}}}}},
                   {"sensor", {{"width_px", 4032}, {"height_px", 3024}}},
                   {"fit",
                    {{{"field", "/focus_um"}, {"low", -50}, {"high", 50}},
                     {{"field", "/tangential_focus_um/0"}, {"low", -100}, {"high", 100}},
                     {{"field", "/coma_um/0"}, {"low", -20}, {"high", 20}},
                     {{"field", "/rims/0/shift"}, {"low", 0}, {"high", 1}},
                     {{"field", "/split/k"}, {"low", 1}, {"high", 3}}}}};
  document["grids"] = {{{"focus_distance_m", 1}, {"x", x}, {"y", y}, {"light", zeros}, {"left_share", zeros}},
                       {{"focus_distance_m", 0.2}, {"depth_m", 0.6}, {"unit_um", 2.8}, {"x", x}, {"y", y}}};
  for (const char* figure : {"disparity_px", "left_sigma_x_px", "right_sigma_x_px", "left_sigma_y_px", "left_skew_x"}) {
    document["grids"][1][figure] = zeros;
  }
  return document;
}

json rows_of(const std::vector<double>& values, std::size_t columns) {
  json rows = json::array();
  for (std::size_t i = 0; i < values.size(); i += columns) {
    rows.push_back(std::vector<double>(values.begin() + static_cast<std::ptrdiff_t>(i),
                                       values.begin() + static_cast<std::ptrdiff_t>(i + columns)));
  }
  return rows;
}

/// A camera that is known, and measurements of it by 16384 rays a place, of which the fit uses the first
/// 4096, with errors of `noise` tolerances.
struct KnownCamera {
  json lens;
  CameraMeasurements measured;
};
KnownCamera known_camera(double noise) {
  json document = blank();
  CameraMeasurements m = read_camera_measurements(document, "small.json");
  json known = m.lens;
  known["focus_um"] = 12;
  known["tangential_focus_um"] = {-40};
  known["coma_um"] = {6};
  known["rims"][0]["shift"] = 0.3;
  known["split"]["k"] = 1.7;
  const PreparedCamera camera = prepare_camera(m, known);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (std::size_t g = 0; g < m.grids.size(); ++g) {
    for (auto& figure : m.grids[g].figures) figure.values.assign(figure.values.size(), 1);
    auto predicted = predict(m, camera, g, 16384);
    for (std::size_t k = 0; k < predicted.size(); ++k) {
      const FigureRow& row = row_of(kFigures, m.grids[g].figures[k].figure);
      double square = 0;
      for (const double value : predicted[k]) square += value * value / static_cast<double>(predicted[k].size());
      for (double& value : predicted[k]) {
        value += noise * normal(random) * row.tolerance * (row.relative ? std::sqrt(square) : 1);
      }
      document["grids"][g][row.name] = rows_of(predicted[k], 4);
    }
  }
  return {known, read_camera_measurements(document, "small.json")};
}

// What the fit's rays err by is under a hundredth of each range.
TEST(SlowCameraFit, FindsACameraThatIsKnown) {
  const auto [known, m] = known_camera(0);
  const CameraFit fit = fit_camera(m);
  EXPECT_LT(fit.after, 1e-2);
  EXPECT_GT(fit.before, 1);
  for (const FittedField& f : m.fit) {
    const json::json_pointer pointer(f.pointer);
    EXPECT_NEAR(fit.lens.at(pointer).get<double>(), known.at(pointer).get<double>(), 0.01 * (f.high - f.low))
        << f.pointer;
  }
  for (const FigureScore& s : score_camera(m, fit.lens)) {
    EXPECT_LT(s.judged.rms, 0.3 * row_of(kFigures, s.figure).tolerance) << row_of(kFigures, s.figure).name;
    EXPECT_EQ(s.fitted.count + s.judged.count, 12);
    EXPECT_EQ(s.fitted.count, row_of(kFigures, s.figure).fitted ? 6 : 0);
  }
}

// Figures that err by a third of their tolerances: five fields are each within four standard errors of what they are
// but for one time in three thousand, and what is left of 36 errors, each 1/9 squared, is their scatter, 1/9 (1 +-
// .24).
TEST(SlowCameraFit, StatesHowWellTheFiguresDetermineIt) {
  const auto [known, m] = known_camera(1.0 / 3);
  const CameraFit fit = fit_camera(m);
  EXPECT_LT(fit.after, (1 + 3 * 0.24) / 9);
  ASSERT_EQ(fit.fields.size(), m.fit.size());
  for (const FittedValue& v : fit.fields) {
    ASSERT_TRUE(v.standard_error) << v.field.pointer;
    EXPECT_LT(*v.standard_error, 0.5 * (v.field.high - v.field.low)) << v.field.pointer;
    EXPECT_NEAR(v.value, known.at(json::json_pointer(v.field.pointer)).get<double>(), 4 * *v.standard_error)
        << v.field.pointer;
  }
  // behind a rim that clips nothing wherever it moves, its shift is free
  CameraMeasurements wide = m;
  wide.lens["rims"][0]["radius"] = 3;
  const std::string text = to_text(fit_camera(wide));
  const std::size_t line = text.find("/rims/0/shift");
  ASSERT_NE(line, std::string::npos) << text;
  const std::string row = text.substr(line, text.find('\n', line) - line);
  EXPECT_TRUE(row.ends_with("not determined")) << text;
}

// The known focus, 12 um, lies beyond what the fit may reach: it ends at the bound, and the figures stay far off.
TEST(SlowCameraFit, SaysWhatEndsAtItsBoundAndWhatErrsByMuch) {
  auto [known, m] = known_camera(0);
  EXPECT_TRUE(warnings_of(score_camera(m, known)).empty());
  for (FittedField& f : m.fit) {
    if (f.pointer == "/focus_um") f.high = 3;
  }
  const CameraFit fit = fit_camera(m);
  const std::string text = to_text(fit);
  const std::size_t line = text.find("/focus_um");
  ASSERT_NE(line, std::string::npos) << text;
  EXPECT_TRUE(text.substr(line, text.find('\n', line) - line).ends_with("at its bound")) << text;
  const std::vector<std::string> warnings = warnings_of(score_camera(m, m.lens));
  ASSERT_FALSE(warnings.empty());
  EXPECT_NE(warnings[0].find("times its tolerance: start from another lens"), std::string::npos) << warnings[0];
}

/// The phone's figures as docs/fit_camera.md fills them in.
json phone_measurements(const std::string& figures) {
  json document = read_json_file(DUALPIXEL_SOURCE_DIR "/tests/data/camera_fit/phone_2019_start.json");
  const json measured = read_json_file(figures);
  const auto cells = [](int count) {
    json places = json::array();
    for (int i = 0; i < count; ++i) places.push_back((i + 0.5) / count);
    return places;
  };
  const json &sheet = measured["white_sheet"], &kernels = measured["kernels"];
  json target = {{"focus_distance_m", 0.137}, {"depth_m", 0.717}, {"unit_um", 2.8}, {"x", cells(8)}, {"y", cells(6)}};
  for (const char* same : {"disparity_px", "left_sigma_x_px", "right_sigma_x_px", "left_sigma_y_px", "right_sigma_y_px",
                           "left_skew_x", "right_skew_x"}) {
    target[same] = kernels[same];
  }
  target["sum_sigma_ratio"] = kernels["sum_sigma_x_px"];
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 8; ++column) {
      json& ratio = target["sum_sigma_ratio"][row][column];
      ratio = ratio.get<double>() / kernels["sum_sigma_y_px"][row][column].get<double>();
    }
  }
  document["grids"] = {{{"focus_distance_m", 0.137},
                        {"x", cells(12)},
                        {"y", cells(9)},
                        {"light", sheet["sum_over_brightest"]},
                        {"left_share", sheet["left_share"]}},
                       target};
  return document;
}

/// Empty where the measurements are not at hand.
std::optional<CameraMeasurements> read_phone_measurements() {
  const std::string figures = (shared_folder() / "data/pixel4/pixel4.json").string();
  if (!std::filesystem::exists(figures)) return std::nullopt;
  return read_camera_measurements(phone_measurements(figures),
                                  DUALPIXEL_SOURCE_DIR "/tests/data/camera_fit/phone_2019_start.json");
}

// The figures of docs/fit_camera.md, where the measurements are at hand, at the places that were not fitted: RMS,
// largest error and the share of places within the tolerance. No tolerance is derived: these are regressions, the
// figures that were measured, rounded up.
TEST(ShippedCamera, IsAsNearToThePhoneAsTheDocumentSays) {
  const std::optional<CameraMeasurements> measured = read_phone_measurements();
  if (!measured) GTEST_SKIP() << "the phone's measurements are not here";
  const CameraMeasurements& m = *measured;
  const json camera = read_json_file(DUALPIXEL_SOURCE_DIR "/scenes/cameras/phone_2019.json");
  struct Stated {
    double rms, most, within;
  };
  const std::map<Figure, Stated> stated = {
      {Figure::light, {.020, .048, .69}},          {Figure::left_share, {.005, .0135, 1}},
      {Figure::disparity, {.020, .0455, .95}},     {Figure::left_sigma_x, {.021, .0465, 1}},
      {Figure::right_sigma_x, {.024, .0625, .95}}, {Figure::left_sigma_y, {.029, .0665, .95}},
      {Figure::right_sigma_y, {.016, .0315, 1}},   {Figure::left_skew_x, {.054, .105, .97}},
      {Figure::right_skew_x, {.085, .165, .74}},   {Figure::sum_sigma_ratio, {.021, .0575, 1}}};
  const std::vector<FigureScore> scores = score_camera(m, camera["lens"]);
  std::printf("%s", to_text(scores).c_str());
  for (const FigureScore& s : scores) {
    const Stated& figure = stated.at(s.figure);
    EXPECT_LT(s.judged.rms, figure.rms) << row_of(kFigures, s.figure).name;
    EXPECT_LT(s.judged.most, figure.most) << row_of(kFigures, s.figure).name;
    EXPECT_GE(s.judged.within, figure.within) << row_of(kFigures, s.figure).name;
  }
  // without coma the skews, to which nothing was fitted, are far off
  json without = camera["lens"];
  without.erase("coma_um");
  for (const FigureScore& s : score_camera(m, without)) {
    if (s.figure == Figure::left_skew_x || s.figure == Figure::right_skew_x) {
      EXPECT_GT(s.judged.rms, 0.2);
    }
  }
}

/// Sum of a lens's coefficients: the polynomial at h = 1.
double at_the_edge(const json& lens, const char* field) {
  double sum = 0;
  for (const json& c : lens.at(field)) sum += c.get<double>();
  return sum;
}

// From all aberrations 0 the fit is as near as the camera that ships, along directions that the measurements leave open
// (docs/fit_camera.md); these they determine. Where it ends there depends on rounding: .2917 to .2971 has been seen.
TEST(SweepCameraFit, FitsThePhoneFromItsStart) {
  const std::optional<CameraMeasurements> measured = read_phone_measurements();
  if (!measured) GTEST_SKIP() << "the phone's measurements are not here";
  const CameraFit fit = fit_camera(*measured);
  const json shipped = read_json_file(DUALPIXEL_SOURCE_DIR "/scenes/cameras/phone_2019.json")["lens"];
  EXPECT_GT(fit.before, 14);
  EXPECT_LT(fit.after, 0.3);
  EXPECT_NEAR(at_the_edge(fit.lens, "coma_um"), at_the_edge(shipped, "coma_um"), 0.8);
  EXPECT_NEAR(at_the_edge(fit.lens, "exit_pupil_growth"), at_the_edge(shipped, "exit_pupil_growth"), 0.01);
  for (const auto& [field, tolerance] :
       {std::pair{"focal_length_px", 0.03}, {"height_px", 0.02}, {"diode_width_px", 0.01}, {"radius_px", 0.01}}) {
    EXPECT_NEAR(fit.lens["split"][field].get<double>(), shipped["split"][field].get<double>(), tolerance) << field;
  }
}

CameraMeasurements full_frame_measurements() {
  const std::string path = DUALPIXEL_SOURCE_DIR "/tests/data/camera_fit/full_frame_measurements.json";
  return read_camera_measurements(read_json_file(path), path);
}

// The figures of docs/fit_camera.md: RMS at the places that were not fitted. A regression, rounded up.
TEST(ShippedCamera, IsAsNearToTheFullFrameCameraAsTheDocumentSays) {
  const CameraMeasurements m = full_frame_measurements();
  json lens = read_json_file(DUALPIXEL_SOURCE_DIR "/lens_models/full_frame_50mm_f4_dual_pixel.json");
  lens["file"] = DUALPIXEL_SOURCE_DIR "/lens_models/" + lens["file"].get<std::string>();
  const std::vector<FigureScore> scores = score_camera(m, lens);
  ASSERT_EQ(scores.size(), 2U);
  EXPECT_LT(scores[0].judged.rms, .146);
  EXPECT_LT(scores[1].judged.rms, .085);
}

// The command that docs/fit_camera.md names, from the file's start: it ends at the split that ships. A regression. What
// the fit leaves, 4.6, changes by a hundredth where diode width and radius change together by a fifth.
TEST(SweepCameraFit, FindsTheShippedFullFrameCamera) {
  const CameraMeasurements m = full_frame_measurements();
  const CameraFit fit = fit_camera(m);
  const json shipped = read_json_file(DUALPIXEL_SOURCE_DIR "/lens_models/full_frame_50mm_f4_dual_pixel.json");
  EXPECT_LT(fit.after, 4.66);
  for (const FittedField& f : m.fit) {
    const json::json_pointer pointer(f.pointer);
    EXPECT_NEAR(fit.lens.at(pointer).get<double>(), shipped.at(pointer).get<double>(), 0.01 * (f.high - f.low))
        << f.pointer;
  }
}

/// Over 6 x 8 places of the field, at the phone's focus and depth.
struct SplitFigures {
  double middle = 0;  ///< alpha: disparity over 4 sigma_y of both kernels, of the four middle places
  double least_alpha = 1, most_alpha = 0;
  double least_share = 1, most_share = 0;  ///< of the light, that the left view has
};

SplitFigures split_figures(const simulator::Lens& lens, const char* name) {
  constexpr int kWidth = 4032, kHeight = 3024;
  const simulator::LensSampler sampler(
      lens, {kWidth, kHeight, 2e-3 * image_radius_mm(lens) / 5040, {kWidth / 2.0, kHeight / 2.0}});
  SplitFigures f;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 8; ++column) {
      const PointFigures p =
          trace_point(sampler, (2 * column + 1) * kWidth / 16, (2 * row + 1) * kHeight / 12, 0.717, 16384);
      const double alpha = (p.right.centroid_m.x - p.left.centroid_m.x) / (4 * p.sum_sigma_m.y);
      const double share = p.left.light / (p.left.light + p.right.light);
      if ((row == 2 || row == 3) && (column == 3 || column == 4)) f.middle += alpha / 4;
      f.least_alpha = std::min(f.least_alpha, alpha), f.most_alpha = std::max(f.most_alpha, alpha);
      f.least_share = std::min(f.least_share, share), f.most_share = std::max(f.most_share, share);
    }
  }
  std::printf("%s: alpha %.3f in the middle, %.3f to %.3f; left share %.3f to %.3f\n", name, f.middle, f.least_alpha,
              f.most_alpha, f.least_share, f.most_share);
  return f;
}

simulator::Lens phone_lens(const std::string& name) {
  return simulator::read_lens_file(DUALPIXEL_SOURCE_DIR "/lens_models/" + name + ".json", 0.137);
}

// Every disparity a tenth larger, as of another camera of the kind: the descent from the file's own lens ends in
// another valley, at some 41 (docs/fit_camera.md), the best of all starts where the same figures fit about as well as
// those that were measured.
TEST(SlowCameraFit, OtherStartsLeaveAFalseMinimum) {
  CameraMeasurements m = full_frame_measurements();
  for (MeasuredGrid& grid : m.grids) {
    for (double& value : grid.figures[0].values) value *= 1.1;
  }
  const CameraFit fit = fit_camera(m);
  EXPECT_GT(fit.after_first, 20);
  EXPECT_LT(fit.after, 6);
  EXPECT_TRUE(warnings_of(score_camera(m, fit.lens)).empty());
}

// Measured on a Pixel 4 (docs/fit_camera.md): disparity over 4 sigma_y of both kernels, which is alpha for a disc, is
// .233 in the middle of the field, .203 to .232 over the rest, and the left view has .50 to .59 of the light. A ramp of
// k = 1.19 gives .21 and .50 everywhere but for vignetting. In the middle the lenses must be as measured, to the 4 %
// that disparity is asked for; over the field they are other lenses: those ranges are regressions, those of
// lens_models/README.md, whose share lies evenly about a half since their microlenses follow each chief ray.
TEST(SlowPhoneLenses, SplitAsThePhoneThatWasMeasured) {
  struct Stated {
    const char* name;
    double least_alpha, most_alpha, uneven;
  };
  for (const Stated& stated :
       {Stated{"phone_6p_4.2mm_f1.8", .215, .266, .046}, {"phone_aberrated_4.4mm_f1.8", .204, .253, .032}}) {
    const SplitFigures f = split_figures(phone_lens(stated.name), stated.name);
    EXPECT_NEAR(f.middle, 0.233, 0.04 * 0.233) << stated.name;
    EXPECT_NEAR(f.least_alpha, stated.least_alpha, 0.001) << stated.name;
    EXPECT_NEAR(f.most_alpha, stated.most_alpha, 0.001) << stated.name;
    EXPECT_NEAR(std::max(f.most_share - 0.5, 0.5 - f.least_share), stated.uneven, 0.001) << stated.name;
  }
}

// Why the seven-element lens keeps the ramp (lens_models/README.md): behind the others' microlens its alpha varies over
// the field twice as much as theirs, and 3.6 times as much as was measured.
TEST(SlowPhoneLenses, TheMicrolensDoesNotSuitTheSevenElements) {
  simulator::Lens lens = phone_lens("phone_7p_4.9mm_f1.85");
  EXPECT_EQ(lens.split.kind, SplitKind::ramp);
  lens.split = phone_lens("phone_6p_4.2mm_f1.8").split;
  const SplitFigures f = split_figures(lens, "phone_7p_4.9mm_f1.85 behind the microlens");
  EXPECT_NEAR(f.least_alpha, 0.19, 0.005);
  EXPECT_NEAR(f.most_alpha, 0.30, 0.005);
}

TEST(CameraFit, WarnsOfDisparityInFocus) {
  json document = blank();
  EXPECT_TRUE(read_camera_measurements(document, "m.json").warnings.empty());
  document["grids"][1]["depth_m"] = document["grids"][1]["focus_distance_m"];
  const std::vector<std::string> warnings = read_camera_measurements(document, "m.json").warnings;
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].rfind("m.json: /grids/1/depth_m: 0.2: is the focus distance", 0), 0U) << warnings[0];
}

std::string refusal(const std::string& pointer, const json& value) {
  json document = blank();
  const json::json_pointer at(pointer);
  if (value.is_discarded()) {
    document.at(at.parent_pointer()).erase(at.back());
  } else {
    document[at] = value;
  }
  try {
    read_camera_measurements(document, "m.json");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(CameraFit, NamesWhatItCannotUse) {
  EXPECT_EQ(refusal("/name", "other"), "");
  const json removed(json::value_t::discarded);
  struct Row {
    const char* pointer;
    json value;
    const char* message;
  };
  for (const Row& row :
       {Row{"/fit", json::array(), "m.json: /fit: must have 1 to 64 fields"},
        Row{"/grids", json::array(), "m.json: /grids: must have 1 to 64 grids"},
        Row{"/grids/1/depth_m", removed, "m.json: /grids/1/depth_m: "},
        Row{"/grids/1/unit_um", removed, "m.json: /grids/1/unit_um: "},
        Row{"/grids/0/light/1", {1, 2, 3}, "m.json: /grids/0/light: each row must have 4 numbers"},
        Row{"/grids/0/light", {1, 2}, "m.json: /grids/0/light: must have 3 rows"},
        Row{"/grids/0/left_share/0/2", 1.5, "m.json: /grids/0/left_share: 1.5: must be null or a number in [0, 1]"},
        Row{"/grids/0/left_share/0/2", "x", "m.json: /grids/0/left_share: \"x\": must be null or a number in [0, 1]"},
        Row{"/grids/0/x/0", 1.5, "m.json: /grids/0/x"},
        Row{"/grids/0/lihgt", 1, "m.json: /grids/0/lihgt: unknown field"},
        Row{"/fit/0/field", "/focus", "m.json: /fit/0/field: /focus: must be the JSON pointer of a number of the lens"},
        Row{"/fit/0/field", "focus_um", "m.json: /fit/0/field: focus_um: must be the JSON pointer"},
        Row{"/fit/0/low", 60, "m.json: /fit/0/high: 50: must be above low, 60"},
        Row{"/fit/0/low", 1, "m.json: /fit/0/field: /focus_um: starts at 0, outside of [1, 50]"},
        Row{"/fit/1/field", "/focus_um", "m.json: /fit/1/field: /focus_um: is named before: must be named once"},
        Row{"/sensor/width_px", 3, "m.json: /sensor/width_px: 3: must be even"},
        Row{"/fit/4/high", 1e7,
            "m.json: /fit/4/high: 10000000: no lens may have it: /lens/split/k: 10000000.0: must be a number in [1, "
            "1e+06]"},
        Row{"/fit/3/low", -1e6, "m.json: /fit/3/low: -1000000: no lens may have it: /lens/rims/0/shift: "},
        Row{"/lens/f_number", -1, "m.json: /lens/f_number: "},
        Row{"/sensor/width_px", -1, "m.json: /sensor/width_px: "},
        Row{"/version", removed, "m.json: /version: "}}) {
    EXPECT_EQ(refusal(row.pointer, row.value).rfind(row.message, 0), 0U) << refusal(row.pointer, row.value);
  }
}

// What only judges, by its kind or its place, tells the fit nothing.
TEST(CameraFit, RefusesGridsWithoutAFigureThatIsFitted) {
  const auto grids_refusal = [](const json& light, const char* figure) {
    const json grid = {{"focus_distance_m", 1}, {"depth_m", 1}, {"x", {0.2, 0.6}}, {"y", {0.5}}, {figure, {light}}};
    return refusal("/grids", json::array({grid}));
  };
  const json null;
  const std::string message = "m.json: /grids: no figure at a place that is fitted: must";
  EXPECT_EQ(grids_refusal({1, null}, "light"), "");
  EXPECT_EQ(grids_refusal({null, 1}, "light").rfind(message, 0), 0U);
  EXPECT_EQ(grids_refusal({null, null}, "light").rfind(message, 0), 0U);
  EXPECT_EQ(grids_refusal({1, 1}, "left_skew_x").rfind(message, 0), 0U);
}

}  // namespace
}  // namespace dualpixel::evaluation
