#include "tools/train_segmentation/train.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <sstream>
#include <thread>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"
#include "tools/report_page.h"
#include "tools/svg_plot.h"
#include "tools/train_segmentation/batches.h"
#include "tools/train_segmentation/evaluate.h"
#include "tools/train_segmentation/export.h"
#include "tools/train_segmentation/people_set.h"

namespace dualpixel::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kBatch = 16;         // as the paper
constexpr double kPoseWeight = 5;  // as the paper
constexpr double kPeakRate = 3e-3, kFineTuneRate = 3e-4, kLastRate = 1e-6, kWarmUp = 0.05;
constexpr double kWeightDecay = 1e-4;
constexpr double kCheckpointEvery_s = 300;
constexpr std::size_t kWatchedHeldOut = 320;  // of the held-out samples, at each checkpoint; the end takes them all

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double learning_rate(double done, double peak) {
  if (done < kWarmUp) return peak * done / kWarmUp;
  return kLastRate + (peak - kLastRate) * 0.5 * (1 + std::cos(M_PI * (done - kWarmUp) / (1 - kWarmUp)));
}

struct Losses {
  torch::Tensor mask, pose;
  torch::Tensor total() const { return pose.defined() ? mask + kPoseWeight * pose : mask; }
};

Losses losses_of(const std::vector<StageOutput>& outputs, const Batch& batch) {
  Losses losses;
  for (const StageOutput& output : outputs) {
    const torch::Tensor mask = torch::binary_cross_entropy_with_logits(output.mask, batch.mask);
    losses.mask = losses.mask.defined() ? losses.mask + mask : mask;
    if (!batch.heatmaps.defined()) continue;
    const torch::Tensor pose = torch::binary_cross_entropy_with_logits(output.heatmaps, batch.heatmaps);
    losses.pose = losses.pose.defined() ? losses.pose + pose : pose;
  }
  return losses;
}

/// What a run goes on from.
struct State {
  Network network;
  std::unique_ptr<torch::optim::AdamW> optimiser;
  std::uint64_t samples = 0;
  double seconds = 0;
};

State new_state(const NetworkShape& shape, std::uint64_t seed) {
  torch::manual_seed(seed);
  State state{Network(shape), nullptr};
  for (torch::Tensor& parameter : state.network->parameters()) {
    if (parameter.dim() == 4) parameter.set_data(parameter.data().contiguous(torch::MemoryFormat::ChannelsLast));
  }
  state.optimiser = std::make_unique<torch::optim::AdamW>(
      state.network->parameters(), torch::optim::AdamWOptions(kPeakRate).weight_decay(kWeightDecay));
  return state;
}

void write_checkpoint(const State& state, const std::string& path) {
  torch::serialize::OutputArchive archive, network, optimiser;
  state.network->save(network);
  archive.write("network", network);
  state.optimiser->save(optimiser);
  archive.write("optimiser", optimiser);
  archive.write("samples", torch::tensor(static_cast<std::int64_t>(state.samples)), true);
  archive.write("seconds", torch::tensor(state.seconds, torch::kFloat64), true);
  std::ostringstream bytes;
  archive.save_to(bytes);
  replace_file(path, bytes.str());
}

/// With the optimiser's state where that is wanted.
void read_checkpoint(const std::string& path, State& state, bool all) {
  require_regular_file(path);
  try {
    torch::serialize::InputArchive archive, network, optimiser;
    archive.load_from(path);
    archive.read("network", network);
    state.network->load(network);
    if (!all) return;
    archive.read("optimiser", optimiser);
    state.optimiser->load(optimiser);
    torch::Tensor samples, seconds;
    archive.read("samples", samples, true);
    archive.read("seconds", seconds, true);
    state.samples = static_cast<std::uint64_t>(samples.item<std::int64_t>());
    state.seconds = seconds.item<double>();
  } catch (const c10::Error&) {
    throw InputError(printable(path) + ": is no checkpoint of a network of this many stages, with or without pose");
  }
}

/// The samples to train on in phase two: all but those with the largest inner errors.
std::vector<std::size_t> kept_samples(Network& network, const PeopleSet& set, double prune) {
  const std::vector<float> errors = inner_errors(network, set, [](double done) {
    if (isatty(STDERR_FILENO) != 0) fmt::print(stderr, "\rpruning: {:3.0f} %{}", 100 * done, done < 1 ? "" : "\n");
  });
  std::vector<std::size_t> order(set.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return errors[a] < errors[b]; });
  const auto kept = static_cast<std::size_t>(std::ceil((1 - prune) * static_cast<double>(set.size())));
  fmt::print(stderr, "pruning: {} of {} samples kept, inner error up to {:.3f}\n", kept, set.size(),
             errors[order[kept - 1]]);
  order.resize(kept);
  std::sort(order.begin(), order.end());
  return order;
}

std::string chart_page(const Json& points) {
  Plot loss{"Loss", "samples", "cross-entropy", {{"mask", {}}, {"5 × pose", {}}}, false, true};
  Plot iou{"Held-out samples", "samples", "mean IoU", {{"", {}}}};
  Plot gradient{"Held-out samples", "samples", "gradient error", {{"", {}}}, false, true};
  for (const Json& point : points) {
    const double x = point["samples"];
    loss.series[0].points.emplace_back(x, point["mask_loss"].get<double>());
    if (point.contains("pose_loss")) {
      loss.series[1].points.emplace_back(x, kPoseWeight * point["pose_loss"].get<double>());
    }
    iou.series[0].points.emplace_back(x, point["held_out_iou"].get<double>());
    gradient.series[0].points.emplace_back(x, point["held_out_gradient_error"].get<double>());
  }
  if (loss.series[1].points.empty()) loss.series.pop_back();
  return html_page("Training of the person segmentation network", kPlotStyle,
                   "<h1>Training of the person segmentation network</h1><div class=\"plots\">" + svg_plot(loss) +
                       svg_plot(iou) + svg_plot(gradient) + "</div>");
}

