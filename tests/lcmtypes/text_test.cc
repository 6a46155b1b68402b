// Text from outside becomes valid UTF-8 on one line.
#include "lcmtypes/wire/text.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <string>

namespace knap {
namespace {

TEST(TextTest, GoodTextStaysAsItIs) {
  for (const std::string text :
       {"", "node-1.lab", "Gerät № 5 — 机器 🤖", "\xc2\xa0", "\xef\xbf\xbd", "\xf4\x8f\xbf\xbf"}) {
    EXPECT_EQ(CleanText(text), text);
  }
}

TEST(TextTest, BytesThatAreNoCharacterBecomeQuestionMarks) {
  EXPECT_EQ(CleanText("a\xff\xfe"
                      "b"),
            "a??b");
  EXPECT_EQ(CleanText("\xc3"), "?");                 // cut in the middle
  EXPECT_EQ(CleanText("\xe6\x9c"), "??");            // the same
  EXPECT_EQ(CleanText("\xc0\xaf"), "??");            // '/' written too long
  EXPECT_EQ(CleanText("\xe0\x80\xaf"), "???");       // the same in three bytes
  EXPECT_EQ(CleanText("\xed\xa0\x80"), "???");       // half of a UTF-16 pair
  EXPECT_EQ(CleanText("\xf4\x90\x80\x80"), "????");  // beyond Unicode
  EXPECT_EQ(CleanText("\x80z"), "?z");               // a continuation of nothing
  EXPECT_EQ(CleanText("Gr\xfc\xdf"
                      "e"),
            "Gr??e");  // Latin-1
}

TEST(TextTest, CharactersThatActBecomeSpaces) {
  EXPECT_EQ(CleanText("\x1b[2Jred\x07\r\n\ttext\x7f"), " [2Jred    text ");
  EXPECT_EQ(CleanText(std::string("a\0b", 3)), "a b");
  EXPECT_EQ(CleanText("\xc2\x9b"
                      "31m"),
            " 31m");  // CSI as one C1 control
  EXPECT_EQ(CleanText("a\xe2\x80\xa8"
                      "b\xe2\x80\xae"
                      "c"),
            "a b c");  // a line separator, right-to-left override
}

TEST(TextTest, LinesKeepTheirEnds) {
  EXPECT_EQ(CleanLines("a\x1b\nb\xff\r\n\nc"), "a \nb? \n\nc");
  EXPECT_EQ(CleanLines("\n"), "\n");
  EXPECT_EQ(CleanLines(""), "");
}

TEST(TextTest, IsCutAtWholeCharacters) {
  EXPECT_EQ(CleanText("Gerät", 3), "Ger");
  EXPECT_EQ(CleanText("Gerät", 4), "Ger");
  EXPECT_EQ(CleanText("Gerät", 5), "Ger\xc3\xa4");
  EXPECT_EQ(CleanText("🤖🤖", 7), "🤖");
  EXPECT_EQ(CleanText("abc", 0), "");
}

RC_GTEST_PROP(TextTest, CleaningTwiceIsCleaningOnceAndNeverLengthens, (const std::string& text)) {
  const std::string clean = CleanText(text);
  RC_ASSERT(CleanText(clean) == clean);
  RC_ASSERT(clean.size() <= text.size());
  for (const char c : clean) RC_ASSERT(static_cast<unsigned char>(c) >= 0x20 && c != 0x7f);
}

TEST(TextTest, HostNameIsClean) {
  EXPECT_FALSE(FindHostName().empty());
  EXPECT_EQ(CleanText(FindHostName()), FindHostName());
}

}  // namespace
}  // namespace knap
