#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

/// Strict reading of JSON: every value is range-checked, unknown keys are refused, and every fault becomes one
/// InputError line such as
///   scenes/portrait.json: /camera/focus_distance_m: -1: must be a number in [0.01, inf]
///   scenes/portrait.json: /camera/focal_lenght_mm: unknown field; did you mean 'focal_length_mm'?
namespace dualpixel {

/// Parses the file; refuses files over 64 MB, nesting deeper than 256, duplicate keys.
nlohmann::json read_json_file(const std::string& path);

/// Parses text in the same way; `file` names it in messages.
nlohmann::json parse_json(const std::string& text, const std::string& file);

/// Sets the field that `assignment` ("camera.focus_distance_m=0.9") names to its value, read as JSON where that
/// parses and as a string otherwise. Intermediate objects must exist or are created; array elements go by index.
void apply_override(nlohmann::json& root, const std::string& assignment);

/// One JSON object being read. Each reader leaves its target unchanged when the key is absent (so the default in the
/// struct holds), unless `required()` asked for it. Call `done()` last: it refuses keys that no reader asked for.
class Fields {
 public:
  Fields(const nlohmann::json& object, std::string file, std::string pointer = "");

  /// For an object that is another with the fields of `own` laid over it: faults in what `own` has are told of under
  /// that one's file and pointer. `own` must outlive the reading.
  Fields& laid_over(const nlohmann::json& own, std::string file, std::string pointer);

  bool has(const std::string& key);
  Fields& required(const std::string& key);

  /// Closed range; JSON has no infinity, so the string "inf" is accepted where `high` is infinite.
  Fields& number(const std::string& key, double& value, double low, double high);
  Fields& number(const std::string& key, float& value, double low, double high);
  Fields& integer(const std::string& key, int& value, std::int64_t low, std::int64_t high);
  Fields& integer(const std::string& key, std::uint64_t& value, std::uint64_t low, std::uint64_t high);
  Fields& boolean(const std::string& key, bool& value);
  Fields& text(const std::string& key, std::string& value);
  Fields& choice(const std::string& key, std::string& value, const std::vector<std::string>& allowed);
  /// Exactly `count` finite numbers.
  Fields& numbers(const std::string& key, double* values, std::size_t count);

  /// Any count up to `most` of numbers in a closed range.
  Fields& list(const std::string& key, std::vector<double>& values, double low, double high, std::size_t most);

  /// The objects of the array under `key`, none where absent.
  std::vector<Fields> objects(const std::string& key);
  /// The object under `key`, an empty one where absent.
  Fields object(const std::string& key);
  /// The value under `key` as it stands; null where absent.
  const nlohmann::json& raw(const std::string& key);

  void done();

  /// Throws InputError "file: pointer/key: message".
  [[noreturn]] void fail(const std::string& key, const std::string& message) const;

 private:
  const nlohmann::json* find(const std::string& key);

  const nlohmann::json& object_;
  std::string file_;
  std::string pointer_;
  const nlohmann::json* own_ = nullptr;  ///< see laid_over
  std::string own_file_, own_pointer_;
  std::vector<std::string> known_;
};

}  // namespace dualpixel
