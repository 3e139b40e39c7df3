#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/image/image_io.h"
#include "capture/json_fields.h"
#include "tests/temporary_folder.h"

namespace dualpixel {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

template <typename T>
ImageOf<T> pattern(int width, int height, int channels, unsigned seed) {
  ImageOf<T> image(width, height, channels);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<T>((i * 7 + seed * 31) % 1000);
  return image;
}

Capture small_capture(bool with_truth) {
  Capture capture;
  capture.camera = {.name = "test",
                    .width_px = 16,
                    .height_px = 8,
                    .pixel_pitch_um = 1.4,
                    .focal_length_mm = 4.4,
                    .f_number = 1.8,
                    .focus_distance_m = 1.25,
                    .principal_point_px = {8.5, 4},
                    .split = "ramp",
                    .alpha = 0.21,
                    .relative_light = pattern<float>(3, 2, 1, 0)};
  for (float& light : capture.camera.relative_light.data) light = 1 - light / 64;
  capture.exposure = {.time_s = 0.01,
                      .iso = 100,
                      .bits = 10,
                      .black_level_dn = 64,
                      .white_level_dn = 1023,
                      .mosaic_white_level_dn = 1000.5,
                      .dp_white_level_dn = 543.5,
                      .mosaic_noise = {0.2, 1.5},
                      .dp_noise = {0.1, 0.5},
                      .white_balance = {1.9, 1, 1.6},
                      .color_matrix = Matrix3{1.5, -0.4, -0.1, -0.2, 1.4, -0.2, 0, -0.5, 1.5},
                      .lux_s_per_unit = 0.3};
  for (unsigned i = 0; i < 3; ++i) {
    Frame& frame = capture.frames.emplace_back();
    frame.mosaic = pattern<std::uint16_t>(16, 8, 1, i);
    frame.left = pattern<std::uint16_t>(8, 2, 1, i + 10);
    frame.right = pattern<std::uint16_t>(8, 2, 1, i + 20);
    frame.seed = 0xffffffffffffff00u + i;
    frame.camera_from_world[3] = 0.1 * i;
  }
  capture.face_px = {{1, 2, 3, 4}};
  capture.provenance.program = "dualpixel 0.1.0";
  capture.provenance.scene = R"({"samples":64})";
  capture.provenance.other["options"] = "[1,2.5]";
  if (with_truth) {
    Truth& truth = capture.truth.emplace();
    truth.depth_m = pattern<float>(16, 8, 1, 1);
    truth.blur_px = pattern<float>(16, 8, 1, 2);
    truth.disparity_dp_px = pattern<float>(16, 8, 1, 3);
    truth.normal = pattern<float>(16, 8, 3, 4);
    truth.object_id = pattern<std::uint32_t>(16, 8, 1, 5);
    truth.object_id.data[0] = 4000000000u;
    truth.person_mask = Image(16, 8, 1, 0.0f);
    truth.person_mask.at(3, 3) = 1;
    truth.valid = Image(16, 8, 1, 1.0f);
    truth.valid.at(5, 5) = 0;
    truth.depth_m.data[0] += 0.123f;
    truth.depth_m.at(5, 5) = kInfinity;
    truth.all_in_focus = pattern<float>(16, 8, 3, 6);
    truth.photograph = pattern<float>(16, 8, 3, 7);
    truth.photograph.data[0] = 1e6f;  // beyond half: the whole picture is stored as float
    truth.photograph_aperture_scale = 4;
    truth.left = pattern<float>(16, 8, 3, 10);
    truth.right = pattern<float>(16, 8, 3, 11);
    truth.noise = {.views = 0.125, .all_in_focus = 0.25, .photograph = 0.5};
    truth.views_sigma = pattern<float>(16, 8, 1, 12);
    truth.photograph_sigma = pattern<float>(16, 8, 1, 13);
    truth.motion = {pattern<float>(16, 8, 2, 8), pattern<float>(16, 8, 2, 9)};
    truth.motion[1].data[6] = truth.motion[1].data[7] = kInfinity;  // behind the camera
  }
  return capture;
}

std::string capture_refusal(const std::string& path) {
  return message_of<InputError>([&] { read_capture(path, true); });
}

std::string write_refusal(const Capture& capture) {
  const TemporaryFolder folder;
  std::string message = message_of<InputError>([&] { write_capture(capture, folder / "out"); });
  EXPECT_TRUE(message.empty() || folder.names().empty());
  return message;
}

/// Changes capture.json of a capture on disk.
void edit(const std::string& path, const std::function<void(json&)>& change) {
  json document = read_json_file(path + "/capture.json");
  change(document);
  write_bytes(path + "/capture.json", document.dump());
}

void expect_equal_frames(const Capture& a, const Capture& b) {
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    EXPECT_EQ(a.frames[i].mosaic.data, b.frames[i].mosaic.data);
    EXPECT_EQ(a.frames[i].left.data, b.frames[i].left.data);
    EXPECT_EQ(a.frames[i].right.data, b.frames[i].right.data);
    EXPECT_EQ(a.frames[i].seed, b.frames[i].seed);
    EXPECT_EQ(a.frames[i].camera_from_world, b.frames[i].camera_from_world);
  }
}

