// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <map>
#include <optional>
#include <vector>

namespace vdrive::tool {

/// What axes show now.
struct AxisStates {
  std::map<client::AxisId, client::AxisSnapshot> states{};  ///< of the benches that answer
  client::Outcome outcome{};                                ///< the first failure of a bench
};

/// Looks at each bench once, for all of its axes.
[[nodiscard]] AxisStates states_of(client::Session& session, const std::vector<client::Axis>& axes);

/// @return who holds the axis, waiting for the name as Session::find_name() does.
[[nodiscard]] std::optional<client::SessionName> owner_of(client::Session& session,
                                                          const client::AxisSnapshot& axis);

}  // namespace vdrive::tool
