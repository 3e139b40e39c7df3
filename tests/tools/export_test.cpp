#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <regex>

#include "capture/image/image_io.h"
#include "tests/pipeline/portrait/synthetic.h"
#include "tests/temporary_folder.h"
#include "tests/tools/run_command.h"

namespace dualpixel::tools {
namespace {

constexpr int kWidth = 96, kHeight = 128;

/// White-balanced linear RGB of the left half, a gray card, and of the right half.
constexpr double kGray = 0.2;
constexpr double kColor[3] = {0.3, 0.2, 0.1};

int color_at(const std::string& cfa, int x, int y) {
  const char letter = cfa[2 * (y & 1) + (x & 1)];
  return letter == 'R' ? 0 : letter == 'G' ? 1 : 2;
}

Capture card(const std::string& cfa) {
  Capture capture = pipeline::synthetic_capture(kWidth, kHeight);
  capture.camera.cfa = cfa;
  capture.exposure.white_balance = {1.9, 1, 1.6};
  capture.exposure.time_s = 0.01;
  capture.exposure.iso = 100;
  capture.exposure.mosaic_noise = {0.2, 1.5};
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int c = color_at(cfa, x, y);
      const double signal = (x < kWidth / 2 ? kGray : kColor[c]) / capture.exposure.white_balance[c];
      capture.frames[0].mosaic.at(x, y) = static_cast<std::uint16_t>(std::lround(64 + 959 * signal));
    }
  }
  return capture;
}

void export_to(const TemporaryFolder& folder, const Capture& capture, const std::string& format) {
  write_capture(capture, folder / "shot");
  const Outcome outcome =
      run_command("export '" + (folder / "shot") + "' -o '" + (folder / "out") + "' --format " + format);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
}

std::string output_of(const std::string& command) {
  const TemporaryFolder folder;
  if (std::system((command + " >'" + (folder / "out") + "' 2>&1").c_str()) != 0) return "";
  return read_bytes(folder / "out");
}

bool has_libraw() { return std::system("command -v dcraw_emu raw-identify >/dev/null 2>&1") == 0; }

TEST(SlowExport, DngOpensInLibRaw) {
  if (!has_libraw()) GTEST_SKIP() << "dcraw_emu and raw-identify of libraw-bin are not installed";
  for (const std::string cfa : {"RGGB", "BGGR", "GRBG", "GBRG"}) {
    const TemporaryFolder folder;
    export_to(folder, card(cfa), "dng");
    const std::string mosaic = folder / "out/000_mosaic.dng";
    const std::string about = output_of("raw-identify -v '" + mosaic + "'");
    EXPECT_TRUE(std::regex_search(about, std::regex("Full size: +96 x 128\n"))) << about;
    EXPECT_NE(about.find("Filter pattern: " + cfa), std::string::npos) << about;
    EXPECT_NE(about.find("black: 64\n"), std::string::npos) << about;
    EXPECT_NE(about.find("ISO speed: 100\n"), std::string::npos) << about;

    // developed: camera white balance, linear, sRGB primaries, bilinear; the white level is 65535
    output_of("dcraw_emu -4 -T -w -o 1 -q 0 '" + mosaic + "'");
    const Image rgb = read_image(mosaic + ".tiff");
    ASSERT_EQ(rgb.width, kWidth);
    ASSERT_EQ(rgb.height, kHeight);
    double gray[3] = {}, color[3] = {};
    constexpr int kPixels = (kHeight - 16) * (kWidth / 2 - 16);
    for (int y = 8; y < kHeight - 8; ++y) {
      for (int x = 8; x < kWidth / 2 - 8; ++x) {
        for (int c = 0; c < 3; ++c) {
          gray[c] += rgb.at(x, y, c) / kPixels;
          color[c] += rgb.at(x + kWidth / 2, y, c) / kPixels;
        }
      }
    }
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(gray[c] / kGray, 1, 0.02) << cfa << c;
      EXPECT_NEAR(color[c] / kColor[c], 1, 0.02) << cfa << c;
    }
    const std::string view = output_of("raw-identify -v '" + (folder / "out/000_left.dng") + "'");
    EXPECT_TRUE(std::regex_search(view, std::regex("Full size: +48 x 32\n"))) << view;
    EXPECT_TRUE(std::regex_search(view, std::regex("Output size: +48 x 64\n"))) << view;  // its pixels are tall
  }
}

/// The pixels of an .npy file that write_npy wrote.
template <typename T>
std::vector<T> npy(const std::string& path, const std::string& shape) {
  const std::string bytes = read_bytes(path);
  EXPECT_EQ(bytes.substr(0, 8), std::string("\x93NUMPY\1\0", 8));
  const std::size_t header = static_cast<unsigned char>(bytes[8]) + 256u * static_cast<unsigned char>(bytes[9]);
  EXPECT_EQ((10 + header) % 64, 0u);
  EXPECT_EQ(bytes[9 + header], '\n');
  EXPECT_NE(bytes.find("'shape': (" + shape + "), }"), std::string::npos) << bytes.substr(10, header);
  std::vector<T> values((bytes.size() - 10 - header) / sizeof(T));
  std::memcpy(values.data(), bytes.data() + 10 + header, values.size() * sizeof(T));
  return values;
}

