#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/image_io.h"
#include "capture/image/read_mask.h"
#include "capture/image/resample.h"
#include "evaluation/metrics/mask_metrics.h"
#include "evaluation/metrics/score_people.h"
#include "evaluation/report/report_assets.h"
#include "evaluation/report/report_images.h"
#include "evaluation/report/report_page.h"
#include "pipeline/edge_aware/filter_mask.h"
#include "pipeline/edge_aware/guide.h"
#include "pipeline/segmentation/person_mask.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kWorst = 20;
constexpr int kThumbnail_px = 360;

struct Command {
  std::string images, masks, people, weights, output;
  bool bf16 = false;
};

struct Portrait {
  std::string name;
  std::string image, mask;  ///< paths
  std::size_t faces = 0;
  // At the picture's size: the network's mask enlarged, and after edge-aware filtering.
  double iou = 0, filtered_iou = 0;
  // At the network's size, of the same two.
  double gradient_error = 0, filtered_gradient_error = 0;
};

/// The regular files of a folder, by name.
std::vector<fs::path> files_of(const std::string& folder) {
  std::error_code error, unreadable;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(folder, error), end; entry != end; entry.increment(error)) {
    if (entry->is_regular_file(unreadable)) files.push_back(entry->path());  // a link to nowhere is none
  }
  if (error) throw InputError(printable(folder) + ": cannot be read as a folder: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

/// Every image with the mask of the same name, whatever their extensions.
std::vector<Portrait> portraits_of(const Command& command) {
  const std::vector<fs::path> masks = files_of(command.masks);
  std::vector<Portrait> portraits;
  for (const fs::path& image : files_of(command.images)) {
    const auto mask =
        std::find_if(masks.begin(), masks.end(), [&](const fs::path& path) { return path.stem() == image.stem(); });
    if (mask == masks.end()) {
      throw InputError(
          fmt::format("{}: {} holds no mask of that name", printable(image.string()), printable(command.masks)));
    }
    portraits.push_back({image.stem().string(), image.string(), mask->string()});
  }
  if (portraits.empty()) throw InputError(printable(command.images) + ": holds no pictures");
  return portraits;
}

/// Linear, one or three channels. EXR and HDR files are linear as they stand, all others are taken for sRGB.
Image read_linear(const std::string& path) {
  const std::string format = picture_size(path).format;
  const Image stored = read_image(path);
  Image picture(stored.width, stored.height, stored.channels < 3 ? 1 : 3);
  for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
    for (int c = 0; c < picture.channels; ++c) {
      const float value = stored.data[i * stored.channels + c];
      picture.data[i * picture.channels + c] = format == "openexr" || format == "hdr" ? value : linear_from_srgb(value);
    }
  }
  return picture;
}

Image read_true_mask(const std::string& path, const Image& picture) {
  Image mask = read_mask(path);
  if (!mask.same_size(picture)) {
    throw InputError(fmt::format("{}: {} x {} pixels; its picture has {} x {}", printable(path), mask.width,
                                 mask.height, picture.width, picture.height));
  }
  return mask;
}

struct Scored {
  Image picture, truth, filtered;
};

/// Measures one portrait. Where no face is found the mask is empty.
Scored score(Portrait& portrait, pipeline::PersonNetwork& network) {
  Scored scored;
  scored.picture = read_linear(portrait.image);
  scored.truth = read_true_mask(portrait.mask, scored.picture);
  const int width = scored.picture.width, height = scored.picture.height;
  const pipeline::FoundPeople found = pipeline::find_people(scored.picture, {}, network);
  portrait.faces = found.faces.size();
  if (found.faces.empty()) {
    scored.filtered = Image(width, height);
    portrait.iou = portrait.filtered_iou = evaluation::mask_iou(scored.filtered, scored.truth);
    return scored;
  }
  Image rgb = scored.picture;
  if (rgb.channels == 1) {
    rgb = Image(width, height, 3);
    for (std::size_t i = 0; i < rgb.data.size(); ++i) rgb.data[i] = scored.picture.data[i / 3];
  }
  scored.filtered = pipeline::filter_mask(found.mask, pipeline::encode_guide(rgb, pipeline::guide_gain(rgb)));
  const bool smaller = width < found.mask.width;
  portrait.iou = evaluation::mask_iou(
      smaller ? resize_area(found.mask, width, height) : resize_bilinear(found.mask, width, height), scored.truth);
  portrait.filtered_iou = evaluation::mask_iou(scored.filtered, scored.truth);
  const Image small_truth = resize_area(scored.truth, found.mask.width, found.mask.height);
  portrait.gradient_error = evaluation::mask_gradient_error(found.mask, small_truth);
  portrait.filtered_gradient_error =
      evaluation::mask_gradient_error(resize_area(scored.filtered, found.mask.width, found.mask.height), small_truth);
  return scored;
}

