// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "values/units.hpp"
#include "values/value.hpp"
#include "vdrive/cia402/operating_mode.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace vdrive::tool {

/// How the actual value must compare with the expected one.
enum class Comparison : std::uint8_t { equal, not_equal, less, at_most, more, at_least };

/// The expected value of an object of an axis.
struct Expectation {
  ObjectName object;
  Comparison comparison = Comparison::equal;
  std::int64_t value = 0;
  std::optional<Quantity> quantity;  ///< the value, if it was given with a unit
  Unit unit = user_unit();           ///< of the axis, for messages
  std::optional<std::uint64_t> mask;
  std::optional<std::uint64_t> tolerance;
  std::optional<Quantity> quantity_of_tolerance;
  std::optional<Duration> within;      ///< must become true within this drive time
  std::optional<Duration> throughout;  ///< must be true in every tick of this drive time

  /// @return whether `actual` meets the expectation.
  [[nodiscard]] bool accepts(std::int64_t actual) const noexcept;

  /// @return the same for Comparison::equal, under the mask or within the tolerance.
  [[nodiscard]] bool equals(std::int64_t actual) const noexcept;
};

/// @param values [COMPARISON] VALUE
/// @throws UsageError
[[nodiscard]] Expectation parse_expectation(const std::string& object,
                                            std::span<const std::string> values);

/// @return such as "0x1237 (4663) under mask 0x00001000", with the comparison unless it is "==".
[[nodiscard]] std::string expected_text(const Expectation& expectation);

/// @param mode of the axis (6061h): decides the names of bits 12 and 13 of the statusword
/// @return the meaning of a value of the statusword (6041h) or controlword (6040h): the power
///         state, and each bit that differs from the expected value, such as "Operation enabled,
///         bit 10 target reached is 0"; empty for other objects.
[[nodiscard]] std::string decoded_text(const Expectation& expectation, std::int64_t actual,
                                       OperatingMode mode);

/// @throws UsageError for an object that does not exist, and for a comparison that no value in the
///         range of the object fulfils.
void check_expectation(const Expectation& expectation);

/// @return such as "<=".
[[nodiscard]] std::string_view to_string(Comparison comparison) noexcept;

/// @return the comparison with this spelling, if any.
[[nodiscard]] std::optional<Comparison> comparison_named(std::string_view text) noexcept;

}  // namespace vdrive::tool
