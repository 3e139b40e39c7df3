#include "tools/train_segmentation/train.h"

#include <ATen/autocast_mode.h>
#include <fmt/format.h>
#include <torch/version.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>
#include <thread>

#include "capture/error.h"
#include "capture/files.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plot.h"
#include "scenes/people/data_set/read_people_set.h"
#include "tools/train_segmentation/batches.h"
#include "tools/train_segmentation/checkpoint.h"
#include "tools/train_segmentation/evaluate.h"
#include "tools/train_segmentation/export.h"
#include "tools/train_segmentation/unfold.h"

namespace dualpixel::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kBatch = 16;          // as the paper
constexpr double kPoseWeight = 5;   // as the paper
constexpr double kIouWeight = 0.5;  // makes the two terms about as large
constexpr double kIouFloor_px = 8;  // limits the weight of a few wrong pixels where hardly anything of a person is seen
constexpr double kPeakRate = 3e-3, kFineTuneRate = 3e-4, kLastRate = 1e-6, kWarmUp = 0.05;
constexpr double kSgdRate = 0.1, kSgdLastRate = 1e-4, kSgdLastShare = 0.1;  // the share is ours
constexpr const char* kWeightsFile = "person.safetensors";
constexpr const char* kCheckpointFile = "checkpoint.pt";
constexpr double kCheckpointEvery_s = 300;
constexpr std::size_t kWatchedHeldOut = 320;  // of the held-out samples, at each checkpoint; the end takes them all
constexpr std::size_t kMeasured = 64;         // samples, for the statistics that exported weights lack

}  // namespace

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

void require_no_run(const std::string& folder, const char* file, const char* advice) {
  std::error_code error;
  if (!std::filesystem::exists(folder + "/" + file, error)) return;
  throw InputError(fmt::format("{}: holds a run; {}", printable(folder), advice));
}

void make_run_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder)) throw InputError(printable(folder) + ": cannot be made a folder");
}

int ready_threads(const TrainOptions& options) {
  const int threads = options.threads > 0 ? options.threads : static_cast<int>(std::thread::hardware_concurrency());
  torch::set_num_threads(threads);
  if (options.device.is_cuda() && !torch::cuda::is_available()) {
    throw InputError("--device: cuda: LibTorch finds no such device here; give cpu");
  }
  at::globalContext().setBenchmarkCuDNN(options.device.is_cuda());  // all batches are alike
  return threads;
}

double learning_rate(double done, double peak, bool sgd) {
  if (sgd) return done < 1 - kSgdLastShare ? peak : kSgdLastRate;
  if (done < kWarmUp) return peak * done / kWarmUp;
  return kLastRate + (peak - kLastRate) * 0.5 * (1 + std::cos(M_PI * (done - kWarmUp) / (1 - kWarmUp)));
}

torch::Tensor soft_iou_loss(const torch::Tensor& logits, const torch::Tensor& mask) {
  const torch::Tensor found = torch::sigmoid(logits.to(torch::kFloat)).flatten(1), truth = mask.flatten(1);
  const torch::Tensor common = (found * truth).sum(1), either = (found + truth).sum(1) - common;
  return 1 - ((common + kIouFloor_px) / (either + kIouFloor_px)).mean();
}

double work_done(double samples, double total, double half_size) {
  const double work = total / (1 + 3 * half_size), halves = 4 * half_size * work;
  if (samples >= total) return 1;
  return samples < halves ? samples / (4 * work) : half_size + (samples - halves) / work;
}

namespace {

struct Losses {
  torch::Tensor mask, pose;
  torch::Tensor total() const { return pose.defined() ? mask + kPoseWeight * pose : mask; }
};

/// While it lives, LibTorch computes in bfloat16 what can bear it; weights and gradients stay f32.
class Autocast {
 public:
  Autocast(torch::DeviceType device, bool bf16) : device_(device) { enable(bf16); }
  ~Autocast() {
    enable(false);
    at::autocast::clear_cache();
  }
  Autocast(const Autocast&) = delete;
  Autocast& operator=(const Autocast&) = delete;

