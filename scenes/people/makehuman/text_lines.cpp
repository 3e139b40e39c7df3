#include "scenes/people/makehuman/text_lines.h"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "capture/error.h"
#include "capture/files.h"

namespace dualpixel::scenes {

TextLines::TextLines(const std::string& path) : path_(path), bytes_(read_file(path, std::size_t{64} << 20)) {}

bool TextLines::next(std::vector<std::string_view>& words) {
  while (at_ < bytes_.size()) {
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    const std::string_view line(bytes_.data() + at_, end - at_);
    at_ = end + 1;
    ++number_;
    words.clear();
    for (std::size_t i = 0; i < line.size();) {
      while (i < line.size() && std::isspace(static_cast<unsigned char>(line[i])) != 0) ++i;
      const std::size_t first = i;
      while (i < line.size() && std::isspace(static_cast<unsigned char>(line[i])) == 0) ++i;
      if (i > first) words.push_back(line.substr(first, i - first));
    }
    if (!words.empty() && words[0][0] != '#') return true;
  }
  return false;
}

void TextLines::fail(const std::string& what) const {
  throw InputError(fmt::format("{}:{}: {}", printable(path_), number_, what));
}

float TextLines::number(std::string_view word) const {
  float value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value) || std::abs(value) > 1e6f) {
    fail(fmt::format("'{}' is not a number", printable(std::string(word), 40)));
  }
  return value;
}

int TextLines::index(std::string_view word, int count) const {
  int value = -1;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || value < 0 || value >= count) {
    fail(fmt::format("'{}' is not an index from 0 to {}", printable(std::string(word), 40), count - 1));
  }
  return value;
}

bool TextLines::is_number(std::string_view word) const {
  return !word.empty() && (std::isdigit(static_cast<unsigned char>(word[0])) != 0 || word[0] == '-');
}

}  // namespace dualpixel::scenes
