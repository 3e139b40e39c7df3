#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

/// A user study as in Wadhwa et al. 2018 (Section 6 and supplement): which of several methods' portraits do people
/// prefer? A page shows two portraits of a scene side by side, blind; the one that is preferred meets the next
/// method's, until all have been shown. Choices are saved as a file of votes (votes.h).
namespace dualpixel::evaluation {

/// The key that says whose picture is whose: study.json. The page does not hold it.
struct Study {
  std::string id;  ///< of the pages's pictures, 16 hexadecimal digits
  std::vector<std::string> methods;
  struct Scene {
    std::string name;
    std::vector<int> method_of_picture;  ///< for each picture in the page's order
  };
  std::vector<Scene> scenes;
};

/// A method's name, and a folder whose subfolders are portrait results, one for each scene.
using MethodFolder = std::pair<std::string, std::string>;

/// Two files of one study.
struct StudyFiles {
  Study study;
  std::string page_html;
};

/// Scenes are the names of subfolders with a result.json; all methods must have the same, of one size each. `seed`
/// decides in which order the page stores the pictures. Throws InputError.
StudyFiles make_study(const std::vector<MethodFolder>& methods, std::uint64_t seed);

nlohmann::ordered_json to_json(const Study& study);

/// Reads study.json. Throws InputError.
Study read_study(const std::string& path);

}  // namespace dualpixel::evaluation
