#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/capture.h"
#include "capture/dng.h"
#include "capture/error.h"
#include "capture/files.h"
#include "capture/folder/capture_json.h"
#include "capture/image/image_io.h"
#include "capture/image/npy.h"
#include "capture/views.h"
#include "datasets/pictures/developed.h"
#include "datasets/pictures/google.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

namespace fs = std::filesystem;
using datasets::developed, datasets::levels, datasets::scaled, datasets::srgb;

struct ExportOptions {
  std::string capture;
  std::string output;
  std::string format;
};

/// What every format writes from and to.
struct Export {
  const Capture& capture;
  std::string source;  ///< as messages name the capture
  std::string name;    ///< of the capture's folder: data sets name their images by it
  std::string folder;  ///< where to write

  const Truth& truth() const {
    if (!capture.truth) throw InputError(printable(source) + ": holds no truth, which this layout needs");
    return *capture.truth;
  }
  const ImageU16& mosaic() const {
    const ImageU16& mosaic = capture.frames.front().mosaic;
    if (mosaic.empty()) throw InputError(printable(source) + ": holds no mosaic, which this layout needs");
    return mosaic;
  }
  /// The path of a new file, its folders made.
  std::string file(const std::string& relative) const {
    const fs::path path = fs::path(folder) / relative;
    fs::create_directories(path.parent_path());
    return path.string();
  }
};

/// visit(file name without its ending, raw, what raw is) for the images of every frame.
void each_raw(const Export& e, const std::function<void(const std::string&, const ImageU16&, DngImage)>& visit) {
  for (std::size_t i = 0; i < e.capture.frames.size(); ++i) {
    const Frame& frame = e.capture.frames[i];
    if (!frame.mosaic.empty()) visit(fmt::format("{:03}_mosaic", i), frame.mosaic, DngImage::mosaic);
    visit(fmt::format("{:03}_left", i), frame.left, DngImage::view);
    visit(fmt::format("{:03}_right", i), frame.right, DngImage::view);
  }
}

void export_dng(const Export& e) {
  each_raw(e, [&](const std::string& name, const ImageU16& raw, DngImage image) {
    write_dng(e.file(name + ".dng"), raw, e.capture, image);
  });
}

void export_png16(const Export& e) {
  each_raw(e, [&](const std::string& name, const ImageU16& raw, DngImage) {
    write_png16(e.file(name + ".png"), levels(normalized(raw, e.capture.exposure)));
  });
}

void export_exr(const Export& e) {
  each_raw(e, [&](const std::string& name, const ImageU16& raw, DngImage) {
    const Image image = normalized(raw, e.capture.exposure);
    write_exr(e.file(name + ".exr"), {{"Y", &image}}, false);
  });
}

void export_npy(const Export& e) {
  each_raw(e, [&](const std::string& name, const ImageU16& raw, DngImage) {
    write_npy(e.file(name + ".npy"), normalized(raw, e.capture.exposure));
  });
  if (!e.capture.truth) return;
  const Truth& truth = *e.capture.truth;
  const std::vector<std::pair<const char*, const Image*>> maps = {{"depth_m", &truth.depth_m},
                                                                  {"blur_px", &truth.blur_px},
                                                                  {"disparity_dp_px", &truth.disparity_dp_px},
                                                                  {"person", &truth.person_mask},
                                                                  {"all_in_focus", &truth.all_in_focus},
                                                                  {"photograph", &truth.photograph}};
  for (const auto& [name, image] : maps) write_npy(e.file(fmt::format("truth/{}.npy", name)), *image);
  for (std::size_t i = 0; i < truth.motion.size(); ++i) {
    write_npy(e.file(fmt::format("truth/motion_{:03}.npy", i + 1)), truth.motion[i]);
  }
}

void export_dpdd(const Export& e) {
  e.truth();  // must be there
  const datasets::DpddPictures pictures = datasets::dpdd_pictures(e.capture);
  const auto write = [&](const char* kind, const Image& linear) {
    write_png16(e.file(fmt::format("{}/{}.png", kind, e.name)), levels(srgb(linear)), true);
  };
  write("inputL", pictures.left);
  write("inputR", pictures.right);
  write("inputC", pictures.combined);
  write("target", pictures.target);
}

