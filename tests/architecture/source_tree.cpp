#include "tests/architecture/source_tree.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <functional>
#include <sstream>
#include <string_view>

namespace dualpixel::architecture {
namespace {

/// Copies `text` with everything that can hold stray braces replaced by spaces; line ends stay, so that lines keep
/// their numbers.
class Blanker {
 public:
  explicit Blanker(const std::string& text) : text_(text), result_(text) {}

  std::string run() {
    while (at_ < text_.size()) {
      if (starts("//")) {
        blank_until(text_.find('\n', at_));
      } else if (starts("/*")) {
        blank_until(end_after("*/", at_ + 2));
      } else if (starts("R\"") && !in_word()) {
        const std::size_t open = text_.find('(', at_);
        const std::string end = ")" + text_.substr(at_ + 2, open - at_ - 2) + "\"";
        blank_until(end_after(end, open));
      } else if (text_[at_] == '"') {
        blank_until(end_of_literal());
      } else if (text_[at_] == '\'' && !in_word()) {  // not the separator in 1'000
        blank_until(end_of_literal());
      } else {
        ++at_;
      }
    }
    return result_;
  }

 private:
  bool starts(std::string_view what) const { return text_.compare(at_, what.size(), what) == 0; }
  bool in_word() const {
    return at_ > 0 && (std::isalnum(static_cast<unsigned char>(text_[at_ - 1])) != 0 || text_[at_ - 1] == '_');
  }
  std::size_t end_after(const std::string& what, std::size_t from) const {
    const std::size_t found = text_.find(what, from);
    return found == std::string::npos ? found : found + what.size();
  }
  std::size_t end_of_literal() const {
    std::size_t i = at_ + 1;
    while (i < text_.size() && text_[i] != text_[at_]) i += text_[i] == '\\' ? 2 : 1;
    return i + 1;
  }
  void blank_until(std::size_t end) {
    end = std::min(end, text_.size());
    for (; at_ < end; ++at_) {
      if (text_[at_] != '\n') result_[at_] = ' ';
    }
  }

  const std::string& text_;
  std::string result_;
  std::size_t at_ = 0;
};

/// Blanks preprocessor lines, and what stands between `#else` or `#elif` and its `#endif`: braces balance in one branch
/// only.
void blank_directives(std::string& text) {
  std::vector<bool> skipped;  // one entry for each open #if: whether its first branch has ended
  bool continued = false;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::size_t first = text.find_first_not_of(" \t", begin);
    first = std::min(first, end);
    const bool directive = continued || (first < end && text[first] == '#');
    if (directive && !continued) {
      const std::size_t word = text.find_first_not_of(" \t", first + 1);
      const auto is = [&](std::string_view name) { return text.compare(word, name.size(), name) == 0; };
      if (is("if")) {
        skipped.push_back(false);
      } else if (is("el") && !skipped.empty()) {
        skipped.back() = true;
      } else if (is("endif") && !skipped.empty()) {
        skipped.pop_back();
      }
    }
    continued = directive && end > begin && text[end - 1] == '\\';
    if (directive || std::find(skipped.begin(), skipped.end(), true) != skipped.end()) {
      std::fill(text.begin() + static_cast<std::ptrdiff_t>(begin), text.begin() + static_cast<std::ptrdiff_t>(end),
                ' ');
    }
    begin = end + 1;
  }
}

enum class Scope { outer, function, other };  // outer: namespace, class, struct, union, enum

bool has_word(const std::string& head, std::string_view word) {
  for (std::size_t at = head.find(word); at != std::string::npos; at = head.find(word, at + 1)) {
    const auto letter = [&](std::size_t i) {
      return i < head.size() && (std::isalnum(static_cast<unsigned char>(head[i])) != 0 || head[i] == '_');
    };
    if (!(at > 0 && letter(at - 1)) && !letter(at + word.size())) return true;
  }
  return false;
}

/// Whether the brace after `head` opens a member initializer, as in `Lens() : f_number_{2}`, and not the body: it then
/// follows a name.
bool in_member_initializer(const std::string& head) {
  int depth = 0;
  bool colon = false;
  for (std::size_t i = 0; i < head.size(); ++i) {
    if (head[i] == '(') ++depth;
    if (head[i] == ')') --depth;
    const bool double_colon = (i > 0 && head[i - 1] == ':') || (i + 1 < head.size() && head[i + 1] == ':');
    if (head[i] == ':' && depth == 0 && !double_colon && head.find(')') < i) colon = true;
  }
  const std::size_t last = head.find_last_not_of(' ');
  return colon && last != std::string::npos && head[last] != ')' && head[last] != '}';
}

/// What a brace opens, by the text since the last statement or block ended.
Scope scope_of(const std::string& head) {
  int depth = 0;
  bool assigned = false;
  std::size_t parenthesis = std::string::npos;
  for (std::size_t i = 0; i < head.size(); ++i) {
    if (head[i] == '(' && depth++ == 0 && parenthesis == std::string::npos) parenthesis = i;
    if (head[i] == ')') --depth;
    if (head[i] == '=' && depth == 0) assigned = true;
  }
  if (depth > 0) return Scope::other;  // a brace within parentheses, e.g. a default argument
  if (has_word(head, "namespace")) return Scope::outer;
  if (parenthesis == std::string::npos) {
    const bool type = has_word(head, "struct") || has_word(head, "class") || has_word(head, "union");
    return (type || has_word(head, "enum")) && !assigned ? Scope::outer : Scope::other;
  }
  if (in_member_initializer(head)) return Scope::other;
  return assigned && !has_word(head, "operator") ? Scope::other : Scope::function;
}

/// The identifier before the first parenthesis; for gtest's macros what they name.
std::string name_in(const std::string& head) {
  const std::size_t open = head.find('(');
  const auto part = [&](std::size_t i) {
    return std::isalnum(static_cast<unsigned char>(head[i])) != 0 || head[i] == '_' || head[i] == ':' || head[i] == '~';
  };
  std::size_t end = open;
  while (end > 0 && head[end - 1] == ' ') --end;
  std::size_t begin = end;
  while (begin > 0 && part(begin - 1)) --begin;
  std::string name = head.substr(begin, end - begin);
  if (const std::size_t keyword = head.find("operator"); keyword < open) name = head.substr(keyword, open - keyword);
  if (name.starts_with("TEST")) {
    std::string inside = head.substr(open + 1, head.find(')', open) - open - 1);
    std::erase(inside, ' ');
    std::replace(inside.begin(), inside.end(), ',', '.');
    name = inside;
  }
  return name;
}

}  // namespace

