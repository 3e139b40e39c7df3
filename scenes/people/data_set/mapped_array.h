#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace dualpixel::scenes {

/// A NumPy file (version 1, C order) of uint8 or little-endian float32, mapped. Throws InputError where it is
/// anything else, or shorter or longer than its header says.
class MappedArray {
 public:
  explicit MappedArray(const std::string& path);
  ~MappedArray();
  MappedArray(const MappedArray&) = delete;
  MappedArray& operator=(const MappedArray&) = delete;

  const std::string& path() const { return path_; }
  const std::vector<std::size_t>& shape() const { return shape_; }
  /// Values from item `i` of the first dimension on, which must have been checked with require().
  const std::uint8_t* bytes(std::size_t i) const;
  const float* floats(std::size_t i) const;
  /// Throws InputError unless the file holds `type` values of the shape (any, rest...).
  void require(const std::string& type, const std::vector<std::size_t>& rest) const;

 private:
  void read_header();

  std::string path_;
  std::string type_;
  std::vector<std::size_t> shape_;
  std::size_t item_bytes_ = 0;
  std::size_t header_bytes_ = 0;
  std::size_t file_bytes_ = 0;
  const char* file_ = nullptr;
};

}  // namespace dualpixel::scenes
