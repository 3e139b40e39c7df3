#pragma once
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>

namespace dualpixel::datasets {

/// A tar file (POSIX.1-1988 ustar) of regular files, all with the same owner and time, so that the same files give the
/// same bytes.
class TarFile {
 public:
  /// Throws InputError where `path` cannot be written; so do the others.
  explicit TarFile(const std::string& path);

  /// `name` has 100 bytes at most.
  void add(const std::string& name, std::string_view bytes);
  void close();

  std::uint64_t bytes() const { return bytes_; }

 private:
  void write(std::string_view bytes);

  std::string path_;
  std::ofstream file_;
  std::uint64_t bytes_ = 0;
};

}  // namespace dualpixel::datasets