std::vector<std::string> includes_of(const std::string& text) {
  std::vector<std::string> includes;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::size_t at = line.find_first_not_of(" \t");
    if (at == std::string::npos || line[at] != '#') continue;
    at = line.find_first_not_of(" \t", at + 1);
    if (at == std::string::npos || line.compare(at, 7, "include") != 0) continue;
    const std::size_t open = line.find('"', at), close = line.find('"', open + 1);
    if (open != std::string::npos && close != std::string::npos)
      includes.push_back(line.substr(open + 1, close - open - 1));
  }
  return includes;
}

std::vector<Function> functions_of(const std::string& source) {
  std::string text = Blanker(source).run();
  blank_directives(text);
  struct Open {
    Scope scope;
    Function function;
  };
  std::vector<Function> functions;
  std::vector<Open> open;
  std::string head;
  int line = 1;
  const auto inside_outer = [&] { return open.empty() || open.back().scope == Scope::outer; };
  for (const char c : text) {
    if (c == '\n') ++line;
    if (c == '{') {
      const Scope scope = inside_outer() ? scope_of(head) : Scope::other;
      open.push_back({scope, {scope == Scope::function ? name_in(head) : "", line, 0}});
      if (scope != Scope::other) head.clear();
    } else if (c == '}') {
      if (open.empty()) continue;
      Open& closed = open.back();
      if (closed.scope == Scope::function) {
        closed.function.lines = line - closed.function.line + 1;
        functions.push_back(closed.function);
      }
      const bool ends = closed.scope != Scope::other;
      open.pop_back();
      if (ends) {
        head.clear();
      } else if (inside_outer()) {
        head += '}';
      }
    } else if (c == ';' && inside_outer()) {
      head.clear();
    } else if (inside_outer()) {
      head += c == '\n' || c == '\t' ? ' ' : c;
    }
  }
  return functions;
}

std::vector<SourceFile> read_source_tree(const std::filesystem::path& root, const std::vector<std::string>& tops) {
  std::vector<SourceFile> files;
  for (const std::string& top : tops) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / top)) {
      const std::string extension = entry.path().extension().string();
      if (!entry.is_regular_file() || (extension != ".h" && extension != ".cpp")) continue;
      std::ostringstream text;
      text << std::ifstream(entry.path()).rdbuf();
      files.push_back(
          {entry.path().lexically_relative(root).generic_string(), includes_of(text.str()), functions_of(text.str())});
    }
  }
  std::sort(files.begin(), files.end(), [](const SourceFile& a, const SourceFile& b) { return a.path < b.path; });
  return files;
}

NamedPaths paths_named_in(const std::string& markdown) {
  NamedPaths named;
  for (std::size_t at = markdown.find("]("); at != std::string::npos; at = markdown.find("](", at + 1)) {
    std::string target = markdown.substr(at + 2, markdown.find(')', at) - at - 2);
    target = target.substr(0, target.find('#'));
    if (!target.empty() && target.find("://") == std::string::npos) named.links.push_back(target);
  }
  bool fenced = false;
  std::istringstream lines(markdown);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) fenced = !fenced;
    if (fenced || line.starts_with("```")) continue;
    for (std::size_t open = line.find('`'); open != std::string::npos;) {
      const std::size_t close = line.find('`', open + 1);
      if (close == std::string::npos) break;
      const std::string quoted = line.substr(open + 1, close - open - 1);
      const bool path = std::all_of(quoted.begin(), quoted.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '/' || c == '-';
      });
      if (path && quoted.find('/') != std::string::npos) named.quoted.push_back(quoted);
      open = line.find('`', close + 1);
    }
  }
  return named;
}

std::string unit_of(const std::string& path) { return path.substr(0, path.rfind('.')); }

std::string folder_of(const std::string& path) { return path.substr(0, path.rfind('/')); }

std::vector<std::string> circles_in(const std::map<std::string, std::set<std::string>>& graph) {
  std::vector<std::string> circles, path;
  std::set<std::string> done;
  const std::function<void(const std::string&)> walk = [&](const std::string& node) {
    const auto seen = std::find(path.begin(), path.end(), node);
    if (seen != path.end()) {
      std::string circle;
      for (auto step = seen; step != path.end(); ++step) circle += *step + " -> ";
      circles.push_back(circle + node);
      return;
    }
    if (done.contains(node)) return;
    path.push_back(node);
    if (const auto edges = graph.find(node); edges != graph.end()) {
      for (const std::string& next : edges->second) walk(next);
    }
    path.pop_back();
    done.insert(node);
  };
  for (const auto& [node, edges] : graph) walk(node);
  return circles;
}

}  // namespace dualpixel::architecture