/// Evenly spread indices, all where there are no more than `most`.
std::vector<std::size_t> spread(std::size_t count, std::size_t most) {
  std::vector<std::size_t> indices(std::min(count, most));
  for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = i * count / indices.size();
  return indices;
}

/// Loss since the last checkpoint, means over batches.
struct Tally {
  double mask = 0, pose = 0;
  int batches = 0;
};

}  // namespace

void train(const TrainOptions& options, const std::atomic<bool>& stop) {
  const PeopleSet set(options.data), held_out(options.held_out);
  std::filesystem::create_directories(options.output);
  const std::string checkpoint = options.output + "/checkpoint.pt", log_path = options.output + "/log.json";
  if (!options.resume && std::filesystem::exists(checkpoint)) {
    throw InputError(printable(options.output) + ": holds a run; go on with it by --resume, or name another folder");
  }
  torch::set_num_threads(options.threads > 0 ? options.threads : static_cast<int>(std::thread::hardware_concurrency()));

  State state = new_state(options.shape, options.seed);
  const bool fine_tune = !options.fine_tune.empty();
  std::vector<std::size_t> kept(set.size());
  std::iota(kept.begin(), kept.end(), std::size_t{0});
  if (fine_tune) {
    read_checkpoint(options.fine_tune + "/checkpoint.pt", state, false);
    if (options.prune > 0) kept = kept_samples(state.network, set, options.prune);
  }
  Json log = {{"data", options.data},
              {"held_out", options.held_out},
              {"training_samples", kept.size()},
              {"samples", options.samples},
              {"hours", options.hours},
              {"stages", options.shape.stages},
              {"pose", options.shape.pose && !fine_tune},
              {"seed", options.seed}};
  if (fine_tune) {
    log["fine_tune"] = options.fine_tune;
    log["prune"] = options.prune;
  }
  log["points"] = Json::array();
  if (options.resume) {
    read_checkpoint(checkpoint, state, true);
    const Json before = Json::parse(read_json_file(log_path).dump());
    for (const Json& point : before.value("points", Json::array())) {
      if (point.value("samples", std::uint64_t{0}) <= state.samples) log["points"].push_back(point);
    }
  }

  const bool pose = options.shape.pose && !fine_tune;
  const double peak = fine_tune ? kFineTuneRate : kPeakRate;
  AugmentedBatches batches(set, kept, kBatch, pose, options.seed, state.samples);
  const double started_s = now_s() - state.seconds;
  const auto fraction = [&] {
    return options.samples > 0 ? static_cast<double>(state.samples) / static_cast<double>(options.samples)
                               : state.seconds / (3600 * options.hours);
  };
  const bool terminal = isatty(STDERR_FILENO) != 0;
  double saved_s = now_s(), shown_s = saved_s, rate_from_s = saved_s;
  std::uint64_t rate_from = state.samples;
  double iou = log["points"].empty() ? 0 : log["points"].back()["held_out_iou"].get<double>();
  Tally tally;

  const auto progress_line = [&] {
    const double now = now_s(), done = fraction();
    const double per_s = static_cast<double>(state.samples - rate_from) / std::max(1e-9, now - rate_from_s);
    const double left_s = options.samples > 0 ? static_cast<double>(options.samples - state.samples) / per_s
                                              : 3600 * options.hours - state.seconds;
    return fmt::format(
        "{} samples ({:.1f} %), {:.1f} samples/s, loss {:.4f} mask {:.4f} pose, held-out IoU {:.4f}, "
        "{:.0f} min left",
        state.samples, 100 * std::min(1.0, done), per_s, tally.mask / std::max(1, tally.batches),
        tally.pose / std::max(1, tally.batches), iou, std::max(0.0, left_s) / 60);
  };
  const auto save = [&](bool end) {
    const MaskScore score =
        evaluate(state.network, held_out, spread(held_out.size(), end ? held_out.size() : kWatchedHeldOut));
    iou = score.iou;
    state.seconds = now_s() - started_s;
    if (tally.batches > 0) {
      Json point = {{"samples", state.samples},
                    {"seconds", state.seconds},
                    {"learning_rate", learning_rate(std::min(1.0, fraction()), peak)},
                    {"mask_loss", tally.mask / tally.batches}};
      if (pose) point["pose_loss"] = tally.pose / tally.batches;
      point["held_out_iou"] = score.iou;
      point["held_out_gradient_error"] = score.gradient_error;
      log["points"].push_back(point);
    }
    replace_file(log_path, log.dump(1) + "\n");
    replace_file(options.output + "/chart.html", chart_page(log["points"]));
    replace_file(options.output + "/person.safetensors", safetensors(folded_layers(state.network)));
    write_checkpoint(state, checkpoint);
    fmt::print(stderr, "{}{}\n", terminal ? "\r\x1b[K" : "", progress_line());
    if (end) {
      fmt::print("{} held-out samples: mean IoU {:.4f}, gradient error {:.6f}\n", held_out.size(), score.iou,
                 score.gradient_error);
    }
    tally = {};
    saved_s = now_s();
    rate_from_s = saved_s;
    rate_from = state.samples;
  };

  while (fraction() < 1 && !stop) {
    const Batch batch = batches.next();
    for (auto& group : state.optimiser->param_groups()) group.options().set_lr(learning_rate(fraction(), peak));
    state.network->train();
    const Losses losses = losses_of(state.network->forward(batch.input), batch);
    state.optimiser->zero_grad();
    losses.total().backward();
    state.optimiser->step();
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
  save(!stop);
}

}  // namespace dualpixel::tools
