// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "values/expectation.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/session.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vdrive::tool {

/// Notices that an axis is in Fault (CiA 402, power state machine) and stands still: a wait for
/// anything but the fault and its reset cannot end well.
class FaultWatch {
 public:
  /// @param period of the bench [us]
  explicit FaultWatch(std::chrono::microseconds period);

  /// @param axis as it was observed next
  void note(const client::AxisSnapshot& axis);

  /// @return whether the axis has been in Fault and at rest for 100 ms of drive time.
  [[nodiscard]] bool is_over() const noexcept { return is_over_; }

  /// @return the tick in which the axis was first observed with its fault, 0 without one.
  [[nodiscard]] std::uint64_t first_tick() const noexcept { return fault_tick_; }

  /// @return whether the axis was observed before its fault: then first_tick() is that of the
  ///         fault.
  [[nodiscard]] bool saw_begin() const noexcept { return was_sound_; }

 private:
  std::uint64_t patience_;              ///< [ticks]
  bool was_sound_ = false;              ///< it was observed before the fault
  bool is_over_ = false;                ///< nothing more comes without a reset
  std::uint64_t fault_tick_ = 0;        ///< in which it was first seen with a fault
  std::optional<std::uint64_t> since_;  ///< driven tick: from then on in Fault and at rest
};

/// Of a fault that is older than the watch the tick comes from the events that the bench keeps:
/// kept_events() takes half a second, and replaces the observer of Session::on_event.
/// @param axis with a fault, as `watch` has observed it last
/// @return such as "axis 1.1 is in Fault 0x8611 following error, since tick 1204".
[[nodiscard]] std::string fault_text(client::Session& session, const client::AxisSnapshot& axis,
                                     const FaultWatch& watch);

/// @return whether a drive in Fault can show the condition (condition_names()) only after a reset
///         and more. Not so: what a reset leads to, and what follows the supply and the limits.
[[nodiscard]] bool is_out_of_reach_in_fault(std::string_view condition) noexcept;

/// @return the same of a value: a position, a speed, a torque or a current, the mode that is in
///         force (6061h), and a statusword that has no fault, is in Operation enabled, has reached
///         a target, or has what the mode says in bit 12. Not so: what another program may write
///         meanwhile, such as 6081h, and what a reset, the supply or an input brings.
[[nodiscard]] bool is_out_of_reach_in_fault(const Expectation& expectation);

}  // namespace vdrive::tool