 private:
  void enable(bool bf16) const {
#if TORCH_VERSION_MAJOR > 2 || (TORCH_VERSION_MAJOR == 2 && TORCH_VERSION_MINOR >= 4)
    at::autocast::set_autocast_dtype(device_, at::kBFloat16);
    at::autocast::set_autocast_enabled(device_, bf16);
#else
    at::autocast::set_autocast_cpu_dtype(at::kBFloat16);
    at::autocast::set_cpu_enabled(bf16 && device_ == torch::kCPU);
#endif
  }
  torch::DeviceType device_;
};

Losses losses_of(const std::vector<StageOutput>& outputs, const Batch& batch, bool soft_iou) {
  Losses losses;
  for (const StageOutput& output : outputs) {
    torch::Tensor mask = torch::binary_cross_entropy_with_logits(output.mask, batch.mask);
    if (soft_iou) mask = mask + kIouWeight * soft_iou_loss(output.mask, batch.mask);
    losses.mask = losses.mask.defined() ? losses.mask + mask : mask;
    if (!batch.heatmaps.defined()) continue;
    const torch::Tensor pose = torch::binary_cross_entropy_with_logits(output.heatmaps, batch.heatmaps);
    losses.pose = losses.pose.defined() ? losses.pose + pose : pose;
  }
  return losses;
}

/// The samples to train on in phase two: all but those with the largest inner errors, in their order.
std::vector<std::size_t> kept_samples(Network& network, const scenes::PeopleSet& set, std::vector<std::size_t> from,
                                      double prune) {
  const std::vector<float> errors = inner_errors(network, set, [](double done) {
    if (isatty(STDERR_FILENO) != 0) fmt::print(stderr, "\rpruning: {:3.0f} %{}", 100 * done, done < 1 ? "" : "\n");
  });
  std::stable_sort(from.begin(), from.end(), [&](std::size_t a, std::size_t b) { return errors[a] < errors[b]; });
  const auto kept = static_cast<std::size_t>(std::ceil((1 - prune) * static_cast<double>(from.size())));
  fmt::print(stderr, "pruning: {} of {} samples kept, inner error up to {:.3f}\n", kept, from.size(),
             errors[from[kept - 1]]);
  from.resize(kept);
  std::sort(from.begin(), from.end());
  return from;
}

std::string chart_page(const Json& points) {
  evaluation::Plot loss{"Loss", "samples", "loss", {{"mask", {}}, {"5 × pose", {}}}, false, true};
  const std::string half = fmt::format("at {} px", kNetworkSize_px / 2),
                    full = fmt::format("at {} px", kNetworkSize_px);
  evaluation::Plot iou{"Held-out samples", "samples", "mean IoU", {{half, {}}, {full, {}}}};
  evaluation::Plot gradient{"Held-out samples", "samples", "gradient error", {{half, {}}, {full, {}}}, false, true};
  for (const Json& point : points) {
    const double x = point["samples"];
    loss.series[0].points.emplace_back(x, point["mask_loss"].get<double>());
    if (point.contains("pose_loss")) {
      loss.series[1].points.emplace_back(x, kPoseWeight * point["pose_loss"].get<double>());
    }
    const int series = point["size_px"] == kNetworkSize_px ? 1 : 0;
    iou.series[series].points.emplace_back(x, point["held_out_iou"].get<double>());
    gradient.series[series].points.emplace_back(x, point["held_out_gradient_error"].get<double>());
  }
  if (loss.series[1].points.empty()) loss.series.pop_back();
  for (evaluation::Plot* plot : {&iou, &gradient}) {
    if (plot->series[0].points.empty()) plot->series.erase(plot->series.begin());
  }
  return evaluation::html_page(
      "Training of the person segmentation network",
      "<h1>Training of the person segmentation network</h1>" + evaluation::html_plots({loss, iou, gradient}));
}

std::string scores_table(const scenes::PeopleSet& set, const std::vector<MaskScore>& scores) {
  std::string table = "sample,seed,people,composite,iou,gradient_error\n";
  for (std::size_t i = 0; i < scores.size(); ++i) {
    table += fmt::format("{},{},{},{},{:.6f},{:.8f}\n", i, set[i].seed, set[i].people, set[i].composite ? 1 : 0,
                         scores[i].iou, scores[i].gradient_error);
  }
  return table;
}

/// Loss since the last checkpoint, means over batches.
struct Tally {
  double mask = 0, pose = 0;
  int batches = 0;
};

double peak_rate(const TrainOptions& options) {
  if (options.rate > 0) return options.rate;
  if (options.sgd) return kSgdRate;
  return options.fine_tune.empty() ? kPeakRate : kFineTuneRate;
}

/// Evenly spread indices, all where there are no more than `most`.
std::vector<std::size_t> spread(std::size_t count, std::size_t most) {
  std::vector<std::size_t> indices(std::min(count, most));
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = i * count / indices.size();
  return indices;
}

/// Whether phase two starts from a run; else it does from exported weights.
bool starts_from_run(const TrainOptions& options) {
  std::error_code error;
  return std::filesystem::is_directory(options.fine_tune, error);
}

/// What phase two starts from, with normalization by the samples `of` the set where it lacks that.
Network first_network(const TrainOptions& options, const scenes::PeopleSet& set, const std::vector<std::size_t>& of) {
  if (starts_from_run(options)) return read_checkpoint(options.fine_tune + "/checkpoint.pt").network;
  std::vector<std::size_t> measured = spread(of.size(), kMeasured);
  for (std::size_t& i : measured) i = of[i];
  return unfolded(pipeline::read_weights(options.fine_tune), plain_batch(set, measured, false).input, options.seed);
}

/// Of what was stored, not of what this machine makes of it.
std::string first_weights_hash(const TrainOptions& options) {
  if (!starts_from_run(options)) return pipeline::read_weights(options.fine_tune).file_hash;
  Network network = read_checkpoint(options.fine_tune + "/checkpoint.pt").network;
  return weights_hash(network);
}

/// What the weights and their scores depend on.
Json recipe_of(const TrainOptions& options, const NetworkShape& shape, const scenes::PeopleSet& set,
               const scenes::PeopleSet& held_out, int threads) {
  Json recipe = {{"version", DUALPIXEL_VERSION},
                 {"fcn", shape.fcn},
                 {"stages", shape.stages},
                 {"pose", shape.pose},
                 {"composites", options.composites},
                 {"seed", options.seed},
                 {"samples", options.samples},
                 {"hours", options.hours},
                 {"sgd", options.sgd},
                 {"device", options.device.str()},
                 {"bf16", options.bf16},
                 {"threads", threads},
                 {"rate", peak_rate(options)},
                 {"data_hash", set.hash()},
                 {"held_out_hash", held_out.hash()}};
  if (options.fine_tune.empty()) {
    recipe["half_size"] = options.half_size;
  } else {
    recipe["fine_tuned_weights_hash"] = first_weights_hash(options);
    recipe["prune"] = options.prune;
  }
  return recipe;
}

/// Where the run starts: with the seed's weights, other weights, or its own. `from`: the samples that it learns from.
Checkpoint start_of(const TrainOptions& options, const std::string& path, const scenes::PeopleSet& set,
                    const std::vector<std::size_t>& from, const scenes::PeopleSet& held_out, int threads) {
  if (options.resume) {
    Checkpoint state = read_checkpoint(path, options.device);
    const bool fine_tunes = !options.fine_tune.empty();
    const Json wanted = recipe_of(options, fine_tunes ? state.network->shape : options.shape, set, held_out, threads);
    if (state.recipe.contains("prune") != fine_tunes) {
      throw InputError(printable(path) + ": is of another run: only one of the two fine-tunes");
    }
    for (const auto& [name, value] : wanted.items()) {
      if (!state.recipe.contains(name)) {
        throw InputError(
            fmt::format("{}: an older version wrote it, without its {}: it cannot be resumed; "
                        "--fine-tune can start from it",
                        printable(path), name));
      }
      const Json was = state.recipe[name];
      if (was == value) continue;
      throw InputError(fmt::format("{}: is of another run: its {} is {}, not {}; give that to resume it",
                                   printable(path), name, printable(was.dump()), value.dump()));
    }
    return state;
  }
  require_no_run(options.output, kCheckpointFile, "resume it with --resume, or name another folder");
  std::error_code error;
  if (std::filesystem::equivalent(options.fine_tune, options.output + "/" + kWeightsFile, error)) {
    throw InputError(printable(options.fine_tune) + ": the run would write over it: name another folder");
  }
  Checkpoint state;
  if (options.fine_tune.empty()) {
    state = new_checkpoint(options.shape, options.seed);
  } else {
    state.network = first_network(options, set, from);
  }
  state.network->to(options.device);
  state.sgd = options.sgd;
  forget_optimizer(state);
  state.recipe = recipe_of(options, state.network->shape, set, held_out, threads);
  return state;
}

std::vector<std::size_t> samples_to_learn_from(const TrainOptions& options, const scenes::PeopleSet& set) {
  std::vector<std::size_t> samples;
  for (std::size_t i = 0; i < set.size(); ++i) {
    if (options.composites || !set[i].composite) samples.push_back(i);
  }
  if (samples.empty()) throw InputError("--no-composites: the data holds composites only");
  return samples;
}

}  // namespace

