// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "execution/command_context.hpp"
#include "values/value.hpp"
#include "vdrive/client/axis.hpp"

#include <cstdint>

namespace vdrive::tool {

/// Writes an object, and prints nothing.
/// @return the tick from which on the value is in force.
client::Result<std::uint64_t> write_unprinted(CommandContext& context, client::Axis& axis,
                                              const ObjectName& object, std::int64_t value);

/// Writes an object, and prints the value and the tick from which on it is in force.
client::Outcome write_object(CommandContext& context, client::Axis& axis, const ObjectName& object,
                             std::int64_t value);

}  // namespace vdrive::tool
