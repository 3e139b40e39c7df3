#include "evaluation/comparison/compare_methods.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "capture/image/resample.h"
#include "capture/json_fields.h"
#include "capture/names.h"
#include "evaluation/baselines/bilateral_space_stereo.h"
#include "evaluation/experiments/defocus_baselines.h"
#include "evaluation/metrics/flip.h"
#include "evaluation/metrics/image_metrics.h"
#include "evaluation/metrics/mask_metrics.h"
#include "evaluation/metrics/photograph_disparity.h"
#include "pipeline/burst/merge.h"
#include "pipeline/defocus/defocused.h"
#include "pipeline/defocus/mask_blur.h"
#include "pipeline/defocus/match_lens.h"
#include "pipeline/defocus/methods.h"
#include "pipeline/portrait/run_portrait.h"

namespace dualpixel::evaluation {
namespace {

using Json = nlohmann::ordered_json;
using pipeline::FoundPeople;
using pipeline::Mode;
using pipeline::PortraitOptions;
using pipeline::PortraitResult;

constexpr int kReferences = 2;     // true disparity, not blurred: beside the methods, and in no ranking
constexpr double kEqual_db = 100;  // for a picture without an error, whose ratio is infinite

struct Linear {
  std::vector<Image> pictures;  ///< as compared_methods(), and the references
  FoundPeople people;
  bool by_stated_face = false;
};

Image shen(const Image& picture, const FoundPeople& people) {
  const pipeline::DefocusMethod& uniform = *find_named(defocus_baselines(), "mask and uniform blur");
  pipeline::DefocusOptions options;
  options.mask_blur = pipeline::blur_for_face(people.faces[0].width, picture.width);
  const Image mask = people.mask.width > picture.width ? resize_area(people.mask, picture.width, picture.height)
                                                       : resize_bilinear(people.mask, picture.width, picture.height);
  const Image no_disparity;
  return uniform.render({picture, no_disparity, mask, {}}, options).rgb;
}

Image blurred_by(const Image& disparity, const Image& picture, const Camera& camera, double pupil_mm) {
  const Image no_mask;
  return pipeline::defocus_method_named("layers")
      .render({picture, disparity, no_mask, pipeline::match_lens(camera, pupil_mm, 0)}, {})
      .rgb;
}

Image barron(const Image& picture, const Capture& shot, double pupil_mm) {
  const pipeline::MergedBurst burst = pipeline::align_and_merge(shot.frames, shot.exposure, {});
  return blurred_by(bilateral_space_stereo(burst.left, burst.right, picture), picture, shot.camera, pupil_mm);
}

/// Those of the faces that are detected; where there is nobody, of the face that the camera states.
FoundPeople find(const Image& picture, const std::vector<pipeline::Face>& stated, const pipeline::SeedOptions& options,
                 pipeline::PersonNetwork& network, bool& by_stated_face) {
  FoundPeople found = pipeline::find_people(picture, {}, network, options);
  by_stated_face = !anybody_seen(found) && !stated.empty();
  return by_stated_face ? pipeline::find_people(picture, stated, network, options) : found;
}

Linear pictures_of(const Capture& capture, double pupil_mm, pipeline::PersonNetwork& network) {
  Capture shot = capture;
  shot.truth.reset();
  shot.face_px.reset();  // find() has it
  std::vector<pipeline::Face> stated;
  if (capture.face_px) {
    const std::array<double, 4>& face = *capture.face_px;
    stated.push_back({face[0], face[1], face[2], face[3]});
  }
  std::optional<FoundPeople> people;
  Linear linear;
  PortraitOptions options;
  options.match_pupil_mm = pupil_mm;
  options.synthetic_noise = false;
  options.find_people = [&](const Image& picture, const std::vector<pipeline::Face>&) {
    if (!people) people = find(picture, stated, options.seed_faces, network, linear.by_stated_face);
    return *people;
  };
  const auto run = [&](Mode mode) {
    options.mode = mode;
    return run_portrait(shot, options);
  };
  PortraitResult both = run(Mode::dp_seg);
  const PortraitResult seg = run(Mode::seg);
  PortraitResult dp = run(Mode::dp);
  const bool found = seg.mode == Mode::seg;
  const Image& input = dp.input;
  linear.pictures = {std::move(both.portrait),
                     found ? seg.portrait : input,
                     std::move(dp.portrait),
                     found ? shen(input, *people) : input,
                     barron(input, shot, pupil_mm),
                     blurred_by(photograph_disparity(capture), input, shot.camera, pupil_mm),
                     input};
  if (found) linear.people = *people;
  return linear;
}

PictureFigures figures_of(const Image& picture, const Image& photograph) {
  return {std::min(psnr_db(picture, photograph).value_or(kEqual_db), kEqual_db), ssim(picture, photograph).value_or(0),
          mean_flip(photograph, picture)};
}

PictureFigures crop_figures(const Image& picture, const Image& photograph, const std::vector<Crop>& crops) {
  PictureFigures mean;
  double square = 0;
  for (const Crop& crop : crops) {
    const PictureFigures one = figures_of(cropped(picture, crop), cropped(photograph, crop));
    const auto share = 1.0 / static_cast<double>(crops.size());
    square += share * std::pow(10, -one.psnr_db / 10);
    mean.ssim += share * one.ssim;
    mean.flip += share * one.flip;
  }
  mean.psnr_db = -10 * std::log10(square);
  return mean;
}

Json to_json(const PictureFigures& figures) {
  return {{"psnr_db", figures.psnr_db}, {"ssim", figures.ssim}, {"flip", figures.flip}};
}

PictureFigures read_figures(Fields fields) {
  PictureFigures figures;
  fields.required("psnr_db").number("psnr_db", figures.psnr_db, 0, kEqual_db);
  fields.required("ssim").number("ssim", figures.ssim, -1, 1);
  fields.required("flip").number("flip", figures.flip, 0, 1);
  fields.done();
  return figures;
}

}  // namespace

std::vector<std::string> compared_methods() { return {"dp+seg", "seg", "dp", "Shen et al.", "Barron et al."}; }

std::vector<std::string> compared_names() {
  std::vector<std::string> names = compared_methods();
  names.insert(names.end(), {"true disparity", "not blurred"});
  return names;
}

ComparedPictures compare_methods(const Capture& capture, const std::string& name, pipeline::PersonNetwork& network) {
  const Truth& truth = *capture.truth;
  const double pupil_mm = truth.photograph_aperture_scale * capture.camera.focal_length_mm / capture.camera.f_number;
  const Linear linear = pictures_of(capture, pupil_mm, network);

  ComparedPictures compared;
  SceneComparison& figures = compared.figures;
  figures.scene = name;
  const std::vector<float>& person = truth.person_mask.data;
  figures.shows_people = std::any_of(person.begin(), person.end(), [](float share) { return share > 0.5f; });
  const Image& mask = linear.people.mask;
  figures.found_people = !mask.empty();
  figures.by_stated_face = figures.found_people && linear.by_stated_face;
  if (figures.found_people && figures.shows_people) {
    figures.mask_iou = mask_iou(mask, resize_area(truth.person_mask, mask.width, mask.height));
  }
  compared.photograph_srgb = displayed(clipped(truth.photograph));
  for (const Image& picture : linear.pictures) compared.pictures_srgb.push_back(displayed(clipped(picture)));
  const std::vector<Image> five(compared.pictures_srgb.begin(), compared.pictures_srgb.end() - kReferences);
  figures.crops = crops_that_differ(five, truth.person_mask);
  const std::vector<std::string> names = compared_names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Image& picture = compared.pictures_srgb[i];
    figures.methods.push_back({names[i], figures_of(picture, compared.photograph_srgb),
                               crop_figures(picture, compared.photograph_srgb, figures.crops)});
  }
  return compared;
}

