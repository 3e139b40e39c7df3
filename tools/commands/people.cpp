#include <fmt/format.h>

#include <atomic>
#include <iostream>
#include <memory>
#include <mutex>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/image_io.h"
#include "scenes/people/data_set/contact_sheet.h"
#include "scenes/people/data_set/write_people_set.h"
#include "tools/cli/signals.h"
#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

struct PeopleArguments {
  scenes::PeopleOptions options;
  std::string folder, preview, makehuman;
};

void run(PeopleArguments arguments) {
  scenes::check_people_options(arguments.options);
  if (!arguments.makehuman.empty())
    arguments.options.makehuman = std::make_shared<scenes::MakeHumanAssets>(arguments.makehuman);
  Progress bar("people");
  std::mutex one_at_a_time;
  const auto progress = [&](double fraction) {
    const std::scoped_lock lock(one_at_a_time);
    bar(fraction);
  };
  constexpr int kPreviewed = 48, kColumns = 8;
  if (arguments.folder.empty() && arguments.preview.empty())
    throw InputError("people: give -o DIR, --preview FILE, or both");
  bool previewed = arguments.preview.empty();
  if (!previewed) {
    if (!arguments.preview.ends_with(".png"))
      throw InputError("--preview: " + printable(arguments.preview) + ": must end in .png");
    require_writable(arguments.preview);
  }
  const auto preview = [&](const std::vector<scenes::PeopleSample>& samples) {
    if (!previewed) write_png8(arguments.preview, scenes::contact_sheet(samples, kPreviewed, kColumns));
    previewed = true;
  };
  if (!arguments.folder.empty()) {
    const std::atomic<int>& stopped = note_first_signal();
    if (!scenes::write_people_set(arguments.options, arguments.folder, progress, preview, &stopped)) {
      std::cerr << fmt::format("dualpixel: {}: stopped after a whole shard; the same command goes on from there\n",
                               printable(arguments.folder));
      throw CLI::RuntimeError(128 + stopped);
    }
  }
  // nothing was made: the first are made again, the same
  if (!previewed)
    preview(scenes::make_people_shard(arguments.options, 0, std::min(arguments.options.count, kPreviewed), progress));
  bar(1);
}

}  // namespace

void add_people(CLI::App& program) {
  auto arguments = std::make_shared<PeopleArguments>();
  CLI::App* command = program.add_subcommand(
      "people", "Make pictures of people with masks, keypoints and face boxes, to train segmentation with");
  command
      ->add_option("-o,--output", arguments->folder,
                   "Folder for the set; an unfinished set of the same options is resumed. The first SIGINT or SIGTERM "
                   "ends the run after the shard that is being made, the second at once")
      ->type_name("DIR");
  command->add_option("--count", arguments->options.count, "How many samples")
      ->check(CLI::Range(1, scenes::kMostSamples))
      ->capture_default_str()
      ->type_name("N");
  command->add_option("--seed", arguments->options.seed, "Which set: the same seed gives the same bytes")
      ->check(any_seed())
      ->capture_default_str()
      ->type_name("SEED");
  command->add_flag("--held-out", arguments->options.held_out,
                    "For evaluation: poses, textures, environments and lights that training sets never use");
  command
      ->add_option("--composites", arguments->options.composites,
                   "How many copies of each rendered picture to cut out and place in front of other backgrounds")
      ->check(CLI::Range(0, scenes::kMostComposites))
      ->capture_default_str()
      ->type_name("K");
  command->add_flag("--faces", arguments->options.faces,
                    "For a face detector: heads turned anyhow, a sample of each face, and pictures of nobody");
  command
      ->add_option("--preview", arguments->preview,
                   "Contact sheet (PNG) of the first samples that this run makes (of a whole set: its first): masks "
                   "outlined, faces boxed, keypoints dotted")
      ->type_name("FILE");
  command
      ->add_option(
          "--makehuman", arguments->makehuman,
          "Folder of assets in MakeHuman's formats (3dobjs, targets, rigs, ...): half of the people come from them")
      ->type_name("DIR");
  add_threads_option(*command);
  command->footer("Example:\n  dualpixel people -o out/people --count 20000 --seed 1 --preview out/people.png");
  command->callback([arguments] { run(*arguments); });
}

}  // namespace dualpixel::tools
