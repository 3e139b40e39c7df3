#include "evaluation/methods/set_evaluation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>

#include "capture/capture.h"
#include "capture/error.h"
#include "capture/image/npy.h"
#include "datasets/plan/plan.h"
#include "datasets/render/render.h"
#include "pipeline/disparity/tile_disparity.h"
#include "tests/datasets/small_recipe.h"
#include "tests/pipeline/portrait/synthetic.h"
#include "tests/pipeline/texture.h"
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
  const std::string png = read_bytes(folder / "left.png");
  EXPECT_EQ(png.substr(1, 3), "PNG");
}

TEST(ForeignMethod, MayAddAnEnding) {
  const Image view(6, 4, 1, 0.5f);
  const std::string command = "cp {left.npy} {out}.npy && cp {left.npy} {sigma}.npy; : {right}";
  const MethodRun run = method_named("a=" + command).run(view, view, {});
  EXPECT_EQ(run.found.disparity_dp_px.data, view.data);
  EXPECT_EQ(run.found.sigma_dp_px.data, view.data);
}

TEST(ForeignMethod, TakesTemporaryFoldersWithQuotes) {
  const TemporaryFolder folder;
  const char* const before = std::getenv("TMPDIR");
  const std::string old = before ? before : "/tmp";
  std::filesystem::create_directory(folder / "it's");
  setenv("TMPDIR", (folder / "it's").c_str(), 1);
  const Image view(6, 4, 1, 0.5f);
  const auto run = [&] { return method_named("a=cp {left.npy} {out}; : {right}").run(view, view, {}); };
  EXPECT_NO_THROW(run());
  setenv("TMPDIR", old.c_str(), 1);
}

// The program blocks what it ends cleanly on; another program must end on it as usual.
TEST(ForeignMethod, HasSignalsAndInputOfItsOwn) {
  const Image view(6, 4, 1, 0.5f);
  sigset_t blocked, before;
  sigemptyset(&blocked);
  for (const int each : {SIGINT, SIGTERM, SIGUSR1}) sigaddset(&blocked, each);
  pthread_sigmask(SIG_BLOCK, &blocked, &before);
  const std::string terminates = "a=kill -TERM $$; cp {left.npy} {out}; : {right}";
  EXPECT_EQ(message_of<InputError>([&] { method_named(terminates).run(view, view, {}); }),
            "a: its command ended with signal 15");
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  EXPECT_NO_THROW(method_named("a=cat; cp {left.npy} {out}; : {right}").run(view, view, {}));  // ends: no input
}

TEST(SlowForeignMethod, CountsItsOwnMemoryAlone) {
  const std::vector<char> held(200 << 20, 1);
  const Image view(6, 4, 1, 0.5f);
  const auto peak_mb = [&](const std::string& command) {
    return method_named("a=" + command + "; cp {left.npy} {out}; : {right}").run(view, view, {}).peak_rss_mb;
  };
  EXPECT_LT(peak_mb("true").value_or(0), 50);
  const double sleeps_mb = peak_mb("sleep 0.1").value_or(0);
  EXPECT_GT(sleeps_mb, 0.1);
  EXPECT_LT(sleeps_mb, 50);
  // dd's buffer of 64 MB, filled, in a child of the shell
  EXPECT_GT(peak_mb("(dd if=/dev/zero bs=64M count=8 of=/dev/null; true)").value_or(0), 64);
  EXPECT_EQ(held.back(), 1);
}

TEST(ForeignMethod, HasANameOfItsOwn) {
  const auto message = [](const std::vector<std::string>& texts) {
    return message_of<InputError>([&] { methods_named(texts, {method_named("paper")}); });
  };
  EXPECT_EQ(message({"a=p {left} {right} {out}", "b=p {left} {right} {out}", "split"}), "");
  EXPECT_EQ(message({"a=p {left} {right} {out}", "a=q {left} {right} {out}"}),
            "--method a=q {left} {right} {out}: is there already");
  EXPECT_EQ(message({"paper"}), "--method paper: is there already");
}

