#include "capture/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <string_view>

namespace dualpixel {
namespace {

constexpr std::size_t kLongestComparedName = 64;

/// Length of the well-formed UTF-8 sequence (RFC 3629) at the start of `text`, or 0.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const std::size_t length = byte(0) < 0x80 ? 1 : byte(0) < 0xc2 ? 0 : byte(0) < 0xe0 ? 2 : byte(0) < 0xf0 ? 3 : 4;
  if (length == 0 || byte(0) > 0xf4 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  if (length > 2) {
    // Overlong forms, surrogates and code points past U+10FFFF show in the second byte.
    const int lead_and_second = byte(0) << 8 | byte(1);
    if (lead_and_second < 0xe0a0 || (lead_and_second >= 0xeda0 && lead_and_second <= 0xedbf)) return 0;
    if (lead_and_second >= 0xf000 && (lead_and_second < 0xf090 || lead_and_second > 0xf48f)) return 0;
  }
  return length;
}

/// Characters that would break the line or reorder it: controls (C0, DEL, C1), line separators, and the marks and
/// overrides of writing direction.
bool is_control(std::string_view character) {
  if (character.size() == 1) return static_cast<unsigned char>(character[0]) < 0x20 || character[0] == 0x7f;
  if (character.size() == 2) return character[0] == '\xc2' && static_cast<unsigned char>(character[1]) < 0xa0;
  for (const char* listed : {"\u200e", "\u200f", "\u2028", "\u2029", "\u202a", "\u202b", "\u202c", "\u202d", "\u202e",
                             "\u2066", "\u2067", "\u2068", "\u2069"}) {
    if (character == listed) return true;
  }
  return false;
}

/// Levenshtein's distance: the fewest insertions, deletions and substitutions that turn one name into the other.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row[b.size()];
}

}  // namespace

std::string printable(const std::string& text, std::size_t longest_bytes) {
  std::string line;
  for (std::size_t i = 0; i < text.size();) {
    if (line.size() > longest_bytes) return line + "...";
    const std::size_t length = utf8_length(std::string_view(text).substr(i));
    const std::string_view character(text.data() + i, std::max<std::size_t>(length, 1));
    if (character == "\n") {
      line += "\\n";
    } else if (length == 0 || is_control(character)) {
      for (const char byte : character) line += fmt::format("\\x{:02x}", static_cast<unsigned char>(byte));
    } else {
      line += character;
    }
    i += character.size();
  }
  return line;
}

std::string did_you_mean(const std::string& name, const std::vector<std::string>& known) {
  if (name.size() > kLongestComparedName) return "";
  // A third of the letters may be wrong; beyond that a guess confuses more than it helps.
  std::size_t best_distance = std::max<std::size_t>(name.size() / 3, 1) + 1;
  const std::string* best = nullptr;
  for (const std::string& candidate : known) {
    const std::size_t distance = edit_distance(name, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = &candidate;
    }
  }
  return best ? fmt::format("; did you mean '{}'?", *best) : "";
}

}  // namespace dualpixel
