#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "scenes/people/makehuman/asset_types.h"

namespace dualpixel::scenes {

/// Figures from assets in MakeHuman's formats (makehumancommunity.org; its assets are CC0): a base mesh with morph
/// targets and skinning weights, and hair, clothes, eyes, brows and lashes that are fitted to it. The program contains
/// none of them: the user names a folder, which must hold 3dobjs/base.obj, targets/ and rigs/default_weights.mhw, and
/// may hold skins/, hair/, clothes/, eyes/, eyebrows/ and eyelashes/. An asset without its texture gets a plain color;
/// hair, brows and lashes without one are left out.
///
/// Held-out sets: of assets that can replace each other (skins of one sex and age, suits of one sex, all others of
/// their kind) and are not alone, the last fifth by name, one at least, is for held-out sets only, and the others for
/// training sets. Where a set has none that fits, it takes any of its own of that kind; a single asset of a kind is in
/// both.
///
/// Errors are InputError with the file, the line and what is wrong; for bodies that targets make, with their folder.
class MakeHumanAssets {
 public:
  /// Reads everything but targets, which are read at first use.
  explicit MakeHumanAssets(const std::string& root);

  std::string folder;
  std::string hash;  ///< of all files that may be read

  const MorphTarget& target(const std::string& name) const;  ///< "macrodetails/asian-female-young"

  struct Skin {
    std::string name;
    std::shared_ptr<const simulator::Texture> texture;
  };

  BaseMesh base;
  std::vector<Skin> skins;
  std::vector<std::shared_ptr<const simulator::Texture>> irises;
  std::vector<FittedAsset> hair, clothes, hats, eyes, brows, lashes, shoes;
  std::vector<std::string> details;  ///< names of the targets of face and body that come in opposite pairs

 private:
  mutable std::mutex mutex_;
  mutable std::map<std::string, std::unique_ptr<const MorphTarget>> targets_;
};

}  // namespace dualpixel::scenes
