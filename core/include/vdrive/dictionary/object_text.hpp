// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <string>

namespace vdrive {

/// How messages name objects.

/// @return an index as the standard writes it, such as "6081h".
[[nodiscard]] std::string index_text(std::uint16_t index);

/// @return name and address of an object, such as "profile_velocity (6081h)" or
///         "user_position_upper_limit (607Dh:2)"; "object (5FFFh)" where the dictionary has none.
[[nodiscard]] std::string object_text(ObjectAddress object);

}  // namespace vdrive
