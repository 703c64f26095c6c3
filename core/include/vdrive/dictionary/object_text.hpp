// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive {

/// Objects as text: how messages name them, and how people and files spell them.

/// @return an index as the standard writes it, such as "6081h".
[[nodiscard]] std::string index_text(std::uint16_t index);

/// @return name and address of an object, such as "profile_velocity (6081h)" or
///         "user_position_upper_limit (607Dh:2)"; "object (5FFFh)" where the dictionary has none.
[[nodiscard]] std::string object_text(ObjectAddress object);

/// An address as a text spells it.
struct SpelledAddress {
  std::uint16_t index = 0;
  std::optional<std::uint8_t> subindex{};  ///< nothing where the text has none

  /// @return the address; without a sub-index that of sub-index 0.
  [[nodiscard]] ObjectAddress address() const noexcept {
    return {.index = index, .subindex = subindex.value_or(0)};
  }
};

/// Every program, file and protocol of vdrive reads addresses by this grammar:
///
///     address   = index [":" sub-index]
///     index     = "0x" 1*hex-digit | 4 hex-digits "h"     such as 0x6081 or 6081h, up to FFFFh
///     sub-index = 1*decimal-digit | "0x" 1*hex-digit      such as 1, 01 or 0x01, up to 255
///
/// Small and capital letters are equal. It contains what `address_text` and `index_text` write.
/// @return the address, whether there is such an object or not; nothing for any other text.
[[nodiscard]] std::optional<SpelledAddress> parse_address(std::string_view text) noexcept;

/// @return " (did you mean 0x6041 or 6041h?)" for an existing index that is written without the
/// mark
///         of hex, such as 6041 or 607D:1; nothing for any other text.
[[nodiscard]] std::string address_suggestion(std::string_view text);

/// @param text an address by the grammar above, a variable_name, or the standard's name
/// @return the address of that object; nothing for a name that no object has. An address that has
///         no object is returned, too: the drive refuses it.
[[nodiscard]] std::optional<ObjectAddress> parse_object(std::string_view text) noexcept;

/// @return every name that `parse_object` knows: each variable_name, then the standard's.
[[nodiscard]] std::vector<std::string> names_of_objects();

/// What a refusal of an object leaves open.
/// @return such as "607Dh has the sub-indices 1 and 2" for AbortCode::subindex_does_not_exist and
///         "positioning_option_code takes 0, 1 or 2" for a value that the object does not take;
///         empty for every other code.
[[nodiscard]] std::string advice_on(ObjectAddress object, AbortCode code);

}  // namespace vdrive
