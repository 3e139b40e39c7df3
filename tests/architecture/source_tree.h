#pragma once
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

/// What the architecture test reads out of the source files: include lines and the lengths of functions.
namespace dualpixel::architecture {

struct Function {
  std::string name;
  int line = 0;   // where its body opens, from 1
  int lines = 0;  // from the line of the opening brace to that of the closing one, both counted
};

struct SourceFile {
  std::string path;                   // from the repository's root, e.g. "pipeline/burst/merge.cpp"
  std::vector<std::string> includes;  // as written between quotes; those in angle brackets are left out
  std::vector<Function> functions;    // at namespace or class scope; a lambda counts as part of what holds it
};

/// What `#include "..."` lines name, in order.
std::vector<std::string> includes_of(const std::string& text);

/// Functions that C++ source defines at namespace or class scope. This is no parser: it drops comments, literals,
/// preprocessor lines and `#else` branches, then tells functions from types, namespaces and initializers by what
/// precedes each brace.
std::vector<Function> functions_of(const std::string& text);

/// Every .h and .cpp under the folders `tops` of `root`, in order of path.
std::vector<SourceFile> read_source_tree(const std::filesystem::path& root, const std::vector<std::string>& tops);

/// What a Markdown document names in the repository: targets of its links, without anchors and web addresses, and what
/// it quotes in single backticks, where that is a path. Links are relative to the document, quoted paths to the root.
struct NamedPaths {
  std::vector<std::string> links, quoted;
};
NamedPaths paths_named_in(const std::string& markdown);

/// Path without its extension: a header and the source file of its name are one unit.
std::string unit_of(const std::string& path);

/// Folder of a path: "pipeline/burst" of "pipeline/burst/merge.cpp".
std::string folder_of(const std::string& path);

/// Circles in a graph of includes, each as "a -> b -> a"; empty where the graph has none. One circle for each edge that
/// closes one in a depth-first walk.
std::vector<std::string> circles_in(const std::map<std::string, std::set<std::string>>& graph);

}  // namespace dualpixel::architecture
