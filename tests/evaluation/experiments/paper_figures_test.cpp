#include "evaluation/experiments/paper_figures.h"

#include <gtest/gtest.h>

#include "capture/error.h"
#include "evaluation/failures/atlas_scene.h"
#include "pipeline/segmentation/network.h"
#include "tests/pipeline/portrait/synthetic.h"
#include "tests/pipeline/segmentation/drawn_face.h"
#include "tests/temporary_folder.h"

namespace dualpixel::evaluation {
namespace {

/// The pictures between a section's title and the next.
std::vector<std::string> pictures_of(const std::string& page, const std::string& title) {
  const std::size_t end = page.find("<h2>", page.find(title));
  std::vector<std::string> pictures;
  for (std::size_t at = page.find(title); (at = page.find("src=\"data:", at)) < end;) {
    const std::size_t first = at + 5;
    at = page.find('"', first);
    pictures.push_back(page.substr(first, at - first));
  }
  return pictures;
}

TEST(PaperFigures, AreThoseThatTheCaptureAllows) {
  AtlasScene scene{focused_for(atlas_camera("thin"), 12), 0};
  add_wall(scene, add_paint(scene, pink_paint(scene, 0)), 3);
  Window side = whole_picture(scene);
  side.left = side.right / 3;
  add_surface(scene, add_paint(scene, pink_paint(scene, 1)), side, [&](double x, double y) {
    return at_blur(scene, 0.5 * x / side.right)(x, y);  // slanted, so that Fig. 11 has radii below the largest
  });
  scene.document["burst"] = {{"frames", 2}};
  PaperFigures figures{take_burst(scene)};
  const std::string of_burst = paper_figures_page(figures);
  for (const char* title : {"Fig. 7", "Fig. 11", "Fig. 13", "Fig. 14", "Fig. S2"}) {
    EXPECT_NE(of_burst.find(title), std::string::npos) << title;
  }
  EXPECT_EQ(of_burst.find("Fig. 8"), std::string::npos);    // no calibration was given
  EXPECT_EQ(of_burst.find("Fig. 16b"), std::string::npos);  // nobody is there
  // what a step is left out of differs from what it is not: pairs of pictures, by their places in the section
  const struct {
    const char* title;
    std::size_t count;
    std::vector<std::pair<std::size_t, std::size_t>> differ;
  } sections[] = {{"Fig. 7", 4, {{0, 1}, {2, 3}}}, {"Fig. 11", 4, {{0, 1}, {2, 3}}}, {"Fig. 14", 3, {{0, 1}, {1, 2}}}};
  for (const auto& [title, count, differ] : sections) {
    const std::vector<std::string> pictures = pictures_of(of_burst, title);
    ASSERT_EQ(pictures.size(), count) << title;
    for (const auto& [a, b] : differ) EXPECT_TRUE(pictures[a] != pictures[b]) << title << ": " << a << " and " << b;
  }
  figures.capture.frames.resize(1);
  EXPECT_EQ(paper_figures_page(figures).find("Fig. 7"), std::string::npos);
  figures.capture.frames[0].left = figures.capture.frames[0].right = {};
  EXPECT_NE(message_of<InputError>([&] { paper_figures_page(figures); }), "");
}

TEST(SlowPaperFigures, ShowSeveralPeople) {
  if (!pipeline::has_person_network()) GTEST_SKIP() << "built without oneDNN";
  constexpr int kWide = 480, kHigh = 320;
  const auto page_of = [&](const std::vector<double>& faces_at) {
    Image picture(kWide, kHigh, 1, 0.2F);
    for (const double x : faces_at) pipeline::draw_face(picture, x, 150, 110);
    Capture capture = pipeline::synthetic_capture(kWide, kHigh);
    ImageU16& mosaic = capture.frames[0].mosaic;
    for (std::size_t i = 0; i < mosaic.data.size(); ++i) {
      mosaic.data[i] = static_cast<std::uint16_t>(64 + (1023 - 64) * picture.data[i]);
    }
    return paper_figures_page({std::move(capture)});
  };
  EXPECT_EQ(pictures_of(page_of({120, 340}), "Fig. 16b").size(), 2u);
  EXPECT_EQ(page_of({120}).find("Fig. 16b"), std::string::npos);
}

}  // namespace
}  // namespace dualpixel::evaluation
