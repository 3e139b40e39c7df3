#include <fmt/format.h>

#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "evaluation/experiments/mask_experiment.h"
#include "evaluation/experiments/portrait_set.h"
#include "pipeline/segmentation/network.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct Command {
  std::string images, masks, people, portraits, weights, output;
  bool bf16 = false;
};

void print(const std::vector<evaluation::PictureMaskScore>& pictures) {
  const evaluation::MaskMeans means = evaluation::means_of(pictures);
  fmt::print("{:<34}{:>12}{:>12}\n", "", "network", "filtered");
  fmt::print("{:<34}{:12.4f}{:12.4f}\n", fmt::format("mean IoU, {} pictures", means.count), means.iou,
             means.filtered_iou);
  fmt::print("{:<34}{:12.0f}\n", "CPU ms to find people, median", means.find_cpu_ms);
  if (means.with_face == 0) {
    fmt::print("no face was found\n");
    return;
  }
  fmt::print("{:<34}{:12.4f}{:12.4f}\n", fmt::format("... where a face was found, {}", means.with_face),
             means.iou_found, means.filtered_iou_found);
  fmt::print("{:<34}{:12.6f}{:12.6f}\n", "gradient error there", means.gradient_error, means.filtered_gradient_error);
}

void print(const evaluation::PeopleScores& scores) {
  fmt::print("{:<20}{:>8}{:>9} +- {:<6}{:>8}{:>10}{:>12}{:>12}\n", "", "samples", "IoU", "error", "filtered", "no face",
             "grad. err.", "filtered");
  for (const evaluation::PeopleRow& row : scores.samples) {
    const std::string error = std::isnan(row.iou_error) ? "-" : fmt::format("{:.4f}", row.iou_error);
    fmt::print("{:<20}{:8}{:9.4f} +- {:<6}{:8.4f}{:10.4f}{:12.6f}{:12.6f}\n", row.name, row.samples, row.iou, error,
               row.filtered_iou, row.iou_without_face, row.gradient_error, row.filtered_gradient_error);
  }
  for (const evaluation::PeopleRow& row : scores.regions) {
    fmt::print("{:<20}{:8}{:>37}{:12.6f}{:12.6f}\n", "near " + row.name, row.samples, "", row.gradient_error,
               row.filtered_gradient_error);
  }
}

/// segmentation.json and segmentation.html.
void write_results(const std::string& output, const nlohmann::ordered_json& json, const std::string& page) {
  NewFolder out(output, "segmentation.json");
  write_file(out.path() + "/segmentation.json", json.dump(2) + "\n");
  write_file(out.path() + "/segmentation.html", page);
  out.commit();
  print_written(output + "/segmentation.html");
}

/// The portraits of a set like Shen et al.'s.
struct Portraits {
  evaluation::PictureMasks found;
  std::vector<evaluation::PictureMaskScore> with_faces;  ///< given ones; empty: there are none
  std::vector<evaluation::PortraitSetRow> table;
};

Portraits run_portraits(const Command& command, pipeline::PersonNetwork& network) {
  const std::vector<evaluation::MaskedPicture> given = evaluation::read_portrait_set(command.portraits);
  const bool has_faces = !given.front().faces.empty();
  std::vector<evaluation::MaskedPicture> to_find = given;
  for (evaluation::MaskedPicture& portrait : to_find) portrait.faces.clear();
  Progress bar("segmentation");
  Portraits portraits;
  portraits.found = score_pictures(to_find, network, [&](double done) { bar(has_faces ? 0.5 * done : done); });
  if (has_faces) {
    portraits.with_faces = score_pictures(given, network, [&](double done) { bar(0.5 + 0.5 * done); }).pictures;
  }
  const std::string training = command.weights.empty() ? "drawn people" : "that of --weights";
  portraits.table = portrait_set_table(portraits.found.pictures, portraits.with_faces, training);
  return portraits;
}

void run(const Command& command) {
  const bool has_pairs = !command.images.empty() && !command.masks.empty();
  if (has_pairs + !command.people.empty() + !command.portraits.empty() != 1) {
    throw InputError("experiment segmentation: needs --images and --masks, or --people, or --portraits");
  }
  const pipeline::NetworkWeights weights =
      command.weights.empty() ? pipeline::built_in_weights() : pipeline::read_weights(command.weights);
  pipeline::PersonNetwork network(weights, 1, command.bf16 ? pipeline::Precision::bf16 : pipeline::Precision::f32);
  if (!command.output.empty()) const NewFolder writable(command.output, "segmentation.json");  // before the work
  const evaluation::NetworkId id{weights.file_hash, command.bf16 ? "bf16" : "f32"};
  if (!command.portraits.empty()) {
    const Portraits portraits = run_portraits(command, network);
    std::cout << to_text(portraits.table);
    if (command.output.empty()) return;
    nlohmann::ordered_json json = to_json(portraits.found.pictures, id);
    json["table"] = to_json(portraits.table);
    if (!portraits.with_faces.empty()) {
      json["pictures_with_faces_given"] = to_json(portraits.with_faces, id)["pictures"];
    }
    write_results(command.output, json, to_page(portraits.found));
    return;
  }
  if (command.people.empty()) {
    const auto pairs = evaluation::pair_masks(command.images, command.masks);
    Progress bar("segmentation");
    const evaluation::PictureMasks masks =
        evaluation::score_pictures(pairs, network, [&](double fraction) { bar(fraction); });
    print(masks.pictures);
    if (!command.output.empty()) write_results(command.output, to_json(masks.pictures, id), to_page(masks));
    return;
  }
  const scenes::PeopleSet set({command.people}, true);
  scenes::require_unchanged(command.people);
  Progress bar("segmentation");
  const evaluation::PeopleMasks masks =
      evaluation::score_people_masks(set, network, [&](double fraction) { bar(fraction); });
  print(masks.scores);
  if (!command.output.empty()) write_results(command.output, to_json(masks.scores, set.hash(), id), to_page(masks));
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
  CLI::Option* const people =
      sub->add_option("--people", command->people,
                      "Instead of both: a held-out set of `dualpixel people`; its face boxes are the seeds");
  people->excludes(images)->type_name("DIR");
  sub->add_option("--portraits", command->portraits,
                  "Instead of these: a folder of Shen et al.'s portraits (Images and Labels, or images_data_crop and "
                  "GT_png; eg1800_test.txt; faces.json), for the paper's Table 1")
      ->excludes(images)
      ->excludes(people)
      ->type_name("DIR");
  sub->add_option("--weights", command->weights, "Other weights than the built-in ones: person.safetensors of a run")
      ->type_name("FILE");
  sub->add_flag("--bf16", command->bf16, "Run the network in 16-bit floats: see `dualpixel portrait --help`");
  sub->add_option("-o,--output", command->output, "Folder for segmentation.json and segmentation.html")
      ->type_name("DIR");
  add_threads_option(*sub);
  sub->footer(
      "Example:\n  dualpixel experiment segmentation --images portraits --masks masks -o out/segmentation\n"
      "  dualpixel experiment segmentation --people out/people_held_out -o out/segmentation\n"
      "  dualpixel experiment segmentation --portraits EG1800 -o out/segmentation");
  sub->callback([command] { run(*command); });
}

}  // namespace dualpixel::tools
