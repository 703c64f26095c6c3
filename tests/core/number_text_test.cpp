// SPDX-License-Identifier: Apache-2.0
#include "vdrive/number_text.hpp"

#include "vdrive/clock_mode.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>

namespace vdrive {
namespace {

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
  for (const char* const text : {"", "0x", "0x-1", "1e3", "9223372036854775808"}) {
    EXPECT_EQ(parse_integer(text), std::nullopt) << text;
  }
}

TEST(ParseNumber, RefusesInfinityAndNotANumber) {
  EXPECT_EQ(parse_number("1.5e2"), 150.0);
  for (const char* const text : {"", "nan", "inf", "1e999", "1.5 "}) {
    EXPECT_EQ(parse_number(text), std::nullopt) << text;
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
