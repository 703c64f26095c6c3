// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/wakeup.hpp"
#include "exchange/exchange.hpp"
#include "exchange/held_axes.hpp"
#include "presence/discovery.hpp"
#include "presence/target.hpp"
#include "vdrive/client/axis_snapshot.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive_messages.hpp"

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

namespace vdrive::client {

/// Replaces std::timed_mutex: the thread sanitizer of gcc 12 does not see that a std::timed_mutex
/// is locked with a steady-clock deadline, and reports its unlock as an error.
class TurnMutex {
 public:
  void lock() {
    std::unique_lock lock(mutex_);
    freed_.wait(lock, [this] {
      return !is_taken_;
    });
    is_taken_ = true;
  }

  /// @return false at the deadline.
  template <typename TimePoint>
  [[nodiscard]] bool try_lock_until(const TimePoint& deadline) {
    std::unique_lock lock(mutex_);
    const bool is_free = freed_.wait_until(lock, deadline, [this] {
      return !is_taken_;
    });
    if (is_free) is_taken_ = true;
    return is_free;
  }

  void unlock() {
    const std::scoped_lock lock(mutex_);
    is_taken_ = false;
    freed_.notify_one();
  }

 private:
  std::mutex mutex_;
  std::condition_variable freed_;
  bool is_taken_ = false;
};

/// Wall time that a step waits for the other steppers of its clock to grant the next tick.
inline constexpr std::chrono::milliseconds kStepPatience{10'000};

/// The grants of this session as a stepper of one run of a service.
struct Grant {
  std::uint64_t granted = 0;  ///< last tick that it allows
  std::uint64_t reached = 0;  ///< tick of the last answer
};

/// A step that was requested and is not answered yet.
struct PendingStep {
  std::uint64_t request = 0;  ///< its number
  std::uint64_t ticks = 0;    ///< that it grants
};

/// The right to step a joined clock: no other thread of the session steps it while this lives.
using StepLock = std::unique_lock<TurnMutex>;

/// The clocks of benches: their rates, and steps, alone or as one of several steppers. Thread-safe:
/// if several threads step at the same time, the steps run one after the other.
class BenchClocks {
 public:
  BenchClocks(std::uint64_t session, Exchange& exchange, HeldAxes& held_axes, Discovery& discovery,
              const Wakeup& wakeup, wire::Participant& participant);

  Result<std::uint64_t> set_rate(const Target& target, double rate);

  /// Steps, then returns the state of `axes`. With 0 ticks, only returns the state.
  /// @param patience wall time for other steppers to grant the next tick
  Result<Observation> step(const Target& target, std::uint64_t ticks,
                           std::span<const std::uint16_t> axes,
                           std::chrono::milliseconds patience = kStepPatience,
                           Silence silence = Silence::ends_call);

  /// As above, reusing the memory of an earlier sample.
  /// @param sample set to the state on success, otherwise unchanged
  Outcome step(const Target& target, std::uint64_t ticks, std::span<const std::uint16_t> axes,
               std::chrono::milliseconds patience, Silence silence, Observation& sample);

  /// @return whether one request, without other steppers, does the step: an interrupt does not end
  ///         it.
  [[nodiscard]] bool steps_at_once(const Target& target, std::uint64_t ticks) const;

  /// Makes this session a stepper of the bench.
  /// @param steppers number of steppers that time waits for, including this one
  /// @return the present tick; refused if a step would wait for ever: on a bus, if this thread has
  ///         joined the clock with another session.
  Result<std::uint64_t> join(const Target& target, std::uint32_t steppers);

  /// Leaves the clock of the bench. Waits only briefly for the answer: the service may be gone.
  void leave(const Target& target);

  /// Leaves the clock of every bench.
  void leave_all();

  /// Like leave_all(), but sends nothing: only frees the threads of this session to join clocks
  /// with other sessions.
  void abandon() noexcept;

  /// Locks the steps of a joined clock: if several threads step at the same time, the steps run one
  /// after the other, and each gets its own ticks.
  /// @return no lock if this session has not joined the clock; timed_out at the deadline.
  [[nodiscard]] Result<StepLock> lock_steps(const Target& target,
                                            Wakeup::Clock::time_point deadline);

  /// @return the grants of this session; nothing if it has not joined the clock.
  [[nodiscard]] std::optional<Grant> grant_of(const BenchKey& key) const;

  /// For a bench whose clock this session has joined: requests time up to `tick`, without waiting.
  /// @param shown axes whose status the answer must contain
  Result<PendingStep> begin_step_to(const Target& target, std::uint64_t tick,
                                    std::vector<std::uint16_t> shown = {});

  /// Waits until the tick of `step` is reached, repeating the request while other steppers have not
  /// granted it.
  /// @return the tick reached; timed_out at the deadline, naming the missing stepper.
  Result<std::uint64_t> end_step(const Target& target, PendingStep step,
                                 Wakeup::Clock::time_point deadline);

 private:
  Result<RequestAnswer> step_once(const Target& target, msg::Request request,
                                  std::chrono::milliseconds patience, Silence silence);
  Result<RequestAnswer> step_as_stepper(const Target& target, const Grant& grant,
                                        const msg::Request& request,
                                        std::chrono::milliseconds patience, Silence silence);
  Result<RequestAnswer> conclude_step(const Target& target, const PendingStep& step,
                                      Wakeup::Clock::time_point deadline, Silence silence);
  void note_reply(const BenchKey& key, const PendingStep& step, const msg::Reply& reply);
  [[nodiscard]] Outcome note_thread(const Target& target);
  void forget_thread(const BenchKey& key);
  [[nodiscard]] Outcome missing_stepper(const Target& target, std::uint64_t session) const;

  const std::uint64_t session_;
  Exchange& exchange_;
  HeldAxes& held_axes_;
  Discovery& discovery_;
  const Wakeup& wakeup_;
  wire::Participant& participant_;       ///< knows which threads have joined clocks
  mutable std::mutex mutex_;             ///< guards the grants
  std::map<BenchKey, Grant> grants_;     ///< of the clocks that this session has joined
  std::map<BenchKey, TurnMutex> steps_;  ///< each admits one step of a clock at a time
};

}  // namespace vdrive::client
