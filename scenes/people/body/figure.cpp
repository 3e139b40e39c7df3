#include "scenes/people/body/figure.h"

#include <algorithm>
#include <utility>

namespace dualpixel::scenes {

Figure draw_body_and_pose(RandomStream& body_rng, RandomStream& pose_rng, const FigureOptions& options) {
  Figure figure;
  figure.body = make_body(body_rng);
  figure.pose = make_pose(pose_rng, figure.body, options.gesture);
  figure.pose.head_yaw = std::clamp(figure.pose.head_yaw + options.head_yaw, -1.25f, 1.25f);
  figure.person = options.person;
  figure.head_cell_m = std::clamp(1.1f * options.meters_per_px, 0.0038f, 0.014f);
  figure.body_cell_m = std::clamp(2.4f * options.meters_per_px, 0.009f, 0.024f);
  figure.lowest_m = options.lowest_m;
  return figure;
}

Figure pose_figure(RandomStream rng, const FigureOptions& options) {
  RandomStream body_rng = rng.substream(1), pose_rng = rng.substream(2);
  Figure figure = draw_body_and_pose(body_rng, pose_rng, options);
  figure.skeleton = make_skeleton(figure.body, figure.pose, options.position, options.yaw, proportions_of(figure.body));
  return figure;
}

void add_object(SceneModel& scene, const Figure& figure, SceneObject object, const Material& material) {
  if (object.triangles.empty()) return;
  object.person = figure.person;
  object.material = scene.add(material);
  scene.objects.push_back(std::move(object));
}

}  // namespace dualpixel::scenes
