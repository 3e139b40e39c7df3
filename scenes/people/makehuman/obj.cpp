#include "scenes/people/makehuman/obj.h"

#include <string_view>
#include <utility>

#include "scenes/people/makehuman/text_lines.h"

namespace dualpixel::scenes {

ObjMesh read_obj(const std::string& path, const std::string& kept) {
  TextLines lines(path);
  ObjMesh obj;
  std::vector<vec2> uvs = {};
  std::map<std::pair<int, int>, unsigned> corner_of;
  std::string group;
  std::vector<std::string_view> words;
  while (lines.next(words)) {
    if (words[0] == "v") {
      if (words.size() < 4) lines.fail("a vertex has three numbers");
      if (obj.positions.size() >= kMostVertices) lines.fail("too many vertices");
      obj.positions.emplace_back(lines.number(words[1]), lines.number(words[2]), lines.number(words[3]));
    } else if (words[0] == "vt") {
      if (words.size() < 3) lines.fail("a texture coordinate has two numbers");
      uvs.emplace_back(lines.number(words[1]), 1 - lines.number(words[2]));
    } else if (words[0] == "g" && words.size() > 1) {
      group = words[1];
    } else if (words[0] == "f") {
      if (words.size() < 4 || words.size() > 64) lines.fail("a face has three corners or more");
      std::vector<unsigned> corners;
      for (std::size_t i = 1; i < words.size(); ++i) {
        const std::size_t slash = words[i].find('/');
        const int v = lines.index(words[i].substr(0, slash), static_cast<int>(obj.positions.size()) + 1) - 1;
        int t = -1;
        if (slash != std::string_view::npos) {
          const std::string_view rest = words[i].substr(slash + 1);
          const std::string_view word = rest.substr(0, rest.find('/'));
          if (!word.empty()) t = lines.index(word, static_cast<int>(uvs.size()) + 1) - 1;
        }
        if (v < 0) lines.fail("vertices are counted from 1");
        obj.group_vertices[group].push_back(v);
        if (!kept.empty() && group != kept) continue;
        const auto [it, is_new] = corner_of.try_emplace({v, t}, static_cast<unsigned>(obj.faces.vertex.size()));
        if (is_new) {
          obj.faces.vertex.push_back(v);
          obj.faces.uv.push_back(t < 0 ? vec2(0) : uvs[static_cast<std::size_t>(t)]);
        }
        corners.push_back(it->second);
      }
      for (std::size_t i = 2; i < corners.size(); ++i)
        obj.faces.triangles.emplace_back(corners[0], corners[i - 1], corners[i]);
    }
  }
  obj.faces.vertices = static_cast<int>(obj.positions.size());
  return obj;
}

}  // namespace dualpixel::scenes
