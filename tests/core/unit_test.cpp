// SPDX-License-Identifier: Apache-2.0
#include "vdrive/unit.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace vdrive {
namespace {

Unit millimetres() {
  return {.kind = UnitKind::linear, .name = "mm", .size = 1'000.0};
}

TEST(Unit, OfTheDefaultAxisIsARevolutionOf4096) {
  // 90 deg are a quarter of 4096, pi/2 rad too.
  EXPECT_DOUBLE_EQ(to_user_units(90.0, Unit()), 1'024.0);
  EXPECT_DOUBLE_EQ(from_user_units(1'024.0, Unit()), 90.0);
  EXPECT_DOUBLE_EQ(*user_units_in(Unit(), "rev"), 4'096.0);
  EXPECT_DOUBLE_EQ(1.5707963267948966 * *user_units_in(Unit(), "rad"), 1'024.0);
  EXPECT_EQ(user_units_in(Unit(), "UU"), 1.0);
}

TEST(Unit, ShownInRadiansConvertsInRadians) {
  const Unit unit{.kind = UnitKind::rotary, .name = "rad", .size = 4'096.0};
  EXPECT_DOUBLE_EQ(to_user_units(1.5707963267948966, unit), 1'024.0);
  EXPECT_DOUBLE_EQ(from_user_units(1'024.0, unit), 1.5707963267948966);
}

TEST(Unit, OfALengthConvertsToTheOtherLengths) {
  // 1 mm = 1000 UU: 1 m is 1000 mm, 1 cm is 10 mm, 1 um a thousandth of a mm.
  EXPECT_DOUBLE_EQ(to_user_units(12.5, millimetres()), 12'500.0);
  EXPECT_DOUBLE_EQ(*user_units_in(millimetres(), "m"), 1e6);
  EXPECT_DOUBLE_EQ(*user_units_in(millimetres(), "cm"), 1e4);
  EXPECT_DOUBLE_EQ(*user_units_in(millimetres(), "um"), 1.0);
  const Unit metres{.kind = UnitKind::linear, .name = "m", .size = 1e6};
  EXPECT_DOUBLE_EQ(*user_units_in(metres, "mm"), 1e3);
}

TEST(Unit, DoesNotConvertUnitsOfAnotherKindOrName) {
  EXPECT_EQ(user_units_in(Unit(), "mm"), std::nullopt);
  EXPECT_EQ(user_units_in(millimetres(), "deg"), std::nullopt);
  const Unit teeth{.kind = UnitKind::linear, .name = "teeth", .size = 64.0};
  EXPECT_EQ(user_units_in(teeth, "teeth"), 64.0);
  EXPECT_EQ(user_units_in(teeth, "mm"), std::nullopt);
  EXPECT_EQ(units_of(teeth), std::vector<std::string>{"teeth"});
}

TEST(Unit, ListsItsOwnNameFirst) {
  EXPECT_EQ(units_of({.kind = UnitKind::rotary, .name = "rev", .size = 1.0}),
            (std::vector<std::string>{"rev", "deg", "rad"}));
  EXPECT_EQ(units_of(millimetres()), (std::vector<std::string>{"mm", "m", "cm", "um"}));
}

TEST(Unit, HasTheDecimalsThatResolveOneUserUnit) {
  // 1 UU is 0.0879 deg: two decimals; 0.001 mm: three.
  EXPECT_EQ(position_text(1'024, Unit()), "90.00 deg");
  EXPECT_EQ(position_text(-1, Unit()), "-0.09 deg");
  EXPECT_EQ(position_text(12'345, millimetres()), "12.345 mm");
  EXPECT_EQ(position_text(7, {.kind = UnitKind::linear, .name = "teeth", .size = 1.0}), "7 teeth");
}

TEST(Unit, NameIsASuffixOfATypedValue) {
  for (const char* const name : {"mm", "teeth", "%", "\u00B5m"}) {
    EXPECT_EQ(check_unit_name(UnitKind::linear, name), std::nullopt) << name;
  }
  for (const char* const name :
       {"", "m2", "m m", "m/s", "mm\n", "\xFF", "seventeen_letters", "UU", "deg", "rpm"}) {
    EXPECT_TRUE(check_unit_name(UnitKind::linear, name)) << name;
  }
  EXPECT_EQ(check_unit_name(UnitKind::rotary, "rad"), std::nullopt);
  EXPECT_TRUE(check_unit_name(UnitKind::rotary, "mm"));
}

TEST(Unit, FromAnotherProgramIsUsableOnlyWithinItsLimits) {
  EXPECT_TRUE(is_usable(Unit()));
  for (const double size : {0.0, -1.0, 9e-7, 1.1e9, std::numeric_limits<double>::quiet_NaN(),
                            std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(is_usable({.kind = UnitKind::rotary, .name = "deg", .size = size})) << size;
  }
  EXPECT_FALSE(is_usable({.kind = UnitKind::linear, .name = "", .size = 1.0}));
}

}  // namespace
}  // namespace vdrive
