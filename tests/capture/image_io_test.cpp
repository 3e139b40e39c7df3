#include "capture/image/image_io.h"

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "capture/error.h"
#include "tests/temporary_folder.h"

namespace dualpixel {
namespace {

std::string image_refusal(const std::string& path) {
  return message_of<InputError>([&] { read_image(path); });
}

/// Distinct values in every pixel and channel.
Image ramp(int width, int height, int channels, float scale = 1) {
  Image image(width, height, channels);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = scale * (static_cast<float>(i) + 0.1f);
  return image;
}

TEST(ImageIo, ExrKeepsFloatsExactly) {
  const TemporaryFolder folder;
  Image depth = ramp(7, 5, 1), normal = ramp(7, 5, 3, -1.7f);
  depth.at(3, 2) = std::numeric_limits<float>::infinity();
  ImageU32 ids(7, 5);
  for (std::size_t i = 0; i < ids.data.size(); ++i) ids.data[i] = 4294967295u - static_cast<std::uint32_t>(i);
  write_exr(folder / "a.exr", {{"Z", &depth}, {"N.X", &normal, 0}, {"N.Y", &normal, 1}, {"N.Z", &normal, 2}}, false,
            &ids, {{"focus", 1.5f}});

  const std::vector<Image> planes = read_exr(folder / "a.exr", {"N.Z", "Z", "N.X"});
  ASSERT_EQ(planes.size(), 3u);
  EXPECT_EQ(planes[1].data, depth.data);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x) {
      EXPECT_EQ(planes[0].at(x, y), normal.at(x, y, 2));
      EXPECT_EQ(planes[2].at(x, y), normal.at(x, y, 0));
    }
  }
  EXPECT_EQ(read_exr_ids(folder / "a.exr").data, ids.data);
  const PictureSize size = picture_size(folder / "a.exr");
  EXPECT_EQ(size.format, "openexr");
  EXPECT_EQ(size.width, 7);
  EXPECT_EQ(size.height, 5);
  EXPECT_EQ(std::set<std::string>(size.channels.begin(), size.channels.end()),
            (std::set<std::string>{"Z", "N.X", "N.Y", "N.Z", "id"}));
  EXPECT_EQ(message_of<InputError>([&] {
              read_exr(folder / "a.exr", {"Z", "W"});
            }).find(folder / "a.exr" + ": has no channel 'W'"),
            0u);
}

TEST(ImageIo, ExrHeaderFollowsItsConventions) {
  const TemporaryFolder folder;
  const Image image = ramp(4, 4, 3);
  write_exr(folder / "a.exr", {{"R", &image, 0}, {"G", &image, 1}, {"B", &image, 2}}, true, nullptr,
            {{"focus", 1.5f}, {"aperture", 1.8f}, {"isoSpeed", 100.0f}, {"expTime", 0.01f}});
  const auto input = OIIO::ImageInput::open(folder / "a.exr");
  ASSERT_TRUE(input);
  EXPECT_EQ(input->spec().format, OIIO::TypeDesc::HALF);
  EXPECT_TRUE(std::string(input->spec()["compression"].get()).starts_with("zip"));
  const std::string header = read_bytes(folder / "a.exr").substr(0, 1000);
  for (const char* attribute : {"focus", "aperture", "isoSpeed", "expTime"}) {
    EXPECT_NE(header.find(std::string(attribute) + '\0' + "float"), std::string::npos) << attribute;
  }
}

TEST(ImageIo, HalfRoundsToElevenBits) {
  const TemporaryFolder folder;
  const Image image = ramp(16, 16, 3, 0.37f);
  write_exr(folder / "a.exr", {{"R", &image, 0}, {"G", &image, 1}, {"B", &image, 2}}, true);
  const Image back = read_image(folder / "a.exr");
  ASSERT_EQ(back.channels, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    EXPECT_NEAR(back.data[i], image.data[i], image.data[i] * std::ldexp(1.0, -11));
  }
}

TEST(ImageIo, Png16KeepsDigitalNumbers) {
  const TemporaryFolder folder;
  ImageU16 image(256, 257);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<std::uint16_t>(i);
  write_png16(folder / "a.png", image);
  EXPECT_EQ(read_image_u16(folder / "a.png", 1).data, image.data);
  EXPECT_FLOAT_EQ(read_image(folder / "a.png").data[65535], 1.0f);
  EXPECT_EQ(message_of<InputError>([&] { read_image_u16(folder / "a.png", 3); }),
            folder / "a.png" + ": has 1 channels; 3 are needed");
}

