#include "capture/error.h"

#include <gtest/gtest.h>

namespace dualpixel {
namespace {

TEST(Printable, LeavesPlainTextAlone) {
  EXPECT_EQ(printable("scenes/portrait.json"), "scenes/portrait.json");
  EXPECT_EQ(printable("Bücher/写真.exr"), "Bücher/写真.exr");
  EXPECT_EQ(printable("\U0001F4F7"), "\U0001F4F7");
}

TEST(Printable, EscapesWhatBreaksOrReordersALine) {
  EXPECT_EQ(printable("a\nb"), "a\\nb");
  EXPECT_EQ(printable(std::string("a\0\x1b[2Jb\x7f", 8)), "a\\x00\\x1b[2Jb\\x7f");
  EXPECT_EQ(printable("\u202egpj"), "\\xe2\\x80\\xaegpj");
  EXPECT_EQ(printable("\u0085"), "\\xc2\\x85");
}

TEST(Printable, EscapesBytesThatAreNotUtf8) {
  EXPECT_EQ(printable("\xff"), "\\xff");
  EXPECT_EQ(printable("\xc0\x80"), "\\xc0\\x80");                    // overlong
  EXPECT_EQ(printable("\xe0\x80\x80"), "\\xe0\\x80\\x80");           // overlong
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");           // surrogate
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // past U+10FFFF
  EXPECT_EQ(printable("a\xe2\x82"), "a\\xe2\\x82");                  // cut short
}

TEST(Printable, CutsLongText) {
  const std::string line = printable(std::string(100000, 'x'));
  EXPECT_LT(line.size(), 250u);
  EXPECT_TRUE(line.ends_with("..."));
}

TEST(DidYouMean, NamesTheNearest) {
  const std::vector<std::string> known = {"focal_length_mm", "focus_distance_m", "iso"};
  EXPECT_EQ(did_you_mean("focal_lenght_mm", known), "; did you mean 'focal_length_mm'?");
  EXPECT_EQ(did_you_mean("focus_distance", known), "; did you mean 'focus_distance_m'?");
  EXPECT_EQ(did_you_mean("ios", {"is", "iso"}), "; did you mean 'is'?");
}

TEST(DidYouMean, IsSilentWhereNothingIsClose) {
  EXPECT_EQ(did_you_mean("banana", {"focal_length_mm", "iso"}), "");
  EXPECT_EQ(did_you_mean("x", {}), "");
  EXPECT_EQ(did_you_mean(std::string(1 << 20, 'a'), {"iso"}), "");
}

}  // namespace
}  // namespace dualpixel
