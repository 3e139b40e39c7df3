#pragma once
#include "scenes/people/body/body_mesh.h"
#include "scenes/people/body/head.h"
#include "scenes/people/photo/camera.h"
#include "scenes/people/photo/render.h"
#include "scenes/people/procedural_figure.h"
#include "scenes/people/truth.h"

/// People in front of a camera, for tests.
namespace dualpixel::scenes {

/// Two people before a camera of 96 x 128 pixels, nothing else.
struct Pair {
  SceneModel scene;
  Figure first, second;
  simulator::CameraView camera;

  static Pair make(std::uint64_t seed) {
    SceneModel scene;
    FigureOptions options;
    options.meters_per_px = 0.009f;
    options.position = {0.22f, 0, 0};
    Figure one = add_figure(scene, RandomStream(seed, false), options);
    options.position = {-0.22f, 0, -0.1f};
    options.person = 1;
    Figure two = add_figure(scene, RandomStream(seed + 1, false), options);
    CameraSetup plan;
    const vec3 middle = 0.5f * (one.skeleton.head.origin + two.skeleton.head.origin);
    plan.eye = middle + vec3(0, 0, 2);
    plan.target = middle - vec3(0, 0.25f, 0);
    plan.height_m = 1.2f;
    plan.width_px = 96;
    plan.height_px = 128;
    plan.aperture_m = 1e-6f;
    return {std::move(scene), std::move(one), std::move(two), make_camera(plan)};
  }
};

/// A person standing upright at the origin, 1.7 m tall, facing the camera four meters away, which covers 2 m by 256
/// pixels: a pixel is 1/128 m at z = 0, and y = 1 m is in row 128.
struct Upright {
  SceneModel scene;
  Figure figure;
  simulator::CameraView camera = make_camera({.eye = {0, 1, 4}, .target = {0, 1, 0}, .height_m = 2});

  explicit Upright(const Pose& pose) {
    figure.pose = pose;
    figure.skeleton = make_skeleton(figure.body, pose, vec3(0), 0, proportions_of(figure.body));
    add_body(scene, figure);
    add_head(scene, figure, RandomStream(1, false));
  }
  PeopleSample truth() const {
    const RayTracer tracer(scene);
    return truth_of(tracer, camera, figure, render(tracer, camera, 1, 5));
  }
};

}  // namespace dualpixel::scenes
