// SPDX-License-Identifier: Apache-2.0
// Objects, values and durations as a user types them.
#include "values/value.hpp"

#include "base/usage_error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace vdrive::tool {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr ObjectAddress kStatusword{0x6041, 0};

TEST(ObjectName, CanBeTheNameOfTheStandard) {
  EXPECT_EQ(parse_object("statusword").address, (ObjectAddress{0x6041, 0}));
  EXPECT_EQ(parse_object("target_position").address, (ObjectAddress{0x607A, 0}));
  EXPECT_EQ(parse_object("max_position_limit").address, (ObjectAddress{0x607D, 2}));
  EXPECT_EQ(object_suggestion("profile_velocty"), " (did you mean 'profile_velocity'?)");
  EXPECT_EQ(object_suggestion("gravity"), "");
}

TEST(ObjectName, WithoutASubIndexCoversAllOfThem) {
  EXPECT_TRUE(parse_object("0x607D").covers({0x607D, 1}));
  EXPECT_TRUE(parse_object("0x607D").covers({0x607D, 2}));
  EXPECT_TRUE(parse_object("607Dh").covers({0x607D, 2}));
  EXPECT_FALSE(parse_object("0x607D:1").covers({0x607D, 2}));
  EXPECT_FALSE(parse_object("user_position_upper_limit").covers({0x607D, 1}));
  EXPECT_FALSE(parse_object("no_such").covers({0x607D, 1}));
}

TEST(ObjectName, CanBeAnIndexWithSubIndexZero) {
  EXPECT_EQ(parse_object("0x6041").address, kStatusword);
}

TEST(ObjectName, CanHaveASubIndexInDecimalOrHex) {
  EXPECT_EQ(parse_object("0x607D:1").address, (ObjectAddress{0x607D, 1}));
  EXPECT_EQ(parse_object("0x607d:0x02").address, (ObjectAddress{0x607D, 2}));
}

TEST(ObjectName, CanBeAVariableName) {
  EXPECT_EQ(parse_object("ds402_statusword").address, kStatusword);
  EXPECT_EQ(parse_object("user_position_upper_limit").address, (ObjectAddress{0x607D, 2}));
}

TEST(ObjectName, OfAMissingObjectIsAccepted) {
  EXPECT_EQ(parse_object("no_such_object").address, std::nullopt);
  EXPECT_EQ(parse_object("0x9999").address, (ObjectAddress{0x9999, 0}));
  EXPECT_EQ(parse_object("0x9999").row(), std::nullopt);
}

class BadObject : public testing::TestWithParam<const char*> {};

TEST_P(BadObject, IsAUsageErrorThatShowsTheText) {
  EXPECT_THAT(
      [] {
        (void)parse_object(GetParam());
      },
      ThrowsMessage<UsageError>(HasSubstr(std::string("'") + GetParam() + "'")));
}

INSTANTIATE_TEST_SUITE_P(Texts, BadObject,
                         testing::Values("", "6041", "0x", "0xZZ", "0x60410",
                                         "0x607D:", "0x607D:256", "0x607D:x", "Statusword",
                                         "0x607D:1:2", "-0x6041"),

                         [](const auto& text) {
                           return "row_" + std::to_string(text.index);
                         });

TEST(ObjectName, OfAnIndexWithoutTheMarkOfHexIsRefusedWithBothSpellings) {
  EXPECT_THAT(
      [] {
        (void)parse_object("6041");
      },
      ThrowsMessage<UsageError>(HasSubstr("'6041' is not an object (did you mean 0x6041 or "
                                          "6041h?): write 0x6041")));
}

