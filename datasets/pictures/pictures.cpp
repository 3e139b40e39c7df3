#include "datasets/pictures/pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "capture/color_filter_array.h"
#include "capture/error.h"
#include "capture/folder/capture_files.h"
#include "capture/image/image_io.h"
#include "capture/image/npy.h"
#include "datasets/pictures/developed.h"
#include "datasets/pictures/google.h"

namespace dualpixel::datasets {
namespace {

Image left_view(const Capture& c) { return normalized(c.frames.front().left, c.exposure); }
Image right_view(const Capture& c) { return normalized(c.frames.front().right, c.exposure); }
Image sum_of_views(const Capture& c) {
  Image sum = left_view(c);
  const Image other = right_view(c);
  for (std::size_t i = 0; i < sum.data.size(); ++i) sum.data[i] += other.data[i];
  return sum;
}
Image mosaic_signal(const Capture& c) { return normalized(c.frames.front().mosaic, c.exposure); }

Image object_ids(const Capture& c) {
  Image ids(c.camera.width_px, c.camera.height_px);
  std::copy(c.truth->object_id.data.begin(), c.truth->object_id.data.end(), ids.data.begin());
  return ids;
}

template <Image Truth::*member>
Image of_truth(const Capture& c) {
  return *c.truth.*member;
}

/// Each DP pixel takes the photosite below and to the right of its center: a value that some ray has, never a mean
/// across an edge. It is half a photosite off the center; of dense captures it is the photosite itself.
Image on_views(const Image& map, const Camera& camera) {
  Image result(camera.dp_width(), camera.dp_height(), map.channels);
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) {
      const int from_x = x * camera.dp_downsample_x + camera.dp_downsample_x / 2;
      const int from_y = y * camera.dp_downsample_y + camera.dp_downsample_y / 2;
      for (int c = 0; c < map.channels; ++c) result.at(x, y, c) = map.at(from_x, from_y, c);
    }
  }
  return result;
}

template <Image Truth::*member>
Image of_truth_on_views(const Capture& c) {
  return on_views(*c.truth.*member, c.camera);
}
Image object_ids_on_views(const Capture& c) { return on_views(object_ids(c), c.camera); }

/// What the DP pixels would read without the sensor's noise: as sensor.h reads them, the mean of a block's green
/// photosites, or of dense captures the photosite under its own filter.
Image noiseless_view(const Image& truth, const Capture& capture) {
  const Camera& camera = capture.camera;
  const Image rgb = camera_colors(truth, capture.exposure);
  const ColorFilterArray cfa = value_named(kColorFilterArrays, camera.cfa, "cfa");
  const bool dense = camera.dp_downsample_x * camera.dp_downsample_y == 1;
  Image view(camera.dp_width(), camera.dp_height());
  Image count(camera.dp_width(), camera.dp_height());
  for (int y = 0; y < rgb.height; ++y) {
    for (int x = 0; x < rgb.width; ++x) {
      const int color = cfa.color(x, y);
      if (!dense && color != 1) continue;
      const int to_x = x / camera.dp_downsample_x, to_y = y / camera.dp_downsample_y;
      view.at(to_x, to_y) +=
          std::max(rgb.at(x, y, color), 0.0f) / static_cast<float>(capture.exposure.white_balance[color]);
      count.at(to_x, to_y) += 1;
    }
  }
  for (std::size_t i = 0; i < view.data.size(); ++i) view.data[i] /= count.data[i];
  return view;
}
Image left_noiseless_view(const Capture& c) { return noiseless_view(c.truth->left, c); }
Image right_noiseless_view(const Capture& c) { return noiseless_view(c.truth->right, c); }

constexpr int kDpddPictures = 4, kDpddBytes = 3 * 2;

constexpr const char* kDpddFiles[] = {"source_c.png", "source_l.png", "source_r.png", "target.png"};

/// No NaN may reach a training set.
void require_finite(const Image& image, const std::string& name, bool infinite = false) {
  const auto good = [&](float value) { return std::isfinite(value) || (infinite && value > 0); };
  if (std::all_of(image.data.begin(), image.data.end(), good)) return;
  throw InputError(name + ": a value is not finite");
}

void write_dpdd(const Capture& capture, const std::string& folder) {
  require_finite(capture.truth->all_in_focus, kDpddFiles[3]);  // before infinity is clipped to white
  const DpddPictures p = dpdd_pictures(capture);
  const Image* pictures[] = {&p.combined, &p.left, &p.right, &p.target};
  for (std::size_t i = 0; i < std::size(kDpddFiles); ++i) {
    require_finite(*pictures[i], kDpddFiles[i]);
    write_png16(folder + "/" + kDpddFiles[i], levels(srgb(*pictures[i])), true);
  }
}

void write_google_files(const Capture& capture, const std::string& folder) {
  require_finite(capture.truth->depth_m, "depth_m", true);
  require_finite(capture.truth->valid, "valid");
  write_google(capture, [&](const GoogleFile& file) { return folder + "/" + file.file; });
}

void write_exr_picture(const std::string& path, const Image& image) {
  if (image.channels == 1) return write_exr(path, {{"Y", &image}}, false);
  write_exr(path, {{"R", &image, 0}, {"G", &image, 1}, {"B", &image, 2}}, false);
}

}  // namespace

