// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/wakeup.hpp"
#include "calls/axes_call.hpp"

#include <chrono>
#include <cstdint>
#include <vector>

namespace vdrive::client {

/// A call that stops axes, also those of other sessions, also after an interrupt of the session: it
/// sends frames to the axes that this session owns and writes 6040h of the others, whose owners
/// keep them.
class AxesStop {
 public:
  AxesStop(SessionCore& core, AxesCall& call);

  /// Connects and observes the axes, as AxesCall::begin() does.
  Outcome begin(std::chrono::nanoseconds timeout);

  /// Takes control of the axes that are free: a halt needs it, a quick stop does not.
  Outcome acquire_free();

  /// Sends the round, which has one controlword for all its axes.
  Answers exchange(const Round& round, Timing timing);

  /// Sends the round and observes the tick in which it is in force.
  Outcome put_in_force(const Round& round);

  /// Quick stop of every axis without a fault, at once.
  /// @param until done = all are at rest
  Outcome quick_stop(Until until);

 private:
  Outcome acquire_free_of(BenchPart& part);
  [[nodiscard]] std::vector<Round> held_of(const Round& round) const;
  void stop_others(BenchPart& part, const Round& round, Answers& answers);

  SessionCore& core_;
  AxesCall& call_;
  Wakeup::StopInProgress in_progress_;
  std::vector<bool> held_;  ///< by place: this session owns the axis
};

}  // namespace vdrive::client
