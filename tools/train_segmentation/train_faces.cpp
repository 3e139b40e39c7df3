#include "tools/train_segmentation/train_faces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numeric>

#include "capture/error.h"
#include "capture/files.h"
#include "pipeline/segmentation/face_map.h"
#include "tools/train_segmentation/checkpoint.h"
#include "tools/train_segmentation/export.h"

namespace dualpixel::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kBatch = 32, kEvaluated = 32;
constexpr double kCenterWeight = 5;
constexpr double kLeastScore = 0.05, kLeastOverlap = 0.5, kBorneAlarms = 0.02;
constexpr double kReportEvery_s = 60;
constexpr const char* kFacesFile = "faces.safetensors";
constexpr const char* kLogFile = "log.json";

pipeline::Face box_of(const TrueFace& face) { return {face.x, face.y, face.side, face.side}; }

/// Adds what one picture's map says.
void judge(const FacePicture& picture, std::size_t index, const float* map, std::vector<FaceFound>& found) {
  const int cells = kNetworkSize_px / pipeline::kFaceCell_px;
  std::vector<double> scores(picture.faces.size(), 0);
  for (const pipeline::ScoredFace& one : pipeline::faces_of_map(map, cells, kLeastScore)) {
    std::size_t best = 0;
    double most = 0;
    for (std::size_t i = 0; i < picture.faces.size(); ++i) {
      const double share = overlap(box_of(picture.faces[i]), one.face);
      // of an uncertain face even a part is none of a false alarm's
      const double counts = picture.faces[i].certain ? share : share > 0.1 ? kLeastOverlap : 0;
      if (counts > most) most = counts, best = i;
    }
    if (most >= kLeastOverlap) {
      scores[best] = std::max(scores[best], one.score);
    } else {
      found.push_back({index, false, 0, one.face.width, one.score});
    }
  }
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const TrueFace& face = picture.faces[i];
    if (face.certain) found.push_back({index, true, face.turn_deg, face.side, scores[i]});
  }
}

std::string scores_table(const std::vector<FaceFound>& found) {
  std::string table = "picture,is_face,turn_deg,side_px,score\n";
  for (const FaceFound& one : found) {
    table += fmt::format("{},{},{:.0f},{:.1f},{:.4f}\n", one.picture, one.is_face ? 1 : 0, one.turn_deg, one.side_px,
                         one.score);
  }
  return table;
}

}  // namespace

torch::Tensor face_loss(const torch::Tensor& map, const torch::Tensor& targets) {
  const torch::Tensor logit = map.select(1, 0), heat = targets.select(1, 0), counts = targets.select(1, 5);
  const torch::Tensor p = logit.sigmoid(), peak = (heat == 1).to(torch::kFloat);
  const torch::Tensor as_face = (1 - p).pow(2) * torch::log_sigmoid(logit) * peak;
  const torch::Tensor as_none = (1 - heat).pow(4) * p.pow(2) * torch::log_sigmoid(-logit) * (1 - peak);
  const torch::Tensor faces = peak.sum().clamp_min(1);
  const torch::Tensor score_loss = -((as_face + as_none) * counts).sum() / faces;
  const torch::Tensor weight = targets.select(1, 4), weights = weight.sum().clamp_min(1);
  const torch::Tensor errors = (map - targets.narrow(1, 0, 4)).abs();
  const torch::Tensor center = ((errors.select(1, 1) + errors.select(1, 2)) * weight).sum() / weights;
  const torch::Tensor size = (errors.select(1, 3) * weight).sum() / weights;
  return score_loss + kCenterWeight * center + size;
}

std::vector<FaceFound> find_faces_of(Network& network, const FaceExamples& examples, torch::Device device) {
  const torch::NoGradGuard no_gradients;
  network->eval();
  std::vector<FaceFound> found;
  const std::size_t count = examples.pictures().size();
  for (std::size_t first = 0; first < count; first += kEvaluated) {
    const std::size_t some = std::min<std::size_t>(kEvaluated, count - first);
    const torch::Tensor input = examples.plain(first, some).input.to(device);
    const torch::Tensor maps = network->face_map(input).to(torch::kFloat).cpu().contiguous();
    for (std::size_t i = 0; i < some; ++i) {
      judge(examples.pictures()[first + i], first + i, maps[static_cast<std::int64_t>(i)].data_ptr<float>(), found);
    }
  }
  return found;
}