void export_google_dp(const Export& e) {
  datasets::require_google(e.capture.camera, printable(e.source));
  e.mosaic(), e.truth();  // must be there
  datasets::write_google(e.capture, [&](const datasets::GoogleFile& to) {
    return e.file(fmt::format("{}/{}/{}", to.folder, e.name, to.file));
  });
}

void export_rgbd(const Export& e) {
  const Capture& capture = e.capture;
  const auto path = [&](const char* kind, const char* ending) {
    return e.file(fmt::format("{}/{}.{}", kind, e.name, ending));
  };
  const Image rgb = developed(normalized(e.mosaic(), capture.exposure), capture);
  write_png16(path("rgb", "png"), levels(srgb(rgb)), true);
  write_exr(path("depth", "exr"), {{"Y", &e.truth().depth_m}}, false);
  write_png16(path("left", "png"), levels(scaled(normalized(capture.frames[0].left, capture.exposure), 2)));
  write_png16(path("right", "png"), levels(scaled(normalized(capture.frames[0].right, capture.exposure), 2)));
}

struct Format {
  void (*write)(const Export&);
  const char* meaning;  ///< shown in export.json and in the help
};
const std::map<std::string, Format> kFormats = {
    {"dng", {export_dng, "every frame's mosaic and views as Digital Negatives; digital numbers"}},
    {"png16", {export_png16, "every frame's mosaic and views; linear, 0 black, 65535 white"}},
    {"exr", {export_exr, "every frame's mosaic and views, channel Y; linear, 0 black, 1 white"}},
    {"npy", {export_npy, "NumPy float32: every frame's mosaic and views, linear, 0 black, 1 white; maps of truth/"}},
    {"dpdd",
     {export_dpdd,
      "the first frame as inputL, inputR, inputC and target, 16-bit sRGB: views times 2; gray at half size unless "
      "dense"}},
    {"google-dp",
     {export_google_dp,
      "the first frame as raw_left_pd, raw_right_pd (10 bits times 16), scaled_images, merged_depth (8 bits d: 20 / "
      "(100 "
      "- 99.8 d / 255) m), merged_conf; turned clockwise"}},
    {"rgbd",
     {export_rgbd,
      "the first frame as rgb (16-bit sRGB), depth (EXR, channel Y, m), left and right (16-bit linear, times 2)"}}};

void run(const ExportOptions& options) {
  NewFolder folder(options.output, "export.json");
  const Capture capture = read_capture(options.capture, true);
  require_views(capture, options.capture);
  const fs::path source = fs::absolute(options.capture).lexically_normal();
  const std::string name = (source.has_filename() ? source : source.parent_path()).filename().string();
  const Format& format = kFormats.at(options.format);
  format.write({capture, options.capture, name, folder.path()});
  const nlohmann::ordered_json about = {
      {"format", "dualpixel-export"}, {"version", 1},    {"layout", options.format},
      {"meaning", format.meaning},    {"capture", name}, {"provenance", to_json(capture.provenance, options.capture)}};
  write_file(folder.path() + "/export.json",
             about.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  folder.commit();
}

}  // namespace

void add_export(CLI::App& program) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command = program.add_subcommand("export", "Write a capture as other software reads it");
  command->add_option("capture", options->capture, "Capture folder")->required()->type_name("CAPTURE_DIR");
  command->add_option("-o,--output", options->output, "Folder to write")->required()->type_name("DIR");
  std::vector<std::string> names;
  std::string list = "Formats:\n";
  for (const auto& [name, format] : kFormats) {
    names.push_back(name);
    list += fmt::format("  {:<10} {}\n", name, format.meaning);
  }
  command->add_option("--format", options->format, "One of those below")->required()->check(CLI::IsMember(names));
  add_threads_option(*command);
  command->footer(list + "Example:\n  dualpixel export out/capture -o out/dng --format dng");
  command->callback([options] { run(*options); });
}

}  // namespace dualpixel::tools
