// SPDX-License-Identifier: Apache-2.0
// Counted nouns; "did you mean": names that are near enough and names that are not; numbers within
// limits.
#include "vdrive/wording.hpp"

#include <gtest/gtest.h>

#include <string>

namespace vdrive {
namespace {

TEST(Counted, GivesTheSingularForOne) {
  EXPECT_EQ(counted(0, "axis", "axes"), "0 axes");
  EXPECT_EQ(counted(1, "axis", "axes"), "1 axis");
  EXPECT_EQ(counted(2, "axis", "axes"), "2 axes");
}

TEST(EditDistance, CountsInsertedRemovedReplacedAndSwappedCharacters) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("axis", "axis"), 0U);
  EXPECT_EQ(edit_distance("", "axis"), 4U);
  EXPECT_EQ(edit_distance("axs", "axis"), 1U);
  EXPECT_EQ(edit_distance("axxis", "axis"), 1U);
  EXPECT_EQ(edit_distance("axos", "axis"), 1U);
  EXPECT_EQ(edit_distance("enabel", "enable"), 1U) << "two neighbours exchanged";
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
}

TEST(Suggestion, IsTheNearestNameWithinTheAllowedDistance) {
  EXPECT_EQ(suggestion("grippper", {"gantry", "gripper", "grip"}), " (did you mean 'gripper'?)");
  EXPECT_EQ(suggestion("dance", {"enable", "disable", "halt"}), "");
  EXPECT_EQ(suggestion("", {"halt"}), "");
  EXPECT_EQ(suggestion("--speed", {"--peer"}), "") << "two of five letters differ";
  EXPECT_EQ(suggestion("x", {"y"}), "") << "nothing in common";
  EXPECT_EQ(suggestion(std::string(100'000, 'a'), {"halt"}), "");
}

TEST(PrefixedLines, SayOfEachLineWhoseItIs) {
  EXPECT_EQ(prefixed_lines("vdrived: ", "one"), "vdrived: one");
  EXPECT_EQ(prefixed_lines("vdrived: ", "one\ntwo"), "vdrived: one\nvdrived: two");
}

TEST(RefusalOfAChoice, NamesTheWordsAndTheNearestOne) {
  EXPECT_EQ(refusal_of_choice("dds", {"local", "dds"}), "");
  EXPECT_EQ(refusal_of_choice("air", {"local", "dds"}), "'air' must be one of local, dds");
  EXPECT_EQ(refusal_of_choice("locl", {"local", "dds"}),
            "'locl' must be one of local, dds (did you mean 'local'?)");
}

TEST(TakeInteger, WritesDecimalDigitsOverAnyWholeNumber) {
  for (const char* const whole : {"16", "016", "0x10", "1.6e1", "16.0"}) {
    std::string text = whole;
    EXPECT_EQ(take_integer(text, 1, 16), "") << whole;
    EXPECT_EQ(text, "16") << whole;
  }
}

TEST(TakeInteger, NamesValueAndLimitsOfWhatItRefusesAndKeepsIt) {
  for (const char* const bad : {"0", "17", "1e9", "1e99", "1.5", "a", ""}) {
    std::string text = bad;
    EXPECT_EQ(take_integer(text, 1, 16),
              std::string("'") + bad + "' must be a whole number from 1 to 16");
    EXPECT_EQ(text, bad);
  }
}

}  // namespace
}  // namespace vdrive
