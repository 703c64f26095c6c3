// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/findings.hpp"
#include "judge/record.hpp"

#include <cstdint>
#include <deque>
#include <optional>

namespace vdrive::judge {

/// Commands of the power state machine, resets, and stops before power is removed (CiA 402-2).
class PowerRules {
 public:
  /// To be called before the track of `context` is updated with the write.
  void take(const Write& write, const Context& context);

  /// To be called after the track of `context` was updated.
  void take(const Shown& shown, const Context& context);

  /// Records that the master has learned the cause of a fault.
  void note_cause() noexcept { is_cause_known_ = true; }

  void forget();

 private:
  void command(PowerCommand command, const Context& context);
  void command_without_transition(PowerCommand command, const Context& context) const;
  void reset(const Context& context);
  void keep_reset_bit(const Write& write, const Context& context);
  static void remove_power(PowerCommand command, const Context& context);
  void give_up(PowerCommand command, const Context& context);

  bool is_cause_known_ = false;
  std::optional<Time> reset_;       ///< edge of bit 7 in Fault; no status has arrived since
  bool has_reset_ = false;          ///< there was an edge of bit 7 in this fault
  std::optional<Time> kept_since_;  ///< bit 7 is set in Fault without an edge
  std::deque<Time> resets_;         ///< the last ones
  std::optional<Time> power_on_;    ///< a command that needs power stage or brake is in progress
};

}  // namespace vdrive::judge