TEST(ImageIo, Png8RoundsAndClamps) {
  const TemporaryFolder folder;
  Image image(4, 1, 3, 0.5f);
  image.at(0, 0, 0) = -1;
  image.at(1, 0, 1) = 7;
  image.at(2, 0, 2) = 100.0f / 255;
  write_png8(folder / "a.png", image);
  const ImageU16 back = read_image_u16(folder / "a.png", 3);
  EXPECT_EQ(back.at(0, 0, 0), 0);
  EXPECT_EQ(back.at(1, 0, 1), 255);
  EXPECT_EQ(back.at(2, 0, 2), 100);
}

TEST(ImageIo, SameBytesEachTime) {
  const TemporaryFolder folder;
  const Image image = ramp(64, 64, 3);
  for (const char* name : {"a.exr", "b.exr"}) write_exr(folder / name, {{"R", &image, 0}, {"G", &image, 1}}, false);
  EXPECT_EQ(read_bytes(folder / "a.exr"), read_bytes(folder / "b.exr"));
}

TEST(ImageIo, TheFormatIsKnownByItsBytes) {
  const TemporaryFolder folder;
  write_png8(folder / "a.png", Image(3, 2, 1, 1.0f));
  std::filesystem::rename(folder / "a.png", folder / "a.exr");
  EXPECT_EQ(read_image(folder / "a.exr").width, 3);
  write_bytes(folder / "b.png", "P6 1 1 255 abc");
  EXPECT_EQ(image_refusal(folder / "b.png"),
            folder / "b.png" + ": is not a picture that can be read (EXR, PNG, TIFF, JPEG or HDR)");
}

TEST(ImageIo, ReadsOtherFormats) {
  const TemporaryFolder folder;
  for (const char* name : {"a.tif", "a.jpg", "a.hdr"}) {
    const auto output = OIIO::ImageOutput::create(folder / name);
    ASSERT_TRUE(output) << name;
    const Image image(8, 8, 3, 0.5f);
    ASSERT_TRUE(output->open(folder / name, OIIO::ImageSpec(8, 8, 3, OIIO::TypeDesc::FLOAT)));
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, image.data.data()));
    output->close();
    EXPECT_NEAR(read_image(folder / name).at(4, 4, 1), 0.5, 0.01) << name;
  }
}

TEST(ImageIo, RefusesWhatIsNoRegularFile) {
  const TemporaryFolder folder;
  EXPECT_EQ(image_refusal(folder / "none.png"), folder / "none.png" + ": no such file");
  EXPECT_EQ(image_refusal(folder.path.string()), folder.path.string() + ": is a folder, not a file");
  ASSERT_EQ(mkfifo((folder / "pipe.png").c_str(), 0600), 0);
  EXPECT_EQ(image_refusal(folder / "pipe.png"), folder / "pipe.png" + ": is not a regular file");
  write_bytes(folder / "empty.png", "");
  EXPECT_NE(image_refusal(folder / "empty.png"), "");
}

void write_tiff(const std::string& path, const Image& image, const std::string& compression, int tile_side = 0) {
  OIIO::ImageSpec spec(image.width, image.height, image.channels, OIIO::TypeDesc::UINT8);
  spec["compression"] = compression;
  spec.tile_width = spec.tile_height = tile_side;
  const auto output = OIIO::ImageOutput::create(path);
  ASSERT_TRUE(output && output->open(path, spec));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, image.data.data()));
  ASSERT_TRUE(output->close());
}

