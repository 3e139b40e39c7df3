#include "capture/folder/capture_files.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "capture/files.h"
#include "capture/json_fields.h"

namespace dualpixel {

namespace fs = std::filesystem;

std::string motion_file(std::size_t i) { return fmt::format("truth/motion_{:03}.exr", i + 1); }

void run_parallel(const std::vector<FileTask>& tasks) {
  tbb::parallel_for(std::size_t{0}, tasks.size(), [&](std::size_t i) { tasks[i](); });
}

nlohmann::ordered_json make_manifest(const std::string& folder, const std::vector<std::string>& names) {
  std::vector<nlohmann::ordered_json> manifest(names.size());
  tbb::parallel_for(std::size_t{0}, names.size(), [&](std::size_t i) {
    const std::string bytes = read_file(folder + "/" + names[i]);
    manifest[i] = {{"path", names[i]}, {"bytes", bytes.size()}, {"xxh64", hash_of(bytes)}};
  });
  return manifest;
}

CaptureFiles::CaptureFiles(const std::string& folder, const nlohmann::json& manifest, const CaptureCheck& check)
    : folder_(folder), check_(check) {
  if (manifest.is_null()) return;
  check_.require(manifest.is_array(), "/files", "must be an array");
  has_manifest_ = true;
  for (std::size_t i = 0; i < manifest.size(); ++i) {
    const std::string pointer = fmt::format("/files/{}", i);
    Fields fields(manifest[i], folder_ + "/" + kCaptureMarker, pointer);
    std::string name;
    Entry entry;
    fields.required("path").text("path", name);
    fields.required("bytes").integer("bytes", entry.bytes, 0, std::numeric_limits<std::uint64_t>::max());
    fields.required("xxh64").text("xxh64", entry.xxh64);
    fields.done();
    check_.require(entries_.emplace(name, entry).second, pointer + "/path", printable(name) + " is listed twice");
    std::string file = locate(name, pointer + "/path");
    std::error_code error;
    const auto bytes = fs::file_size(file, error);
    if (error) throw InputError(printable(file) + ": is listed in capture.json but cannot be read");
    if (bytes != entry.bytes) {
      throw InputError(fmt::format("{}: has {} bytes; capture.json says {}", printable(file), bytes, entry.bytes));
    }
  }
}

std::string CaptureFiles::verified(const std::string& name, const std::string& pointer) const {
  std::string file = locate(name, pointer);
  require_regular_file(file);
  if (has_manifest_) {
    const auto entry = entries_.find(name);
    check_.require(entry != entries_.end(), pointer, printable(name) + " is not listed under /files");
    if (file_hash(file) != entry->second.xxh64) {
      throw InputError(printable(file) + ": its xxh64 is not the one in capture.json: the file was changed");
    }
  }
  return file;
}

std::string CaptureFiles::locate(const std::string& name, const std::string& pointer) const {
  const fs::path relative(name);
  const bool inside = !name.empty() && name.find('\0') == std::string::npos && relative.is_relative() &&
                      std::find(relative.begin(), relative.end(), "..") == relative.end();
  check_.require(inside, pointer, printable(name) + ": must be a path inside the capture's folder");
  std::error_code error;
  const fs::path root = fs::canonical(folder_, error);
  const fs::path file = fs::weakly_canonical(root / relative, error);
  check_.require(!error && std::mismatch(root.begin(), root.end(), file.begin(), file.end()).first == root.end(),
                 pointer, printable(name) + ": leads out of the capture's folder");
  return (fs::path(folder_) / relative).string();
}

}  // namespace dualpixel
