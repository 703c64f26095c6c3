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

/// One clock for several lock-step benches, shared with other programs that step them: the time of
/// a bench advances to the tick that the slowest of its steppers has granted.
///
/// While this object lives, the session is a stepper of each bench, and its calls on one of them
/// (Session::wait, Axis::move_to) also advance time: by their own grants, as far as the other
/// steppers of that bench allow. The service removes a stepper from the clock if it is silent for
/// 10 s of wall time while others wait for it, or if its program is gone.
///
/// With a bench in this process (vdrive::bench), the thread that grants last runs the step. There,
/// a thread can join a clock with one session only, and a second session is refused: each would
/// wait for ever for the grant of the other.
///
/// If several threads step at the same time, the steps run one after the other.
class StepClock {
 public:
  /// Wall time that a step may take.
  static constexpr std::chrono::milliseconds kPatience{10'000};

  static constexpr std::uint32_t kMostSteppers = 64;  ///< of a bench

  /// Joins the clock of each bench. Without `steppers`, on a bench that is not configured to wait
  /// for steppers, the first of several programs steps alone until the next one has joined: the
  /// number of ticks that it steps alone differs from run to run.
  /// @param benches by number, each in lock-step; their periods may differ
  /// @param steppers 1 to kMostSteppers: the time of each bench stands still until that many
  ///        sessions, including this one, have joined its clock; after that it passes even if some
  ///        of them leave. 0 = as the bench is configured. Joining does not wait, the first step
  ///        does.
  /// @return not_found or refused, naming the bench; then no clock was joined. Also refused if this
  ///         thread has joined the clock of a bench in this process with another session.
  static Result<StepClock> join(Session& session, std::span<const std::uint32_t> benches,
                                std::uint32_t steppers = 0);

  /// Leaves the clock of each bench.
  ~StepClock();
  StepClock(const StepClock&) = delete;
  StepClock& operator=(const StepClock&) = delete;
  StepClock(StepClock&&) noexcept;
  StepClock& operator=(StepClock&&) noexcept;

  /// Steps all benches together and waits for all of them.
  /// @param ticks of each bench; their periods must be equal
  /// @return the tick that each bench has reached, in the order of `join`;
  ///         timed_out, naming the benches that have not reached it and what each waits for (a
  ///         session, or more steppers): granted ticks stay granted, and the same call, made again,
  ///         continues with them;
  ///         timed_out, with nothing granted, if another thread is still stepping this clock;
  ///         lost, naming the bench, if its service fell silent or was restarted: the new run is
  ///         never stepped, and the other benches only after their clock is joined again;
  ///         failed if the periods differ, if the ticks take 2^63 ns or more, and after
  ///         Session::interrupt, which ends the call as a time-out does.
  Result<std::vector<std::uint64_t>> step(std::uint64_t ticks,
                                          std::chrono::milliseconds patience = kPatience);

  /// As step(), by drive time.
  /// @param duration a multiple of the period of every bench, otherwise failed
  Result<std::vector<std::uint64_t>> step_for(std::chrono::nanoseconds duration,
                                              std::chrono::milliseconds patience = kPatience);

  /// Drive time that has passed on all benches under this clock.
  [[nodiscard]] std::chrono::nanoseconds now() const noexcept;

 private:
  struct State;
  explicit StepClock(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace vdrive::client
