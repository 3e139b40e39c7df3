// Any photograph as `portrait`'s input: what is read, what is refused, and what becomes of it.
#include "pipeline/portrait/photograph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/dng.h"
#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/image_io.h"
#include "capture/image/jpeg.h"
#include "pipeline/portrait/result_io.h"
#include "pipeline/segmentation/network.h"
#include "tests/pipeline/portrait/synthetic.h"
#include "tests/pipeline/segmentation/drawn_face.h"
#include "tests/pipeline/texture.h"
#include "tests/tools/run_command.h"

namespace dualpixel::tools {
namespace {

using pipeline::Photograph;
using pipeline::read_photograph;

/// sRGB values of a smooth colored ramp.
Image ramp(int width, int height) {
  Image srgb(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      srgb.at(x, y, 0) = 0.2f + 0.6f * static_cast<float>(x) / static_cast<float>(width);
      srgb.at(x, y, 1) = 0.5f;
      srgb.at(x, y, 2) = 0.2f + 0.6f * static_cast<float>(y) / static_cast<float>(height);
    }
  }
  return srgb;
}

/// The JPEG with an EXIF segment that says how it is turned.
std::string with_orientation(const std::string& jpeg, int orientation) {
  std::string exif("Exif\0\0MM\0*\0\0\0\10\0\1\1\22\0\3\0\0\0\1\0", 25);
  exif += static_cast<char>(orientation);
  exif += std::string("\0\0\0\0\0\0", 6);
  const std::size_t length = exif.size() + 2;
  return jpeg.substr(0, 2) + "\xff\xe1" + static_cast<char>(length >> 8) + static_cast<char>(length & 255) + exif +
         jpeg.substr(2);
}

TEST(Photograph, IsLinearLightAndUpright) {
  const TemporaryFolder folder;
  write_png8(folder / "a.png", ramp(7, 5));
  const Photograph photograph = read_photograph(folder / "a.png");
  EXPECT_EQ(photograph.capture.camera.width_px, 7);  // no need to be even
  EXPECT_NEAR(photograph.picture.at(3, 2, 1), linear_from_srgb(0.5f), 0.005);
  ASSERT_EQ(photograph.assumed.size(), 2u);
  EXPECT_NE(photograph.assumed[0].find("sRGB"), std::string::npos);

  write_png16(folder / "linear.png", ImageU16(4, 4, 3, 16384));  // declares linear light
  EXPECT_NEAR(read_photograph(folder / "linear.png").picture.at(1, 1, 1), 0.25, 1e-4);
  write_png16(folder / "srgb.png", ImageU16(4, 4, 3, 32768), true);
  EXPECT_NEAR(read_photograph(folder / "srgb.png").picture.at(1, 1, 1), linear_from_srgb(0.5f), 1e-4);

  const std::string file = jpeg(ramp(64, 32), 95);
  for (const int orientation : {0, 1, 6, 9, 255}) {  // EXIF knows 1 to 8
    write_bytes(folder / "turned.jpg", with_orientation(file, orientation));
    const Image turned = read_photograph(folder / "turned.jpg").picture;
    EXPECT_EQ(turned.width, orientation == 6 ? 32 : 64) << orientation;
    if (orientation == 6) {
      EXPECT_GT(turned.at(16, 60, 0), turned.at(16, 4, 0));  // the right side is stored last: it is the bottom
    }
  }
}

TEST(Photograph, GrayIsGivenNoColoredNoise) {
  const TemporaryFolder folder;
  write_png8(folder / "gray.png", Image(32, 32, 1, 0.5f));
  const Photograph gray = read_photograph(folder / "gray.png");
  EXPECT_EQ(gray.picture.channels, 3);
  EXPECT_EQ(gray.capture.exposure.mosaic_noise.shot_dn, 0);
  write_png8(folder / "color.png", ramp(32, 32));
  EXPECT_GT(read_photograph(folder / "color.png").capture.exposure.mosaic_noise.shot_dn, 0);
}

// What LibRaw makes of our own DNG is what its mosaic says.
TEST(Photograph, DngIsDeveloped) {
  const TemporaryFolder folder;
  const Capture capture = pipeline::synthetic_capture(64, 48);
  write_dng(folder / "a.dng", capture.frames[0].mosaic, capture, DngImage::mosaic);
  const Image developed = read_photograph(folder / "a.dng").picture;
  ASSERT_EQ(developed.channels, 3);
  ASSERT_EQ(developed.width, 64);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(developed.at(32, 24, c), (500.0 - 64) / (1023 - 64), 0.01) << c;
  const std::string whole = read_bytes(folder / "a.dng");
  const std::size_t field = whole.find(std::string("\x12\1\3\0\1\0\0\0\1\0", 10));  // orientation, one short: 1
  ASSERT_NE(field, std::string::npos);
  for (const int orientation : {0, 6, 9, 128}) {
    std::string turned = whole;
    turned[field + 8] = static_cast<char>(orientation);
    write_bytes(folder / "turned.dng", turned);
    EXPECT_EQ(read_photograph(folder / "turned.dng").picture.width, orientation == 6 ? 48 : 64) << orientation;
  }
  const std::size_t white = whole.find(std::string("\x1d\xc6", 2));  // the level's tag, and 8 bytes on its value
  ASSERT_NE(white, std::string::npos);
  std::string inverted = whole;
  inverted.replace(white + 8, 4, std::string("\x20\0\0\0", 4));  // black is 64
  write_bytes(folder / "inverted.dng", inverted);
  const Outcome refused = run_command("portrait '" + (folder / "inverted.dng") + "' -o '" + (folder / "out") + "'");
  expect_one_line_refusal(refused);
  EXPECT_NE(refused.err.find("its white level"), std::string::npos) << refused.err;
  for (const std::size_t size : {whole.size() / 2, std::size_t{300}, std::size_t{20}}) {
    write_bytes(folder / "cut.dng", whole.substr(0, size));
    expect_one_line_refusal(run_command("portrait '" + (folder / "cut.dng") + "' -o '" + (folder / "out") + "'"));
  }
  for (const std::size_t lost : {1, 60}) {  // of its colors and levels, which lie at the end
    write_bytes(folder / "cut.dng", whole.substr(0, whole.size() - lost));
    const Outcome cut = run_command("portrait '" + (folder / "cut.dng") + "' -o '" + (folder / "out") + "'");
    expect_one_line_refusal(cut);
    EXPECT_NE(cut.err.find("what its fields point to"), std::string::npos) << cut.err;
  }
}

TEST(SlowPhotograph, UnusableFilesAreOneClearLine) {
  const TemporaryFolder folder;
  const std::string whole = jpeg(ramp(64, 48), 90);
  write_bytes(folder / "cut.jpg", whole.substr(0, whole.size() - 40));
  write_bytes(folder / "head.jpg", whole.substr(0, 100));
  write_bytes(folder / "text.jpg", "hello");
  write_bytes(folder / "empty.jpg", "");
  const Image plane(8, 8, 1, 0.5f);
  write_exr(folder / "a.exr", {{"Y", &plane}}, false);
  std::string wide = whole;  // the frame header's sides, at its fifth byte
  const std::size_t frame = wide.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  wide.replace(frame + 5, 4, "\xff\xff\xff\xff");
  write_bytes(folder / "wide.jpg", wide);
  const std::set<std::string> before = folder.names();
  for (const auto& [name, part] : {std::pair{"cut.jpg", "the file ends before the JPEG does"},
                                   {"head.jpg", "head.jpg: cannot be read"},
                                   {"text.jpg", "is not a picture"},
                                   {"empty.jpg", "is not a picture"},
                                   {"a.exr", "must be a JPEG"},
                                   {"wide.jpg", "wide.jpg: cannot be read"},
                                   {"none.jpg", "none.jpg"}}) {
    const Outcome outcome = run_command("portrait '" + (folder / name) + "' -o '" + (folder / "out") + "'");
    expect_one_line_refusal(outcome);
    EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
    EXPECT_EQ(folder.names(), before);
  }
  write_bytes(folder / "whole.jpg", whole + std::string(100, '\xff'));  // what follows the end is not looked at
  for (const char* needs_views : {"--mode dp", "--mode dp+seg", "--match-lens f/2@50mm-equivalent", "--true-mask",
                                  "--calibration c", "--disparity d.npy"}) {
    const Outcome outcome =
        run_command("portrait '" + (folder / "whole.jpg") + "' -o '" + (folder / "out") + "' " + needs_views);
    expect_one_line_refusal(outcome);
    EXPECT_NE(outcome.err.find("photograph"), std::string::npos) << outcome.err;
  }
}

/// A picture with a drawn face, which the detector finds.
void write_portrait(const std::string& path) {
  Image rgb(320, 240, 3);
  const Image texture = pipeline::Texture(5, 0.02).raster(320, 240, 0.5, 1, 0.5, 1);
  for (std::size_t i = 0; i < rgb.data.size(); ++i) rgb.data[i] = 0.25F * (1 + 0.3F * texture.data[i / 3]);
  pipeline::draw_face(rgb, 150, 110, 90);
  for (float& value : rgb.data) value = srgb_from_linear(value);
  write_bytes(path, jpeg(rgb, 95));
}

TEST(SlowPhotograph, BecomesAPortraitOfItsPeople) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without";
  const TemporaryFolder folder;
  const std::string in = "'" + folder.path.string() + "/";
  write_portrait(folder / "a.jpg");
  const Outcome outcome = run_command("portrait " + in + "a.jpg' -o " + in + "out'");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("a.jpg: assumed: its values are sRGB"), std::string::npos) << outcome.err;
  const pipeline::StoredResult stored = pipeline::read_result(folder / "out");
  const nlohmann::json& said = stored.json["provenance"];
  EXPECT_EQ(said["mode"], "seg");
  EXPECT_EQ(said["requested_mode"], "auto");
  EXPECT_EQ(said["mode_reason"], "no dual-pixel views, people found");
  EXPECT_EQ(said["picture_hash"], file_hash(folder / "a.jpg"));
  EXPECT_EQ(said["assumed"].size(), 2u);
  EXPECT_FALSE(said.contains("matcher"));
  EXPECT_EQ(stored.result.input.width, 320);
  EXPECT_GT(stored.result.mask.at(150, 110), 0.5f);  // the face
  EXPECT_LT(stored.result.blur_radius_px.at(150, 110), 1);

  ASSERT_EQ(run_command("portrait " + in + "a.jpg' --zoom -o " + in + "zoomed'").status, 0);
  const Outcome tapped = run_command("portrait " + in + "a.jpg' --zoom --tap 150,110 -o " + in + "tapped'");
  EXPECT_EQ(tapped.status, 0) << tapped.err;
  const Outcome report = run_command("report " + in + "out' " + in + "zoomed' -o " + in + "page.html'");
  ASSERT_EQ(report.status, 0) << report.err;
  const std::string page = read_bytes(folder / "page.html");
  for (const char* part : {"photograph: 320 × 240 photosites; 1 frame", "photograph: 213 × 160 photosites; 1 frame"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(run_command("info " + in + "out'").status, 0);

  write_capture(pipeline::synthetic_capture(), folder / "capture");
  const Outcome score = run_command("score " + in + "capture' " + in + "out'");
  expect_one_line_refusal(score);
  EXPECT_NE(score.err.find("a.jpg"), std::string::npos) << score.err;

  write_png8(folder / "wall.png", ramp(320, 240));
  const Outcome nobody = run_command("portrait " + in + "wall.png' -o " + in + "none'");
  expect_one_line_refusal(nobody);
  EXPECT_NE(nobody.err.find("wall.png: no face found, and there are no dual-pixel views"), std::string::npos)
      << nobody.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "none"));
  const Outcome missing = run_command("portrait " + in + "no.jpg' -o " + in + "none'");
  EXPECT_EQ(missing.err, "dualpixel: " + (folder / "no.jpg") + ": no such capture folder or picture\n");
  write_png8(folder / "wall.png", ramp(9, 7));  // with a mask there is nothing to be found
  write_png8(folder / "mask.png", Image(9, 7, 1, 1.0f));
  EXPECT_EQ(run_command("portrait " + in + "wall.png' --mask " + in + "mask.png' -o " + in + "small'").status, 0);
}

