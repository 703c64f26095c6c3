// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <map>
#include <optional>
#include <vector>

namespace vdrive::tool {

/// The present status of axes.
struct AxisStates {
  std::map<client::AxisId, client::AxisSnapshot> states{};  ///< of the benches that answered
  client::Outcome outcome{};                                ///< first failure of a bench
};

/// Reads the status of all axes of each bench together.
[[nodiscard]] AxisStates states_of(client::Session& session, const std::vector<client::Axis>& axes);

/// @return the owner of the axis; waits for its name as Session::find_name() does.
[[nodiscard]] std::optional<client::SessionName> owner_of(client::Session& session,
                                                          const client::AxisSnapshot& axis);

}  // namespace vdrive::tool
