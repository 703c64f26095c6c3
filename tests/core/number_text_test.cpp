// SPDX-License-Identifier: Apache-2.0
#include "vdrive/number_text.hpp"

#include "vdrive/clock_mode.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/dictionary/object_text.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>

namespace vdrive {
namespace {

using namespace std::chrono_literals;

TEST(ParseDigits, AcceptsOnlyTextThatIsAllDigits) {
  EXPECT_EQ(parse_digits<std::uint16_t>("65535"), 65'535);
  EXPECT_EQ(parse_digits<std::uint16_t>("65536"), std::nullopt);
  EXPECT_EQ(parse_digits<std::uint64_t>("FFFFFFFFFFFFFFFF", 16), ~std::uint64_t{0});
  EXPECT_EQ(parse_digits<std::int32_t>("-7"), -7);
  for (const char* const text : {"", " 1", "1 ", "+1", "0x1", "1.0", "x"}) {
    EXPECT_EQ(parse_digits<std::int32_t>(text), std::nullopt) << text;
  }
}

TEST(ParseInteger, ReadsDecimalAndHexadecimalNumbers) {
  EXPECT_EQ(parse_integer("-12"), -12);
  EXPECT_EQ(parse_integer("0x1F"), 31);
  EXPECT_EQ(parse_integer("0X1f"), 31);
  for (const char* const text : {"", "0x", "0x-1", "-0x1", "+1", " 1", "1 ", "1,5", "ten", "."}) {
    EXPECT_EQ(parse_integer(text), std::nullopt) << text;
    EXPECT_EQ(read_integer(text).kind, IntegerKind::no_number) << text;
  }
}

TEST(ParseInteger, ReadsAnExponentAndADecimalPointWhereTheNumberIsWhole) {
  EXPECT_EQ(parse_integer("1e6"), 1'000'000);
  EXPECT_EQ(parse_integer("-1.5E+3"), -1'500);
  EXPECT_EQ(parse_integer("2.0"), 2);
  EXPECT_EQ(parse_integer("120e-1"), 12);
  EXPECT_EQ(parse_integer("-0"), 0);
  EXPECT_EQ(parse_integer("0e999999999999999999999"), 0);
}

TEST(ParseInteger, IsExactUpToTheEndsOf64Bits) {
  EXPECT_EQ(parse_integer("9223372036854775807"), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(parse_integer("-9223372036854775808"), std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(parse_integer("9007199254740993e0"), 9'007'199'254'740'993);  // no double represents it
  EXPECT_EQ(parse_integer("0x7FFFFFFFFFFFFFFF"), std::numeric_limits<std::int64_t>::max());
  for (const char* const text :
       {"9223372036854775808", "-9223372036854775809", "1e19", "18446744073709551616",
        "1e999999999999999999999", "0x8000000000000000", "0x10000000000000000"}) {
    EXPECT_EQ(read_integer(text).kind, IntegerKind::too_large) << text;
  }
}

TEST(ReadInteger, TellsAFractionFromATextThatIsNoNumber) {
  for (const char* const text : {"12.5", "-0.5", ".5", "1e-3", "1e-999999999999999999999",
                                 "123456789012345678901234567890.5"}) {
    EXPECT_EQ(read_integer(text).kind, IntegerKind::fraction) << text;
  }
}

TEST(ParseNumber, RefusesInfinityAndNotANumber) {
  EXPECT_EQ(parse_number("1.5e2"), 150.0);
  for (const char* const text : {"", "nan", "inf", "-infinity", "1e999", "1.5 ", "+1", "1e", "."}) {
    EXPECT_EQ(parse_number(text), std::nullopt) << text;
  }
}

TEST(ParseNumber, ReadsWhateverIsAWholeNumber) {
  for (const char* const text : {"0x1F", "-12", "1e6", "2.0", "5.", "0"}) {
    const auto whole = parse_integer(text);
    ASSERT_TRUE(whole) << text;
    EXPECT_EQ(parse_number(text), static_cast<double>(*whole)) << text;
  }
}

TEST(DecimalLength, EndsWhereTheUnitBegins) {
  EXPECT_EQ(decimal_length("90deg"), 2U);
  EXPECT_EQ(decimal_length("-1.5e-2m"), 7U);
  EXPECT_EQ(decimal_length("5em"), 1U);  // an e without digits is no exponent
  EXPECT_EQ(decimal_length("5e+"), 1U);
  EXPECT_EQ(decimal_length(".5 rev"), 2U);
  for (const char* const text : {"", "deg", "-", ".", "-.", "+5", "e5"}) {
    EXPECT_EQ(decimal_length(text), 0U) << text;
  }
}

TEST(ParseDuration, ReadsANumberWithAUnit) {
  EXPECT_EQ(parse_duration("500us"), 500us);
  EXPECT_EQ(parse_duration("20ms"), 20ms);
  EXPECT_EQ(parse_duration("1.5 s"), 1500ms);
  EXPECT_EQ(parse_duration("1e3s"), 1000s);
  EXPECT_EQ(parse_duration(".5min"), 30s);
  EXPECT_EQ(parse_duration("1000h"), 1000h);
  EXPECT_EQ(parse_duration("0ms"), 0s);
}

TEST(ParseDuration, WithoutAUnitIsInSeconds) {
  EXPECT_EQ(parse_duration("5"), 5s);
  EXPECT_EQ(parse_duration("0.2"), 200ms);
}

TEST(ParseDuration, FinerThanANanosecondIsRoundedUp) {
  EXPECT_EQ(parse_duration("0.0000001ms"), 1ns);
  EXPECT_EQ(parse_duration("1e-999999s"), 1ns);
  EXPECT_EQ(parse_duration("0.1s"), 100ms);            // no double is 0.1
  EXPECT_EQ(parse_duration("0.00000000001h"), 36ns);   // 3600e9 ns * 1e-11
  EXPECT_EQ(parse_duration("0.000000000012h"), 44ns);  // 43.2 ns
}

TEST(ParseDuration, RefusesOtherTextsAndMoreThanItsLimit) {
  for (const char* const text :
       {"", "s", "-1s", "-0", "5 ", "5d", "5S", "1.2.3s", "0x5s", "nan", "1000.0000000000001h",
        "3600001", "1e999999999999999999h", "99999999999999999999s"}) {
    EXPECT_EQ(parse_duration(text), std::nullopt) << text;
  }
}

TEST(Hex, HasAtLeastTheGivenDigits) {
  EXPECT_EQ(hex(0x607D, 4), "0x607D");
  EXPECT_EQ(hex(0x37, 3), "0x037");
  EXPECT_EQ(hex(0, 8), "0x00000000");
  EXPECT_EQ(hex(0x12345, 4), "0x12345");
  EXPECT_EQ(session_text(0x0123456789ABCDEF), "0x0123456789abcdef");
  EXPECT_EQ(session_text(42), "0x000000000000002a");
}

TEST(AddressText, NamesTheSubindexUnlessItIsZero) {
  EXPECT_EQ(address_text({0x6081, 0}), "0x6081");
  EXPECT_EQ(address_text({0x607D, 1}), "0x607D:1");
}

TEST(ClockModes, HaveNamesThatCanBeParsed) {
  for (const ClockMode mode : kClockModes) EXPECT_EQ(clock_mode_named(to_string(mode)), mode);
  EXPECT_EQ(clock_mode_named("warp"), std::nullopt);
}

}  // namespace
}  // namespace vdrive
