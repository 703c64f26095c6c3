// SPDX-License-Identifier: Apache-2.0
#include "execution/axis_states.hpp"

#include <cstdint>

namespace vdrive::tool {

AxisStates states_of(client::Session& session, const std::vector<client::Axis>& axes) {
  std::map<std::uint32_t, std::vector<client::AxisId>> benches;
  for (const client::Axis& axis : axes) benches[axis.id().bench].push_back(axis.id());
  AxisStates shown;
  for (const auto& [bench, ids] : benches) {
    const auto seen = session.observe(ids);
    if (!seen && shown.outcome) shown.outcome = seen.outcome();
    if (!seen) continue;
    for (const client::AxisSnapshot& state : seen->axes) shown.states.emplace(state.id, state);
  }
  return shown;
}

std::optional<client::SessionName> owner_of(client::Session& session,
                                            const client::AxisSnapshot& axis) {
  if (axis.owner_session == 0) return std::nullopt;
  return session.find_name(axis.id.bench, axis.owner_session);
}

}  // namespace vdrive::tool