void train(const TrainOptions& options, const std::function<bool(std::uint64_t samples)>& stop) {
  const scenes::PeopleSet set(options.data, false), held_out(options.held_out, true);
  const int threads = ready_threads(options);
  const std::string checkpoint = options.output + "/" + kCheckpointFile;
  std::vector<std::size_t> kept = samples_to_learn_from(options, set);
  Checkpoint state = start_of(options, checkpoint, set, kept, held_out, threads);
  make_run_folder(options.output);
  const bool fine_tune = !options.fine_tune.empty();
  if (fine_tune && options.prune > 0) {
    // by the first phase's network, also when the second phase is resumed
    Network judge = options.resume ? first_network(options, set, kept) : state.network;
    judge->to(options.device);
    kept = kept_samples(judge, set, kept, options.prune);
  }
  Json log = {{"data", options.data},
              {"held_out", options.held_out},
              {"recipe", state.recipe},
              {"training_samples", kept.size()}};
  if (fine_tune) log["fine_tune"] = options.fine_tune;

  const bool pose = state.network->shape.pose && !fine_tune;
  const double peak = peak_rate(options);
  const double half_size = fine_tune ? 0 : options.half_size;
  AugmentedBatches batches(kept, kBatch, options.seed, state.samples,
                           [&](const std::vector<Draw>& draws) { return augmented_batch(set, draws, pose); });
  const double started_s = now_s() - state.seconds;
  const auto fraction = [&] {
    if (options.samples == 0) return state.seconds / (3600 * options.hours);
    return work_done(static_cast<double>(state.samples), static_cast<double>(options.samples), half_size);
  };
  const bool terminal = isatty(STDERR_FILENO) != 0;
  double saved_s = now_s(), shown_s = saved_s, rate_from_s = saved_s;
  std::uint64_t rate_from = state.samples;
  double iou = state.points.empty() ? 0 : state.points.back()["held_out_iou"].get<double>();
  Tally tally;

  const auto progress_line = [&] {
    const double now = now_s(), done = fraction();
    const double per_s = static_cast<double>(state.samples - rate_from) / std::max(1e-9, now - rate_from_s);
    const double left_s = done > 0 ? (1 - done) / done * state.seconds : 0;
    return fmt::format(
        "{} samples ({:.1f} %), {:.1f} samples/s, loss {:.4f} mask {:.4f} pose, held-out IoU {:.4f}, "
        "{:.0f} min left",
        state.samples, 100 * std::min(1.0, done), per_s, tally.mask / std::max(1, tally.batches),
        tally.pose / std::max(1, tally.batches), iou, std::max(0.0, left_s) / 60);
  };
  bool half = fraction() < half_size;  // what is being trained on
  const auto save = [&](bool end) {
    const std::vector<MaskScore> scores =
        evaluate(state.network, held_out, spread(held_out.size(), end ? held_out.size() : kWatchedHeldOut), {}, half);
    const MaskScore score = mean_of(scores);
    iou = score.iou;
    state.seconds = now_s() - started_s;
    if (tally.batches > 0) {
      Json point = {{"samples", state.samples},
                    {"seconds", state.seconds},
                    {"size_px", half ? kNetworkSize_px / 2 : kNetworkSize_px},
                    {"learning_rate", learning_rate(std::min(1.0, fraction()), peak, options.sgd)},
                    {"mask_loss", tally.mask / tally.batches}};
      if (pose) point["pose_loss"] = tally.pose / tally.batches;
      point["held_out_iou"] = score.iou;
      point["held_out_gradient_error"] = score.gradient_error;
      state.points.push_back(point);
    }
    log["points"] = state.points;
    replace_file(options.output + "/log.json", log.dump(1) + "\n");
    replace_file(options.output + "/chart.html", chart_page(state.points));
    if (!state.network->shape.fcn) {
      replace_file(options.output + "/" + kWeightsFile, safetensors(folded_layers(state.network)));
    }
    write_checkpoint(state, checkpoint);
    fmt::print(stderr, "{}{}\n", terminal ? "\r\x1b[K" : "", progress_line());
    if (end) {
      replace_file(options.output + "/scores.csv", scores_table(held_out, scores));
      fmt::print("{} held-out samples at {} px: mean IoU {:.4f}, gradient error {:.6f}\n", held_out.size(),
                 half ? kNetworkSize_px / 2 : kNetworkSize_px, score.iou, score.gradient_error);
    }
    tally = {};
    saved_s = now_s();
    rate_from_s = saved_s;
    rate_from = state.samples;
  };

  while (fraction() < 1 && !stop(state.samples)) {
    Batch batch = on(options.device, batches.next());
    if (half && fraction() >= half_size) {
      save(false);  // so that no entry of the log is of both sizes
      half = false;
    }
    if (half) batch = halved(batch);
    for (auto& group : state.optimizer->param_groups())
      group.options().set_lr(learning_rate(fraction(), peak, options.sgd));
    state.network->train();
    const Losses losses = [&] {
      const Autocast autocast(options.device.type(), options.bf16);
      return losses_of(state.network->forward(batch.input), batch, fine_tune);
    }();
    state.optimizer->zero_grad();
    losses.total().backward();
    state.optimizer->step();
    state.samples += kBatch;
    state.seconds = now_s() - started_s;
    tally.mask += losses.mask.item<double>();
    if (pose) tally.pose += losses.pose.item<double>();
    ++tally.batches;
    if (!std::isfinite(tally.mask)) throw std::runtime_error("the loss is not finite: training has diverged");
    if (terminal && now_s() - shown_s > 1) {
      shown_s = now_s();
      fmt::print(stderr, "\r\x1b[K{}", progress_line());
    }
    if (now_s() - saved_s > kCheckpointEvery_s) save(false);
  }
  save(fraction() >= 1);
}

}  // namespace dualpixel::tools