/// The picture in grey, what the mask has too much in orange, what it lacks in blue.
std::string errors_uri(const Scored& scored) {
  const double scale = std::min(1.0, 1.0 * kThumbnail_px / std::max(scored.picture.width, scored.picture.height));
  const int width = std::max(1, static_cast<int>(scale * scored.picture.width));
  const int height = std::max(1, static_cast<int>(scale * scored.picture.height));
  const Image picture = evaluation::resized(scored.picture, width, height),
              truth = evaluation::resized(scored.truth, width, height);
  const Image filtered = evaluation::resized(scored.filtered, width, height);
  Image shown(width, height, 3);
  for (std::size_t i = 0; i < shown.pixel_count(); ++i) {
    const float grey = srgb_from_linear(picture.data[i * picture.channels + (picture.channels == 3 ? 1 : 0)]);
    const float error = filtered.data[i] - truth.data[i];
    const float amount = 0.8F * std::abs(error);
    const float orange[3] = {1, 0.5F, 0.1F}, blue[3] = {0.2F, 0.5F, 1};
    for (int c = 0; c < 3; ++c) {
      shown.data[3 * i + c] = grey * (1 - amount) + amount * (error > 0 ? orange[c] : blue[c]);
    }
  }
  return evaluation::jpeg_data_uri(shown);
}

constexpr const char* kPageStyle = ".plots { display: flex; flex-wrap: wrap; gap: 1rem; } td { text-align: right; }";

/// The indices of the twenty lowest values, lowest first.
std::vector<std::size_t> worst_of(const std::vector<double>& iou) {
  std::vector<std::size_t> order(iou.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return iou[a] < iou[b]; });
  order.resize(std::min(order.size(), kWorst));
  return order;
}

std::string figure(const Scored& scored, const std::string& name, const std::string& caption) {
  return fmt::format("<figure><img src=\"{}\" alt=\"\"><figcaption><b>{}</b> {}</figcaption></figure>",
                     errors_uri(scored), evaluation::escape_html(printable(name)), evaluation::escape_html(caption));
}

/// segmentation.json and segmentation.html; `body` comes before the worst.
void write_results(const std::string& output, const nlohmann::ordered_json& json, const std::string& body,
                   const std::string& worst) {
  NewFolder out(output, "segmentation.json");
  write_file(out.path() + "/segmentation.json", json.dump(2) + "\n");
  write_file(out.path() + "/segmentation.html",
             evaluation::html_page(
                 "Person masks", std::string(evaluation::kReportStyle) + kPageStyle,
                 "<h1>Person masks against true ones</h1>" + body +
                     "<h2>The worst</h2><p>After edge-aware filtering. Orange: too much; blue: lacking.</p><div "
                     "class=\"plots\">" +
                     worst + "</div>"));
  out.commit();
}

struct Means {
  std::size_t count = 0, without_face = 0;
  double iou = 0, filtered_iou = 0;              ///< over all
  double iou_found = 0, filtered_iou_found = 0;  ///< over those with a face, as the following; 0 of none
  double gradient_error = 0, filtered_gradient_error = 0;
};

Means means_of(const std::vector<Portrait>& portraits) {
  Means means;
  means.count = portraits.size();
  for (const Portrait& p : portraits) {
    means.without_face += p.faces == 0 ? 1 : 0;
    means.iou += p.iou;
    means.filtered_iou += p.filtered_iou;
    if (p.faces == 0) continue;
    means.iou_found += p.iou;
    means.filtered_iou_found += p.filtered_iou;
    means.gradient_error += p.gradient_error;
    means.filtered_gradient_error += p.filtered_gradient_error;
  }
  const auto all = static_cast<double>(means.count);
  const double found = std::max(1.0, all - static_cast<double>(means.without_face));
  for (double* sum : {&means.iou, &means.filtered_iou}) *sum /= all;
  for (double* sum :
       {&means.iou_found, &means.filtered_iou_found, &means.gradient_error, &means.filtered_gradient_error}) {
    *sum /= found;
  }
  return means;
}