TEST(CaptureIo, EverythingSurvivesTheRoundTrip) {
  const TemporaryFolder folder;
  const Capture written = small_capture(true);
  write_capture(written, folder / "out");
  EXPECT_EQ(folder.names(), std::set<std::string>{"out"});
  const Capture back = read_capture(folder / "out", true);

  EXPECT_EQ(back.camera.name, "test");
  EXPECT_EQ(back.camera.width_px, 16);
  EXPECT_EQ(back.camera.height_px, 8);
  EXPECT_EQ(back.camera.pixel_pitch_um, 1.4);
  EXPECT_EQ(back.camera.cfa, "RGGB");
  EXPECT_EQ(back.camera.dp_downsample_x, 2);
  EXPECT_EQ(back.camera.dp_downsample_y, 4);
  EXPECT_EQ(back.camera.focal_length_mm, 4.4);
  EXPECT_EQ(back.camera.f_number, 1.8);
  EXPECT_EQ(back.camera.focus_distance_m, 1.25);
  EXPECT_EQ(back.camera.principal_point_px, written.camera.principal_point_px);
  EXPECT_EQ(back.camera.split, "ramp");
  EXPECT_EQ(back.camera.alpha, 0.21);
  EXPECT_TRUE(back.camera.relative_light.same_size(written.camera.relative_light));
  EXPECT_EQ(back.camera.relative_light.at(2, 1), written.camera.relative_light.at(2, 1));
  EXPECT_EQ(back.camera.relative_light.data, written.camera.relative_light.data);
  EXPECT_EQ(back.exposure.time_s, 0.01);
  EXPECT_EQ(back.exposure.iso, 100);
  EXPECT_EQ(back.exposure.bits, 10);
  EXPECT_EQ(back.exposure.black_level_dn, 64);
  EXPECT_EQ(back.exposure.white_level_dn, 1023);
  EXPECT_EQ(back.exposure.mosaic_white_level_dn, 1000.5);
  EXPECT_EQ(back.exposure.dp_white_level_dn, 543.5);
  EXPECT_EQ(back.exposure.mosaic_noise.shot_dn, 0.2);
  EXPECT_EQ(back.exposure.mosaic_noise.read_dn2, 1.5);
  EXPECT_EQ(back.exposure.dp_noise.shot_dn, 0.1);
  EXPECT_EQ(back.exposure.dp_noise.read_dn2, 0.5);
  EXPECT_EQ(back.exposure.white_balance, written.exposure.white_balance);
  EXPECT_EQ(back.exposure.color_matrix, written.exposure.color_matrix);
  EXPECT_EQ(back.exposure.lux_s_per_unit, 0.3);
  EXPECT_EQ(back.face_px, written.face_px);
  EXPECT_EQ(back.provenance, written.provenance);
  expect_equal_frames(back, written);

  ASSERT_TRUE(back.truth);
  const Truth &a = *back.truth, &b = *written.truth;
  EXPECT_EQ(a.depth_m.data, b.depth_m.data);
  EXPECT_EQ(a.blur_px.data, b.blur_px.data);
  EXPECT_EQ(a.disparity_dp_px.data, b.disparity_dp_px.data);
  EXPECT_EQ(a.normal.data, b.normal.data);
  EXPECT_EQ(a.object_id.data, b.object_id.data);
  EXPECT_EQ(a.person_mask.data, b.person_mask.data);
  EXPECT_EQ(a.valid.data, b.valid.data);
  EXPECT_EQ(a.all_in_focus.data, b.all_in_focus.data);  // whole numbers below 1000 are exact in half
  EXPECT_EQ(a.photograph.data, b.photograph.data);
  EXPECT_EQ(a.photograph_aperture_scale, 4);
  EXPECT_EQ(a.left.data, b.left.data);
  EXPECT_EQ(a.right.data, b.right.data);
  EXPECT_EQ(a.noise, b.noise);
  EXPECT_EQ(a.views_sigma.data, b.views_sigma.data);
  EXPECT_EQ(a.photograph_sigma.data, b.photograph_sigma.data);
  EXPECT_TRUE(a.all_in_focus_sigma.empty());
  ASSERT_EQ(a.motion.size(), 2u);
  for (int i : {0, 1}) EXPECT_EQ(a.motion[i].data, b.motion[i].data);
}

