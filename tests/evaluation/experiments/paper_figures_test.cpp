#include "evaluation/experiments/paper_figures.h"

#include <gtest/gtest.h>

#include "capture/error.h"
#include "evaluation/failures/atlas_scene.h"
#include "tests/temporary_folder.h"

namespace dualpixel::evaluation {
namespace {

TEST(PaperFigures, AreThoseThatTheCaptureAllows) {
  AtlasScene scene{focused_for(atlas_camera("thin"), 12), 0};
  add_wall(scene, add_paint(scene, pink_paint(scene, 0)), 3);
  scene.document["burst"] = {{"frames", 2}};
  PaperFigures figures{take_burst(scene)};
  const std::string of_burst = paper_figures_page(figures);
  for (const char* title : {"Fig. 7", "Fig. 11", "Fig. 13", "Fig. 14", "Fig. S2"}) {
    EXPECT_NE(of_burst.find(title), std::string::npos) << title;
  }
  EXPECT_EQ(of_burst.find("Fig. 8"), std::string::npos);  // no calibration was given
  figures.capture.frames.resize(1);
  EXPECT_EQ(paper_figures_page(figures).find("Fig. 7"), std::string::npos);
  figures.capture.frames[0].left = figures.capture.frames[0].right = {};
  EXPECT_NE(message_of<InputError>([&] { paper_figures_page(figures); }), "");
}

}  // namespace
}  // namespace dualpixel::evaluation
