#pragma once
#include <fmt/format.h>

#include <string>

#include "tests/temporary_folder.h"

/// The smallest folder in MakeHuman's formats, for tests.
namespace dualpixel::scenes {

/// A body of one triangle with every joint, at the same positions on both sides but for the eyes.
inline std::string smallest_body(const std::string& tall = "17") {
  std::string obj = "v 0 0 0\nv 1 0 0\nv 0 " + tall + " 0\nv 0.6 0 0\n";
  // from the fifth on: shoulder, elbow, hand, three knuckles (middle, first, last), upper leg, knee, ankle
  obj += "v 0 14 0\nv 0 11 0\nv 0 8.5 0\nv 0 7.7 0\nv 0.3 7.7 0\nv -0.3 7.7 0\nv 0 9 0\nv 0 5 0\nv 0 1 0\n";
  obj += "g body\nf 1 2 3\n";
  const auto joint = [&](const std::string& name, int vertex) {
    obj += fmt::format("g joint-{0}\nf {1} {1} {1}\n", name, vertex);
  };
  joint("neck", 5);
  joint("jaw", 5);
  for (const std::string side : {"l-", "r-"}) {
    joint(side + "eye", side == "l-" ? 1 : 4);
    joint(side + "shoulder", 5);
    joint(side + "elbow", 6);
    joint(side + "hand", 7);
    joint(side + "upper-leg", 11);
    joint(side + "knee", 12);
    joint(side + "ankle", 13);
    for (int finger = 2; finger <= 5; ++finger) {
      for (int bone = 1; bone <= 3; ++bone)
        joint(fmt::format("{}finger-{}-{}", side, finger, bone), finger == 2 ? 9 : finger == 5 ? 10 : 8);
    }
  }
  return obj;
}

inline void write_makehuman(const TemporaryFolder& folder, const std::string& obj, const std::string& weights) {
  folder.write("3dobjs/base.obj", obj);
  folder.write("rigs/default_weights.mhw", weights);
}

/// All macro targets; those of a body of one origin, sex and age, of which one or a mixture is drawn, hold `rows`.
inline void write_targets(const TemporaryFolder& folder, const std::string& rows) {
  for (const std::string origin : {"african", "asian", "caucasian"}) {
    for (const std::string gender : {"male", "female"}) {
      for (const std::string age : {"young", "old", "child"})
        folder.write(fmt::format("targets/macrodetails/{}-{}-{}.target", origin, gender, age), rows);
    }
    folder.write("targets/expression/units/" + origin + "/mouth-corner-puller.target", "");
  }
  for (const std::string gender : {"male", "female"}) {
    for (const std::string age : {"young", "old", "child"}) {
      for (const std::string muscle : {"min", "average", "max"}) {
        for (const std::string weight : {"min", "average", "max"}) {
          folder.write(
              fmt::format("targets/macrodetails/universal-{}-{}-{}muscle-{}weight.target", gender, age, muscle, weight),
              "");
        }
      }
    }
  }
}

}  // namespace dualpixel::scenes
