// Mode automatic, captures without views, and the forced zoom.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "capture/error.h"
#include "pipeline/portrait/describe_run.h"
#include "pipeline/portrait/photograph.h"
#include "pipeline/portrait/plain_pair.h"
#include "pipeline/portrait/run_portrait.h"
#include "pipeline/portrait/zoom.h"
#include "tests/pipeline/texture.h"

namespace dualpixel::pipeline {
namespace {

constexpr int kModesWidth = 192, kModesHeight = 144;

/// A textured wall at disparity 1, one frame.
Capture wall_capture(bool with_views = true) {
  Capture capture;
  capture.camera.width_px = kModesWidth;
  capture.camera.height_px = kModesHeight;
  capture.camera.focus_distance_m = 1;
  capture.camera.principal_point_px = {kModesWidth / 2.0, kModesHeight / 2.0};
  capture.exposure.black_level_dn = 64;
  capture.exposure.white_level_dn = 1023;
  capture.exposure.mosaic_noise = capture.exposure.dp_noise = {0.16, 1};
  const Texture wall(2, 0.06);
  const auto digital = [](float texture, double light) {
    return static_cast<std::uint16_t>(std::lround(64 + 959 * light * (1 + 0.25 * texture)));
  };
  const auto recorded = [&](const Image& texture, double light) {
    ImageU16 raw(texture.width, texture.height);
    for (std::size_t i = 0; i < raw.data.size(); ++i) raw.data[i] = digital(texture.data[i], light);
    return raw;
  };
  Frame& frame = capture.frames.emplace_back();
  frame.mosaic = recorded(wall.raster(kModesWidth, kModesHeight, 0.5, 1, 0.5, 1), 0.4);
  if (!with_views) return capture;
  frame.left = recorded(wall.raster(kModesWidth / 2, kModesHeight / 4, 2, 2, 2, 4), 0.2);
  frame.right = recorded(wall.raster(kModesWidth / 2, kModesHeight / 4, 0, 2, 2, 4), 0.2);
  return capture;
}

constexpr Face kModesFace{70, 40, 30, 30};

FoundPeople somebody(const Image& picture, const std::vector<Face>&) {
  Image mask(picture.width, picture.height);
  for (int y = 40; y < 110; ++y) std::fill_n(&mask.at(60, y), 60, 1.0f);
  return {{kModesFace}, std::move(mask), {kModesFace}};
}

FoundPeople nobody(const Image&, const std::vector<Face>&) { return {}; }

PortraitOptions automatic(FoundPeople (*find)(const Image&, const std::vector<Face>&)) {
  PortraitOptions options;
  options.mode = Mode::automatic;
  if (find) options.find_people = find;
  return options;
}

TEST(PortraitModes, ViewsAndPeopleChoose) {
  const Capture capture = wall_capture();
  const auto expect_same_as = [&](const PortraitResult& chosen, Mode mode, auto find) {
    PortraitOptions named = automatic(find);
    named.mode = mode;
    EXPECT_EQ(chosen.mode, mode);
    const PortraitResult asked = run_portrait(capture, named);
    EXPECT_EQ(chosen.portrait.data, asked.portrait.data);
    EXPECT_EQ(asked.mode_reason, "");
    for (const std::string& warning : chosen.warnings) EXPECT_EQ(warning.find("mode dp"), std::string::npos) << warning;
  };
  const PortraitResult both = run_portrait(capture, automatic(somebody));
  EXPECT_EQ(both.mode_reason, "dual-pixel views, people found");
  expect_same_as(both, Mode::dp_seg, somebody);
  const PortraitResult views = run_portrait(capture, automatic(nobody));
  EXPECT_EQ(views.mode_reason, "dual-pixel views, no face found");
  expect_same_as(views, Mode::dp, nobody);
  EXPECT_EQ(run_portrait(capture, automatic(nullptr)).mode_reason, "dual-pixel views, people not looked for");
  Image mask(kModesWidth, kModesHeight, 1, 1.0f);
  const PortraitResult given = run_portrait(capture, automatic(nullptr), mask);
  EXPECT_EQ(given.mode, Mode::dp_seg);
  EXPECT_EQ(given.mode_reason, "dual-pixel views, a person mask is given");

  const auto said = describe_run(capture, automatic(somebody), both);
  EXPECT_EQ(said["mode"], "dp+seg");
  EXPECT_EQ(said["requested_mode"], "auto");
  EXPECT_EQ(said["mode_reason"], both.mode_reason);
}

TEST(PortraitModes, ACaptureWithoutViewsNeedsPeople) {
  const Capture capture = wall_capture(false);
  const PortraitResult result = run_portrait(capture, automatic(somebody));
  EXPECT_EQ(result.mode, Mode::seg);
  EXPECT_EQ(result.mode_reason, "no dual-pixel views, people found");
  EXPECT_TRUE(result.disparity_dp_px.empty());
  // the same picture with views beside it
  PortraitOptions named = automatic(somebody);
  named.mode = Mode::seg;
  EXPECT_EQ(result.portrait.data, run_portrait(wall_capture(), named).portrait.data);

  const auto refusal = [&](const PortraitOptions& options) {
    try {
      run_portrait(capture, options);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  for (const Mode mode : {Mode::automatic, Mode::seg}) {
    PortraitOptions options = automatic(nobody);
    options.mode = mode;
    EXPECT_NE(refusal(options).find("no face found, and there are no dual-pixel views"), std::string::npos);
  }
  for (const Mode mode : {Mode::dp, Mode::dp_seg}) {
    PortraitOptions options = automatic(somebody);
    options.mode = mode;
    EXPECT_NE(refusal(options).find("there are no dual-pixel views; choose seg"), std::string::npos);
  }
  PortraitOptions options = automatic(somebody);
  options.match_pupil_mm = 5;
  EXPECT_EQ(refusal(options), "match_lens: there are no dual-pixel views to use it with; leave it out");
}

// Section 5.1: the median over a well-focused face, also where the mode becomes dp.
TEST(PortraitModes, DetectedFacesSetTheFocusWithoutAMask) {
  const Capture capture = wall_capture();
  PortraitOptions options = automatic([](const Image&, const std::vector<Face>&) {
    return FoundPeople{{}, {}, {{70, 40, 20, 20}}};
  });
  options.face_in_focus_dp_px = 64;  // in a picture as wide as the reference
  const PortraitResult result = run_portrait(capture, options);
  EXPECT_EQ(result.mode, Mode::dp);
  EXPECT_EQ(result.mode_reason, "dual-pixel views, no face is large enough to be the subject's");
  EXPECT_NEAR(result.focus_disparity_dp_px, 1, 0.05);  // the wall's
  EXPECT_EQ(run_portrait(capture, automatic(nobody)).focus_disparity_dp_px, 0);
}

// A window's pixels are the whole picture's, and what is given in the whole picture's pixels arrives in its own.
TEST(PortraitZoom, ShowsTheMiddleOfThePicture) {
  Capture capture = wall_capture();
  capture.camera.relative_light = Image(2, 2);
  capture.camera.relative_light.data = {1, 0.5f, 0.7f, 0.9f};  // known of places of the whole picture
  const Window window = zoom_window(capture.camera, true);
  EXPECT_EQ(window.width, 128);  // 192 / 1.5
  EXPECT_EQ(window.height, 96);
  EXPECT_EQ(window.x, 32);
  EXPECT_EQ(window.y, 24);
  PortraitOptions options = default_options();
  options.zoom = true;
  const PortraitResult part = run_portrait(capture, options);
  const PortraitResult whole = run_portrait(capture);
  ASSERT_TRUE(part.window_px);
  EXPECT_EQ(*part.window_px, (std::array<int, 4>{32, 24, 128, 96}));
  ASSERT_EQ(part.input.width, 128);
  // away from the border, which demosaicking mirrors; merging's tiles lie elsewhere, and round otherwise
  for (int y = 8; y < 88; ++y) {
    for (int x = 8; x < 120; ++x) {
      ASSERT_NEAR(part.input.at(x, y, 1), whole.input.at(x + 32, y + 24, 1), 1e-5) << x << " " << y;
    }
  }
}

TEST(PortraitZoom, ChecksWhatIsGivenBeforeItIsCut) {
  const Capture capture = wall_capture();
  PortraitOptions options;
  options.zoom = true;
  const int width = capture.camera.dp_width(), height = capture.camera.dp_height();
  for (const auto& [w, h] : {std::pair{5, 5}, {4 * width, 4 * height}, {width, height - 1}}) {
    options.disparity = GivenDisparity{Image(w, h), {}, {}};
    EXPECT_THROW(run_portrait(capture, options), InputError) << w << " x " << h;
  }
  options.disparity.reset();
  options.picture = Image(7, 5, 3, 0.5f);
  EXPECT_THROW(run_portrait(capture, options), InputError);
  Camera tiny = capture.camera;
  tiny.width_px = 2, tiny.height_px = 4;
  EXPECT_THROW(zoom_window(tiny, true), InputError);
}

// They come and go in the whole picture's pixels.
TEST(PortraitZoom, MovesFaces) {
  const Capture capture = wall_capture();
  PortraitOptions options;
  options.zoom = true;
  options.faces = {kModesFace};
  options.mode = Mode::seg;
  options.find_people = [](const Image& picture, const std::vector<Face>& seeds) {
    EXPECT_EQ(seeds.at(0).x, 38);
    EXPECT_EQ(seeds.at(0).y, 16);
    return FoundPeople{seeds, Image(picture.width, picture.height, 1, 1.0f), seeds};
  };
  EXPECT_EQ(run_portrait(capture, options).faces.at(0).x, 70);
  options.faces[0].x = 0;
  EXPECT_THROW(run_portrait(capture, options), InputError);
}

// A picture that is the sum of the views is gray, whatever the exposure says of a mosaic's noise.
TEST(PortraitModes, PicturesOfViewsAloneStayGray) {
  Capture capture = wall_capture();
  capture.frames[0].mosaic = {};
  const PortraitResult result = run_portrait(capture, automatic(nobody));
  ASSERT_FALSE(result.portrait.empty());
  for (std::size_t i = 0; i < result.portrait.data.size(); i += 3) {
    ASSERT_EQ(result.portrait.data[i], result.portrait.data[i + 1]);
    ASSERT_EQ(result.portrait.data[i], result.portrait.data[i + 2]);
  }
}

TEST(PortraitZoom, SaysThatItCutsTheCapturesFaceAway) {
  Capture capture = wall_capture();
  capture.face_px = {{1, 1, 12, 12}};
  PortraitOptions options = automatic(nobody);
  options.zoom = true;
  const PortraitResult result = run_portrait(capture, options);
  const std::string warnings = fmt::format("{}", fmt::join(result.warnings, "; "));
  EXPECT_NE(warnings.find("/face_px is cut away by the zoom"), std::string::npos) << warnings;
  EXPECT_FALSE(describe_run(capture, options, result).contains("faces"));
  options.zoom = false;
  EXPECT_EQ(describe_run(capture, options, run_portrait(capture, options))["faces"], "capture");
}

TEST(PortraitZoom, TakesAMaskOfTheWholePicture) {
  const Capture capture = wall_capture();
  PortraitOptions options;
  options.zoom = true;
  Image mask(kModesWidth / 2, kModesHeight / 2);
  for (int y = 12; y < 60; ++y) std::fill_n(&mask.at(16, y), 32, 1.0f);  // the window's left half
  options.mode = Mode::dp_seg;
  const PortraitResult masked = run_portrait(capture, options, mask);
  EXPECT_EQ(masked.mask.at(32, 48), 1);
  EXPECT_EQ(masked.mask.at(96, 48), 0);
}

// A crop is a smaller sensor behind the same lens: a disparity has the same radius in pixels.
TEST(PortraitZoom, BlursAsTheWholePictureIs) {
  PortraitOptions options;
  options.blur_radius.r_max_px = 1000;
  const PortraitResult whole = run_portrait(wall_capture(), options);
  options.zoom = true;
  const PortraitResult part = run_portrait(wall_capture(), options);
  const double ours = part.blur_radius_px.at(64, 48), theirs = whole.blur_radius_px.at(96, 72);
  EXPECT_NEAR(theirs, 24, 1);  // of disparity 1, at any width
  EXPECT_NEAR(ours, theirs, 0.5);
}

TEST(PortraitZoom, TransposedPicturesAreCutUpright) {
  PortraitOptions options;
  options.transposed = options.zoom = true;
  options.mode = Mode::seg;
  const PortraitResult result = run_portrait(wall_capture(), options, Image(kModesHeight, kModesWidth, 1, 1.0f));
  ASSERT_TRUE(result.window_px);
  EXPECT_EQ(*result.window_px, (std::array<int, 4>{24, 32, 96, 128}));
  EXPECT_EQ(result.input.height, 128);
}

// TIFF 6.0, tag 274: the corner of the picture that is stored first, and the way rows run.
TEST(Photograph, IsTurnedUpright) {
  Image upright(3, 2);
  for (int i = 0; i < 6; ++i) upright.data[i] = static_cast<float>(i);
  const std::vector<std::pair<int, std::vector<float>>> stored = {
      {1, {0, 1, 2, 3, 4, 5}}, {2, {2, 1, 0, 5, 4, 3}}, {3, {5, 4, 3, 2, 1, 0}}, {4, {3, 4, 5, 0, 1, 2}},
      {5, {0, 3, 1, 4, 2, 5}}, {6, {2, 5, 1, 4, 0, 3}}, {7, {5, 2, 4, 1, 3, 0}}, {8, {3, 0, 4, 1, 5, 2}}};
  for (const auto& [orientation, pixels] : stored) {
    Image image = orientation < 5 ? Image(3, 2) : Image(2, 3);
    image.data.assign(pixels.begin(), pixels.end());
    const Image turned = turned_upright(image, orientation);
    EXPECT_EQ(turned.width, 3) << orientation;
    EXPECT_EQ(turned.data, upright.data) << orientation;
  }
}

}  // namespace
}  // namespace dualpixel::pipeline
