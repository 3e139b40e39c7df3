#include "evaluation/methods/set_evaluation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/image/npy.h"
#include "tests/pipeline/portrait/synthetic.h"
#include "tests/temporary_folder.h"

namespace dualpixel::evaluation {
namespace {

// synthetic.h: views of 32 x 12, 300 and 250 DN throughout; on the left half disparity -1, on the right a ramp from 0.5
// to 1.5; the last of 48 rows of photosites has no truth, but none of the views' pixels lies there.
constexpr int kPixels = 32 * 12;

TEST(ForeignMethod, GivesTheViewsAndTakesTheMaps) {
  const TemporaryFolder folder;
  Image views[2] = {Image(6, 4), Image(6, 4)};
  for (int i = 0; i < 24; ++i) views[0].data[i] = static_cast<float>(i) / 24, views[1].data[i] = 1.5f;
  const DisparityMethod copies =
      method_named("copies=cp {left.npy} {out} && cp {right.npy} {sigma} && cp {left} '" + (folder / "left.png") + "'");
  EXPECT_EQ(copies.name, "copies");
  const MethodRun run = copies.run(views[0], views[1], {.white = 0.5f});
  for (int i = 0; i < 24; ++i) EXPECT_FLOAT_EQ(run.found.disparity_dp_px.data[i], 2 * views[0].data[i]);
  EXPECT_EQ(run.found.sigma_dp_px.data, std::vector<float>(24, 3.0f));
  EXPECT_TRUE(run.found.confidence.empty());
  EXPECT_GT(run.wall_s, 0);
  EXPECT_GT(*run.peak_rss_mb, 0);
  const std::string png = read_bytes(folder / "left.png");
  EXPECT_EQ(png.substr(1, 3), "PNG");
}

TEST(ForeignMethod, SaysWhatIsWrong) {
  const Image view(6, 4, 1, 0.5f);
  const auto message = [&](const std::string& text) {
    return message_of<InputError>([&] { method_named(text).run(view, view, {}); });
  };
  const std::string form = ": must be NAME=COMMAND, with {left}, {right} and {out} in the command, or a matcher's name";
  EXPECT_EQ(message("a=prog {left} {out}"), "--method a=prog {left} {out}" + form);
  EXPECT_EQ(message("=prog {left} {right} {out}"), "--method =prog {left} {right} {out}" + form);
  EXPECT_EQ(message("paper=prog {left} {right} {out}"), "--method paper: is the name of a matcher: choose another");
  EXPECT_EQ(message("a=true {left} {right} {out}"), "a: its command wrote no {out}");
  EXPECT_EQ(message("a=exit 3; {left} {right} {out}"), "a: its command ended with status 3");
  EXPECT_EQ(message("a=kill -9 $$; {left} {right} {out}"), "a: its command ended with signal 9");
  EXPECT_NE(message("a=echo x > {out}; : {left} {right}").find("a: its disparity_dp_px: "), std::string::npos);
}

/// A folder of one capture, and a method that gives `found` whatever it sees.
struct OneCapture {
  TemporaryFolder folder;
  std::string in(const std::string& name) const { return folder / name; }
  OneCapture() { write_capture(pipeline::synthetic_capture(), folder / "set/one"); }

  SetScore score(const Image& found) const {
    write_npy(folder / "found.npy", found);
    const DisparityMethod method = method_named("fixed=cp '" + (folder / "found.npy") + "' {out}; : {left} {right}");
    const SetScore scored = evaluate_set(sample_folders(folder / "set", ""), {method}).front();
    std::filesystem::remove(folder / "found.npy");
    return scored;
  }
};

SetFigures region(const SetScore& score, const std::string& name) {
  const std::vector<std::string> names = region_names();
  return score.regions.at(std::find(names.begin(), names.end(), name) - names.begin());
}

TEST(SetEvaluation, CutsRegionsByTheTruth) {
  const OneCapture set;
  const ViewSample sample = read_view_sample(set.in("set/one"));
  Image found = sample.truth_dp_px;
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 16; ++x) found.at(x, y) += 1;           // all that is in front errs by 1
    found.at(31, y) = std::numeric_limits<float>::quiet_NaN();  // one column is not found
  }
  const SetScore score = set.score(found);
  EXPECT_EQ(score.method, "fixed");
  EXPECT_EQ(region(score, "everything").pixels, kPixels);
  EXPECT_DOUBLE_EQ(*region(score, "everything").wrong, 17.0 / 32);
  EXPECT_DOUBLE_EQ(region(score, "everything").found, 31.0 / 32);
  EXPECT_NEAR(*region(score, "everything").rmse_dp_px, std::sqrt(16.0 / 31), 1e-6);
  EXPECT_EQ(region(score, "front").pixels, kPixels / 2);
  EXPECT_EQ(region(score, "front").wrong, 1);
  EXPECT_DOUBLE_EQ(*region(score, "behind").wrong, 1.0 / 16);
  // the jump from -1 to 0.5 lies between columns 15 and 16: two on either side
  EXPECT_EQ(region(score, "edges").pixels, 4 * 12);
  EXPECT_DOUBLE_EQ(*region(score, "edges").wrong, 0.5);
  EXPECT_EQ(region(score, "clipped").pixels, 0);
  EXPECT_FALSE(region(score, "clipped").wrong);
  EXPECT_FALSE(region(score, "everything").within_one_sigma);
  EXPECT_EQ(region(score, "1 to 2").pixels + region(score, "0.25 to 1").pixels, kPixels);
}

TEST(SetEvaluation, WritesOnePage) {
  const OneCapture set;
  const SetScore score = set.score(Image(32, 12));
  const std::string page = to_page({score}, 1);
  EXPECT_NE(page.find("fixed"), std::string::npos);
  EXPECT_NE(page.find("addEventListener"), std::string::npos);
  EXPECT_EQ(to_json({score}, 1)["methods"]["fixed"]["regions"]["front"]["pixels"], kPixels / 2);
  EXPECT_NE(to_text({score}).find("fixed"), std::string::npos);
}

TEST(SetEvaluation, RefusesFoldersWithoutSamples) {
  const TemporaryFolder folder;
  EXPECT_EQ(message_of<InputError>([&] { sample_folders(folder / "none", ""); }),
            folder / "none" + ": holds no samples: must be a data set that is rendered, or a folder of captures");
}

}  // namespace
}  // namespace dualpixel::evaluation