// OpenImageIO takes what cannot be read of a TIFF for black.
TEST(ImageIo, RefusesTiffsWithoutAllOfTheirPicture) {
  const TemporaryFolder folder;
  write_tiff(folder / "a.tif", ramp(33, 17, 3, 1e-3f), "none");
  std::string whole = read_bytes(folder / "a.tif");
  const auto refusal_with = [&](std::vector<std::uint16_t> tags, std::uint32_t value) {  // of the only directory
    std::string bytes = whole;
    std::uint32_t directory = 0;
    std::uint16_t entries = 0;
    std::memcpy(&directory, &bytes[4], 4);
    std::memcpy(&entries, &bytes[directory], 2);
    for (std::size_t at = directory + 2; at < directory + 2 + 12u * entries; at += 12) {
      for (const std::uint16_t tag : tags) {
        if (std::memcmp(&bytes[at], &tag, 2) == 0) std::memcpy(&bytes[at + 8], &value, 4);
      }
    }
    write_bytes(folder / "b.tif", bytes);
    return image_refusal(folder / "b.tif");
  };
  const std::string begin = folder / "b.tif" + ": cannot be read: ";
  constexpr std::uint16_t kCompression = 259, kStripOffsets = 273, kWidth = 256, kTileWidth = 322, kTileLength = 323;
  EXPECT_EQ(refusal_with({}, 0), "");
  EXPECT_EQ(refusal_with({kStripOffsets}, 1 << 20), begin + "the file ends before its picture does");
  EXPECT_EQ(refusal_with({kCompression}, 34712), begin + "its compression, 34712, is not supported");
  EXPECT_TRUE(refusal_with({kCompression}, 8).starts_with(begin + "its picture is broken: "))
      << refusal_with({kCompression}, 8);
  EXPECT_EQ(refusal_with({kWidth}, 1000), begin + "the file ends before its picture does");
  // 13 GB would be taken for a file of a few kB
  write_tiff(folder / "a.tif", ramp(33, 17, 3, 1e-3f), "none", 16);
  whole = read_bytes(folder / "a.tif");
  EXPECT_EQ(refusal_with({}, 0), "");
  EXPECT_EQ(refusal_with({kTileWidth, kTileLength}, 65520),
            begin + "a strip or tile of it takes 12878611200 bytes: at most 2000000000 are allowed");
}

TEST(ImageIo, RefusesEveryTruncation) {
  const TemporaryFolder folder;
  const Image image = ramp(33, 17, 3);
  write_png8(folder / "a.png", ramp(33, 17, 3, 1e-3f));
  write_exr(folder / "a.exr", {{"R", &image, 0}, {"G", &image, 1}, {"B", &image, 2}}, false);
  write_tiff(folder / "none.tif", image, "none");
  write_tiff(folder / "zip.tif", image, "zip");
  for (const std::string name : {"a.png", "a.exr", "none.tif", "zip.tif"}) {
    const std::string bytes = read_bytes(folder / name);
    // What is cut off at the very end of an EXR may be padding that no decoder needs; a PNG ends with IEND's checksum,
    // and a TIFF with its directory.
    const std::size_t needed = name == "a.exr" ? bytes.size() - 32 : bytes.size();
    for (std::size_t size = 0; size<needed; size += size + 16> needed ? 1 : 1 + size / 8) {
      write_bytes(folder / "cut", bytes.substr(0, size));
      const std::string message = image_refusal(folder / "cut");
      EXPECT_TRUE(message.starts_with(folder / "cut" + ": ")) << name << " cut to " << size << " of " << bytes.size();
      EXPECT_EQ(message.find('\n'), std::string::npos);
    }
  }
}

/// A PNG's chunk: length, name, data, checksum.
std::string png_chunk(const std::string& name, const std::string& data) {
  const auto four = [](std::uint32_t value) {
    std::string bytes;
    for (const int shift : {24, 16, 8, 0}) bytes += static_cast<char>(value >> shift);
    return bytes;
  };
  const std::string chunk = name + data;
  std::uint32_t crc = ~0u;
  for (const char c : chunk) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
  }
  return four(static_cast<std::uint32_t>(data.size())) + chunk + four(~crc);
}

const std::string kPngBegin = "\x89PNG\r\n\x1a\n";

/// Its size is a claim.
std::string png_without_pixels(std::uint32_t width, std::uint32_t height) {
  std::string header;
  for (const std::uint32_t side : {width, height}) {
    for (const int shift : {24, 16, 8, 0}) header += static_cast<char>(side >> shift);
  }
  header += std::string("\x10\x02\0\0\0", 5);
  return kPngBegin + png_chunk("IHDR", header) + png_chunk("IDAT", "") + png_chunk("IEND", "");
}

