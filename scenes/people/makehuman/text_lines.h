#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace dualpixel::scenes {

/// The words of a text file, line by line. Errors (InputError) name the file and the line.
class TextLines {
 public:
  explicit TextLines(const std::string& path);

  /// The next line that has words and is no comment; false at the end.
  bool next(std::vector<std::string_view>& words);

  [[noreturn]] void fail(const std::string& what) const;
  float number(std::string_view word) const;
  /// A whole number from 0 to count - 1.
  int index(std::string_view word, int count) const;
  bool is_number(std::string_view word) const;

 private:
  std::string path_, bytes_;
  std::size_t at_ = 0;
  int number_ = 0;
};

}  // namespace dualpixel::scenes
