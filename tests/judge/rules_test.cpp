// SPDX-License-Identifier: Apache-2.0
// A planted mistake is found by its rule and the others that it breaks, and by no others; a correct
// master has no finding.
#include "judge/planted.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

namespace vdrive::judge {
namespace {

using testing::Contains;
using testing::IsEmpty;
using testing::Not;

TEST(Rules, FindTheMasterThatBreaksThemAndNothingElse) {
  for (const Planted& planted : planted_masters()) {
    const std::string name(row_of(planted.rule).name);
    std::vector<std::string> found = planted.wrong();
    EXPECT_THAT(found, Contains(name));
    std::erase_if(found, [&](const std::string& other) {
      return other == name || std::ranges::find(planted.also, other) != planted.also.end();
    });
    EXPECT_THAT(found, IsEmpty()) << "beside " << name;
  }
}

TEST(Rules, FindNothingInTheMasterThatDoesTheSameRightly) {
  for (const Planted& planted : planted_masters()) {
    EXPECT_THAT(planted.right(), IsEmpty()) << row_of(planted.rule).name;
  }
}

TEST(Rules, HaveAPlantedMasterEach) {
  std::set<Rule> planted;
  for (const Planted& row : planted_masters()) planted.insert(row.rule);
  for (const RuleRow& row : rules()) EXPECT_TRUE(planted.contains(row.rule)) << row.name;
}

TEST(Rules, HaveUniqueNamesAndNoEmptyCell) {
  std::set<std::string_view> names;
  for (const RuleRow& row : rules()) {
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_EQ(find_rule(row.name), row.rule);
    for (const std::string_view cell :
         {row.title, row.clause, row.expected, row.remedy, row.wrong, row.right}) {
      EXPECT_THAT(cell, Not(IsEmpty())) << row.name;
      EXPECT_FALSE(cell.ends_with('.')) << row.name << ": the report ends its sentences";
    }
  }
}

}  // namespace
}  // namespace vdrive::judge