TEST(Value, IsDecimalOrNegative) {
  EXPECT_EQ(parse_value("10000", DataType::integer32), 10000);
  EXPECT_EQ(parse_value("-10000", DataType::integer32), -10000);
  EXPECT_EQ(parse_value("1e6", DataType::integer32), 1'000'000);
  EXPECT_EQ(parse_value("1.5e3", DataType::unsigned16), 1'500);
}

TEST(Value, ThatIsAFractionIsRefusedWithTheTypeThatTakesNone) {
  EXPECT_THAT(
      [] {
        (void)parse_value("12.5", DataType::unsigned16);
      },
      ThrowsMessage<UsageError>("'12.5' is a fraction: the object is UNS16 and takes whole "
                                "numbers from 0 to 65535"));
}

TEST(Number, IsReadByTheSameGrammarWhateverItCounts) {
  EXPECT_EQ(parse_number("1e3", "count", 1'000), 1'000U);
  EXPECT_EQ(parse_number("0x10", "count", 1'000), 16U);
  for (const char* const text : {"2.5", "-1", "1001", "many"}) {
    EXPECT_THAT(
        [text] {
          (void)parse_number(text, "count", 1'000);
        },
        ThrowsMessage<UsageError>("'" + std::string(text) +
                                  "' is not a valid count: write a whole number from 0 to 1000"))
        << text;
  }
  EXPECT_EQ(parse_real("0x10", "rate"), 16.0);
  EXPECT_EQ(parse_real("1e-1", "rate"), 0.1);
}

TEST(Value, InHexIsTheTwosComplementOfItsType) {
  EXPECT_EQ(parse_value("0xFFFFD8F0", DataType::integer32), -10000);
  EXPECT_EQ(parse_value("0x2710", DataType::integer32), 10000);
  EXPECT_EQ(parse_value("0xFF", DataType::integer8), -1);
  EXPECT_EQ(parse_value("0xFFFF", DataType::integer16), -1);
  EXPECT_EQ(parse_value("0x7F", DataType::integer8), 127);
  EXPECT_EQ(parse_value("0xFFFFFFFF", DataType::unsigned32), 4294967295);
  EXPECT_EQ(parse_value("0xFFFF", DataType::unsigned16), 65535);
}

struct Row {
  const char* name;
  const char* text;
  DataType type;
};

class BadValue : public testing::TestWithParam<Row> {};

TEST_P(BadValue, IsAUsageErrorThatShowsTheText) {
  EXPECT_THAT(
      [] {
        (void)parse_value(GetParam().text, GetParam().type);
      },
      ThrowsMessage<UsageError>(HasSubstr(std::string("'") + GetParam().text + "'")));
}

INSTANTIATE_TEST_SUITE_P(
    Texts, BadValue,
    testing::Values(Row{"empty", "", DataType::integer32}, Row{"words", "ten", DataType::integer32},
                    Row{"half_a_number", "10x", DataType::integer32},
                    Row{"a_fraction", "1.5", DataType::integer32},
                    Row{"a_plus", "+1", DataType::integer32},
                    Row{"a_negative_hex", "-0x10", DataType::integer32},
                    Row{"no_hex_digit", "0x1G", DataType::integer32},
                    Row{"one_too_high", "2147483648", DataType::integer32},
                    Row{"one_too_low", "-2147483649", DataType::integer32},
                    Row{"nine_hex_digits", "0x100000000", DataType::integer32},
                    Row{"too_wide_for_a_byte", "0x1FF", DataType::integer8},
                    Row{"negative_unsigned", "-1", DataType::unsigned16},
                    Row{"far_too_high", "99999999999999999999999", DataType::unsigned32},
                    Row{"far_too_wide", "0x123456789ABCDEF012345", DataType::unsigned32}),
    [](const auto& row) {
      return row.param.name;
    });

TEST(Value, OutOfRangeIsRefusedWithItsLimits) {
  EXPECT_THAT(
      [] {
        (void)parse_value("300", DataType::integer8);
      },
      ThrowsMessage<UsageError>(HasSubstr("-128 to 127")));
}

TEST(Value, OfAnUnknownObjectIsAnyNumberOf32Bits) {
  EXPECT_EQ(parse_value("0xFFFFFFFF", parse_object("0x9999")), 4294967295);
  EXPECT_EQ(parse_value("-1", parse_object("no_such_object")), -1);
}

TEST(Duration, HasAUnitOrIsInSeconds) {
  EXPECT_EQ(parse_duration("20ms"), 20ms);
  EXPECT_EQ(parse_duration("2min"), 120s);
  EXPECT_EQ(parse_duration("5"), 5s);
}

TEST(Duration, OfAnotherTextIsRefusedWithTheRule) {
  for (const char* const text : {"", "soon", "-1s", "5d", "1000.5h"}) {
    EXPECT_THAT(
        [text] {
          (void)parse_duration(text);
        },
        ThrowsMessage<UsageError>("'" + std::string(text) +
                                  "' is not a duration: write for example 500us, 20ms, 1.5s or "
                                  "2min, at most 1000 hours; a number without a unit is in "
                                  "seconds"))
        << text;
  }
}

}  // namespace
}  // namespace vdrive::tool
