// SPDX-License-Identifier: Apache-2.0
#include "language/command.hpp"

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

}  // namespace

bool ExpectCommand::equals(std::int64_t actual) const noexcept {
  if (mask) {
    return (static_cast<std::uint64_t>(actual) & *mask) ==
           (static_cast<std::uint64_t>(value) & *mask);
  }
  if (tolerance) return distance(actual, value) <= *tolerance;
  return actual == value;
}

bool ExpectCommand::accepts(std::int64_t actual) const noexcept {
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

std::string_view to_string(Comparison comparison) noexcept {
  const auto* const row = std::ranges::find(kComparisons, comparison, &ComparisonRow::comparison);
  return row == kComparisons.end() ? "unknown" : row->text;
}

std::optional<Comparison> comparison_named(std::string_view text) noexcept {
  const auto* const row = std::ranges::find(kComparisons, text, &ComparisonRow::text);
  return row == kComparisons.end() ? std::nullopt : std::optional(row->comparison);
}

std::vector<std::string> axes_of(const Command& command) {
  return std::visit(
      [](const auto& word) -> std::vector<std::string> {
        if constexpr (requires { word.axes; }) {
          return word.axes;
        } else if constexpr (requires { word.axis; }) {
          return {word.axis};
        } else if constexpr (requires { word->command; }) {
          return axes_of(word->command);
        } else {
          return {};
        }
      },
      command);
}

std::optional<std::uint32_t> bench_of(const Command& command) {
  return std::visit(
      [](const auto& word) -> std::optional<std::uint32_t> {
        if constexpr (requires { word.bench; }) {
          return word.bench;
        } else if constexpr (requires { word->command; }) {
          return bench_of(word->command);
        } else {
          return std::nullopt;
        }
      },
      command);
}

std::string_view to_string(AxisAction action) noexcept {
  switch (action) {
    case AxisAction::enable:
      return "enable";
    case AxisAction::disable:
      return "disable";
    case AxisAction::halt:
      return "halt";
    case AxisAction::resume:
      return "resume";
    case AxisAction::quick_stop:
      return "quick-stop";
    case AxisAction::reset:
      return "reset";
    case AxisAction::power_cycle:
      return "power-cycle";
    case AxisAction::store:
      return "store";
    case AxisAction::restore:
      return "restore";
  }
  return "unknown";
}

std::string_view to_string(SnapshotCommand::Action action) noexcept {
  switch (action) {
    case SnapshotCommand::Action::take:
      return "take";
    case SnapshotCommand::Action::restore:
      return "restore";
    case SnapshotCommand::Action::drop:
      return "drop";
    case SnapshotCommand::Action::list:
      return "list";
  }
  return "unknown";
}

}  // namespace vdrive::tool
