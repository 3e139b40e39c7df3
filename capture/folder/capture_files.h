#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "capture/folder/capture_check.h"

/// The files in a capture's folder: their names, and the manifest in capture.json ("files": path, bytes, xxh64).
namespace dualpixel {

inline constexpr const char* kCaptureFormat = "dualpixel-capture";
inline constexpr const char* kCaptureMarker = "capture.json";
inline constexpr const char* kGeometryFile = "truth/geometry.exr";
inline constexpr const char* kAllInFocusFile = "truth/all_in_focus.exr";
inline constexpr const char* kPhotographFile = "truth/photograph.exr";
inline constexpr const char* kViewsFile = "truth/views.exr";
inline constexpr const char* kSamplingFile = "truth/sampling.exr";

/// Of the motion from the first frame to frame i + 1.
std::string motion_file(std::size_t i);

/// Reads or writes one file; independent of the others.
using FileTask = std::function<void()>;
void run_parallel(const std::vector<FileTask>& tasks);

/// The manifest of the files `names` under `folder`.
nlohmann::ordered_json make_manifest(const std::string& folder, const std::vector<std::string>& names);

/// The files of a capture that is being read: paths, and what its manifest says of them.
class CaptureFiles {
 public:
  /// `manifest` is null where capture.json has none. Throws InputError where it is malformed, or where a listed file is
  /// missing or of another size.
  CaptureFiles(const std::string& folder, const nlohmann::json& manifest, const CaptureCheck& check);

  /// The path of a file that the field `pointer` of capture.json names, inside the folder and unchanged since the
  /// manifest was written. Throws InputError.
  std::string verified(const std::string& name, const std::string& pointer) const;

 private:
  struct Entry {
    std::uint64_t bytes = 0;
    std::string xxh64;
  };

  /// Refuses names that lead out of the folder, by their text or by a link.
  std::string locate(const std::string& name, const std::string& pointer) const;

  std::string folder_;
  CaptureCheck check_;
  bool has_manifest_ = false;
  std::map<std::string, Entry> entries_;
};

}  // namespace dualpixel
