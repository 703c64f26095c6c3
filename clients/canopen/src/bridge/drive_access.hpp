// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "node/node_host.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/outcome.hpp"
#include "vdrive/dictionary/abort_code.hpp"
#include "vdrive/dictionary/object.hpp"

#include <span>
#include <vector>

namespace vdrive::canopen {

/// The requests of a node as calls of its axis. Each waits for the answer of the bench, but not for
/// drive time to pass.

/// Reads or writes an object.
[[nodiscard]] DriveAnswer carry_out(client::Axis& axis, const DriveAccess& access);

/// Reads objects, all in the same tick if there are at most client::kMostObjectsAtOnce.
/// @return the values that the drive returned; none if the bench could not be reached
[[nodiscard]] std::vector<DriveValue> read_values(client::Axis& axis,
                                                  std::span<const ObjectAddress> objects);

/// The drive loses its master, or has it again: test-bench input 5E0Ah. The drive reacts to every
/// loss, whatever the previous value of the input.
client::Outcome tell_connection(client::Axis& axis, bool is_lost);

/// Switches the drive off and on again.
client::Outcome cycle_power(client::Axis& axis);

}  // namespace vdrive::canopen
