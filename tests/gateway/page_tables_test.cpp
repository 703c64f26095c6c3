// SPDX-License-Identifier: Apache-2.0
// The tables of the page, as the build has written them.
#include "descriptions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <set>
#include <string>

namespace vdrive::gateway {
namespace {

using testing::ElementsAre;

/// @return the value of `export const NAME = VALUE as const;`, null where the file has none.
Json table(const std::string& name) {
  std::ifstream file(VDRIVE_PAGE_TABLES);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::string before = "\nexport const " + name + " = ";
  const std::size_t begin = text.find(before);
  if (begin == std::string::npos) return nullptr;
  const std::size_t value = begin + before.size();
  return Json::parse(text.substr(value, text.find(" as const;\n", value) - value));
}

TEST(PageTables, HaveTheSchemasOfTheGateway) {
  EXPECT_EQ(table("BENCH_DESCRIPTION"), Json::parse(description_channel("").schema));
  EXPECT_EQ(table("BENCH_STATE"), Json::parse(state_channel("").schema));
  EXPECT_EQ(table("CONTROL"), Json::parse(control_channel().schema));
  EXPECT_EQ(table("DICTIONARY"), Json::parse(dictionary_channel().schema));
}

TEST(PageTables, HaveTheMaskOfAStateOfTheStandard) {
  const Json states = table("POWER_STATES");
  ASSERT_EQ(states.size(), 8U);
  const Json expected{{"state", "operation_enabled"},
                      {"name", "Operation enabled"},
                      {"mask", 0x6F},
                      {"value", 0x27}};
  EXPECT_EQ(states[3], expected);
}

TEST(PageTables, HaveEachTransitionOfTheStandard) {
  std::set<unsigned> numbers;
  for (const Json& transition : table("TRANSITIONS"))
    numbers.insert(transition["number"].get<unsigned>());
  EXPECT_THAT(numbers, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16));
}

// The page finds the Chinese name of a bit by the English one.
TEST(PageTables, HaveOneChineseNameOfEachModeAndBit) {
  for (const char* const rows : {"OPERATING_MODES", "BIT_NAMES"}) {
    std::set<std::string> names;
    ASSERT_GT(table(rows).size(), 5U) << rows;
    for (const Json& row : table(rows)) {
      EXPECT_TRUE(names.insert(row["name"].get<std::string>()).second) << row << " is named twice";
      EXPECT_NE(row["name_zh"], "") << row;
    }
  }
}

}  // namespace
}  // namespace vdrive::gateway
