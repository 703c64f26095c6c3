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

/// What a node asks of its drive, as calls of the axis. Each waits for the answer of the bench, and
/// for no drive time.

/// Reads or writes an object.
[[nodiscard]] DriveAnswer carry_out(client::Axis& axis, const DriveAccess& access);

/// Reads objects, all of one tick where they are no more than client::kMostObjectsAtOnce.
/// @return the values of those that the drive gave; none when the bench could not be asked
[[nodiscard]] std::vector<DriveValue> read_values(client::Axis& axis,
                                                  std::span<const ObjectAddress> objects);

/// The drive loses its master, or has it again: test-bench input 5E0Ah. It reacts to each loss,
/// whatever the input was before.
client::Outcome tell_connection(client::Axis& axis, bool is_lost);

/// Switches the drive off and on again.
client::Outcome cycle_power(client::Axis& axis);

}  // namespace vdrive::canopen
