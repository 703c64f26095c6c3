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

/// Objects as text: how messages name them and how people and files spell them.

/// @return an index as the standard writes it, such as "6081h".
[[nodiscard]] std::string index_text(std::uint16_t index);

/// @return name and address of an object, such as "profile_velocity (6081h)" or
///         "user_position_upper_limit (607Dh:2)"; "object (5FFFh)" for one that does not exist.
[[nodiscard]] std::string object_text(ObjectAddress object);

/// An address as spelled in a text.
struct SpelledAddress {
  std::uint16_t index = 0;
  std::optional<std::uint8_t> subindex{};  ///< nothing if the text has none

  /// @return the address, with sub-index 0 if the text has none.
  [[nodiscard]] ObjectAddress address() const noexcept {
    return {.index = index, .subindex = subindex.value_or(0)};
  }
};

/// The grammar of an address in every program, file and protocol of vdrive:
///
///     address   = index [":" sub-index]
///     index     = "0x" 1*hex-digit | 4 hex-digits "h"     such as 0x6081 or 6081h, up to FFFFh
///     sub-index = 1*decimal-digit | "0x" 1*hex-digit      such as 1, 01 or 0x01, up to 255
///
/// Case does not matter. The output of `address_text` and `index_text` is valid input.
/// @return the address, whether or not such an object exists; nothing for any other text.
[[nodiscard]] std::optional<SpelledAddress> parse_address(std::string_view text) noexcept;

/// @return " (did you mean 0x6041 or 6041h?)" for an existing index written without a hex mark,
///         such as 6041 or 607D:1; nothing for any other text.
[[nodiscard]] std::string address_suggestion(std::string_view text);

/// @param text an address in the grammar above, a variable_name, or the standard's name
/// @return the address of that object; nothing for an unknown name. An address without an object is
///         returned as well: the drive refuses it.
[[nodiscard]] std::optional<ObjectAddress> parse_object(std::string_view text) noexcept;

/// @return every name that `parse_object` knows: all variable_names, then the standard's names.
[[nodiscard]] std::vector<std::string> names_of_objects();

/// Explains a refusal beyond its abort code.
/// @return for example "607Dh has sub-indices 1 and 2" for AbortCode::subindex_does_not_exist and
///         "positioning_option_code accepts 0, 1 or 2" for a value that the object does not accept;
///         empty for every other code.
[[nodiscard]] std::string advice_on(ObjectAddress object, AbortCode code);

}  // namespace vdrive