TEST(CaptureIo, MotionIsThereForEveryFrameButTheFirstOrForNone) {
  Capture capture = small_capture(true);
  capture.truth->motion.pop_back();
  EXPECT_NE(write_refusal(capture).find("/truth/motion: 1 of them"), std::string::npos);
  capture.truth->motion.assign(2, Image(16, 8, 1));
  EXPECT_NE(write_refusal(capture).find("/truth/motion/0: 16 x 8 pixels of 1 channels"), std::string::npos);
  capture.truth->motion.assign(2, Image(16, 8, 2, NAN));
  EXPECT_NE(write_refusal(capture).find("/truth/motion/0: must be finite"), std::string::npos);
  const TemporaryFolder folder;
  for (const json& wrong : {json(3), json::array({1, 2}), json::array({"no.exr", "truth/motion_002.exr"})}) {
    write_capture(small_capture(true), folder / "out");
    edit(folder / "out", [&](json& d) { d["truth"]["motion"] = wrong; });
    EXPECT_NE(capture_refusal(folder / "out"), "") << wrong;
  }
}

TEST(CaptureIo, LensShadingIsAWholeGridOfShares) {
  const TemporaryFolder folder;
  write_capture(small_capture(false), folder / "out");
  const auto refusal = [&](const char* field, const json& value) {
    const json before = read_json_file(folder / "out/capture.json");
    edit(folder / "out", [&](json& d) { d["camera"]["lens_shading"][field] = value; });
    std::string message = capture_refusal(folder / "out");
    write_bytes(folder / "out/capture.json", before.dump());
    return message;
  };
  EXPECT_NE(refusal("columns", 1).find("/camera/lens_shading/columns: 1: must be"), std::string::npos);
  EXPECT_NE(refusal("rows", 3).find("/camera/lens_shading/relative_light: 6 numbers: must be columns times rows, 9"),
            std::string::npos);
  EXPECT_NE(refusal("relative_light", {1, 1, 1, 1, 1, -0.5}).find("/camera/lens_shading/relative_light"),
            std::string::npos);
  EXPECT_NE(refusal("relative_light", {1, 1, 1, 1, 1, 11}).find("11"), std::string::npos);
  EXPECT_NE(refusal("gain", 2).find("/camera/lens_shading/gain: unknown field"), std::string::npos);
  edit(folder / "out", [](json& d) { d["camera"].erase("lens_shading"); });
  EXPECT_TRUE(read_capture(folder / "out", false).camera.relative_light.empty());
}

TEST(CaptureIo, TruthIsReadOnlyWhenAskedFor) {
  const TemporaryFolder folder;
  write_capture(small_capture(true), folder / "out");
  EXPECT_FALSE(read_capture(folder / "out", false).truth);
}

TEST(CaptureIo, FocusAtInfinitySurvives) {
  const TemporaryFolder folder;
  Capture capture = small_capture(false);
  capture.camera.focus_distance_m = std::numeric_limits<double>::infinity();
  write_capture(capture, folder / "out");
  EXPECT_EQ(read_capture(folder / "out", true).camera.focus_distance_m, capture.camera.focus_distance_m);
}

