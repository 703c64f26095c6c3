// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "judge/findings.hpp"
#include "judge/record.hpp"

#include <cstdint>
#include <deque>
#include <optional>

namespace vdrive::judge {

/// Commands of the power state machine, resets, and stops before the power goes (CiA 402-2).
class PowerRules {
 public:
  /// Before the track of `context` has the write.
  void take(const Write& write, const Context& context);

  /// After the track of `context` has what was shown.
  void take(const Shown& shown, const Context& context);

  /// The cause of a fault has reached the master.
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
  std::optional<Time> reset_;       ///< edge of bit 7 in Fault; no status came since
  bool has_reset_ = false;          ///< an edge of bit 7 came in this fault
  std::optional<Time> kept_since_;  ///< bit 7 is up in Fault without an edge
  std::deque<Time> resets_;         ///< the last ones
  std::optional<Time> power_on_;    ///< a command that needs power stage or brake is under way
};

}  // namespace vdrive::judge
