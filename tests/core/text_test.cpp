// SPDX-License-Identifier: Apache-2.0
#include "vdrive/text.hpp"

#include <gtest/gtest.h>

#include <string>

namespace vdrive {
namespace {

using namespace std::string_literals;

TEST(EscapedText, KeepsPrintableText) {
  EXPECT_EQ(escaped("it's 1.5 \"mm\""), "it's 1.5 \"mm\"");
  EXPECT_EQ(escaped("\u5DE6 \u00E4\u20AC\U0001F600"), "\u5DE6 \u00E4\u20AC\U0001F600");
  EXPECT_EQ(escaped(""), "");
}

TEST(EscapedText, EscapesControlCharacters) {
  EXPECT_EQ(escaped("a\nb\rc\td\\e"), R"(a\nb\rc\td\\e)");
  EXPECT_EQ(escaped("\x1B[31m\x07\x7F\0"s), R"(\x1B[31m\x07\x7F\x00)");
  EXPECT_EQ(escaped("\u009B31m"), R"(\xC2\x9B31m)") << "the same for a terminal as ESC [";
  EXPECT_EQ(escaped("\u202E\u2028\u2066"), R"(\xE2\x80\xAE\xE2\x80\xA8\xE2\x81\xA6)")
      << "characters that reorder or break a line";
  EXPECT_EQ(escaped("\u2026\u00A0"), "\u2026\u00A0") << "their neighbours do neither";
}

TEST(EscapedText, EscapesBytesThatAreNotUtf8) {
  EXPECT_EQ(escaped("a\xFF"), R"(a\xFF)");
  EXPECT_EQ(escaped("\xC0\xAF"), R"(\xC0\xAF)") << "an overlong /";
  EXPECT_EQ(escaped("\xED\xA0\x80"), R"(\xED\xA0\x80)") << "a surrogate";
  EXPECT_EQ(escaped("\xE2\x82"), R"(\xE2\x82)") << "cut off";
}

// Of 8 characters: three quarters from the front are 6, one quarter from the end is 2.
TEST(EscapedText, KeepsBeginAndEndOfLongText) {
  EXPECT_EQ(escaped("12345678", 8), "12345678");
  EXPECT_EQ(escaped("123456789", 8), "123456...89");
  EXPECT_EQ(escaped("\u00E4\u00E4\u00E4\u00E4\u00E4\u00E4xyz", 8),
            "\u00E4\u00E4\u00E4\u00E4\u00E4\u00E4...yz")
      << "characters count, not bytes";
}

TEST(QuotedText, GivesTheLengthOfAShortenedValue) {
  EXPECT_EQ(in_quotes("x"), "'x'");
  EXPECT_EQ(in_quotes(""), "''");
  EXPECT_EQ(in_quotes(std::string(64, 'a')), "'" + std::string(64, 'a') + "'");
  // Three quarters of 64 are 48, one quarter is 16.
  EXPECT_EQ(in_quotes(std::string(5'000, 'a')),
            "'" + std::string(48, 'a') + "..." + std::string(16, 'a') + "' (5000 bytes)");
}

TEST(WideText, IsRecognisedByItsByteOrderMarkOrAZeroByte) {
  EXPECT_TRUE(
      is_wide_text("\xFF\xFE"
                   "a\0"s));
  EXPECT_TRUE(is_wide_text("\xFE\xFF\0a"s));
  EXPECT_TRUE(is_wide_text("a\0b\0"s));
  EXPECT_TRUE(is_wide_text("\0\0\0a"s));
  EXPECT_FALSE(
      is_wide_text("\xEF\xBB\xBF"
                   "abc"))
      << "the mark of UTF-8";
  EXPECT_FALSE(is_wide_text(""));
}

}  // namespace
}  // namespace vdrive
