#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "scenes/people/body/figure.h"

/// Figures from assets in MakeHuman's formats (makehumancommunity.org; its assets are CC0): a base mesh with morph
/// targets and skinning weights, and hair, clothes, eyes, brows and lashes that are fitted to it. Nothing of theirs is
/// in the program: the folder is the user's, and must hold 3dobjs/base.obj, targets/, rigs/default_weights.mhw, and may
/// hold skins/, hair/, clothes/, eyes/, eyebrows/, eyelashes/ (what lacks its texture is dyed plain, hair left out).
/// Of what stands in for each other (skins of one sex and age, suits of one sex, all else of its kind) and is not
/// alone, the last fifth by name, one at least, is for held-out sets only, and the rest for training's. Where a set has
/// none that suits, it takes any of its own of that kind; one of a kind is in both. All throws InputError with the
/// file, the line and what is wrong with it; bodies that targets make, with the folder of those.
namespace dualpixel::scenes {

/// Faces with corners that have a place and a texture coordinate: corners are split where texture coordinates differ.
struct TexturedMesh {
  std::vector<int> vertex;  ///< of each corner, index into positions
  std::vector<vec2> uv;     ///< of each corner, v = 0 at the top
  std::vector<glm::uvec3> triangles;
  int vertices = 0;
};

/// Something fitted to the base mesh: each vertex hangs on three of its vertices.
struct FittedAsset {
  struct Hold {
    std::array<int, 3> vertex{};
    std::array<float, 3> weight{1, 0, 0};
    vec3 offset{0};
  };
  struct Scale {
    int a = 0, b = 0;
    float length = 0;  ///< 0: no scale is given
  };
  std::string name;
  TexturedMesh mesh;
  std::vector<Hold> holds;
  std::array<Scale, 3> scale;                         ///< x, y, z
  std::vector<bool> hides;                            ///< of the base mesh's vertices: covered
  std::shared_ptr<const simulator::Texture> texture;  ///< null: missing
  vec3 mean_color{0.5f};                              ///< linear, of what is not transparent
};

struct MorphTarget {
  std::vector<int> vertex;
  std::vector<vec3> offset;
};

/// How much of a vertex follows which part of the body; parts as in makehuman.cpp.
struct PartWeights {
  std::vector<std::vector<std::pair<int, float>>> of_vertex;
};

class MakeHumanAssets {
 public:
  /// Reads all but targets, which are read when they are first wanted.
  explicit MakeHumanAssets(const std::string& root);

  std::string folder;
  std::string hash;  ///< of all files that may be read

  const MorphTarget& target(const std::string& name) const;  ///< "macrodetails/asian-female-young"

  struct Skin {
    std::string name;
    std::shared_ptr<const simulator::Texture> texture;
  };

  std::vector<vec3> base;  ///< meters
  TexturedMesh body;
  std::map<std::string, std::vector<int>> joints;  ///< vertices whose mean is the joint
  PartWeights weights;
  std::vector<Skin> skins;
  std::vector<std::shared_ptr<const simulator::Texture>> irises;
  std::vector<FittedAsset> hair, clothes, hats, eyes, brows, lashes, shoes;
  std::vector<std::string> details;  ///< targets of the face and body that come in opposite pairs, all of them

 private:
  mutable std::mutex mutex_;
  mutable std::map<std::string, std::unique_ptr<const MorphTarget>> targets_;
};

/// Draws a person and adds it to the stage, like add_figure().
Figure add_makehuman_figure(SceneModel& scene, const MakeHumanAssets& assets, RandomStream rng,
                            const FigureOptions& options);

}  // namespace dualpixel::scenes
