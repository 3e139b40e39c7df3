#include "capture/json_fields.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "capture/error.h"
#include "tests/temporary_folder.h"

namespace dualpixel {
namespace {

using nlohmann::json;
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

template <typename Act>
std::string refusal(Act act) {
  return message_of<InputError>(act);
}

std::string parse_refusal(const std::string& text) {
  return refusal([&] { parse_json(text, "f.json"); });
}

std::string nested(std::size_t depth, const std::string& open, const std::string& close) {
  std::string text;
  for (std::size_t i = 0; i < depth; ++i) text += open;
  text += "1";
  for (std::size_t i = 0; i < depth; ++i) text += close;
  return text;
}

TEST(ParseJson, ReadsWhatIsAllowed) {
  EXPECT_EQ(parse_json(R"({"a": [1, {"a": 2}, {"a": 3}], "b": {"a": null}})", "f").at("a").size(), 3u);
  EXPECT_NO_THROW(parse_json(nested(256, "[", "]"), "f"));
  EXPECT_NO_THROW(parse_json(nested(256, "{\"a\":", "}"), "f"));
}

TEST(ParseJson, RefusesDeepNesting) {
  EXPECT_EQ(parse_refusal(nested(257, "[", "]")), "f.json: nested deeper than 256 levels");
  EXPECT_EQ(parse_refusal(nested(257, "{\"a\":", "}")), "f.json: nested deeper than 256 levels");
  EXPECT_EQ(parse_refusal(std::string(5'000'000, '[')), "f.json: nested deeper than 256 levels");
}

TEST(ParseJson, RefusesDuplicateKeys) {
  EXPECT_EQ(parse_refusal(R"({"a": 1, "b": {"x": 1}, "a": 2})"), "f.json: field \"a\" is given twice");
  EXPECT_EQ(parse_refusal(R"([{"b": {"x": 1, "x": 1}}])"), "f.json: field \"x\" is given twice");
  EXPECT_EQ(parse_refusal(R"({"a": 1, "\u0061": 2})"), "f.json: field \"a\" is given twice");
}

TEST(ParseJson, RefusesWhatIsNotJsonInOneLine) {
  for (const std::string text : {"", "{", "{\"a\": NaN}", "{\"a\": Infinity}", "{\"a\": 1e999}", "{\"a\": 01}", "[1,]",
                                 "{} {}", "// c\n{}", "\"\xff\"", "\"a\nb\"", "{\"a\" 1}", "nul", "\x1b[2J"}) {
    const std::string message = parse_refusal(text);
    EXPECT_TRUE(message.starts_with("f.json: ")) << text;
    EXPECT_EQ(message.find_first_of("\n\r\x1b"), std::string::npos) << message;
    EXPECT_EQ(message.find("json.exception"), std::string::npos) << message;
  }
}

TEST(ParseJson, SaysWhereANumberIsTooLarge) {
  EXPECT_EQ(parse_refusal("{\"a\": 1,\n \"b\": -1e999}"), "f.json: line 2: a number is too large");
  EXPECT_EQ(parse_refusal("[1e999]"), "f.json: a number is too large");
}

TEST(ReadJsonFile, RefusesWhatIsNoReadableFile) {
  const TemporaryFolder folder;
  EXPECT_EQ(refusal([&] { read_json_file(folder / "none.json"); }), folder / "none.json" + ": no such file");
  EXPECT_EQ(refusal([&] { read_json_file(folder.path.string()); }), folder.path.string() + ": is a folder, not a file");
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(refusal([&] { read_json_file(folder / "pipe"); }), folder / "pipe" + ": is not a regular file");
  EXPECT_EQ(refusal([&] { read_json_file("/dev/zero"); }), "/dev/zero: is not a regular file");
}

TEST(ReadJsonFile, RefusesHugeFilesUnread) {
  const TemporaryFolder folder;
  write_bytes(folder / "big.json", "");
  std::filesystem::resize_file(folder / "big.json", std::uintmax_t{1} << 40);  // sparse
  EXPECT_NE(refusal([&] { read_json_file(folder / "big.json"); }).find("at most 67108864 are read"), std::string::npos);
}

TEST(Fields, KeepsDefaultsAndReadsEachType) {
  const json object = json::parse(R"({"d": 2.5, "far": "inf", "i": -3, "u": 18446744073709551615, "b": true,
                                      "t": "x", "c": "ramp", "n": [1, 2.5, 3]})");
  Fields fields(object, "f.json");
  double d = 0, far = 0, absent = 7;
  float single = 0;
  int i = 0;
  std::uint64_t u = 0;
  bool b = false;
  std::string t, c = "hard";
  std::array<double, 3> n{};
  fields.number("d", d, 0, 10).number("d", single, 0, 10).number("far", far, 0, kUnbounded).number("no", absent, 0, 1);
  fields.integer("i", i, -5, 5).integer("u", u, 0, ~std::uint64_t{0}).boolean("b", b).text("t", t);
  fields.choice("c", c, {"hard", "ramp"}).numbers("n", n.data(), 3);
  fields.done();
  EXPECT_EQ(d, 2.5);
  EXPECT_EQ(single, 2.5f);
  EXPECT_EQ(far, kUnbounded);
  EXPECT_EQ(absent, 7);
  EXPECT_EQ(i, -3);
  EXPECT_EQ(u, ~std::uint64_t{0});
  EXPECT_TRUE(b);
  EXPECT_EQ(t, "x");
  EXPECT_EQ(c, "ramp");
  EXPECT_EQ(n, (std::array<double, 3>{1, 2.5, 3}));
}

/// The refusal of field "x" with this value, read by `read`.
template <typename Read>
std::string field_refusal(const std::string& value, Read read) {
  const json object = parse_json("{\"x\": " + value + "}", "f");
  return refusal([&] {
    Fields fields(object, "s.json", "/camera");
    read(fields);
  });
}

TEST(Fields, RefusesNumbersOutOfRange) {
  double value = 1;
  const auto read = [&](Fields& fields) { fields.number("x", value, 0.01, kUnbounded); };
  EXPECT_EQ(field_refusal("-1", read), "s.json: /camera/x: -1: must be a number in [0.01, inf]");
  EXPECT_EQ(field_refusal("\"1\"", read), "s.json: /camera/x: \"1\": must be a number in [0.01, inf]");
  EXPECT_EQ(field_refusal("\"nan\"", read), "s.json: /camera/x: \"nan\": must be a number in [0.01, inf]");
  for (const char* wrong : {"null", "true", "[1]", "{}", "\"-inf\"", "0.0099999"})
    EXPECT_NE(field_refusal(wrong, read), "");
  EXPECT_EQ(value, 1);
  EXPECT_EQ(field_refusal("0.01", read), "");
  const auto finite = [&](Fields& fields) { fields.number("x", value, 0, 10); };
  EXPECT_EQ(field_refusal("\"inf\"", finite), "s.json: /camera/x: \"inf\": must be a number in [0, 10]");
  float single = 0;
  const auto narrow = [&](Fields& fields) { fields.number("x", single, 0, 1e300); };
  EXPECT_EQ(field_refusal("1e200", narrow), "s.json: /camera/x: 1e+200: beyond single precision");
}

TEST(Fields, RefusesIntegersThatWouldWrap) {
  int small = 1;
  const auto read = [&](Fields& fields) { fields.integer("x", small, -10, 10); };
  for (const char* wrong : {"11", "-11", "1.5", "1.0", "4294967297", "18446744073709551615", "9223372036854775808",
                            "\"1\"", "null", "true", "-9223372036854775808"}) {
    EXPECT_NE(field_refusal(wrong, read), "") << wrong;
  }
  EXPECT_EQ(small, 1);
  std::uint64_t large = 1;
  const auto read_large = [&](Fields& fields) { fields.integer("x", large, 0, 100); };
  for (const char* wrong : {"-1", "101", "0.5", "18446744073709551616"})
    EXPECT_NE(field_refusal(wrong, read_large), "");
  EXPECT_EQ(large, 1u);
}

TEST(Fields, RefusesOtherTypes) {
  bool flag = false;
  std::string text;
  std::array<double, 2> pair{};
  EXPECT_EQ(field_refusal("0", [&](Fields& f) { f.boolean("x", flag); }),
            "s.json: /camera/x: 0: must be true or false");
  EXPECT_EQ(field_refusal("[]", [&](Fields& f) { f.text("x", text); }), "s.json: /camera/x: []: must be a string");
  EXPECT_EQ(field_refusal("\"rmap\"",
                          [&](Fields& f) {
                            f.choice("x", text, {"hard", "ramp"});
                          }),
            "s.json: /camera/x: \"rmap\": must be one of 'hard', 'ramp'");
  EXPECT_EQ(field_refusal("\"ramq\"",
                          [&](Fields& f) {
                            f.choice("x", text, {"hard", "ramp"});
                          }),
            "s.json: /camera/x: \"ramq\": must be one of 'hard', 'ramp'; did you mean 'ramp'?");
  for (const char* wrong : {"1", "[1]", "[1, 2, 3]", "[1, \"2\"]", "[1, null]", "{\"0\": 1, \"1\": 2}"}) {
    EXPECT_NE(field_refusal(wrong, [&](Fields& f) { f.numbers("x", pair.data(), 2); }), "") << wrong;
  }
  EXPECT_EQ(field_refusal("3", [&](Fields& f) { f.object("x"); }), "s.json: /camera/x: 3: must be an object");
  EXPECT_EQ(refusal([&] { Fields(json::array(), "s.json"); }), "s.json: must be an object");
}

TEST(Fields, NamesUnknownAndMissingKeys) {
  const json object = parse_json(R"({"focal_lenght_mm": 4, "sensor": {"bits": 10, "extra": 1}})", "f");
  double value = 0;
  EXPECT_EQ(refusal([&] {
              Fields fields(object, "s.json");
              fields.number("focal_length_mm", value, 0, 10).has("sensor");
              fields.done();
            }),
            "s.json: /focal_lenght_mm: unknown field; did you mean 'focal_length_mm'?");
  EXPECT_EQ(refusal([&] { Fields(object, "s.json").required("focal_length_mm"); }),
            "s.json: /focal_lenght_mm: unknown field; did you mean 'focal_length_mm'?");
  EXPECT_EQ(refusal([&] { Fields(object, "s.json").required("f_number"); }), "s.json: /f_number: is required");
  EXPECT_EQ(refusal([&] {
              Fields fields(object, "s.json");
              Fields sensor = fields.object("sensor");
              sensor.raw("bits");
              sensor.done();
            }),
            "s.json: /sensor/extra: unknown field; there are bits");
  EXPECT_NO_THROW(Fields(object, "s.json").object("absent").done());
  EXPECT_TRUE(Fields(object, "s.json").raw("absent").is_null());
}

TEST(Fields, QuotesHostileNamesInOneLine) {
  const json object = {{"a/b~\n<script>", 1}};
  EXPECT_EQ(refusal([&] { Fields(object, "s.json").done(); }), "s.json: /a~1b~0\\n<script>: unknown field");
  const json long_name = {{std::string(1 << 20, 'k'), 1}};
  EXPECT_LT(refusal([&] { Fields(long_name, "s.json").done(); }).size(), 400u);
  const json deep = parse_json(nested(250, "[", "]"), "f");
  const json holder = {{"x", deep}};
  double value = 0;
  EXPECT_LT(refusal([&] { Fields(holder, "s.json").number("x", value, 0, 1); }).size(), 400u);
}

TEST(ApplyOverride, SetsFieldsOfEveryType) {
  json root = parse_json(R"({"camera": {"focus_distance_m": 1}, "lights": [{"on": true}, {"on": true}]})", "f");
  apply_override(root, "camera.focus_distance_m=0.9");
  apply_override(root, "camera.name=a=b c");
  apply_override(root, "lights.1.on=false");
  apply_override(root, "sensor.noise.read=[1, 2]");
  apply_override(root, "camera.far=inf");
  EXPECT_EQ(root["camera"]["focus_distance_m"], 0.9);
  EXPECT_EQ(root["camera"]["name"], "a=b c");
  EXPECT_EQ(root["lights"][1]["on"], false);
  EXPECT_EQ(root["lights"][0]["on"], true);
  EXPECT_EQ(root["sensor"]["noise"]["read"], json::array({1, 2}));
  EXPECT_EQ(root["camera"]["far"], "inf");
}

TEST(ApplyOverride, RefusesWhatItCannotSet) {
  json root = parse_json(R"({"camera": {"iso": 1}, "lights": [1, 2]})", "f");
  const json before = root;
  for (const std::string wrong :
       {"", "camera", "=1", ".=1", "camera.=1", ".camera=1", "camera..iso=1", "camera.iso.deep=1", "lights.2=1",
        "lights.-1=1", "lights.x=1", "lights.99999999999999999999=1", "camera.iso={\"a\": 1, \"a\": 2}",
        "camera.iso=\xff", "\xff=1"}) {
    EXPECT_NE(refusal([&] { apply_override(root, wrong); }), "") << wrong;
  }
  std::string deep = "a";
  for (int i = 0; i < 100; ++i) deep += ".a";
  EXPECT_NE(refusal([&] { apply_override(root, deep + "=1"); }), "");
  EXPECT_NE(refusal([&] { apply_override(root, "camera.iso=" + nested(100000, "[", "]")); }), "");
  EXPECT_EQ(root, before);
  EXPECT_EQ(refusal([&] { apply_override(root, "lights.2=1"); }), "--set lights.2=1: '2' must be an index below 2");
}

}  // namespace
}  // namespace dualpixel
