// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "protocol.hpp"

#include <string_view>

namespace vdrive::gateway {

/// The JSON schema of an object.
/// @param members such as "name:string axes?:axis[]": each with a type of JSON schema or one of
///        `types`; [] is a list, ? stands behind the name of one that may be left out
/// @param types schemas by their names
[[nodiscard]] Json object_schema(std::string_view members, const Json& types = Json::object());

}  // namespace vdrive::gateway