double recall_at(const std::vector<FaceFound>& found, std::size_t pictures, double alarms_per_picture) {
  std::vector<double> alarms;
  double faces = 0, right = 0;
  for (const FaceFound& one : found) {
    if (!one.is_face) alarms.push_back(one.score);
  }
  std::sort(alarms.rbegin(), alarms.rend());
  const auto borne = static_cast<std::size_t>(alarms_per_picture * static_cast<double>(pictures));
  const double threshold = borne < alarms.size() ? alarms[borne] : 0;
  for (const FaceFound& one : found) {
    if (!one.is_face) continue;
    ++faces;
    right += one.score > threshold ? 1 : 0;
  }
  return faces > 0 ? right / faces : 0;
}

void train_faces(const TrainOptions& options, const std::function<bool(std::uint64_t samples)>& stop) {
  const scenes::PeopleSet set(options.data, false, scenes::PeopleSetKind::faces),
      held_out_set(options.held_out, true, scenes::PeopleSetKind::faces);
  const FaceExamples examples(set), held_out(held_out_set);
  const int threads = ready_threads(options);
  require_no_run(options.output, kLogFile, "name another folder");
  make_run_folder(options.output);
  Checkpoint state = new_checkpoint(face_network_shape(), options.seed);
  state.network->to(options.device);
  forget_optimizer(state);
  std::vector<std::size_t> all(examples.pictures().size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  AugmentedBatches batches(all, kBatch, options.seed, 0,
                           [&](const std::vector<Draw>& draws) { return examples.augmented(draws); });
  const double peak = options.rate > 0 ? options.rate : 3e-3;
  const double started_s = now_s();
  double reported_s = started_s, loss_sum = 0;
  int losses = 0;
  Json points = Json::array();
  const auto fraction = [&] {
    return options.samples == 0 ? (now_s() - started_s) / (3600 * options.hours)
                                : static_cast<double>(state.samples) / static_cast<double>(options.samples);
  };
  const auto save = [&] {
    const std::vector<FaceFound> found = find_faces_of(state.network, held_out, options.device);
    const double recall = recall_at(found, held_out.pictures().size(), kBorneAlarms);
    points.push_back({{"samples", state.samples},
                      {"seconds", now_s() - started_s},
                      {"loss", loss_sum / std::max(1, losses)},
                      {"held_out_recall", recall}});
    fmt::print(stderr, "{} samples, {:.0f} s, loss {:.4f}, held-out recall at {} false alarms a picture {:.4f}\n",
               state.samples, now_s() - started_s, loss_sum / std::max(1, losses), kBorneAlarms, recall);
    const Json log = {{"data_hash", set.hash()}, {"held_out_hash", held_out_set.hash()},
                      {"seed", options.seed},    {"samples", options.samples},
                      {"hours", options.hours},  {"rate", peak},
                      {"threads", threads},      {"training_pictures", examples.pictures().size()},
                      {"points", points}};
    replace_file(options.output + "/" + kLogFile, log.dump(1) + "\n");
    replace_file(options.output + "/" + kFacesFile, safetensors(folded_layers(state.network)));
    replace_file(options.output + "/scores.csv", scores_table(found));
    loss_sum = losses = 0;
    reported_s = now_s();
  };
  while (fraction() < 1 && !stop(state.samples)) {
    const Batch batch = on(options.device, batches.next());
    for (auto& group : state.optimizer->param_groups()) {
      group.options().set_lr(learning_rate(std::min(1.0, fraction()), peak, false));
    }
    state.network->train();
    const torch::Tensor loss = face_loss(state.network->face_map(batch.input), batch.heatmaps);
    state.optimizer->zero_grad();
    loss.backward();
    state.optimizer->step();
    state.samples += kBatch;
    loss_sum += loss.item<double>();
    ++losses;
    if (!std::isfinite(loss_sum)) throw std::runtime_error("the loss is not finite: training has diverged");
    if (now_s() - reported_s > kReportEvery_s) save();
  }
  save();
}

}  // namespace dualpixel::tools
