// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "values/expectation.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/client/outcome.hpp"

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

namespace vdrive::tool {

/// Notices that an axis is in Fault (CiA 402, power state machine) and stands still: a wait for
/// anything but the fault and its reset cannot end well.
class FaultWatch {
 public:
  /// @param period of the bench [us]
  explicit FaultWatch(std::chrono::microseconds period);

  /// @param axis as it was observed next
  /// @return failed, with the fault and its tick, once the axis has been in Fault and at rest for
  ///         100 ms of drive time. @param awaited for the message
  [[nodiscard]] client::Outcome note(const client::AxisSnapshot& axis, std::string_view awaited);

 private:
  std::uint64_t patience_;              ///< [ticks]
  bool was_sound_ = false;              ///< it was observed before the fault
  std::uint64_t fault_tick_ = 0;        ///< in which it was first seen in Fault
  std::optional<std::uint64_t> since_;  ///< driven tick: from then on in Fault and at rest
};

/// @return whether a drive in Fault can show the condition (condition_names()) only after a reset
///         and more. Not so: what a reset leads to, and what follows the supply and the limits.
[[nodiscard]] bool is_out_of_reach_in_fault(std::string_view condition) noexcept;

/// @return the same of a value: a position, a speed, a torque or a current, and a statusword that
///         has no fault, is in Operation enabled, or has reached a target.
[[nodiscard]] bool is_out_of_reach_in_fault(const Expectation& expectation);

}  // namespace vdrive::tool
