#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "capture/capture.h"
#include "datasets/plan/sample_line.h"
#include "scenes/drawn/meter.h"

/// A sample on the disk: DATASET/samples/NAME with its pictures and sample.json.
namespace dualpixel::datasets {

inline constexpr const char* kSampleFile = "sample.json";
inline constexpr const char* kPreviewFile = "preview.png";
inline constexpr const char* kSamplesFolder = "samples";

std::string sample_folder(const std::string& dataset, const SampleLine& line);

struct SampleFile {
  std::string name;   ///< in the sample's folder
  std::string xxh64;  ///< of its bytes as they were written
};

/// What is made of a line.
struct RenderedSample {
  Capture capture;
  std::optional<scenes::MissedExposure> missed_exposure;  ///< of relations.exposure_mean
  std::vector<std::string> scene_warnings = {};           ///< what drawing the scene said of it, one line each
};

/// Whether the sample is there. Its folder appears in one step, so that it is whole.
bool is_there(const std::string& dataset, const SampleLine& line);

/// Throws InputError where `path` is a link: nothing is to be written or removed in what it leads to, which may be
/// anybody's.
void require_no_link(const std::string& path);

/// Writes the line's pictures of the capture and sample.json: the line, the scene file that the capture was made of,
/// camera, exposure and a manifest of sizes and hashes. Throws InputError where it cannot be written, or a
/// picture, or the views' light, is not finite.
void write_sample(const SampleLine& line, const RenderedSample& sample, const std::string& dataset);

/// The files of a sample, preview included, from its sample.json, which is `document`: they are those that the
/// line keeps, whatever the document says. Throws InputError where it names others, is another line's, or one is not
/// there or is no regular file.
std::vector<SampleFile> files_of_sample(const std::string& dataset, const SampleLine& line,
                                        const nlohmann::json& document);

/// Why the sample is not as it was written from this line; empty where it is.
std::string fault_of_sample(const std::string& dataset, const SampleLine& line);

}  // namespace dualpixel::datasets