TEST(Export, DngHoldsHighBlackLevels) {
  if (!has_libraw()) GTEST_SKIP() << "raw-identify of libraw-bin is not installed";
  Capture capture = card("RGGB");
  capture.exposure.bits = 16;
  capture.exposure.black_level_dn = 4096;
  capture.exposure.white_level_dn = 65535;
  const TemporaryFolder folder;
  export_to(folder, capture, "dng");
  const std::string about = output_of("raw-identify -v '" + (folder / "out/000_mosaic.dng") + "'");
  EXPECT_NE(about.find("black: 4096\n"), std::string::npos) << about;
}

TEST(Export, NumbersSurviveInEveryFormat) {
  const TemporaryFolder folder;
  const Capture capture = card("RGGB");
  const double signal = (capture.frames[0].mosaic.at(60, 9) - 64) / 959.0;
  export_to(folder, capture, "npy");
  EXPECT_NEAR(npy<float>(folder / "out/000_mosaic.npy", "128, 96")[9 * 96 + 60], signal, 1e-6);
  EXPECT_EQ(npy<float>(folder / "out/truth/depth_m.npy", "128, 96").size(), 128u * 96);
  // a capture keeps its pictures as half
  EXPECT_NEAR(npy<float>(folder / "out/truth/photograph.npy", "128, 96, 3")[3 * 7 + 1],
              capture.truth->photograph.at(7, 0, 1), 3e-4);
  export_to(folder, capture, "exr");
  EXPECT_NEAR(read_image(folder / "out/000_mosaic.exr").at(60, 9), signal, 1e-6);
  export_to(folder, capture, "png16");
  EXPECT_NEAR(read_image_u16(folder / "out/000_mosaic.png", 1).at(60, 9), 65535 * signal, 1);
  EXPECT_FALSE(std::filesystem::exists(folder / "out/000_mosaic.exr"));  // replaced as a whole
}

TEST(SlowExport, LayoutsOfTrainingSets) {
  const TemporaryFolder folder;
  Capture capture = card("RGGB");
  export_to(folder, capture, "dpdd");
  const ImageU16 left = read_image_u16(folder / "out/inputL/shot.png", 3);
  ASSERT_EQ(left.width, 48);
  ASSERT_EQ(left.height, 64);  // the Bayer planes' size: pixels are square
  const auto level = static_cast<float>(2 * (300 - 64) / 959.0);
  EXPECT_NEAR(left.at(20, 20, 2), 65535 * srgb_from_linear(level), 1);
  for (const char* kind : {"inputR", "inputC", "target"}) {
    EXPECT_EQ(read_image_u16(folder / ("out/" + std::string(kind) + "/shot.png"), 3).height, 64);
  }

  export_to(folder, capture, "google-dp");
  const ImageU16 turned = read_image_u16(folder / "out/raw_left_pd/shot/result_pd_left_center.png", 1);
  EXPECT_EQ(turned.width, 32);  // turned by a quarter
  EXPECT_EQ(turned.height, 48);
  EXPECT_EQ(turned.at(3, 3), 16 * 300);
  const Image depth = read_image(folder / "out/merged_depth/shot/result_merged_depth_center.png");
  // at 0.5 m: d = (100 - 20 / 0.5) / 99.8; the left half is at the top now
  EXPECT_NEAR(depth.at(30, 10), 60 / 99.8, 0.5 / 255);
  EXPECT_EQ(npy<float>(folder / "out/merged_conf/shot/result_merged_conf_center.npy", "96, 128")[0], 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "out/scaled_images/shot/result_scaled_image_center.jpg"));

  export_to(folder, capture, "rgbd");
  EXPECT_EQ(read_image(folder / "out/rgb/shot.png").width, 96);
  EXPECT_NEAR(read_image(folder / "out/rgb/shot.png").at(20, 20, 0), srgb_from_linear(kGray), 2e-3);
  // the one name that OpenCV takes for no zeros
  EXPECT_EQ(read_exr(folder / "out/depth/shot.exr", {"Y"})[0].at(5, 5), 0.5f);

  // dense views are demosaicked
  capture.camera.dp_downsample_x = capture.camera.dp_downsample_y = 1;
  capture.frames[0].left = capture.frames[0].right = capture.frames[0].mosaic;
  for (ImageU16* view : {&capture.frames[0].left, &capture.frames[0].right}) {
    for (auto& v : view->data) v = static_cast<std::uint16_t>(64 + (v - 64) / 2);
  }
  export_to(folder, capture, "dpdd");
  const Image dense = read_image(folder / "out/inputL/shot.png");
  ASSERT_EQ(dense.width, 96);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(dense.at(80, 30, c), srgb_from_linear(static_cast<float>(kColor[c])), 0.01);
}

TEST(Export, RefusesWhatCannotBeWrittenAndLeavesNothing) {
  const TemporaryFolder folder;
  Capture capture = card("RGGB");
  capture.truth.reset();
  write_capture(capture, folder / "shot");
  for (const std::string format : {"dpdd", "google-dp", "rgbd", "tiff"}) {
    expect_one_line_refusal(
        run_command("export '" + (folder / "shot") + "' -o '" + (folder / "out") + "' --format " + format));
    EXPECT_EQ(folder.names(), std::set<std::string>{"shot"});
  }
  expect_one_line_refusal(run_command("export '" + (folder / "no") + "' -o '" + (folder / "out") + "' --format dng"));
  write_bytes(folder / "mine", "mine");
  expect_one_line_refusal(
      run_command("export '" + (folder / "shot") + "' -o '" + (folder / "mine") + "' --format dng"));
}

}  // namespace
}  // namespace dualpixel::tools