TEST(DisparityMethod, TakesAMatchersOptions) {
  const pipeline::Texture paper(3, 0.1);
  const Image left = textured(paper, 128, 64, 0), right = textured(paper, 128, 64, 3);
  const auto found = [&](const std::string& text) {
    return method_named(text).run(left, right, {}).found.disparity_dp_px.data;
  };
  const std::string text = "split:split_match.window_px=9,split_match.high_pass_px=14";
  EXPECT_EQ(method_named(text).name, text);
  pipeline::MatcherOptions options;
  options.split_match.window_px = 9;
  options.split_match.high_pass_px = 14;
  const pipeline::TileDisparity tiles = pipeline::matcher_named("split").match(left, right, {}, options);
  EXPECT_EQ(found(text), pipeline::upsample_tiles(tiles, left.width, left.height).disparity_dp_px.data);
  EXPECT_NE(found(text), found("split:split_match.window_px=9"));
  EXPECT_NE(found(text), found("split"));

  const auto message = [&](const std::string& of) { return message_of<InputError>([&] { method_named(of); }); };
  EXPECT_EQ(message("split:split_match.window=9"),
            "--method split:split_match.window=9: split_match.window: unknown option; did you mean "
            "'split_match.window_px'?");
  EXPECT_EQ(message("split:match.range_px=9").substr(0, 77),
            "--method split:match.range_px=9: match.range_px: matcher split does not use i");
  EXPECT_EQ(message("split:"), "--method split:: an option is missing after ':' or ','");
  EXPECT_EQ(message("split:split_match.window_px=9,"),
            "--method split:split_match.window_px=9,: an option is missing after ':' or ','");
  EXPECT_NE(message("splt:split_match.window_px=9").find("did you mean 'split'?"), std::string::npos);
  EXPECT_NE(message("split:split_match.alpha=0.01").find("split_match.alpha: 0.01: must be"), std::string::npos);
  EXPECT_EQ(message("split:a=cp {left} {out}; : {right}"), "");  // another program's name
}

TEST(ForeignMethod, SaysWhatIsWrong) {
  const Image view(6, 4, 1, 0.5f);
  const auto message = [&](const std::string& text) {
    return message_of<InputError>([&] { method_named(text).run(view, view, {}); });
  };
  const std::string form =
      ": must be NAME=COMMAND, with {left} or {left.npy}, {right} or {right.npy}, and {out} (or {out}.npy) in the "
      "command, "
      "or be a matcher, with or without options";
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
    SetScore scored = evaluate_set(sample_folders(folder / "set", ""), {method}).front();
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

// The upper third of the right half is sky: its border with the rest is no edge of depth.
TEST(SetEvaluation, TruthEndsWithoutAnEdge) {
  const TemporaryFolder folder;
  Capture capture = pipeline::synthetic_capture();
  for (int y = 0; y < 16; ++y) {
    std::fill_n(&capture.truth->valid.at(32, y), 32, 0.0f);
    std::fill_n(&capture.truth->depth_m.at(32, y), 32, INFINITY);
  }
  write_capture(capture, folder / "set/one");
  const SetScore score = evaluate_set(sample_folders(folder / "set", ""), {method_named("paper")}).front();
  EXPECT_EQ(region(score, "everything").pixels, kPixels - 16 * 4);
  // two on either side of eight rows, and what lies beside the border's upper end
  EXPECT_EQ(region(score, "edges").pixels, 4 * 8 + 2);
}

// Bars before planes at disparities of -1 and, on the right, 0.5 and more; a gap behind them is no thin thing.
TEST(SetEvaluation, FindsThinThingsInFront) {
  const TemporaryFolder folder;
  const auto thin_with_bar = [&](float dp_px, int first, int last, bool along_rows) {
    Capture capture = pipeline::synthetic_capture();
    Image& truth = capture.truth->disparity_dp_px;  // of photosites, 2 x 4 of them a pixel
    for (int y = 0; y < truth.height; ++y) {
      for (int x = 0; x < truth.width; ++x) {
        const int at = along_rows ? y / 4 : x / 2;
        if (at >= first && at <= last) truth.at(x, y) = dp_px;
      }
    }
    write_capture(capture, folder / "set/one");
    const DisparityMethod nothing = {"nothing", [](const Image& left, const Image&, const pipeline::ViewSensor&) {
                                       MethodRun run;
                                       run.found.disparity_dp_px = Image(left.width, left.height);
                                       return run;
                                     }};
    const SetScore score = evaluate_set(sample_folders(folder / "set", ""), {nothing}).front();
    std::filesystem::remove_all(folder / "set");
    return region(score, "thin").pixels;
  };
  EXPECT_EQ(thin_with_bar(-2, 4, 11, false), 8U * 12);
  EXPECT_EQ(thin_with_bar(-2, 4, 12, false), 0U) << "nine wide";
  EXPECT_EQ(thin_with_bar(-2, 0, 3, false), 0U) << "at the border nothing is seen of its other side";
  EXPECT_EQ(thin_with_bar(-2, 3, 4, true), 2U * 32);
  EXPECT_EQ(thin_with_bar(0, 2, 5, false), 0U) << "behind what is beside it";
  EXPECT_EQ(thin_with_bar(-1.05f, 4, 7, false), 0U) << "no jump";
}

// Of two samples one has a sigma: the share is that of its pixels.
TEST(SetEvaluation, CountsSigmaWhereItIsGiven) {
  const OneCapture set;
  write_capture(pipeline::synthetic_capture(), set.in("set/two"));
  int calls = 0;
  const DisparityMethod method = {"half", [&](const Image& left, const Image&, const pipeline::ViewSensor&) {
                                    MethodRun run;
                                    run.found.disparity_dp_px = Image(left.width, left.height);
                                    if (calls++ == 0) run.found.sigma_dp_px = Image(left.width, left.height, 1, 9);
                                    return run;
                                  }};
  const SetScore score = evaluate_set(sample_folders(set.in("set"), ""), {method}).front();
  EXPECT_EQ(calls, 2);
  EXPECT_EQ(region(score, "everything").within_one_sigma, 1);
}

/// The samples of a data set whose DP pixels have `side` x `side` photosites.
std::vector<ViewSample> rendered_samples(const std::string& folder, int side) {
  nlohmann::json recipe = datasets::testing::small_recipe(2);
  recipe["set"]["sensor.dp_downsample_x"] = recipe["set"]["sensor.dp_downsample_y"] = side;
  recipe["keep"] = {"left", "right", "view_disparity_dp_px", "view_valid"};
  const datasets::Recipe read = datasets::read_recipe(recipe, "r.json");
  datasets::write_plan(datasets::make_plan(read), read, folder);
  EXPECT_EQ(datasets::render_shard({.dataset = folder}).rendered, 2);
  std::vector<ViewSample> samples;
  for (const std::string& sample : sample_folders(folder, "")) samples.push_back(read_view_sample(sample));
  return samples;
}

// The same electrons fall on both sensors: a DP pixel of 2 x 2 reads the mean of its two green photosites.
TEST(SlowSetEvaluation, TakesDenseSamplesAsThoseOfTwoByTwo) {
  constexpr double kRange = 1023 - 64;  // black to white
  const TemporaryFolder folder;
  const std::vector<ViewSample> dense = rendered_samples(folder / "dense", 1),
                                two = rendered_samples(folder / "two", 2);
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_TRUE(dense[i].left.same_size(two[i].left));
    for (std::size_t p = 0; p < dense[i].left.data.size(); ++p) {
      // rounded to 1/2 DN each, two and their mean
      ASSERT_NEAR(dense[i].left.data[p], two[i].left.data[p], 1.01 / kRange) << p;
      ASSERT_NEAR(dense[i].right.data[p], two[i].right.data[p], 1.01 / kRange) << p;
      const float truth = two[i].truth_dp_px.data[p];
      ASSERT_EQ(std::isnan(dense[i].truth_dp_px.data[p]), std::isnan(truth)) << p;
      if (std::isnan(truth)) continue;
      ASSERT_FLOAT_EQ(dense[i].truth_dp_px.data[p], truth) << p;
    }
    EXPECT_FLOAT_EQ(dense[i].sensor.noise->shot, two[i].sensor.noise->shot);
    // rounding's variance, 1/12 DN^2, is halved by the mean of two that are rounded, not by rounding once
    EXPECT_NEAR(two[i].sensor.noise->read - dense[i].sensor.noise->read, 1.0 / 24 / (kRange * kRange), 1e-11);
  }
}