// libpng would write lines of its own to stderr.
TEST(ImageIo, RefusesEveryChangedByteOfAPngInOneLine) {
  const TemporaryFolder folder;
  write_png8(folder / "a.png", ramp(9, 5, 3, 0.005f));
  const std::string whole = read_bytes(folder / "a.png");
  ::testing::internal::CaptureStderr();
  for (std::size_t i = 8; i < whole.size(); ++i) {
    std::string changed = whole;
    changed[i] = static_cast<char>(changed[i] ^ 0x55);
    std::ofstream(folder / "b.png", std::ios::binary) << changed;
    const std::string refusal = image_refusal(folder / "b.png");
    EXPECT_TRUE(refusal.starts_with(folder / "b.png" + ": ")) << i << " " << refusal;
    EXPECT_EQ(refusal.find('\n'), std::string::npos) << i;
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

// With the right checksums.
TEST(ImageIo, RefusesPngsThatNoProgramWritesInOneLine) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& file, const std::string& said) {
    write_bytes(folder / "a.png", file);
    ::testing::internal::CaptureStderr();
    const std::string refusal = image_refusal(folder / "a.png");
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(refusal, folder / "a.png" + ": cannot be read: " + said);
  };
  const std::string header("\0\0\0\1\0\0\0\1\10\2\0\0\0", 13), data = png_chunk("IDAT", "\x78\x9c"),
                                                               end = png_chunk("IEND", "");
  const std::pair<int, char> changes[] = {{3, 0}, {1, 16}, {4, '\x7f'}, {4, '\xff'}, {8, 3},
                                          {9, 1}, {9, 5},  {10, 1},     {11, 1},     {12, 2}};
  for (const auto& [at, value] : changes) {
    std::string changed = header;
    changed[at] = value;
    expect(kPngBegin + png_chunk("IHDR", changed) + data + end,
           "its header IHDR says what no PNG may, or that it is of more than a million pixels a side");
  }
  const std::string begin = kPngBegin + png_chunk("IHDR", header);
  const std::string order = "IHDR must be its first chunk, and the only one of that name";
  expect(kPngBegin + data + end, order);
  expect(begin + png_chunk("IHDR", header) + data + end, order);
  expect(begin + png_chunk("IaDR", "x") + data + end, "its critical chunk IaDR is of no kind that is known");
  for (const char* not_zlib : {"\x88\x1c", "\x79\x9c", "\x78\x9d", "\x78\xbb"}) {
    expect(begin + png_chunk("IDAT", not_zlib) + end, "its chunk IDAT holds no compressed data");
  }
  expect(begin + end, "it has no chunk IDAT");
  // One pixel is a filter type and three colors; "\1", its length and the length's complement: as they are (RFC 1951).
  const auto stored = [&](const std::string& pixels) {
    const char count = static_cast<char>(pixels.size());
    const std::string length{count, 0, static_cast<char>(~count), '\xff'};
    return begin + png_chunk("IDAT", "\x78\x01\1" + length + pixels) + end;
  };
  expect(stored(std::string("\0ab", 3)), "its picture ends early");
  expect(stored("\5abc"), "a scanline of it has a filter type that no PNG may have");
  expect(begin + png_chunk("IDAT", "\x78\x01\7") + end, "its compressed picture is broken: invalid block type");
  std::string palette = header;
  palette[9] = 3;
  expect(kPngBegin + png_chunk("IHDR", palette) + data + end, "it has no palette PLTE before its picture");
}

// By the seven passes of interlacing, of which small pictures lack some.
TEST(ImageIo, KnowsTheScanlinesOfInterlacedPngs) {
  const TemporaryFolder folder;
  for (const auto& [side, scanline_bytes] : {std::pair{1, 2}, {2, 7}, {3, 15}, {5, 36}}) {
    std::string header("\0\0\0\0\0\0\0\0\10\0\0\0\1", 13);  // 8 bits of gray
    header[3] = header[7] = static_cast<char>(side);
    for (const int missing : {0, 1}) {
      std::string pixels(scanline_bytes - missing, '\0');
      std::vector<Bytef> packed(compressBound(pixels.size()));
      uLongf size = packed.size();
      compress(packed.data(), &size, reinterpret_cast<const Bytef*>(pixels.data()), pixels.size());
      const std::string data(packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(size));
      write_bytes(folder / "a.png",
                  kPngBegin + png_chunk("IHDR", header) + png_chunk("IDAT", data) + png_chunk("IEND", ""));
      EXPECT_EQ(image_refusal(folder / "a.png"),
                missing ? folder / "a.png" + ": cannot be read: its picture ends early" : "");
    }
  }
}

