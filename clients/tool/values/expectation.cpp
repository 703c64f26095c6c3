// SPDX-License-Identifier: Apache-2.0
#include "values/expectation.hpp"

#include "base/usage_error.hpp"
#include "values/object_check.hpp"
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

/// Of an unequal value there is always another one; the other comparisons hold at an end of the
/// range, or nowhere.
bool is_possible(const Expectation& expectation, const ObjectDescription& object) {
  return expectation.comparison == Comparison::not_equal ||
         expectation.accepts(object.lower_limit) || expectation.accepts(object.upper_limit) ||
         (expectation.comparison == Comparison::equal && expectation.value >= object.lower_limit &&
          expectation.value <= object.upper_limit);
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
  std::string text = value_text(expectation.object, expectation.value);
  if (const auto& mask = expectation.mask) {
    text = value_text(expectation.object, expectation.value & static_cast<std::int64_t>(*mask)) +
           " under mask " + hex(static_cast<std::uint32_t>(*mask), 8);
  }
  if (expectation.tolerance) text += " +- " + std::to_string(*expectation.tolerance);
  if (expectation.comparison == Comparison::equal) return text;
  return std::string(to_string(expectation.comparison)) + " " + text;
}

void check_expectation(const Expectation& expectation) {
  const ObjectRow row = checked_row(expectation.object);
  // Under a mask, and with a tolerance, a value beyond the range may match all the same.
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
