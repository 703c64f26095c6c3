// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/client/outcome.hpp"

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace vdrive::client {

class Session;

/// One clock for several lock-step benches, shared with other programs that step them: time of a
/// bench advances to what the slowest of its steppers has granted.
///
/// While it lives, the session is a stepper of each bench, and what the session does on one of them
/// (Session::wait, Axis::move_to) passes time there too: by its own grants, as far as the other
/// steppers of that bench let it. A stepper that is silent for 10 s of wall time while others wait
/// for it, or whose program is gone, is taken off the clock by the service.
///
/// With a bench in this process (vdrive::bench) the thread that grants last runs the step. There a
/// thread joins a clock with one session only, and another one of its is refused: the step of each
/// would wait for ever for the grant of the other.
///
/// Steps that several threads ask for at once follow each other.
class StepClock {
 public:
  /// Wall time that a step may take.
  static constexpr std::chrono::milliseconds kPatience{10'000};

  static constexpr std::uint32_t kMostSteppers = 64;  ///< of a bench

  /// Joins the clock of each bench. Without `steppers`, and on a bench that is configured to wait
  /// for none, the first of several programs steps alone until the next one has joined: its first
  /// ticks differ from run to run.
  /// @param benches by number, each in lock-step; their periods may differ
  /// @param steppers 1 to kMostSteppers: the time of each bench stands until that many sessions,
  ///        including this one, have joined its clock, then passes even when some of them leave.
  ///        0 = as the bench is configured. Joining does not wait, the first step does.
  /// @return not_found or refused, naming the bench; then no clock was joined. Refused also where
  ///         this thread has joined the clock of a bench in this process with another session.
  static Result<StepClock> join(Session& session, std::span<const std::uint32_t> benches,
                                std::uint32_t steppers = 0);

  /// Leaves the clock of each bench.
  ~StepClock();
  StepClock(const StepClock&) = delete;
  StepClock& operator=(const StepClock&) = delete;
  StepClock(StepClock&&) noexcept;
  StepClock& operator=(StepClock&&) noexcept;

  /// Steps all benches at once, and waits for all of them.
  /// @param ticks of each bench; their periods have to be equal
  /// @return the tick that each bench has reached, in the order of `join`;
  ///         timed_out, naming the benches that have not got there and the session each waits for,
  ///         or that it waits for more steppers:
  ///         what was granted stays granted, and the same call again continues with it;
  ///         timed_out, with nothing granted, when another thread has stepped this clock since;
  ///         lost, naming the bench, when its service fell silent or was restarted: the new one is
  ///         never stepped, and the others no more, until its clock is joined anew;
  ///         failed when the periods differ, when the ticks take 2^63 ns and more, and after
  ///         Session::interrupt, which ends it as a time-out does.
  Result<std::vector<std::uint64_t>> step(std::uint64_t ticks,
                                          std::chrono::milliseconds patience = kPatience);

  /// The same by drive time.
  /// @param duration a multiple of the period of every bench, else failed
  Result<std::vector<std::uint64_t>> step_for(std::chrono::nanoseconds duration,
                                              std::chrono::milliseconds patience = kPatience);

  /// Drive time that this clock has let pass on all benches.
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept;

 private:
  struct State;
  explicit StepClock(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace vdrive::client