// OpenEXR would take two gigabytes for a name of the file's.
TEST(ImageIo, RefusesExrAttributesLargerThanTheFile) {
  const TemporaryFolder folder;
  const std::string begin("\x76\x2f\x31\x01\2\0\0\0", 8);
  const std::string attribute("owner\0string\0\x00\x00\x00\x76vw", 19);
  write_bytes(folder / "a.exr", begin + attribute);
  EXPECT_EQ(image_refusal(folder / "a.exr"),
            folder / "a.exr" +
                ": cannot be read: its attribute owner is said to be of 1979711488 bytes, more than the file has");
  for (const std::string& rest : {std::string(), std::string("own"), std::string(300, 'a'), attribute.substr(0, 15)}) {
    write_bytes(folder / "a.exr", begin + rest);
    EXPECT_EQ(image_refusal(folder / "a.exr"), folder / "a.exr" + ": cannot be read: its header does not end");
  }
}

TEST(ImageIo, RefusesClaimedSizesBeforeReading) {
  const TemporaryFolder folder;
  write_bytes(folder / "wide.png", png_without_pixels(70000, 1));
  EXPECT_NE(image_refusal(folder / "wide.png"), "");
  write_bytes(folder / "big.png", png_without_pixels(60000, 60000));
  EXPECT_NE(image_refusal(folder / "big.png").find("at most 65536 a side and 500000000 values"), std::string::npos);
}

TEST(ImageIo, RefusesDeepAndMultipartExr) {
  const TemporaryFolder folder;
  const OIIO::ImageSpec spec(4, 4, 3, OIIO::TypeDesc::FLOAT);
  const Image image(4, 4, 3, 0.5f);
  {
    const auto output = OIIO::ImageOutput::create("openexr");
    const OIIO::ImageSpec parts[2] = {spec, spec};
    ASSERT_TRUE(output->open(folder / "parts.exr", 2, parts));
    output->write_image(OIIO::TypeDesc::FLOAT, image.data.data());
    ASSERT_TRUE(output->open(folder / "parts.exr", spec, OIIO::ImageOutput::AppendSubimage));
    output->write_image(OIIO::TypeDesc::FLOAT, image.data.data());
    output->close();
  }
  EXPECT_EQ(image_refusal(folder / "parts.exr"), folder / "parts.exr" + ": EXR of several parts is not supported");
  {
    const auto output = OIIO::ImageOutput::create("openexr");
    OIIO::ImageSpec deep(4, 4, 1, OIIO::TypeDesc::FLOAT);
    deep.channelnames = {"Z"};
    deep.deep = true;
    ASSERT_TRUE(output->open(folder / "deep.exr", deep));
    OIIO::DeepData data(deep);
    for (int pixel = 0; pixel < 16; ++pixel) data.set_samples(pixel, 1);
    output->write_deep_image(data);
    output->close();
  }
  EXPECT_EQ(image_refusal(folder / "deep.exr"), folder / "deep.exr" + ": deep EXR is not supported");
}

TEST(ImageIo, RefusesToWriteWhereItCannot) {
  const Image image(2, 2, 1, 0.5f);
  EXPECT_THROW(write_png8("/proc/no/a.png", image), InputError);
  EXPECT_THROW(write_exr("/proc/no/a.exr", {{"Y", &image}}, false), InputError);
  EXPECT_THROW(write_png16("/dev/full", ImageU16(64, 64)), InputError);
}

TEST(Srgb, MatchesTheStandardsTable) {
  // IEC 61966-2-1: code values 0..255 decode to these linear values.
  EXPECT_NEAR(srgb_from_linear(0.21586050f) * 255, 128, 0.01);
  EXPECT_NEAR(srgb_from_linear(0.00303527f) * 255, 10, 0.01);
  EXPECT_EQ(srgb_from_linear(-1), 0);
  EXPECT_NEAR(srgb_from_linear(2), 1, 1e-6);
  EXPECT_EQ(srgb_from_linear(std::nanf("")), 0);
  EXPECT_NEAR(linear_from_srgb(128 / 255.0f), 0.21586050f, 1e-7);
  EXPECT_NEAR(linear_from_srgb(10 / 255.0f), 0.00303527f, 1e-8);
}

}  // namespace
}  // namespace dualpixel
