#include "capture/image/map_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "capture/error.h"
#include "capture/image/image_io.h"
#include "capture/image/npy.h"
#include "tests/temporary_folder.h"

namespace dualpixel {
namespace {

/// 3 x 2, each value its own, with one that is not finite.
Image some_map() {
  Image map(3, 2);
  map.data = {-1.5f, 0, 2.25f, std::numeric_limits<float>::infinity(), 4, 5};
  return map;
}

template <typename T>
std::string array_bytes(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

TEST(MapFile, ReadsWhatNumPyWrites) {
  const TemporaryFolder folder;
  write_npy(folder / "m.npy", some_map());
  EXPECT_EQ(read_map(folder / "m.npy", "d").data, some_map().data);
  const std::string path =
      folder.write("d.npy", npy_bytes("<f8", {1, 2, 3}, array_bytes<double>({1, 2, 3, 4, 5, 6.5})));
  const Image doubles = read_map(path, "d");
  EXPECT_EQ(doubles.width, 3);
  EXPECT_EQ(doubles.data, (std::vector<float>{1, 2, 3, 4, 5, 6.5f}));
  folder.write("i.npy", npy_bytes("<i2", {2, 1}, array_bytes<std::int16_t>({-7, 300})));
  EXPECT_EQ(read_map(folder / "i.npy", "d").data, (std::vector<float>{-7, 300}));
}

TEST(MapFile, ReadsPfmFromTheBottomUp) {
  const TemporaryFolder folder;
  folder.write("m.pfm", "Pf\n3 2\n-1.0\n" + array_bytes<float>({4, 5, 6, 1, 2, 3}));
  EXPECT_EQ(read_map(folder / "m.pfm", "d").data, (std::vector<float>{1, 2, 3, 4, 5, 6}));
}

TEST(MapFile, ReadsTheNamedOrOnlyChannelOfExr) {
  const TemporaryFolder folder;
  const Image map = some_map(), other(3, 2, 1, 9);
  write_exr(folder / "one.exr", {{"Y", &map}}, false);
  write_exr(folder / "two.exr", {{"d", &map}, {"other", &other}}, false);
  EXPECT_EQ(read_map(folder / "one.exr", "d").data, map.data);
  EXPECT_EQ(read_map(folder / "two.exr", "d").data, map.data);
  EXPECT_EQ(message_of<InputError>([&] { read_map(folder / "two.exr", "sigma"); }),
            folder / "two.exr" + ": has the channels d, other; must have 'sigma', or one alone");
}

TEST(MapFile, ScalesIntegers) {
  const TemporaryFolder folder;
  ImageU16 stored(2, 1);
  stored.data = {32768, 33024};
  write_png16(folder / "m.png", stored);
  EXPECT_TRUE(is_integer_picture(folder / "m.png"));
  write_npy(folder / "m.npy", some_map());
  EXPECT_FALSE(is_integer_picture(folder / "m.npy"));
  EXPECT_EQ(read_map(folder / "m.png", "d", IntegerScale{1.0 / 256, -128}).data, (std::vector<float>{0, 1}));
  EXPECT_EQ(message_of<InputError>([&] { read_map(folder / "m.png", "d"); }),
            folder / "m.png" + ": holds integers: give --scale, and --offset where 0 is not 0");
}

TEST(MapFile, RefusesWhatItCannotRead) {
  const TemporaryFolder folder;
  const std::string four(4, '\0');
  const auto with_shape = [](const std::string& shape) {
    std::string bytes = npy_bytes("<f4", {2, 2}, std::string(16, '\0'));
    const std::size_t at = bytes.find("(2, 2)");
    return bytes.replace(at, shape.size(), shape);  // over the padding
  };
  const std::pair<std::string, std::string> bad[] = {
      {npy_bytes("<f2", {1, 2}, four), "holds '<f2'; must be float32, float64 or integers, little endian"},
      {npy_bytes("<f4", {2, 2}, four), "ends before its last value"},
      {npy_bytes("<f4", {65536, 65536, 4}, four), "ends before its last value"},  // 64 GiB were they there
      {npy_bytes("<f4", {7}, four),
       "has the shape (7, ); must be (height, width) or (height, width, channels), with at most 4 channels"},
      {with_shape("(-2, 2)"),
       "has the shape (-2, 2); must be (height, width) or (height, width, channels), with at "
       "most 4 channels"},
      {with_shape("(2 2, 2)"),
       "has the shape (2 2, 2); must be (height, width) or (height, width, channels), with at "
       "most 4 channels"},
      {with_shape("(2x2, 2)"),
       "has the shape (2x2, 2); must be (height, width) or (height, width, channels), with at "
       "most 4 channels"},
      {npy_bytes("<f4", {2, 1, 3}, std::string(24, '\0')), "has 3 channels; one is needed"},
      {"\x93NUMPY\x01", "is not a NumPy file"},
      {"\x93NUMPY\x01" + std::string(1, '\0') + "\xff\xff{}}}", "ends before its header does"},
      {"Pf\n3 2\n-1.0\n" + four, "ends before its last pixel"},
      {"PF\n1 1\n-1.0\n" + four, "is a PFM of three channels; one is needed"},
      {"Pf\n1 1\n1.0\n" + four, "is a big-endian PFM; write it little endian (a negative scale)"},
      {"Pf\n1 -1\n-1.0\n" + four, "1 x -1 pixels: 1 to 65536 a side are allowed"},
      {"hello", "is not a picture that can be read (EXR, PNG, TIFF, JPEG or HDR)"}};
  for (const auto& [bytes, why] : bad) {
    const std::string path = folder.write("bad", bytes);
    EXPECT_EQ(message_of<InputError>([&] { read_map(path, "d"); }), path + ": " + why);
  }
}

}  // namespace
}  // namespace dualpixel