TEST(CaptureIo, SameBytesForAnyNumberOfThreads) {
  const TemporaryFolder folder;
  const Capture capture = small_capture(true);
  for (const int threads : {1, 2, 8}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    write_capture(capture, folder / std::to_string(threads));
  }
  for (const auto& entry : fs::recursive_directory_iterator(folder / "1")) {
    if (!entry.is_regular_file()) continue;
    const std::string name = fs::relative(entry.path(), folder / "1").string();
    for (const std::string other : {"2/", "8/"}) {
      EXPECT_EQ(read_bytes(entry.path().string()), read_bytes(folder / (other + name))) << name;
    }
  }
}

TEST(CaptureIo, OverwritesACaptureButNothingElse) {
  const TemporaryFolder folder;
  write_capture(small_capture(true), folder / "out");
  write_capture(small_capture(false), folder / "out");
  EXPECT_FALSE(fs::exists(folder / "out/truth"));
  EXPECT_TRUE(fs::exists(folder / "out.old/truth"));  // which the new one lacks
  fs::create_directory(folder / "precious");
  write_bytes(folder / "precious/thesis", "text");
  EXPECT_THROW(write_capture(small_capture(false), folder / "precious"), InputError);
  EXPECT_THROW(write_capture(small_capture(false), folder / "precious/thesis/out"), InputError);
  EXPECT_THROW(write_capture(small_capture(false), "/proc/dualpixel_out"), InputError);
  EXPECT_EQ(folder.names(), (std::set<std::string>{"out", "out.old", "precious"}));
}

TEST(CaptureIo, RefusesToWriteWhatIsInconsistent) {
  EXPECT_EQ(write_refusal(small_capture(true)), "");
  const auto refusal = [](const std::function<void(Capture&)>& spoil) {
    Capture capture = small_capture(true);
    spoil(capture);
    return write_refusal(capture);
  };
  EXPECT_NE(refusal([](Capture& c) { c.frames.clear(); }), "");
  EXPECT_NE(refusal([](Capture& c) { c.frames[1].left = ImageU16(8, 3); }).find("/frames/1/left: 8 x 3 pixels"),
            std::string::npos);
  EXPECT_NE(refusal([](Capture& c) { c.frames[1].mosaic = {}; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.frames[1].right.at(0, 0) = 1024; }).find("digital number 1024, beyond 10 bits"),
            std::string::npos);
  EXPECT_NE(refusal([](Capture& c) { c.camera.focus_distance_m = 0.004; }).find("inside the focal length"),
            std::string::npos);
  EXPECT_NE(refusal([](Capture& c) { c.exposure.black_level_dn = 1023; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.exposure.dp_white_level_dn = 64; }).find("/exposure/dp_white_level_dn: 64"),
            std::string::npos);
  EXPECT_NE(refusal([](Capture& c) { c.exposure.dp_white_level_dn = 1024; }), "");
  EXPECT_NE(refusal([](Capture& c) {
              c.exposure.mosaic_white_level_dn = 1024;
            }).find("/exposure/mosaic_white_level_dn: 1024"),
            std::string::npos);
  EXPECT_NE(refusal([](Capture& c) { c.exposure.color_matrix = Matrix3{1, 0, 0, 1, 0, 0, 0, 0, 1}; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.frames[0].camera_from_world[0] = NAN; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.truth->depth_m.at(1, 1) = NAN; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.truth->depth_m.at(5, 5) = 3; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.truth->disparity_dp_px.at(1, 1) = kInfinity; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.truth->photograph.at(1, 1, 2) = NAN; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.truth->left.at(1, 1, 2) = NAN; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.truth->left = {}; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.truth->views_sigma.at(1, 1) = -1; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.truth->normal = Image(16, 8, 1); }), "");
  // What could not be read back is not written either.
  EXPECT_NE(refusal([](Capture& c) { c.camera.f_number = 0; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.camera.width_px = 0; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.camera.dp_downsample_x = 0; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.exposure.bits = 40; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.exposure.dp_noise.read_dn2 = NAN; }), "");
  EXPECT_NE(refusal([](Capture& c) { c.truth->photograph_aperture_scale = 0; }), "");
}