void run_pictures(const Command& command, pipeline::PersonNetwork& network, const std::string& weights_hash) {
  std::vector<Portrait> portraits = portraits_of(command);
  Progress bar("segmentation");
  for (std::size_t i = 0; i < portraits.size(); ++i) {
    score(portraits[i], network);
    bar(static_cast<double>(i + 1) / static_cast<double>(portraits.size()));
  }
  const Means means = means_of(portraits);
  fmt::print("{:<34}{:>12}{:>12}\n", "", "network", "filtered");
  fmt::print("{:<34}{:12.4f}{:12.4f}\n", fmt::format("mean IoU, {} pictures", means.count), means.iou,
             means.filtered_iou);
  const std::size_t found = means.count - means.without_face;
  if (found > 0) {
    fmt::print("{:<34}{:12.4f}{:12.4f}\n", fmt::format("... where a face was found, {}", found), means.iou_found,
               means.filtered_iou_found);
    fmt::print("{:<34}{:12.6f}{:12.6f}\n", "gradient error there", means.gradient_error, means.filtered_gradient_error);
  } else {
    fmt::print("no face was found\n");
  }
  if (command.output.empty()) return;

  nlohmann::ordered_json json = {{"format", "dualpixel-experiment-segmentation"},
                                 {"version", 1},
                                 {"person_weights_hash", weights_hash},
                                 {"person_network", command.bf16 ? "bf16" : "f32"},
                                 {"count", means.count},
                                 {"without_face", means.without_face},
                                 {"mean_iou", means.iou},
                                 {"mean_iou_filtered", means.filtered_iou}};
  if (found > 0) {
    json["mean_iou_where_found"] = means.iou_found;
    json["mean_iou_filtered_where_found"] = means.filtered_iou_found;
    json["gradient_error"] = means.gradient_error;
    json["gradient_error_filtered"] = means.filtered_gradient_error;
  }
  json["pictures"] = nlohmann::ordered_json::array();
  std::vector<double> iou;
  for (const Portrait& p : portraits) {
    iou.push_back(p.filtered_iou);
    nlohmann::ordered_json picture = {
        {"name", printable(p.name)}, {"faces", p.faces}, {"iou", p.iou}, {"iou_filtered", p.filtered_iou}};
    if (p.faces > 0) {
      picture["gradient_error"] = p.gradient_error;
      picture["gradient_error_filtered"] = p.filtered_gradient_error;
    }
    json["pictures"].push_back(std::move(picture));
  }
  std::string body =
      fmt::format("<p>{} pictures, {} without a face. Mean IoU {:.4f}, {:.4f} after edge-aware filtering", means.count,
                  means.without_face, means.iou, means.filtered_iou);
  if (found > 0) {
    body += fmt::format("; {:.4f} and {:.4f} where a face was found. Gradient error there {:.6f}, {:.6f} filtered",
                        means.iou_found, means.filtered_iou_found, means.gradient_error, means.filtered_gradient_error);
  }
  body += ".</p>";
  std::string worst;
  for (const std::size_t i : worst_of(iou)) {
    Portrait& p = portraits[i];
    worst += figure(score(p, network), p.name,
                    fmt::format("IoU {:.3f} after filtering, {:.3f} before, faces {}", p.filtered_iou, p.iou, p.faces));
  }
  write_results(command.output, json, body, worst);
}