const std::vector<PictureKind>& pictures() {
  constexpr Grid kSensor = Grid::sensor, kViews = Grid::views;
  static const std::vector<PictureKind> all = {
      {"left", kViews, 1, left_view, "left view with the sensor's noise, 0 black, 1 white"},
      {"right", kViews, 1, right_view, "right view, likewise"},
      {"combined", kViews, 1, sum_of_views, "left + right"},
      {"raw", kSensor, 1, mosaic_signal, "Bayer mosaic (RGGB) with the sensor's noise, 0 black, 1 white"},
      {"left_noiseless", kViews, 1, left_noiseless_view, "what `left` would be without the sensor's noise"},
      {"right_noiseless", kViews, 1, right_noiseless_view, "what `right` would be"},
      {"left_rgb", kSensor, 3, of_truth<&Truth::left>, "left view of each photosite, noiseless, white balanced"},
      {"right_rgb", kSensor, 3, of_truth<&Truth::right>, "right view, likewise"},
      {"all_in_focus", kSensor, 3, of_truth<&Truth::all_in_focus>, "through a pinhole, noiseless, white balanced"},
      {"photograph", kSensor, 3, of_truth<&Truth::photograph>, "through the wider aperture, likewise"},
      {"depth_m", kSensor, 1, of_truth<&Truth::depth_m>, "planar depth from the entrance pupil, m; inf: nothing", true},
      {"blur_px", kSensor, 1, of_truth<&Truth::blur_px>, "signed blur diameter, photosites"},
      {"disparity_dp_px", kSensor, 1, of_truth<&Truth::disparity_dp_px>, "disparity, DP pixels"},
      {"normal", kSensor, 3, of_truth<&Truth::normal>, "unit normal, camera axes: x right, y down, z forward"},
      {"person", kSensor, 1, of_truth<&Truth::person_mask>, "share of the photosite that people cover"},
      {"valid", kSensor, 1, of_truth<&Truth::valid>, "1 where the ray hit something"},
      {"object_id", kSensor, 1, object_ids, "1-based index of the glTF node; 0: nothing"},
      {"view_depth_m", kViews, 1, of_truth_on_views<&Truth::depth_m>, "depth_m at the views' pixels", true},
      {"view_blur_px", kViews, 1, of_truth_on_views<&Truth::blur_px>, "blur_px, likewise (photosites)"},
      {"view_disparity_dp_px", kViews, 1, of_truth_on_views<&Truth::disparity_dp_px>, "disparity_dp_px, likewise"},
      {"view_normal", kViews, 3, of_truth_on_views<&Truth::normal>, "normal, likewise"},
      {"view_person", kViews, 1, of_truth_on_views<&Truth::person_mask>, "person, likewise"},
      {"view_valid", kViews, 1, of_truth_on_views<&Truth::valid>, "valid, likewise"},
      {"view_object_id", kViews, 1, object_ids_on_views, "object_id, likewise"},
  };
  return all;
}

std::uint64_t picture_bytes(const Camera& camera, Layout layout, const std::vector<std::string>& keep) {
  const std::uint64_t sensor = std::uint64_t{1} * camera.width_px * camera.height_px;
  const std::uint64_t views = std::uint64_t{1} * camera.dp_width() * camera.dp_height();
  if (layout == Layout::dpdd) {
    const bool dense = camera.dp_downsample_x * camera.dp_downsample_y == 1;
    return kDpddPictures * kDpddBytes * (dense ? sensor : sensor / 4);
  }
  if (layout == Layout::google) {
    require_google(camera, "/sensor/dp_downsample_x, dp_downsample_y: 1 x 1");
    constexpr int kSensorBytes = 3 + 1 + 2 * sizeof(float), kViewBytes = 2 * 2;
    return kSensorBytes * sensor + kViewBytes * views;
  }
  std::uint64_t bytes = 0;
  for (const std::string& name : keep) {
    const PictureKind& kind = *find_named(pictures(), name);
    bytes += sizeof(float) * kind.channels * (kind.grid == Grid::sensor ? sensor : views);
  }
  return bytes;
}

std::vector<std::string> picture_files(Layout layout, const std::vector<std::string>& keep) {
  if (layout == Layout::dpdd) return {std::begin(kDpddFiles), std::end(kDpddFiles)};
  std::vector<std::string> names;
  if (layout == Layout::google) {
    for (const GoogleFile& file : kGoogleFiles) names.emplace_back(file.file);
  }
  for (const std::string& name : keep) names.push_back(name + "." + name_of(kLayouts, layout));
  return names;
}

void write_pictures(const Capture& capture, Layout layout, const std::vector<std::string>& keep,
                    const std::string& folder) {
  if (layout == Layout::dpdd) return write_dpdd(capture, folder);
  if (layout == Layout::google) return write_google_files(capture, folder);
  const std::vector<std::string> files = picture_files(layout, keep);
  std::vector<FileTask> tasks;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    tasks.push_back([&, path = folder + "/" + files[i], kind = find_named(pictures(), keep[i])] {
      const Image image = kind->make(capture);
      require_finite(image, kind->name, kind->infinite);
      layout == Layout::exr ? write_exr_picture(path, image) : write_npy(path, image);
    });
  }
  run_parallel(tasks);
}

}  // namespace dualpixel::datasets
