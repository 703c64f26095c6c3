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

/// One axis as a tick left it.
struct AxisSnapshot {
  AxisId id;
  std::uint64_t tick = 0;
  AxisStatus status;
  std::uint64_t owner_session = 0;  ///< 0 = free
  std::uint32_t owner_epoch = 0;
  std::uint64_t last_sequence = 0;  ///< last command frame of the owner that was applied
  /// Whether owner and last command are known: not where the objects of a paused bench were read.
  bool has_owner = true;

  /// Ticks that the number jumped over since the call or the follower that shows this began: they
  /// were not run. Drive time between two snapshots of it is that of driven_tick().
  std::uint64_t skipped = 0;

  /// @return `tick` without the ticks that were skipped: for durations.
  [[nodiscard]] std::uint64_t driven_tick() const noexcept { return tick - skipped; }

  /// @return the state that 6041h shows.
  [[nodiscard]] PowerState state() const noexcept {
    return decode_power_state(status.ds402_statusword);
  }

  /// @return 6061h.
  [[nodiscard]] OperatingMode mode() const noexcept {
    return static_cast<OperatingMode>(status.op_mode_actual);
  }

  /// @return whether its mode presses with a torque, also where the axis stands.
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
  std::uint64_t missed = 0;        ///< samples of the stream lost since the one before
  std::uint64_t skipped = 0;       ///< ticks since the one before that the number jumped over
  std::vector<AxisSnapshot> axes;  ///< in the order of the request
};

/// @return the object's value when the status image has it, else nothing.
[[nodiscard]] std::optional<std::int64_t> value_of(const AxisSnapshot& snapshot,
                                                   ObjectAddress object);

/// @return [s] how long the demand position (6062h) still needs to `target` [UU] at its present
/// speed
///         (606Bh), rounded up; nothing where it stands, is there or leads away from it.
[[nodiscard]] std::optional<std::int64_t> seconds_to(const AxisSnapshot& axis,
                                                     std::int32_t target) noexcept;

/// @return the names of the bits of 6041h that are 1, bits 0 to 3, 5 and 6 left out: those are the
///         state. Such as {"voltage enabled", "remote", "target reached"}. Bits 12 and 13 have the
///         names that `mode` (6061h) gives them.
[[nodiscard]] std::vector<std::string_view> statusword_flags(std::uint16_t statusword,
                                                             OperatingMode mode);

/// @return such as "0x1637 Operation enabled: remote, target reached, set-point acknowledge".
[[nodiscard]] std::string describe_statusword(std::uint16_t statusword, OperatingMode mode);

/// @return what an axis shows, for a message: such as "shows error 0x8611 following error,
///         0x218 Fault". For error 8130h it ends with what to change.
[[nodiscard]] std::string what_it_shows(const AxisSnapshot& axis);

}  // namespace vdrive::client
