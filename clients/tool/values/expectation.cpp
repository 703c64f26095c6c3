// SPDX-License-Identifier: Apache-2.0
#include "values/expectation.hpp"

#include "base/usage_error.hpp"
#include "vdrive/cia402/bit_names.hpp"
#include "vdrive/cia402/power_state_machine.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/dictionary/dictionary.hpp"
#include "vdrive/number_text.hpp"
#include "vdrive/text.hpp"

#include <algorithm>
#include <array>

namespace vdrive::tool {
namespace {

struct ComparisonRow {
  Comparison comparison;
  std::string_view text;
};

constexpr std::array kComparisons{
    ComparisonRow{Comparison::equal, "=="}, ComparisonRow{Comparison::not_equal, "!="},
    ComparisonRow{Comparison::less, "<"},   ComparisonRow{Comparison::at_most, "<="},
    ComparisonRow{Comparison::more, ">"},   ComparisonRow{Comparison::at_least, ">="},
};

std::uint64_t distance(std::int64_t a, std::int64_t b) {
  return a > b ? static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b)
               : static_cast<std::uint64_t>(b) - static_cast<std::uint64_t>(a);
}

/// `not_equal` is always possible, and `equal` within the range. Any other comparison that some
/// value fulfils is also fulfilled by an end of the range.
bool is_possible(const Expectation& expectation, const ObjectDescription& object) {
  return expectation.comparison == Comparison::not_equal ||
         expectation.accepts(object.lower_limit) || expectation.accepts(object.upper_limit) ||
         (expectation.comparison == Comparison::equal && expectation.value >= object.lower_limit &&
          expectation.value <= object.upper_limit);
}

constexpr std::uint16_t kIndexOfControlword = 0x6040;
constexpr std::uint16_t kIndexOfStatusword = 0x6041;
constexpr unsigned kBitsOfWord = 16;

/// A statusword or a controlword whose bits have names.
struct ShownWord {
  bool is_statusword;
  std::uint16_t value;
  OperatingMode mode;
};

std::string_view bit_name(const ShownWord& word, std::uint16_t bit) {
  if (!word.is_statusword) return controlword_bit_name(bit, word.mode);
  // Outside Operation enabled, bit 13 means following error, whatever the mode uses it for.
  const bool is_of_fault = bit == Statusword::kFollowingError &&
                           decode_power_state(word.value) != PowerState::operation_enabled;
  return statusword_bit_name(bit, is_of_fault ? OperatingMode::none : word.mode);
}

/// @return such as "bit 10 target reached is 0".
std::string bit_text(const ShownWord& word, unsigned number) {
  const auto bit = static_cast<std::uint16_t>(1U << number);
  const std::string_view name = bit_name(word, bit);
  std::string text = "bit " + std::to_string(number);
  if (!name.empty() && name != text) text.append(" ").append(name);
  return text + ((word.value & bit) != 0 ? " is 1" : " is 0");
}

}  // namespace

bool Expectation::equals(std::int64_t actual) const noexcept {
  if (mask) {
    return (static_cast<std::uint64_t>(actual) & *mask) ==
           (static_cast<std::uint64_t>(value) & *mask);
  }
  if (tolerance) return distance(actual, value) <= *tolerance;
  return actual == value;
}

bool Expectation::accepts(std::int64_t actual) const noexcept {
  switch (comparison) {
    case Comparison::equal:
      return equals(actual);
    case Comparison::not_equal:
      return !equals(actual);
    case Comparison::less:
      return actual < value;
    case Comparison::at_most:
      return actual <= value;
    case Comparison::more:
      return actual > value;
    case Comparison::at_least:
      return actual >= value;
  }
  return false;
}

Expectation parse_expectation(const std::string& object, std::span<const std::string> values) {
  Expectation expectation;
  expectation.object = parse_object(object);
  if (values.size() > 2) {
    throw UsageError(in_quotes(values[2]) + " is one argument too many: write OBJECT [==] VALUE");
  }
  if (values.size() == 2) {
    const auto comparison = comparison_named(values.front());
    if (!comparison) {
      throw UsageError(in_quotes(values.front()) +
                       " is not a comparison: write ==, !=, <, <=, > or >=");
    }
    expectation.comparison = *comparison;
  }
  expectation.quantity = parse_quantity(values.back(), expectation.object);
  if (!expectation.quantity) {
    expectation.value = parse_value(values.back(), expectation.object);
  }
  return expectation;
}

std::string expected_text(const Expectation& expectation) {
  const auto shown = [&expectation](std::int64_t value) {
    return value_text(expectation.object, value, expectation.unit);
  };
  std::string text = shown(expectation.value);
  if (const auto& mask = expectation.mask) {
    text = shown(expectation.value & static_cast<std::int64_t>(*mask)) + " under mask " +
           hex(static_cast<std::uint32_t>(*mask), 8);
  }
  if (expectation.tolerance) {
    text += " +- " + shown(static_cast<std::int64_t>(*expectation.tolerance));
  }
  if (expectation.comparison == Comparison::equal) return text;
  return std::string(to_string(expectation.comparison)) + " " + text;
}

std::string decoded_text(const Expectation& expectation, std::int64_t actual, OperatingMode mode) {
  const auto index = expectation.object.address ? expectation.object.address->index : 0;
  const ShownWord word{.is_statusword = index == kIndexOfStatusword,
                       .value = static_cast<std::uint16_t>(actual),
                       .mode = mode};
  if (!word.is_statusword && index != kIndexOfControlword) return {};
  std::string text;
  if (word.is_statusword) text = to_string(decode_power_state(word.value));
  if (expectation.comparison != Comparison::equal || expectation.tolerance) return text;
  const std::uint64_t differing =
      (static_cast<std::uint64_t>(actual) ^ static_cast<std::uint64_t>(expectation.value)) &
      expectation.mask.value_or(~std::uint64_t{0});
  for (unsigned number = 0; number < kBitsOfWord; ++number) {
    if (((differing >> number) & 1U) == 0) continue;
    text.append(text.empty() ? "" : ", ").append(bit_text(word, number));
  }
  return text;
}

void check_expectation(const Expectation& expectation) {
  const ObjectRow row = checked_row(expectation.object);
  // Under a mask, or with a tolerance, a value out of range may still match.
  if (expectation.mask || expectation.tolerance || expectation.quantity) return;
  if (is_possible(expectation, describe(row))) return;
  const std::string sign = expectation.comparison == Comparison::equal
                               ? ""
                               : std::string(to_string(expectation.comparison)) + " ";
  throw UsageError(sign + std::to_string(expectation.value) +
                   " is never reached: " + range_text(row));
}

std::string_view to_string(Comparison comparison) noexcept {
  const auto* const row = std::ranges::find(kComparisons, comparison, &ComparisonRow::comparison);
  return row == kComparisons.end() ? "unknown" : row->text;
}

std::optional<Comparison> comparison_named(std::string_view text) noexcept {
  const auto* const row = std::ranges::find(kComparisons, text, &ComparisonRow::text);
  return row == kComparisons.end() ? std::nullopt : std::optional(row->comparison);
}

}  // namespace vdrive::tool
