// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_status.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/cia402/power_state.hpp"
#include "vdrive/client/bench.hpp"
#include "vdrive/dictionary/object.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdrive::client {

/// The state of one axis after a tick.
struct AxisSnapshot {
  AxisId id;
  std::uint64_t tick = 0;
  AxisStatus status;
  std::uint64_t owner_session = 0;  ///< 0 = free
  std::uint32_t owner_epoch = 0;
  std::uint64_t last_sequence = 0;  ///< the owner's last command frame that was applied
  /// Whether owner and last command are known. They are not known in the samples of a black-box
  /// window, nor if the bench was paused and the state was read from objects.
  bool has_owner = true;

  /// Ticks that were not run because the tick number jumped over them, since the start of the call
  /// or follower that returned this snapshot. For the drive time between two snapshots of the same
  /// call or follower, use driven_tick().
  std::uint64_t skipped = 0;

  /// @return `tick` minus the skipped ticks: for durations.
  [[nodiscard]] std::uint64_t driven_tick() const noexcept { return tick - skipped; }

  /// @return the state in 6041h.
  [[nodiscard]] PowerState state() const noexcept {
    return decode_power_state(status.ds402_statusword);
  }

  /// @return 6061h.
  [[nodiscard]] OperatingMode mode() const noexcept {
    return static_cast<OperatingMode>(status.op_mode_actual);
  }

  /// @return whether the drive applies a torque that its mode commands, even at standstill.
  [[nodiscard]] bool has_torque() const noexcept {
    const OperatingModeRow* const row = find_operating_mode(mode());
    return row != nullptr && row->commands_torque && state() == PowerState::operation_enabled &&
           status.torque_demand != 0;
  }

  /// @return whether all of `bits` are 1 in 6041h.
  [[nodiscard]] bool shows(std::uint16_t bits) const noexcept {
    return (status.ds402_statusword & bits) == bits;
  }
};

/// All watched axes after the same tick.
struct Observation {
  std::uint64_t tick = 0;
  std::uint64_t missed = 0;   ///< samples of the stream lost since the previous one
  std::uint64_t skipped = 0;  ///< ticks that the tick number jumped over since the previous one
  std::vector<AxisSnapshot> axes;  ///< in the order of the request
};

/// @return the object's value if the status image contains it, otherwise nothing.
[[nodiscard]] std::optional<std::int64_t> value_of(const AxisSnapshot& snapshot,
                                                   ObjectAddress object);

/// @return the time [s] that the demand position (6062h) still needs to reach `target` [UU] at its
///         present speed (606Bh), rounded up; nothing if it stands still, has arrived or is moving
///         away.
[[nodiscard]] std::optional<std::int64_t> seconds_to(const AxisSnapshot& axis,
                                                     std::int32_t target) noexcept;

/// @return the names of the bits of 6041h that are 1, such as {"voltage enabled", "remote", "target
///         reached"}, without bits 0 to 3, 5 and 6, which encode the state. The names of bits 12
///         and 13 depend on `mode` (6061h).
[[nodiscard]] std::vector<std::string_view> statusword_flags(std::uint16_t statusword,
                                                             OperatingMode mode);

/// @return a text such as "0x1637 Operation enabled: remote, target reached".
[[nodiscard]] std::string describe_statusword(std::uint16_t statusword, OperatingMode mode);

/// @return the condition of an axis for a message, such as "shows error 0x8611 following error,
///         0x218 Fault". For error 8130h it ends with the setting to change.
[[nodiscard]] std::string what_it_shows(const AxisSnapshot& axis);

}  // namespace vdrive::client