void run_people(const Command& command, pipeline::PersonNetwork& network, const std::string& weights_hash) {
  const scenes::PeopleSet set({command.people}, true);
  scenes::require_unchanged(command.people);
  Progress bar("segmentation");
  const evaluation::PeopleScores scores = evaluation::score_people(set, network, [&](double done) { bar(done); });
  nlohmann::ordered_json json = {{"format", "dualpixel-experiment-segmentation-people"},
                                 {"version", 1},
                                 {"people_hash", set.hash()},
                                 {"person_weights_hash", weights_hash},
                                 {"person_network", command.bf16 ? "bf16" : "f32"},
                                 {"samples", nlohmann::ordered_json::array()},
                                 {"regions", nlohmann::ordered_json::array()}};
  std::string table =
      "<table><tr><th></th><th>samples</th><th>IoU</th><th>standard error</th><th>filtered</th><th>no face channel</th>"
      "<th>gradient error</th><th>filtered</th></tr>";
  fmt::print("{:<20}{:>8}{:>9} +- {:<6}{:>8}{:>10}{:>12}{:>12}\n", "", "samples", "IoU", "error", "filtered", "no face",
             "grad. err.", "filtered");
  for (const evaluation::PeopleRow& row : scores.samples) {
    const std::string error = std::isnan(row.iou_error) ? "-" : fmt::format("{:.4f}", row.iou_error);
    fmt::print("{:<20}{:8}{:9.4f} +- {:<6}{:8.4f}{:10.4f}{:12.6f}{:12.6f}\n", row.name, row.samples, row.iou, error,
               row.filtered_iou, row.iou_without_face, row.gradient_error, row.filtered_gradient_error);
    table += fmt::format(
        "<tr><th>{}</th><td>{}</td><td>{:.4f}</td><td>{}</td><td>{:.4f}</td><td>{:.4f}</td><td>{:.6f}</td>"
        "<td>{:.6f}</td></tr>",
        evaluation::escape_html(printable(row.name)), row.samples, row.iou, error, row.filtered_iou,
        row.iou_without_face, row.gradient_error, row.filtered_gradient_error);
    json["samples"].push_back({{"name", printable(row.name)},
                               {"samples", row.samples},
                               {"iou", row.iou},
                               {"iou_standard_error", row.iou_error},
                               {"iou_filtered", row.filtered_iou},
                               {"iou_without_face_channel", row.iou_without_face},
                               {"gradient_error", row.gradient_error},
                               {"gradient_error_filtered", row.filtered_gradient_error}});
  }
  for (const evaluation::PeopleRow& row : scores.regions) {
    fmt::print("{:<20}{:8}{:>37}{:12.6f}{:12.6f}\n", "near " + row.name, row.samples, "", row.gradient_error,
               row.filtered_gradient_error);
    table += fmt::format(
        "<tr><th>near {}</th><td>{}</td><td></td><td></td><td></td><td></td><td>{:.6f}</td><td>{:.6f}</td></tr>",
        row.name, row.samples, row.gradient_error, row.filtered_gradient_error);
    json["regions"].push_back({{"name", row.name},
                               {"samples", row.samples},
                               {"gradient_error", row.gradient_error},
                               {"gradient_error_filtered", row.filtered_gradient_error}});
  }
  if (command.output.empty()) return;
  std::string worst;
  for (const std::size_t i : worst_of(scores.filtered_iou)) {
    const Scored scored{evaluation::picture_of(set[i]), evaluation::mask_of(set[i]),
                        evaluation::filtered_mask_of(set[i], network)};
    worst +=
        figure(scored, std::to_string(i),
               fmt::format("IoU {:.3f} after filtering; {}", scores.filtered_iou[i], fmt::join(set[i].tags, ", ")));
  }
  write_results(command.output, json, table + "</table>", worst);
}

void run(const Command& command) {
  if (command.people.empty() == (command.images.empty() || command.masks.empty())) {
    throw InputError("experiment segmentation: needs --images and --masks, or --people");
  }
  const pipeline::NetworkWeights weights =
      command.weights.empty() ? pipeline::built_in_weights() : pipeline::read_weights(command.weights);
  pipeline::PersonNetwork network(weights, 1, command.bf16 ? pipeline::Precision::bf16 : pipeline::Precision::f32);
  if (!command.output.empty()) const NewFolder writable(command.output, "segmentation.json");  // before the work
  if (command.people.empty()) {
    run_pictures(command, network, weights.file_hash);
  } else {
    run_people(command, network, weights.file_hash);
  }
}

}  // namespace

void add_experiment_segmentation(CLI::App& experiment) {
  auto command = std::make_shared<Command>();
  CLI::App* sub = experiment.add_subcommand(
      "segmentation", "Find people in pictures and compare with true masks: IoU, gradient error, the worst twenty");
  CLI::Option* const images =
      sub->add_option("--images", command->images, "Folder of pictures, each of people")->type_name("DIR");
  sub->add_option("--masks", command->masks, "Folder of their masks, of the same names, white on the people")
      ->needs(images)
      ->type_name("DIR");
  sub->add_option("--people", command->people,
                  "In place of both: a held-out set of `dualpixel people`; its faces are the seeds")
      ->excludes(images)
      ->type_name("DIR");
  sub->add_option("--weights", command->weights, "Other weights than the built-in ones: person.safetensors of a run")
      ->type_name("FILE");
  sub->add_flag("--bf16", command->bf16, "Run the network in 16-bit floats: see `dualpixel portrait --help`");
  sub->add_option("-o,--output", command->output, "Folder for segmentation.json and segmentation.html")
      ->type_name("DIR");
  add_threads_option(*sub);
  sub->footer(
      "Example:\n  dualpixel experiment segmentation --images portraits --masks masks -o out/segmentation\n"
      "  dualpixel experiment segmentation --people out/people_held_out -o out/segmentation");
  sub->callback([command] { run(*command); });
}

}  // namespace dualpixel::tools