Json to_json(const SceneComparison& scene) {
  Json json = {{"scene", scene.scene},
               {"shows_people", scene.shows_people},
               {"found_people", scene.found_people},
               {"by_stated_face", scene.by_stated_face},
               {"mask_iou", scene.mask_iou},
               {"crops", Json::array()},
               {"methods", Json::array()}};
  for (const Crop& crop : scene.crops) json["crops"].push_back({{"x", crop.x}, {"y", crop.y}, {"side", crop.side}});
  for (const MethodFigures& method : scene.methods) {
    json["methods"].push_back(
        {{"method", method.method}, {"whole", to_json(method.whole)}, {"crops", to_json(method.crops)}});
  }
  return json;
}

SceneComparison read_scene_comparison(const std::string& path) {
  constexpr int kMost_px = 1 << 16;
  const nlohmann::json json = read_json_file(path);
  Fields fields(json, path);
  SceneComparison scene;
  fields.required("scene").text("scene", scene.scene);
  fields.required("shows_people").boolean("shows_people", scene.shows_people);
  fields.required("found_people").boolean("found_people", scene.found_people);
  fields.required("by_stated_face").boolean("by_stated_face", scene.by_stated_face);
  fields.required("mask_iou").number("mask_iou", scene.mask_iou, 0, 1);
  for (Fields& crop : fields.objects("crops")) {
    Crop& read = scene.crops.emplace_back();
    crop.required("x").integer("x", read.x, 0, kMost_px);
    crop.required("y").integer("y", read.y, 0, kMost_px);
    crop.required("side").integer("side", read.side, 1, kMost_px);
    crop.done();
  }
  for (Fields& method : fields.objects("methods")) {
    MethodFigures& read = scene.methods.emplace_back();
    method.required("method").text("method", read.method);
    read.whole = read_figures(method.required("whole").object("whole"));
    read.crops = read_figures(method.required("crops").object("crops"));
    method.done();
  }
  if (scene.methods.size() != compared_methods().size() + kReferences) fields.fail("methods", "must be seven");
  fields.done();
  return scene;
}

}  // namespace dualpixel::evaluation