/// The zoomed result of a capture is scored against the same part of its truth.
TEST(Photograph, AZoomedCaptureIsScoredAndReported) {
  const TemporaryFolder folder;
  const std::string in = "'" + folder.path.string() + "/";
  write_capture(pipeline::synthetic_capture(), folder / "c");
  ASSERT_EQ(run_command("portrait " + in + "c' --mode dp --zoom -o " + in + "r'").status, 0);
  const pipeline::StoredResult stored = pipeline::read_result(folder / "r");
  EXPECT_EQ(stored.json["provenance"]["window_px"], nlohmann::json::parse("[10, 8, 42, 32]"));
  for (const std::string& command : {"score " + in + "c' " + in + "r'", "report " + in + "r' -o " + in + "p.html'"}) {
    const Outcome outcome = run_command(command);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
  }
  nlohmann::json lying = stored.json;
  for (const char* window : {"[11, 8, 42, 32]", "[40, 8, 42, 32]", "[1, 2]", "[0, 0, 0, 0]", "[0.5, 0, 42, 32]", "7"}) {
    lying["provenance"]["window_px"] = nlohmann::json::parse(window);
    write_bytes(folder / "r/result.json", lying.dump());
    const Outcome outcome = run_command("score " + in + "c' " + in + "r'");
    expect_one_line_refusal(outcome);
    EXPECT_NE(outcome.err.find("window_px"), std::string::npos) << outcome.err;
  }
}

}  // namespace
}  // namespace dualpixel::tools
