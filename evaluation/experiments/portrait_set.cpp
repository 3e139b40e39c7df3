#include "evaluation/experiments/portrait_set.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/image/image_io.h"
#include "capture/json_fields.h"

namespace dualpixel::evaluation {
namespace {

namespace fs = std::filesystem;

/// The first of `names` that the folder holds; empty: none of them.
std::string first_of(const std::string& folder, std::initializer_list<const char*> names) {
  std::error_code missing;
  for (const char* name : names) {
    std::string path = folder + "/" + name;
    if (fs::exists(path, missing)) return path;
  }
  return "";
}

/// Paths by the name without extension.
std::map<std::string, std::string> files_by_name(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const fs::path& path : regular_files(folder)) {
    if (!files.emplace(path.stem().string(), path.string()).second) {
      throw InputError(printable(path.string()) + ": another file of " + printable(folder) + " has that name, too");
    }
  }
  return files;
}

/// One name a line, with or without an extension.
std::vector<std::string> read_names(const std::string& path) {
  constexpr std::size_t kMostBytes = std::size_t{4} << 20;
  std::string text = read_file(path, kMostBytes);
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);  // a byte order mark
  std::istringstream lines(text);
  std::vector<std::string> names;
  for (std::string name; lines >> name;) {
    name = fs::path(name).stem().string();
    if (std::find(names.begin(), names.end(), name) != names.end()) {
      throw InputError(printable(path) + ": " + printable(name) + ": is named twice");
    }
    names.push_back(name);
  }
  if (names.empty()) throw InputError(printable(path) + ": holds no names");
  return names;
}

pipeline::Face face_of(const nlohmann::json& faces, const MaskedPicture& portrait, const std::string& file) {
  if (!faces.is_object() || !faces.contains(portrait.name)) {
    throw InputError(fmt::format("{}: /{}: is missing: every portrait that is scored needs its face", printable(file),
                                 printable(portrait.name)));
  }
  double box[4] = {};
  Fields fields(faces, file);
  fields.numbers(portrait.name, box, 4);
  const PictureSize size = picture_size(portrait.picture);
  const double x = box[0] + box[2] / 2, y = box[1] + box[3] / 2;
  if (!(box[2] > 0 && box[3] > 0 && x >= 0 && x < size.width && y >= 0 && y < size.height)) {
    fields.fail(portrait.name,
                fmt::format("[{}]: must be [x, y, width, height] with its center in the picture of {} x {}",
                            fmt::join(box, ", "), size.width, size.height));
  }
  return {box[0], box[1], box[2], box[3]};
}

const std::string& file_named(const std::map<std::string, std::string>& files, const std::string& name,
                              const std::string& folder) {
  const auto found = files.find(name);
  if (found == files.end()) throw InputError(printable(folder) + ": holds no file " + printable(name));
  return found->second;
}

}  // namespace

std::vector<MaskedPicture> read_portrait_set(const std::string& folder) {
  std::error_code missing;
  if (!fs::is_directory(folder, missing)) throw InputError(printable(folder) + ": no such folder");
  const std::string pictures = first_of(folder, {"Images", "images_data_crop"});
  const std::string masks = first_of(folder, {"Labels", "GT_png"});
  if (pictures.empty() || masks.empty()) {
    throw InputError(printable(folder) + ": needs folders Images or images_data_crop, and Labels or GT_png");
  }
  const std::map<std::string, std::string> picture_files = files_by_name(pictures), mask_files = files_by_name(masks);
  const std::string list = first_of(folder, {"eg1800_test.txt", "testlist.txt", "test.txt"});
  std::vector<std::string> names;
  if (!list.empty())
    names = read_names(list);
  else {
    for (const auto& [name, path] : picture_files) names.push_back(name);
  }
  const std::string suffix = fs::path(masks).filename() == "GT_png" ? "_mask" : "";
  std::vector<MaskedPicture> set;
  for (const std::string& name : names) {
    set.push_back(
        {name, file_named(picture_files, name, pictures), file_named(mask_files, name + suffix, masks), {}, true});
  }
  if (set.empty()) throw InputError(printable(pictures) + ": holds no pictures");
  const std::string faces_file = first_of(folder, {"faces.json"});
  if (faces_file.empty()) return set;
  const nlohmann::json faces = read_json_file(faces_file);
  for (MaskedPicture& portrait : set) portrait.faces = {face_of(faces, portrait, faces_file)};
  return set;
}

std::vector<PortraitSetRow> portrait_set_table(const std::vector<PictureMaskScore>& automatic,
                                               const std::vector<PictureMaskScore>& given,
                                               const std::string& training) {
  std::vector<PortraitSetRow> table = {{"PortraitFCN+ (Shen et al. 2016)", "Shen et al. 2016", 0.9591},
                                       {"Wadhwa et al. 2018", "Shen et al. 2016", 0.9701},
                                       {"Wadhwa et al. 2018", "theirs", 0.9770}};
  for (const auto& [faces, scores] : {std::pair{"faces found", &automatic}, std::pair{"faces given", &given}}) {
    if (scores->empty()) continue;
    const MaskMeans means = means_of(*scores);
    table.push_back({fmt::format("dualpixel, {}", faces), training, means.iou, means.count});
    table.push_back({fmt::format("dualpixel, {}, filtered", faces), training, means.filtered_iou, means.count});
  }
  return table;
}

std::string to_text(const std::vector<PortraitSetRow>& table) {
  std::string text = fmt::format("{:<36}{:<20}{:>10}{:>10}\n", "model", "training data", "mean IoU", "pictures");
  for (const PortraitSetRow& row : table) {
    text += fmt::format("{:<36}{:<20}{:>8.2f} %{:>10}\n", row.model, row.training, 100 * row.iou,
                        row.pictures > 0 ? fmt::to_string(row.pictures) : "theirs");
  }
  return text;
}

nlohmann::ordered_json to_json(const std::vector<PortraitSetRow>& table) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const PortraitSetRow& row : table) {
    rows.push_back({{"model", row.model}, {"training_data", row.training}, {"mean_iou", row.iou}});
    if (row.pictures > 0) rows.back()["pictures"] = row.pictures;
  }
  return rows;
}

}  // namespace dualpixel::evaluation
