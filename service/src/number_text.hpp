// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::service {

/// @return the whole number that `text` spells, decimal or 0x..., or nothing.
[[nodiscard]] std::optional<std::int64_t> parse_integer(std::string_view text);

/// @return the finite number that `text` spells, or nothing.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);

/// @return the shortest text that reads back to the same number.
[[nodiscard]] std::string to_text(double number);

}  // namespace vdrive::service