TEST(SetEvaluation, TakesDenseCapturesAsThoseOfTwoByTwo) {
  const TemporaryFolder folder;
  Capture dense = pipeline::synthetic_capture();
  dense.camera.dp_downsample_x = dense.camera.dp_downsample_y = 1;
  Frame& frame = dense.frames[0];
  frame.left = frame.right = ImageU16(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {  // RGGB: green where x + y is odd
      frame.left.at(x, y) = static_cast<std::uint16_t>((x + y) % 2 == 1 ? 300 + y % 2 : 200);
      frame.right.at(x, y) = static_cast<std::uint16_t>((x + y) % 2 == 1 ? 250 : 150);
    }
  }
  write_capture(dense, folder / "dense");
  const ViewSample sample = read_view_sample(folder / "dense");
  ASSERT_EQ(sample.left.width, 32);
  ASSERT_EQ(sample.left.height, 24);
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 32; ++x) {
      ASSERT_FLOAT_EQ(sample.left.at(x, y), (300.5f - 64) / (1023 - 64));
      ASSERT_FLOAT_EQ(sample.right.at(x, y), (250.0f - 64) / (1023 - 64));
      const bool valid = 2 * y + 1 < 47;
      ASSERT_EQ(std::isnan(sample.truth_dp_px.at(x, y)), !valid);
      if (!valid) continue;
      ASSERT_EQ(2 * sample.truth_dp_px.at(x, y), dense.truth->disparity_dp_px.at(2 * x + 1, 2 * y + 1));
    }
  }
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
  const OneCapture set;
  EXPECT_EQ(message_of<InputError>([&] { sample_folders(set.in("set"), "test"); }),
            set.in("set") + ": is no data set, which alone has splits: leave out --split");
}

}  // namespace
}  // namespace dualpixel::evaluation
