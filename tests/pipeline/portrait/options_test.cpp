#include "pipeline/portrait/options.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <sstream>

#include "capture/error.h"
#include "pipeline/portrait/subject.h"
#include "tests/pipeline/portrait/synthetic.h"

namespace dualpixel::pipeline {
namespace {

std::string refusal(const std::string& assignment) {
  PortraitOptions options;
  try {
    set_field(fields(options), assignment);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(PortraitFields, AreSetByName) {
  PortraitOptions options;
  const OptionFields all = fields(options);
  set_field(all, "match.range_px=5");
  set_field(all, "smooth.solver.lambda=12.5");
  set_field(all, "noise.periods_px.1=43");
  EXPECT_EQ(options.matching.match.range_px, 5);
  EXPECT_EQ(options.smooth.solver.lambda, 12.5f);
  EXPECT_EQ(options.noise.periods_px[1], 43);
  EXPECT_EQ(changed_fields(options).dump(),
            R"({"match.range_px":5,"smooth.solver.lambda":12.5,"noise.periods_px.1":43})");
}

// A wide window answers for the foreground (1 px) up to 12 px beyond its edge, where the background (5 px) is.
TEST(DefaultOptions, SmoothingOverrulesWideWindowsAtEdges) {
  const int size = 96, edge = 40, fooled = 12;
  Image picture(size, size, 3);
  ConfidentMap map{Image(size, size), Image(size, size)};
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      for (int c = 0; c < 3; ++c) picture.at(x, y, c) = x < edge ? 0.1f : 0.6f;
      map.value.at(x, y) = x < edge + fooled ? 1 : 5;
      map.confidence.at(x, y) = 0.9f;
    }
  }
  const auto at_edge = [&](std::string_view matcher) {
    SmoothOptions options = default_options(matcher).smooth;
    options.divisor = 1;
    return smooth_disparity(map, picture, options).at(edge + 4, size / 2);
  };
  EXPECT_NEAR(at_edge("split"), 5, 0.1);
  EXPECT_LT(at_edge("likelihood"), 4);
  EXPECT_EQ(changed_fields(default_options("split")).dump(), "{}");
}

TEST(PortraitFields, RefusalsNameFieldValueAndWhatIsAllowed) {
  EXPECT_EQ(refusal("match.range_px=5"), "");
  EXPECT_EQ(refusal("match.range_px=65"), "match.range_px: 65: must be an integer in [1, 64]");
  EXPECT_EQ(refusal("match.range_px=2.5"), "match.range_px: 2.5: must be an integer in [1, 64]");
  EXPECT_EQ(refusal("match.range_px=many"), "match.range_px: many: must be an integer in [1, 64]");
  EXPECT_EQ(refusal("layers.overlap=nan"), "layers.overlap: nan: must be a number in [0.01, 1]");
  EXPECT_EQ(refusal("match.ranges_px=5"), "match.ranges_px: unknown option; did you mean 'match.range_px'?");
  EXPECT_EQ(refusal("match.range_px"), "match.range_px: must read FIELD=VALUE");
}

// Names are told apart, defaults are allowed, and one value beyond either end of a range is refused by check().
TEST(PortraitFields, EveryRangeIsChecked) {
  PortraitOptions options;
  EXPECT_NO_THROW(check(options));
  EXPECT_TRUE(changed_fields(options).empty());
  std::set<std::string> names;
  for (const OptionField& field : fields(options)) {
    EXPECT_TRUE(names.insert(field.name).second) << field.name;
    EXPECT_FALSE(field.source.empty()) << field.name;
    std::visit(
        [&](auto* value) {
          using Value = std::remove_pointer_t<decltype(value)>;
          const Value usual = *value;
          for (const double beyond : {field.low - 1, field.high * 2 + 1}) {
            *value = static_cast<Value>(beyond);
            EXPECT_THROW(check(options), InputError) << field.name << " " << beyond;
          }
          *value = usual;
        },
        field.value);
  }
  EXPECT_GT(names.size(), 50U);
  options.matching.normalize.window_px = 10;
  EXPECT_THROW(check(options), InputError);  // it has no center
  options = {};
  options.matcher = "papers";
  EXPECT_THROW(check(options), InputError);
}

TEST(PortraitFields, AreListedInColumns) {
  std::istringstream lines(describe_fields("paper"));
  std::string line;
  std::getline(lines, line);
  const std::size_t range = line.find("range"), unit = line.find("unit"), source = line.find("source");
  for (int i = 0; std::getline(lines, line) && !line.starts_with("Source"); ++i) {
    for (const std::size_t column : {range, unit, source}) {
      ASSERT_GT(line.size(), column) << line;
      EXPECT_EQ(line[column - 1], ' ') << line;
    }
    EXPECT_NE(line[range], ' ') << line;
    EXPECT_NE(line[source], ' ') << line;
  }
}

TEST(KnownSubject, WhatTheUserPointsAtComesBeforeTheCapturesFace) {
  Capture capture = synthetic_capture();
  capture.face_px = {2, 3, 10, 8};
  PortraitOptions options;
  EXPECT_EQ(known_subject(capture, options).source, "capture");
  EXPECT_EQ(known_subject(capture, options).faces.at(0).width, 10);
  options.tap = tapped_region(40, 20, capture.camera);
  EXPECT_TRUE(known_subject(capture, options).faces.empty());
  EXPECT_EQ(known_subject(capture, options).tap->x, 40 - 4.8 / 2);
  options.faces = {{0, 0, 4, 4}, {20, 20, 9, 9}};
  const KnownSubject given = known_subject(capture, options);
  EXPECT_EQ(given.source, "given");
  EXPECT_EQ(given.faces.at(0).width, 9);  // largest first
}

TEST(KnownSubject, FacesLieInTheUprightPicture) {
  Capture capture = synthetic_capture();  // 64 x 48: upright 48 x 64
  capture.face_px = {50, 3, 10, 8};
  PortraitOptions options;
  options.transposed = true;
  EXPECT_EQ(known_subject(capture, options).faces.at(0).y, 50);
  options.faces = {{0, 56, 4, 4}};
  EXPECT_NO_THROW(known_subject(capture, options));
  options.faces = {{56, 0, 4, 4}};
  EXPECT_THROW(known_subject(capture, options), InputError);
  options.faces = {{0, 0, 0, 4}};
  EXPECT_THROW(known_subject(capture, options), InputError);

  options = {};
  capture.face_px = {-50, 3, 10, 8};
  const KnownSubject outside = known_subject(capture, options);
  EXPECT_TRUE(outside.faces.empty());
  ASSERT_EQ(outside.warnings.size(), 1U);
  EXPECT_NE(outside.warnings[0].find("/face_px"), std::string::npos);
}

}  // namespace
}  // namespace dualpixel::pipeline
