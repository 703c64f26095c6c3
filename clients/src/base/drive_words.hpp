// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/cia402/controlword.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/dictionary/object.hpp"
#include "vdrive_messages.hpp"

#include <cstdint>

namespace vdrive::client {

using controlwords::kDisableVoltage;
using controlwords::kEnableOperation;
using controlwords::kQuickStop;
using controlwords::kShutdown;
inline constexpr std::uint16_t kHalt = kEnableOperation | Controlword::kHalt;

/// Enable operation with bits 4 to 6 set, which cyclic synchronous position does not define: a
/// drive with the habit 5E20h:02 follows positions only while they are 1.
inline constexpr std::uint16_t kReleaseStream = kEnableOperation | Controlword::kNewSetPoint |
                                                Controlword::kChangeSetImmediately |
                                                Controlword::kRelative;

/// The lowest value of 605Ah with which an axis stays in Quick stop active.
inline constexpr std::int64_t kFirstQuickStopThatStays = 5;

/// Adds a further object to a command (up to msg::MAX_OBJECTS_PER_AXIS). The bench writes it after
/// the members of the command and before its controlword.
inline void add_object(msg::AxisCommand& command, ObjectAddress address, std::int64_t value) {
  auto& object = command.objects.emplace_back();
  object.index = address.index;
  object.subindex = address.subindex;
  object.value = value;
}

/// Adds the controlword of a command, or replaces it.
inline void add_word(msg::AxisCommand& command, std::uint16_t word) {
  command.members = static_cast<std::uint16_t>(command.members | msg::HAS_DS402_CONTROLWORD);
  command.ds402_controlword = word;
}

[[nodiscard]] inline bool is_enabled(const AxisSnapshot& axis) {
  return axis.state() == PowerState::operation_enabled;
}

[[nodiscard]] inline bool has_no_fault(const AxisSnapshot& axis) {
  return !is_fault(axis.state());
}

[[nodiscard]] inline bool every_axis(const AxisSnapshot& /*axis*/) {
  return true;
}

[[nodiscard]] inline bool target_reached(const AxisSnapshot& axis) {
  return axis.shows(Statusword::kTargetReached);
}

/// @return whether bit 10 reports a target. It does not in the cyclic modes, where the master plans
///         the path, nor without a mode (6060h = 0), where the axis stands still.
[[nodiscard]] inline bool has_target_bit(const AxisSnapshot& axis) {
  const OperatingModeRow* const row = find_operating_mode(axis.mode());
  return row == nullptr || row->has_target;
}

/// @return whether an axis that continues after a halt has nothing left to reach: it is at its
///         target or has none.
[[nodiscard]] inline bool has_no_way_left(const AxisSnapshot& axis) {
  return !has_target_bit(axis) || target_reached(axis);
}

/// @return whether an axis that was halted in Operation enabled stands still.
[[nodiscard]] inline bool stands_still(const AxisSnapshot& axis) {
  return has_target_bit(axis) ? target_reached(axis) : axis.status.velocity_demand_value == 0;
}

/// @return whether the drive moves the axis or holds it.
[[nodiscard]] inline bool is_driven(const AxisSnapshot& axis) {
  const PowerState state = axis.state();
  return state == PowerState::operation_enabled || state == PowerState::quick_stop_active ||
         state == PowerState::fault_reaction_active;
}

/// @return whether nothing moves the axis: it is not driven, or its demand is at rest with no
///         target left to reach. An applied torque counts as motion.
[[nodiscard]] inline bool rests(const AxisSnapshot& axis) {
  if (!is_driven(axis)) return true;
  if (axis.status.velocity_demand_value != 0 || axis.has_torque()) return false;
  return !has_target_bit(axis) || target_reached(axis);
}

/// @return whether a quick stop has ended: in another state, or at rest if 605Ah keeps the state.
[[nodiscard]] inline bool quick_stop_ended(const AxisSnapshot& axis, std::int64_t option) {
  return axis.state() != PowerState::quick_stop_active ||
         (option >= kFirstQuickStopThatStays && target_reached(axis));
}

}  // namespace vdrive::client