TEST(CaptureIo, ReadsDualPixelViewsWrittenByHand) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "phone");
  const ImageU16 left = pattern<std::uint16_t>(8, 2, 1, 1), right = pattern<std::uint16_t>(8, 2, 1, 2);
  write_png16(folder / "phone/l.png", left);
  write_png16(folder / "phone/r.png", right);
  write_bytes(folder / "phone/capture.json", R"({
    "format": "dualpixel-capture", "version": 1,
    "conventions": {
      "axes": "opencv", "pixel_center": 0.5, "depth": "planar z from the entrance pupil, metres",
      "disparity": "right(x + d) = left(x), DP pixels; negative in front of the focus plane",
      "left_view": "light that crossed the pupil at x < 0",
      "camera_from_world": "row-major 4x4, points are columns, metres"},
    "camera": {"width_px": 16, "height_px": 8, "pixel_pitch_um": 1.4, "focal_length_mm": 4.4, "f_number": 1.8,
               "focus_distance_m": "inf"},
    "exposure": {"bits": 10, "black_level_dn": 64, "white_level_dn": 1023},
    "frames": [{"left": "l.png", "right": "r.png"}]})");
  const Capture capture = read_capture(folder / "phone", true);
  EXPECT_FALSE(capture.truth);
  EXPECT_TRUE(capture.frames[0].mosaic.empty());
  EXPECT_EQ(capture.frames[0].left.data, left.data);
  EXPECT_EQ(capture.frames[0].right.data, right.data);
  EXPECT_EQ(capture.camera.alpha, 0);
  EXPECT_EQ(capture.camera.split, "unknown");
  EXPECT_EQ(capture.camera.principal_point_px, (std::array<double, 2>{8, 4}));
}

TEST(CaptureIo, NoticesChangedFiles) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  for (const std::string name : {"frames/001_left.png", "truth/geometry.exr"}) {
    write_capture(small_capture(true), out);
    std::string bytes = read_bytes(out + "/" + name);
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    write_bytes(out + "/" + name, bytes);
    EXPECT_EQ(capture_refusal(out),
              out + "/" + name + ": its xxh64 is not the one in capture.json: the file was changed");
    write_bytes(out + "/" + name, bytes + "x");
    EXPECT_NE(capture_refusal(out).find("capture.json says"), std::string::npos);
    fs::remove(out + "/" + name);
    EXPECT_NE(capture_refusal(out), "");
  }
}

// Whatever another program recorded, its own fields and values of other types in ours, is written back as it was read.
TEST(CaptureIo, KeepsTheProvenanceOfOtherPrograms) {
  const TemporaryFolder folder;
  const json foreign = {{"program", 3},
                        {"scene_file", ""},
                        {"noise_fraction_reached", 1},
                        {"scene", {1, {{"b", nullptr}}}},
                        {"lab", {{"who", "x"}, {"at", {1.5, -0.0, 1e300}}}}};
  write_capture(small_capture(false), folder / "foreign");
  edit(folder / "foreign", [&](json& document) { document["provenance"] = foreign; });
  write_capture(read_capture(folder / "foreign", false), folder / "copy");
  EXPECT_EQ(json::parse(read_bytes(folder / "copy/capture.json"))["provenance"].dump(), foreign.dump());
}

TEST(CaptureIo, RefusesProvenanceThatIsNoJson) {
  const TemporaryFolder folder;
  Capture capture = small_capture(false);
  capture.provenance.scene = "{";
  const std::string message = message_of<InputError>([&] { write_capture(capture, folder / "out"); });
  EXPECT_NE(message.find("out: /provenance/scene: "), std::string::npos) << message;
  EXPECT_TRUE(folder.names().empty());
}

TEST(CaptureIo, RefusesFoldersThatAreNoCapture) {
  const TemporaryFolder folder;
  EXPECT_EQ(capture_refusal(folder / "none"), folder / "none" + ": is not a capture: no such folder");
  EXPECT_EQ(capture_refusal(folder.path.string()), folder.path.string() + ": is not a capture: it has no capture.json");
  write_bytes(folder / "capture.json", "{");
  EXPECT_NE(capture_refusal(folder.path.string()), "");
}

