// SPDX-License-Identifier: Apache-2.0
// Positions, velocities and accelerations as a user types them, with and without a unit.
#include "values/units.hpp"

#include "base/usage_error.hpp"
#include "vdrive/dictionary/object_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace vdrive::tool {
namespace {

using namespace vdrive::literals;
using testing::HasSubstr;

const client::Unit kTurning{};
const client::Unit kSliding{.kind = client::UnitKind::linear, .name = "mm", .size = 1'000.0};

std::int64_t position(const std::string& text, const client::Unit& unit) {
  return user_units_of(parse_quantity(text, Dimension::position, DataType::integer32), unit, "1.1");
}

std::int64_t speed(const std::string& text, const client::Unit& unit) {
  return user_units_of(parse_quantity(text, Dimension::velocity, DataType::unsigned32), unit,
                       "1.1");
}

std::int64_t ramp(const std::string& text, const client::Unit& unit) {
  return user_units_of(parse_quantity(text, Dimension::acceleration, DataType::unsigned32), unit,
                       "1.1");
}

template <typename Work>
std::string refusal_of_quantity(const Work& work) {
  try {
    static_cast<void>(work());
  } catch (const UsageError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Quantity, WithoutAUnitIsInUserUnits) {
  EXPECT_EQ(position("-10000", kSliding), -10'000);
  EXPECT_EQ(position("1e4", kTurning), 10'000);
  EXPECT_EQ(position("0xFFFFD8F0", kTurning), -10'000) << "two's complement";
  EXPECT_EQ(position("10UU", kSliding), 10);
  EXPECT_EQ(position("-2147483648", kTurning), -2'147'483'648);
  EXPECT_EQ(speed("4294967295", kTurning), 4'294'967'295);
}

// A revolution has 4096 UU: 90 deg are 1024, 180 deg/s 2048 UU/s, 60 rpm 4096 UU/s.
TEST(Quantity, WithAUnitIsConvertedForTheAxis) {
  EXPECT_EQ(position("90deg", kTurning), 1'024);
  EXPECT_EQ(position("-0.25rev", kTurning), -1'024);
  EXPECT_EQ(position("90 deg", kTurning), 1'024);
  EXPECT_EQ(speed("180deg/s", kTurning), 2'048);
  EXPECT_EQ(speed("60rpm", kTurning), 4'096);
  EXPECT_EQ(ramp("360deg/s2", kTurning), 4'096);
  EXPECT_EQ(ramp("1rev/s^2", kTurning), 4'096);
  EXPECT_EQ(ramp("1rev/s\u00B2", kTurning), 4'096);
  EXPECT_EQ(position("12.5mm", kSliding), 12'500);
  EXPECT_EQ(position("1.5e-2m", kSliding), 15'000);
}

// 0.044 deg are 0.5006 UU, 0.0439 deg 0.4995 UU.
TEST(Quantity, IsRoundedToTheNearestUserUnit) {
  EXPECT_EQ(position("0.044deg", kTurning), 1);
  EXPECT_EQ(position("0.0439deg", kTurning), 0);
  EXPECT_EQ(position("-0.044deg", kTurning), -1);
}

// Rounded, 12.5 would silently become 13 in 6081h.
TEST(Quantity, OfAFractionOfAUserUnitIsRefused) {
  for (const char* const text : {"1.5", "-0.5", "1.6UU", "1e-3"}) {
    EXPECT_THAT(refusal_of_quantity([&] {
                  return position(text, kTurning);
                }),
                HasSubstr("is a fraction, but user units are whole numbers"))
        << text;
  }
  EXPECT_EQ(position("2.0", kTurning), 2);
  EXPECT_EQ(position("1e3", kTurning), 1'000);
  EXPECT_THAT(refusal_of_quantity([] {
                return parse_torque("12.5");
              }),
              HasSubstr("'12.5' is a fraction"));
  EXPECT_EQ(parse_torque("1.25%"), 13);  // 12.5 per mille
}

TEST(Quantity, OfAnotherUnitIsRefusedWithTheUnitsOfTheAxis) {
  EXPECT_EQ(refusal_of_quantity([] {
              return position("12.5mm", kTurning);
            }),
            "'12.5mm': axis 1.1 has no unit 'mm'; it has deg, rad, rev, UU");
  EXPECT_EQ(refusal_of_quantity([] {
              return speed("5deg/s", kSliding);
            }),
            "'5deg/s': axis 1.1 has no unit 'deg'; it has mm/s, m/s, cm/s, um/s, UU/s");
  EXPECT_THAT(refusal_of_quantity([] {
                return speed("5mm/s", kTurning);
              }),
              HasSubstr("rev/s, rpm, UU/s"));
  EXPECT_THAT(refusal_of_quantity([] {
                return speed("5rpm", kSliding);
              }),
              HasSubstr("no unit 'rpm'"));
}

// 1e9 deg are 11377777778 UU.
TEST(Quantity, OutOfRangeIsRefusedWithValueAndLimit) {
  EXPECT_EQ(refusal_of_quantity([] {
              return position("1e9deg", kTurning);
            }),
            "'1e9deg' of axis 1.1 is 11377777778 UU: must be from -2147483648 UU (-188743680.00 "
            "deg) to 2147483647 UU (188743679.91 deg)");
  EXPECT_EQ(refusal_of_quantity([] {
              return parse_quantity("3000000000", Dimension::position, DataType::integer32);
            }),
            "'3000000000' is 3e+09 UU: must be from -2147483648 UU to 2147483647 UU");
  EXPECT_THAT(refusal_of_quantity([] {
                return speed("-1", kTurning);
              }),
              HasSubstr("must be from 0 UU/s to 4294967295 UU/s"));
}

TEST(Quantity, OfInvalidTextIsRefusedWithAnExample) {
  for (const char* const text :
       {"", "ten", "inf", "nan", "1e400", "deg", "5deg/s", "+5", "1.5.5/"}) {
    EXPECT_THAT(refusal_of_quantity([&] {
                  return position(text, kTurning);
                }),
                HasSubstr("is not a position: write for example 1024, 90deg"))
        << text;
  }
  EXPECT_THAT(refusal_of_quantity([] {
                return speed("180deg", kTurning);
              }),
              HasSubstr("is not a speed: write for example 1000, 180deg/s"));
  EXPECT_THAT(refusal_of_quantity([] {
                return ramp("180deg/s", kTurning);
              }),
              HasSubstr("is not a ramp: write for example 6000, 900deg/s2"));
}

TEST(Quantity, AppliesToPositionsSpeedsRampsAndJerksOfTheDictionary) {
  EXPECT_EQ(dimension_of("position_user_target_value"_object), Dimension::position);
  EXPECT_EQ(dimension_of("user_position_upper_limit"_object), Dimension::position);
  EXPECT_EQ(dimension_of("target_velocity"_object), Dimension::velocity);
  EXPECT_EQ(dimension_of("profile_acc"_object), Dimension::acceleration);
  EXPECT_EQ(dimension_of("profile_jerk_2"_object), Dimension::jerk);
  EXPECT_EQ(dimension_of("target_torque"_object), std::nullopt);
  EXPECT_EQ(dimension_of("ds402_controlword"_object), std::nullopt);
}

}  // namespace
}  // namespace vdrive::tool
