// DNG files against the numbers of the specifications, read here byte by byte: TIFF 6.0 (1992), DNG 1.4 (2012).
#include "capture/dng.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <sstream>
#include <vector>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/dng_picture.h"
#include "capture/image/faults/dng_fault.h"
#include "tests/temporary_folder.h"

namespace dualpixel {
namespace {

enum Tag {
  kWidth = 256,
  kHeight = 257,
  kBits = 258,
  kCompression = 259,
  kPhotometric = 262,
  kStripOffsets = 273,
  kStripBytes = 279,
  kExposureTime = 33434,
  kExif = 34665,
  kIso = 34855,
  kCfaPattern = 33422,
  kBlackLevel = 50714,
  kWhiteLevel = 50717,
  kDefaultScale = 50718,
  kColorMatrix1 = 50721,
  kAsShotNeutral = 50728,
  kNoiseProfile = 51041
};

/// The fields of a little-endian TIFF file's only directory and of the EXIF directory that it names, as numbers.
struct Directory {
  explicit Directory(const std::string& path) : bytes(read_file(path)) {
    EXPECT_EQ(bytes.substr(0, 4), std::string("II*\0", 4));
    read_directory(at<std::uint32_t>(4));
    EXPECT_TRUE(fields[kExposureTime].empty()) << "is EXIF's";
    if (fields.count(kExif)) read_directory(static_cast<std::size_t>(fields[kExif].at(0)));
  }

  void read_directory(std::size_t start) {
    const auto count = at<std::uint16_t>(start);
    for (int i = 0; i < count; ++i) read_field(start + 2 + 12 * i);
    EXPECT_EQ(at<std::uint32_t>(start + 2 + 12 * count), 0u) << "one directory";
  }

  std::vector<double> operator[](int tag) const { return fields.count(tag) ? fields.at(tag) : std::vector<double>(); }

  template <typename T>
  T at(std::size_t offset) const {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
  }

  void read_field(std::size_t entry) {
    static_assert(std::endian::native == std::endian::little);
    const std::map<int, int> sizes = {{1, 1}, {2, 1}, {3, 2}, {4, 4}, {5, 8}, {10, 8}, {12, 8}, {13, 4}};
    const int type = at<std::uint16_t>(entry + 2);
    const auto count = at<std::uint32_t>(entry + 4);
    ASSERT_TRUE(sizes.count(type)) << "type " << type;
    const int size = sizes.at(type);
    std::size_t offset = size * count <= 4 ? entry + 8 : at<std::uint32_t>(entry + 8);
    std::vector<double>& values = fields[at<std::uint16_t>(entry)];
    for (std::uint32_t i = 0; i < count; ++i, offset += size) {
      values.push_back(type == 3                 ? at<std::uint16_t>(offset)
                       : type == 4 || type == 13 ? at<std::uint32_t>(offset)
                       : type == 5               ? 1.0 * at<std::uint32_t>(offset) / at<std::uint32_t>(offset + 4)
                       : type == 10              ? 1.0 * at<std::int32_t>(offset) / at<std::int32_t>(offset + 4)
                       : type == 12              ? at<double>(offset)
                                                 : at<std::uint8_t>(offset));
    }
  }