TEST(SlowCaptureIo, RefusesWhatTheDocumentForbids) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  const auto refusal = [&](const std::function<void(json&)>& change) {
    write_capture(small_capture(true), out);
    edit(out, change);
    return capture_refusal(out);
  };
  const std::string where = out + "/capture.json: ";
  EXPECT_EQ(refusal([](json&) {}), "");
  EXPECT_EQ(refusal([](json& d) { d["version"] = 2; }), where + "/version: 2: must be an integer in [1, 1]");
  EXPECT_NE(refusal([](json& d) { d["format"] = "zip"; }).find("/format"), std::string::npos);
  EXPECT_EQ(refusal([](json& d) { d["camera"]["focal_lenght_mm"] = 1; }),
            where + "/camera/focal_lenght_mm: unknown field; did you mean 'focal_length_mm'?");
  EXPECT_EQ(refusal([](json& d) { d["camera"].erase("f_number"); }), where + "/camera/f_number: is required");
  EXPECT_EQ(refusal([](json& d) { d["frmes"] = 1; }), where + "/frmes: unknown field; did you mean 'frames'?");
  EXPECT_EQ(refusal([](json& d) { d["conventions"]["axes"] = "opengl"; }),
            where + "/conventions/axes: must be \"opencv\"");
  EXPECT_NE(refusal([](json& d) { d["camera"]["width_px"] = 15; }).find("/camera/width_px: 15: must be even"),
            std::string::npos);
  EXPECT_NE(refusal([](json& d) { d["camera"]["width_px"] = 32; }).find("the camera calls for"), std::string::npos);
  EXPECT_NE(refusal([](json& d) { d["camera"]["focus_distance_m"] = 0.004; }).find("inside the focal length"),
            std::string::npos);
  EXPECT_NE(refusal([](json& d) { d["camera"]["f_number"] = 0; }).find("/camera/f_number: 0: must be"),
            std::string::npos);
  EXPECT_NE(refusal([](json& d) { d["exposure"]["time_s"] = -1; }).find("/exposure/time_s: -1"), std::string::npos);
  EXPECT_NE(refusal([](json& d) { d["exposure"]["bits"] = 8; }), "");
  EXPECT_NE(refusal([](json& d) { d["frames"] = json::array(); }), "");
  EXPECT_NE(refusal([](json& d) { d["frames"][0].erase("left"); }).find("/frames/0/left: is required"),
            std::string::npos);
  EXPECT_NE(refusal([](json& d) { d["frames"][2].erase("mosaic"); }).find("either every frame"), std::string::npos);
  EXPECT_NE(refusal([](json& d) { d["files"].erase(0); }).find("is not listed under /files"), std::string::npos);
  EXPECT_NE(refusal([](json& d) { d["files"].push_back(d["files"][0]); }).find("is listed twice"), std::string::npos);
  EXPECT_NE(refusal([](json& d) { d["face_px"] = {1, 2, 3}; }).find("must be 4 finite numbers"), std::string::npos);
  EXPECT_NE(refusal([](json& d) { d["face_px"] = {1, 2, -3, -4}; }).find("/face_px"), std::string::npos);
  EXPECT_NE(refusal([](json& d) { d["provenance"] = 3; }), "");
  EXPECT_NE(refusal([](json& d) { d["truth"].erase("photograph"); }).find("/truth/photograph: is required"),
            std::string::npos);
}

TEST(CaptureIo, StaysInsideItsFolder) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  write_png16(folder / "outside.png", small_capture(false).frames[0].left);
  const auto refusal = [&](const std::string& name) {
    write_capture(small_capture(false), out);
    fs::create_symlink(folder / "outside.png", out + "/link.png");
    fs::create_directory_symlink(folder.path, out + "/up");
    edit(out, [&](json& d) {
      d.erase("files");
      d["frames"][0]["left"] = name;
    });
    return capture_refusal(out);
  };
  for (const std::string& name : {std::string("../outside.png"), folder / "outside.png", std::string("link.png"),
                                  std::string("up/outside.png"), std::string("frames/../../outside.png"), std::string(),
                                  std::string("a\0b", 3), std::string("frames"), std::string("no.png")}) {
    const std::string message = refusal(name);
    EXPECT_NE(message, "") << name;
    EXPECT_EQ(message.find('\n'), std::string::npos);
  }
  EXPECT_EQ(refusal("frames/000_left.png"), "");
}

}  // namespace
}  // namespace dualpixel
