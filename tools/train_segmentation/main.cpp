#include <signal.h>

#include <CLI/CLI.hpp>
#include <atomic>

#include "tools/cli/number_range.h"
#include "tools/cli/small_program.h"
#include "tools/train_segmentation/train.h"
#include "tools/train_segmentation/train_faces.h"

#include <malloc.h>

namespace {

std::atomic<bool> stop{false};
std::atomic<int> stopped_by{0};

/// The run ends with a checkpoint; a second signal ends it at once.
void end_after_checkpoint(int signal_number) {
  stopped_by = signal_number;
  stop = true;
  signal(signal_number, SIG_DFL);
}

}  // namespace

int main(int argc, char** argv) {
  // Keep what is freed: each sample and each layer needs megabytes for a moment, and new pages cost more than the work.
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  mallopt(M_MMAP_THRESHOLD, 32 << 20);  // as large as may be
  CLI::App program(
      "Trains the networks of the portrait pipeline: that which segments people, and that which finds faces.",
      "dualpixel_train");
  dualpixel::tools::TrainOptions options;
  bool no_pose = false;
  program.add_option("--data", options.data, "People sets to learn from, as `dualpixel people` writes them")
      ->required()
      ->type_name("DIR");
  program.add_option("--held-out", options.held_out, "People sets to score on")->required()->type_name("DIR");
  program.add_option("-o,--output", options.output, "Folder of the run: checkpoint, log, chart, weights")
      ->required()
      ->type_name("DIR");
  CLI::Option* const samples = program.add_option("--samples", options.samples, "Samples to train on in total")
                                   ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 40))
                                   ->type_name("N");
  CLI::Option* const hours = program.add_option("--hours", options.hours, "Instead of --samples: hours to train")
                                 ->check(dualpixel::tools::number_range(1e-4, 1e4))
                                 ->excludes(samples)
                                 ->type_name("H");
  CLI::Option* const resume = program.add_flag("--resume", options.resume,
                                               "Resume from the folder's checkpoint; a finished run is scored again");
  CLI::Option* const stages = program.add_option("--stages", options.shape.stages, "Stacked U-Nets")
                                  ->check(CLI::Range(1, 3))
                                  ->capture_default_str();
  CLI::Option* const no_composites = program.add_flag(
      "!--no-composites", options.composites, "Leave out the composites (people in front of other backgrounds)");
  CLI::Option* const half_size =
      program
          .add_option("--half-size", options.half_size,
                      "Share of the training time, at its start, that uses pictures of half the side")
          ->check(dualpixel::tools::number_range(0.0, 1.0))
          ->capture_default_str();
  CLI::Option* const pose = program.add_flag("--no-pose", no_pose, "Learn no keypoints");
  CLI::Option* const fcn =
      program.add_flag("--fcn", options.shape.fcn, "Instead of the U-Nets, a baseline: FCN-8 (Long et al. 2015)")
          ->excludes(stages, pose);
  CLI::Option* const fine_tune =
      program
          .add_option("--fine-tune", options.fine_tune,
                      "Second phase: start from this run, or from exported weights (person.safetensors), without pose "
                      "loss and without the samples with the largest error")
          ->excludes(stages, pose, fcn, half_size)
          ->type_name("RUN|FILE");
  program.add_option("--prune", options.prune, "Share of the samples that the second phase leaves out")
      ->check(dualpixel::tools::number_range(0.0, 0.9))
      ->needs(fine_tune)
      ->capture_default_str();
  program
      .add_option("--rate", options.rate,
                  "Learning rate at its peak: 3e-3 where not given, 3e-4 in the second phase, 0.1 with --sgd")
      ->check(dualpixel::tools::number_range(1e-6, 1.0))
      ->type_name("R");
  program.add_option("--seed", options.seed, "Seed of the initial weights, the sample order and the augmentation")
      ->type_name("N")
      ->capture_default_str();
  CLI::Option* const sgd =
      program.add_flag("--sgd", options.sgd,
                       "Train as the paper did: stochastic gradient descent at a rate of 0.1, and of 1e-4 for the last "
                       "tenth, in place of Adam and one cycle of rates");
  std::string device = "cpu";
  program.add_option("--device", device, "Where the network is trained: cuda where LibTorch has it")
      ->check(CLI::IsMember({"cpu", "cuda"}))
      ->capture_default_str();
  CLI::Option* const bf16 =
      program.add_flag("--bf16", options.bf16, "Convolve in 16-bit floats: faster where the processor has AMX");
  bool faces = false;
  program.add_flag("--faces", faces, "Train the face detector instead, on sets of `dualpixel people --faces`")
      ->excludes(resume, stages, no_composites, half_size, pose, fcn, fine_tune, sgd, bf16);
  program.add_option("--threads", options.threads, "0: one for each core")->check(CLI::Range(0, 1024))->type_name("N");
  program.footer(
      "Example:\n  dualpixel_train --data out/people --held-out out/people_held_out -o out/run --hours 3\n"
      "  dualpixel_train --data out/people --held-out out/people_held_out -o out/fine --fine-tune out/run --hours 0.5");
  return dualpixel::tools::run_small_program(program, argc, argv, [&] {
    if (samples->empty() && hours->empty()) throw CLI::RequiredError("--samples or --hours");
    options.shape.pose = !no_pose && !options.shape.fcn;
    if (options.shape.fcn) options.shape.stages = 1;
    options.device = torch::Device(device);
    signal(SIGINT, end_after_checkpoint);
    signal(SIGTERM, end_after_checkpoint);
    (faces ? dualpixel::tools::train_faces : dualpixel::tools::train)(options,
                                                                      [](std::uint64_t) { return stop.load(); });
    return stopped_by == 0 ? 0 : 128 + stopped_by;
  });
}
