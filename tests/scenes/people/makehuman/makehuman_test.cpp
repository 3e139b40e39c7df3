#include <gtest/gtest.h>

#include <fmt/format.h>
#include <algorithm>
#include <cstdlib>
#include <set>
#include <string>

#include "capture/error.h"
#include "scenes/people/makehuman/makehuman_figure.h"
#include "scenes/people/photo/ray_tracer.h"
#include "scenes/people/truth.h"
#include "tests/scenes/people/makehuman_assets.h"

namespace dualpixel::scenes {
namespace {

TEST(SlowMakeHuman, HeldOutAssetsAreNeverInTrainingSets) {
  const TemporaryFolder folder;
  write_makehuman(folder, smallest_body(), R"({"weights": {"head": [[0, 1.0]]}})");
  write_targets(folder, "");
  for (const std::string suit : {"female_a", "male_a", "male_b", "male_c"}) {
    folder.write("clothes/" + suit + "/" + suit + ".mhclo", "obj_file a.obj\nverts 0\n0\n1\n2\n");
    folder.write("clothes/" + suit + "/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  }
  const MakeHumanAssets assets(folder.path.string());
  const auto worn = [&](bool held_out) {
    std::set<std::string> suits;
    for (int seed = 0; seed < 60; ++seed) {
      SceneModel scene;
      for (const std::string& tag : add_makehuman_figure(scene, assets, RandomStream(seed, held_out), {}).tags) {
        if (tag.starts_with("top:") && tag != "top:shell") suits.insert(tag.substr(4));
      }
    }
    return suits;
  };
  // the last of three; the only one for women is training's, and held-out women wear what their set has
  EXPECT_EQ(worn(false), (std::set<std::string>{"female_a", "male_a", "male_b"}));
  EXPECT_EQ(worn(true), std::set<std::string>{"male_c"});
}

TEST(MakeHuman, BrokenAssetsAreRefusedByFileAndLine) {
  const std::string good = smallest_body(), weights = R"({"weights": {"head": [[0, 1.0]]}})";
  const auto message = [](const std::string& obj, const std::string& rig, const std::string& clothes) -> std::string {
    const TemporaryFolder folder;
    write_makehuman(folder, obj, rig);
    if (!clothes.empty()) folder.write("clothes/a/a.mhclo", clothes), folder.write("clothes/a/a.obj", "v 0 0 0\n");
    try {
      const MakeHumanAssets assets(folder.path.string());
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(message(good, weights, ""), "");
  EXPECT_NE(message("v 0 0 zero\n", weights, "").find("base.obj:1: 'zero' is not a number"), std::string::npos);
  EXPECT_NE(message("v 0 0 0\nf 1 2 1\n", weights, "").find("base.obj:2: '2' is not an index from 0 to 1"),
            std::string::npos);
  EXPECT_NE(message(good + "f 0 1 2\n", weights, "").find("counted from 1"), std::string::npos);
  EXPECT_NE(message(good.substr(0, good.find("g joint-r-knee")), weights, "").find("'joint-r-knee'"),
            std::string::npos);
  EXPECT_NE(message(smallest_body("9.9"), weights, "").find("0.99 m high; 1 to 2.5 m"), std::string::npos);
  EXPECT_NE(message(smallest_body("26"), weights, "").find("2.60 m high"), std::string::npos);
  std::string wide = smallest_body();
  wide.replace(wide.find("v 1 0 0"), 7, "v 300 0 0");
  EXPECT_NE(message(wide, weights, "").find("reaches 30.00 m aside; up to 1.5 m"), std::string::npos);
  std::string armless = good;
  armless.replace(armless.find("v 0 11 0"), 8, "v 0 14 0");
  EXPECT_NE(message(armless, weights, "").find("base.obj: from l-shoulder to l-elbow is 0.0000 m; 0.01 m or more"),
            std::string::npos);
  for (const char* weight : {"-0.1", "1.5", "1e300"}) {
    EXPECT_NE(message(good, fmt::format(R"({{"weights": {{"head": [[0, {}]]}}}})", weight), "").find("0 to 1"),
              std::string::npos);
  }
  EXPECT_NE(message(good, weights, "obj_file a.obj\nverts 0\n0 1 2 0.5 0.5\n").find("a.mhclo:3: a row is"),
            std::string::npos);
  EXPECT_NE(message("v 0 0 0\n", weights, "").find("no group 'body'"), std::string::npos);
  EXPECT_NE(message(good, "{", "").find("default_weights.mhw"), std::string::npos);
  EXPECT_NE(message(good, R"({"weights": {"head": [[13, 1.0]]}})", "").find("'head'"), std::string::npos);
  EXPECT_EQ(message(good, weights, "obj_file a.obj\nverts 0\n0\n"), "");
  EXPECT_NE(message(good, weights, "obj_file ../a.obj\nverts 0\n0\n").find("obj_file must name"), std::string::npos);
  EXPECT_NE(message(good, weights, "obj_file a.obj\nverts 0\n13\n").find("a.mhclo:3"), std::string::npos);
  EXPECT_NE(message(good, weights, "obj_file a.obj\nverts 0\n").find("0 vertices are fitted"), std::string::npos);
}

TEST(MakeHuman, MorphsThatMakeNoHumanAreRefused) {
  const auto message = [](const std::string& rows) -> std::string {
    const TemporaryFolder folder;
    write_makehuman(folder, smallest_body(), R"({"weights": {"head": [[0, 1.0]]}})");
    write_targets(folder, rows);
    const MakeHumanAssets assets(folder.path.string());
    SceneModel scene;
    try {
      add_makehuman_figure(scene, assets, RandomStream(1, false), {});
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  EXPECT_NE(message("1 500 0 0\n").find("m aside; up to 1.5 m"), std::string::npos);
  EXPECT_NE(message("3 5 0 0\n").find("m apart; 0.03 to 0.09 m"), std::string::npos);
  EXPECT_NE(message("2 0 50 0\n").find("0.4 to 3 m is allowed"), std::string::npos);
  // the elbow (its vertex is 5): by the shoulder, far from the body, too near to the shoulder
  EXPECT_NE(message("5 0 3 0\n").find("from l-shoulder to l-elbow is 0.0000 m; 0.01 m or more"), std::string::npos);
  EXPECT_NE(message("5 30 0 0\n").find("joint-l-elbow is at 3.00, 1.10, 0.00 m; at most 0.1 m outside the body"),
            std::string::npos);
  EXPECT_NE(message("5 0 2.5 0\n").find("from l-shoulder to l-elbow is 0.050 m, to l-hand 0.500 m; one may be 2 times"),
            std::string::npos);
}

TEST(SlowMakeHuman, FiguresAreWhereTheirJointsAre) {
  const char* folder = std::getenv("DUALPIXEL_MAKEHUMAN");
  if (folder == nullptr) GTEST_SKIP() << "DUALPIXEL_MAKEHUMAN names no folder of assets";
  const MakeHumanAssets assets(folder);
  for (const std::uint64_t seed : {1, 2, 3}) {
    SceneModel scene;
    FigureOptions options;
    options.meters_per_px = 0.009f;
    options.position = {0.3f, 0, 0.2f};
    const Figure figure = add_makehuman_figure(scene, assets, RandomStream(seed, false), options);
    const RayTracer tracer(scene);
    // a ray from in front of the face meets the person within 2 cm of the nose, for any rotation of the head
    const vec3 nose = figure.face_points[0], forward = figure.skeleton.head.axes[2];
    const auto hit = tracer.intersector().intersect({nose + forward, -forward});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->t, 1, 0.02) << seed;
    // every joint is within the body: nearer than a thigh's radius to one of its vertices
    for (const vec3& joint : keypoints_of(figure)) {
      float nearest = 1;
      for (const SceneObject& object : scene.objects) {
        if (object.person != 0) continue;
        for (const vec3& p : object.positions) nearest = std::min(nearest, glm::distance(p, joint));
      }
      EXPECT_LT(nearest, 0.14f) << seed;
    }
  }
}

}  // namespace
}  // namespace dualpixel::scenes