  std::string bytes;
  std::map<int, std::vector<double>> fields;
};

Capture capture_of(const std::string& cfa) {
  Capture capture;
  capture.camera.name = "test";
  capture.camera.cfa = cfa;
  capture.camera.f_number = 1.75;
  capture.camera.focal_length_mm = 4.5;
  capture.exposure = {.time_s = 0.0078125, .iso = 200, .black_level_dn = 64, .white_level_dn = 1023};
  capture.exposure.white_balance = {2, 1, 1.6};
  capture.exposure.mosaic_noise = {.shot_dn = 0.5, .read_dn2 = 3};
  capture.exposure.dp_noise = {.shot_dn = 0.25, .read_dn2 = 2};
  return capture;
}

ImageU16 ramp(int width, int height) {
  ImageU16 raw(width, height);
  for (std::size_t i = 0; i < raw.data.size(); ++i) raw.data[i] = static_cast<std::uint16_t>(257 * i);
  return raw;
}

/// As rationals, whose denominators libtiff chooses, hold them.
void expect_near(const std::vector<double>& actual, const std::vector<double>& expected) {
  ASSERT_EQ(actual.size(), expected.size());
  for (std::size_t i = 0; i < actual.size(); ++i) EXPECT_NEAR(actual[i], expected[i], 1e-6) << i;
}

TEST(Dng, AMosaicKeepsItsNumbersAndSaysWhatTheyMean) {
  const TemporaryFolder folder;
  const ImageU16 raw = ramp(6, 4);
  write_dng(folder / "a.dng", raw, capture_of("GRBG"), DngImage::mosaic);
  const Directory file(folder / "a.dng");
  EXPECT_EQ(file[kWidth], std::vector<double>{6});
  EXPECT_EQ(file[kHeight], std::vector<double>{4});
  EXPECT_EQ(file[kBits], std::vector<double>{16});
  EXPECT_EQ(file[kCompression], std::vector<double>{1});
  EXPECT_EQ(file[kPhotometric], std::vector<double>{32803}) << "color filter array";
  EXPECT_EQ(file[kCfaPattern], (std::vector<double>{1, 0, 2, 1}));
  expect_near(file[kBlackLevel], {64});
  EXPECT_EQ(file[kWhiteLevel], std::vector<double>{1023});
  expect_near(file[kExposureTime], {0.0078125});
  EXPECT_EQ(file[kIso], std::vector<double>{200});
  expect_near(file[kAsShotNeutral], {0.5, 1, 0.625});
  // XYZ of the neutral that sRGB calls white (D65: 0.95047, 1, 1.08883) is what the sensor records of a neutral gray
  const std::vector<double> matrix = file[kColorMatrix1];
  ASSERT_EQ(matrix.size(), 9u);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(0.95047 * matrix[3 * c] + matrix[3 * c + 1] + 1.08883 * matrix[3 * c + 2], file[kAsShotNeutral][c],
                2e-4)
        << "a sum of numbers that the standard gives with four digits";
  }
  // of the signal that runs from 0 to 1
  ASSERT_EQ(file[kNoiseProfile].size(), 2u);
  EXPECT_DOUBLE_EQ(file[kNoiseProfile][0], 0.5 / 959);
  EXPECT_DOUBLE_EQ(file[kNoiseProfile][1], 3.0 / (959 * 959));
  ASSERT_EQ(file[kStripBytes], std::vector<double>{48});
  EXPECT_EQ(std::memcmp(file.bytes.data() + static_cast<std::size_t>(file[kStripOffsets][0]), raw.data.data(), 48), 0);
}

TEST(Dng, AViewIsMonochromeAndItsPixelsMayBeHigh) {
  const TemporaryFolder folder;
  Capture capture = capture_of("RGGB");
  capture.exposure.dp_white_level_dn = 544;
  write_dng(folder / "a.dng", ramp(3, 2), capture, DngImage::view);
  const Directory file(folder / "a.dng");
  EXPECT_EQ(file[kPhotometric], std::vector<double>{34892}) << "linear raw";
  EXPECT_TRUE(file[kCfaPattern].empty());
  EXPECT_TRUE(file[kColorMatrix1].empty());
  expect_near(file[kDefaultScale], {1, 2});
  EXPECT_EQ(file[kWhiteLevel], std::vector<double>{544});
  EXPECT_DOUBLE_EQ(file[kNoiseProfile].at(0), 0.25 / (544 - 64));
}

// Of all colors, but with wells and read-outs of halves.
TEST(Dng, ADenseViewHasTheFiltersColorsAndAViewsLevels) {
  const TemporaryFolder folder;
  Capture capture = capture_of("GRBG");
  capture.camera.dp_downsample_x = capture.camera.dp_downsample_y = 1;
  capture.exposure.dp_white_level_dn = 544;
  write_dng(folder / "a.dng", ramp(4, 2), capture, DngImage::view);
  const Directory file(folder / "a.dng");
  EXPECT_EQ(file[kPhotometric], std::vector<double>{32803}) << "color filter array";
  EXPECT_EQ(file[kCfaPattern], (std::vector<double>{1, 0, 2, 1}));
  expect_near(file[kDefaultScale], {1, 1});
  EXPECT_EQ(file[kWhiteLevel], std::vector<double>{544});
  EXPECT_DOUBLE_EQ(file[kNoiseProfile].at(0), 0.25 / (544 - 64));
}

TEST(Dng, AMosaicIsWhiteWhereItClips) {
  const TemporaryFolder folder;
  Capture capture = capture_of("RGGB");
  capture.exposure.mosaic_white_level_dn = 544;
  write_dng(folder / "a.dng", ramp(2, 2), capture, DngImage::mosaic);
  const Directory file(folder / "a.dng");
  EXPECT_EQ(file[kWhiteLevel], std::vector<double>{544});
  EXPECT_DOUBLE_EQ(file[kNoiseProfile].at(0), 0.5 / (544 - 64));
}

/// Where the first directory's entry of a field begins.
std::size_t entry_of(const std::string& file, std::uint16_t tag) {
  std::uint32_t directory = 0;
  std::memcpy(&directory, &file[4], 4);
  std::size_t entry = directory + 2;
  while (std::memcmp(&file.at(entry), &tag, 2) != 0) entry += 12;
  return entry;
}

/// Gives a field of one number another value.
void set_field(std::string& file, std::uint16_t tag, std::uint32_t value) {
  const std::size_t entry = entry_of(file, tag);
  file[entry + 2] = 4;  // a long
  std::memcpy(&file[entry + 8], &value, 4);
}

/// A lossless JPEG (ITU T.81, Annex H), 64 px wide, of 9 bits: the first pixel is predicted as 256, others by their
/// left neighbor. Of its two codes, 0 is no difference, and 10 has 9 bits more.
std::string lossless_jpeg(const std::string& data, int rows = 64) {
  using namespace std::string_literals;
  return "\xff\xd8"
         "\xff\xc3\0\x0b\x09\0"s +
         static_cast<char>(rows) +
         "\0\x40\1\1\x11\0"                                        // frame: one component
         "\xff\xc4\0\x15\0\1\1\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x09"  // table: a code of one bit, one of two
         "\xff\xda\0\x08\1\1\0\1\0\0"s +                           // scan: predictor 1
         data +
         "\xff\xd9";
}

// LibRaw reads black where its data end, and prints a line.
TEST(Dng, ReadsNoneThatEndsBeforeItsPicture) {
  const TemporaryFolder folder;
  const std::string path = folder / "a.dng";
  write_dng(path, ramp(64, 64), capture_of("RGGB"), DngImage::mosaic);
  const std::string whole = read_bytes(path);
  std::string beyond = whole;
  set_field(beyond, kStripOffsets, 1 << 20);
  for (const std::string& broken : {whole.substr(0, 5000), beyond}) {
    write_bytes(path, broken);
    ::testing::internal::CaptureStderr();
    const std::string refusal = message_of<InputError>([&] { read_dng(path); });
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_TRUE(refusal.starts_with(path + ": cannot be read: ")) << refusal;
  }
}

// LibRaw alone would print a line and give garbage, or leave its memory as it found it.
TEST(Dng, ReadsNoneWhoseCompressedDataAreBroken) {
  const TemporaryFolder folder;
  const std::string path = folder / "a.dng";
  Capture capture = capture_of("RGGB");
  capture.exposure.mosaic_white_level_dn = 544;
  write_dng(path, ramp(64, 64), capture, DngImage::mosaic);
  const std::string whole = read_bytes(path);
  const auto strip = static_cast<std::size_t>(Directory(path)[kStripOffsets].at(0));
  const auto compressed = [&](const std::string& jpeg, std::uint32_t compression) {
    std::string file = whole;
    file.replace(strip, jpeg.size(), jpeg);
    set_field(file, kStripBytes, static_cast<std::uint32_t>(jpeg.size()));
    set_field(file, kCompression, compression);
    write_bytes(path, file);
  };
  constexpr int kLossless = 7, kLossy = 34892;
  const std::string flat(64 * 64 / 8, '\0');  // one bit a pixel
  compressed(lossless_jpeg(flat), kLossless);
  const Image gray = read_dng(path);
  EXPECT_EQ(gray.width, 64);
  EXPECT_NEAR(gray.at(30, 30, 1), (256.0 - 64) / (544 - 64), 1e-3);
  std::string without_start = lossless_jpeg(flat), without_scan = without_start, of_20_bits = without_start;
  without_start[1] = '\0';
  without_scan.resize(30);
  of_20_bits[6] = 20;
  const struct {
    std::string jpeg;
    std::uint32_t compression;
    std::string said;
  } broken[] = {{lossless_jpeg("\xbf\xe0" + flat), kLossless, "raw data are broken"},  // adds 511 to 256, of 9 bits
                {without_start, kLossless, "no lossless JPEG"},
                {without_scan, kLossless, "no lossless JPEG"},
                {of_20_bits, kLossless, "no lossless JPEG"},
                {lossless_jpeg(flat, 60), kLossless, "has 64 x 60 pixels of 1 samples, where 64 x 64 of 1 are needed"},
                {lossless_jpeg(flat), kLossy, "its compression, 34892, is not supported"}};
  for (const auto& [jpeg, compression, said] : broken) {
    compressed(jpeg, compression);
    ::testing::internal::CaptureStderr();
    const std::string refusal = message_of<InputError>([&] { read_dng(path); });
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_TRUE(refusal.starts_with(path + ": cannot be read: ") && refusal.find(said) != std::string::npos)
        << said << ": " << refusal;
  }
}

std::string two_bytes(int value) { return {static_cast<char>(value >> 8), static_cast<char>(value)}; }

/// The headers of a lossless JPEG: `frame` is 0xc3 for a lossless one; `sampling` 0x11 for samples of one density.
struct JpegHeaders {
  int frame = 0xc3, bits = 12, rows = 64, columns = 32, components = 2, sampling = 0x11;
  int predictor = 1, shift = 0, restart = -1;
};

std::string bytes_of(const JpegHeaders& h) {
  std::string jpeg = "\xff\xd8";
  jpeg += std::string("\xff\xe0") + two_bytes(4) + "ab";  // an application's
  jpeg += std::string("\xff") + static_cast<char>(h.frame) + two_bytes(8 + 3 * h.components) +
          static_cast<char>(h.bits) + two_bytes(h.rows) + two_bytes(h.columns) + static_cast<char>(h.components);
  for (int c = 0; c < h.components; ++c) jpeg += {static_cast<char>(c), static_cast<char>(h.sampling), 0};
  jpeg += std::string("\xff\xc4") + two_bytes(20) + std::string(1, 0) + '\1' + std::string(16, 0);
  if (h.restart >= 0) jpeg += std::string("\xff\xdd") + two_bytes(4) + two_bytes(h.restart);
  jpeg += std::string("\xff\xda") + two_bytes(6 + 2 * h.components) + static_cast<char>(h.components);
  for (int c = 0; c < h.components; ++c) jpeg += {static_cast<char>(c), 0};
  return jpeg + static_cast<char>(h.predictor) + std::string(1, 0) + static_cast<char>(h.shift);
}

TEST(DngFault, HeadersMustBeThoseOfTheTiles) {
  const auto fault = [](const JpegHeaders& headers, int samples = 1) {
    // 100 x 64 in two tiles, whose offsets come first
    std::istringstream file(std::string("\0\0\0\x08\0\0\0\x08", 8) + bytes_of(headers));
    return fault_of_lossless_dng(file, {0, true, 100, 64, samples, 64, 64}).value_or("");
  };
  EXPECT_EQ(fault({}), "");  // two components, as Adobe's converter writes a mosaic
  EXPECT_EQ(fault({.restart = 32}), "");
  EXPECT_EQ(fault({.columns = 64, .components = 1}), "");
  EXPECT_EQ(fault({.rows = 32, .columns = 64}), "");  // two rows in one
  EXPECT_EQ(fault({.columns = 64, .components = 3}, 3), "");
  const std::string none = "a part of its raw data is no lossless JPEG that can be read";
  for (const JpegHeaders& broken : {JpegHeaders{.frame = 0xc0},
                                    {.frame = 0xc9},
                                    {.bits = 1},
                                    {.bits = 17},
                                    {.rows = 0},
                                    {.components = 5},
                                    {.sampling = 0x22},
                                    {.predictor = 0},
                                    {.predictor = 8},
                                    {.shift = 12},
                                    {.restart = 0}}) {
    EXPECT_EQ(fault(broken), none);
  }
  for (const JpegHeaders& other :
       {JpegHeaders{.rows = 63}, {.columns = 31}, {.columns = 33}, {.rows = 65535, .columns = 65535}}) {
    EXPECT_NE(fault(other).find("where 64 x 64 of 1 are needed"), std::string::npos) << fault(other);
  }
  EXPECT_NE(fault({.columns = 192, .components = 1}, 3), "");  // LibRaw would take pixels for samples
  std::istringstream file(bytes_of({}));
  EXPECT_NE(fault_of_lossless_dng(file, {0, true, 60000, 60000, 1, 1, 1}).value_or("").find("tiles"),
            std::string::npos);
  EXPECT_NE(fault_of_lossless_dng(file, {0, true, 100, 64, 1, 1 << 30, 64}).value_or("").find("in tiles of"),
            std::string::npos);
}

// LibRaw makes pixels square: 8000 rows of pixels nine times as high as wide are 72 000.
TEST(Dng, ReadsNoneThatIsTooLargeWithSquarePixels) {
  const TemporaryFolder folder;
  const std::string path = folder / "a.dng";
  write_dng(path, ramp(64, 8000), capture_of("RGGB"), DngImage::mosaic);
  std::string file = read_bytes(path);
  std::uint32_t scale = 0;
  std::memcpy(&scale, &file[entry_of(file, kDefaultScale) + 8], 4);
  const std::uint32_t tall[] = {1, 9, 1, 1};  // two fractions, along x and y
  std::memcpy(&file.at(scale), tall, sizeof(tall));
  write_bytes(path, file);
  const std::string refusal = message_of<InputError>([&] { read_dng(path); });
  EXPECT_NE(refusal.find("at most 65536 a side"), std::string::npos) << refusal;
}

TEST(Dng, RefusesPlacesThatCannotBeWritten) {
  const TemporaryFolder folder;
  const std::string path = folder / "none/a.dng";
  const std::string refusal =
      message_of<InputError>([&] { write_dng(path, ramp(2, 2), capture_of("RGGB"), DngImage::mosaic); });
  EXPECT_TRUE(refusal.starts_with(path + ": cannot be written: ")) << refusal;
}

}  // namespace
}  // namespace dualpixel
