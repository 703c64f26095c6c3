// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/counters.hpp"
#include "base/reason.hpp"
#include "configuration/configuration.hpp"
#include "engine/bench_clock.hpp"
#include "engine/bench_events.hpp"
#include "engine/command_frames.hpp"
#include "engine/masters.hpp"
#include "engine/request_answers.hpp"
#include "engine/requests.hpp"
#include "engine/stepper_table.hpp"
#include "seam/queues.hpp"
#include "vdrive/wire/request_kinds.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

namespace vdrive::service {

/// What the network knows of the participant that sent a request.
enum class ReaderState : std::uint8_t {
  unknown,  ///< not seen yet
  matched,  ///< it reads replies
  gone,     ///< it read replies and does so no more
};

/// The requests that let the time of a lock-step bench pass: `step`, and joining and leaving its
/// clock. Takes each from its arrival to its answer; whoever runs the ticks asks `ticks_to_run` how
/// many there may be.
///
/// While no session has joined the clock, a step waits for the command frames that were sent before
/// it, and then lets its ticks pass; requests that came after it act after it. With steppers, time
/// passes as far as all of them grant it, once as many have joined as are awaited, and a step is
/// answered in the tick that its session waits for; other requests are carried out while it waits.
///
/// Wall time is an argument. Not thread-safe.
class StepRequests {
 public:
  using Time = StepperTable::Time;

  static constexpr std::uint64_t kMaxTicksPerStep = 1'000'000;

  /// A step is refused with REASON_MISSING_COMMANDS when its frames have not come after this time.
  static constexpr std::chrono::seconds kLongestWaitForCommands{1};

  /// ... and with REASON_MISSING_STEPPER when another stepper has not granted its ticks.
  static constexpr std::chrono::seconds kLongestWaitForSteppers{1};

  static constexpr std::size_t kMostWaiting = 1'024;

  StepRequests(const Configuration& configuration, const BenchClock& clock,
               const CommandFrames& frames, Masters& masters, Requests& requests,
               RequestAnswers& answers, BenchEvents& events, Counters& counters);

  /// @return whether requests of this kind let time pass, or say who does.
  [[nodiscard]] static constexpr bool is_for(msg::RequestKind kind) noexcept {
    const wire::RequestKindRow* const row = wire::request_kind_row(kind);
    return row != nullptr && row->caller == wire::RequestCaller::stepper;
  }

  /// @return whether the arrival is such a request.
  [[nodiscard]] static bool is_for(const Arrival& arrival) noexcept {
    return arrival.kind == Arrival::Kind::request && is_for(arrival.request.kind);
  }

  /// Answers the request, or keeps a step until `answer_due` answers it; then its content is taken.
  /// The queue of answers needs room.
  /// @return false when it had arrived before.
  bool handle(Arrival& arrival, Time now);

  /// A message of the session, stepper or not, arrived.
  void note_message(std::uint64_t session, Time now) noexcept {
    steppers_.note_message(session, now);
  }

  /// @return whether requests have to wait until the step that waits for its frames is answered.
  [[nodiscard]] bool holds_requests_back() const noexcept {
    return !waiting_.empty() && waiting_.back().is_alone;
  }

  /// @return how many ticks may pass until a step is to be answered.
  [[nodiscard]] std::uint64_t ticks_to_run(Time now);

  /// Before each of these ticks: the sessions that step show that they are alive.
  void begin_tick();

  /// Answers each step whose tick is reached, or that has waited too long.
  /// @return false when the queue of answers is full and steps may be left: empty it, call again.
  bool answer_due(Time now);

  /// Takes steppers off the clock that are not there any more: a program that died must not stop
  /// the time of the others for good.
  void remove_absent(Time now, const std::function<ReaderState(const wire::Source&)>& reader_of);

  /// The bench ends: no tick will answer the steps that wait.
  /// @return false as `answer_due`.
  bool refuse_waiting();

 private:
  /// A step: first it waits for its command frames, then, granted, for time.
  struct WaitingStep {
    Arrival arrival;
    Time deadline;
    bool is_alone = false;       ///< it arrived while there was no stepper
    bool is_granted = false;     ///< its command frames are here
    bool is_of_stepper = false;  ///< holds when `is_granted`
    std::uint64_t aim = 0;       ///< tick that it is answered in; holds when `is_granted`
  };

  [[nodiscard]] Reason check(const Arrival& arrival) const;
  [[nodiscard]] Reason keep(Arrival& arrival, Time now);
  [[nodiscard]] Reason change_steppers(const Arrival& arrival, Time now);
  [[nodiscard]] Reason join(const Arrival& arrival, Time now);
  [[nodiscard]] Reason leave(const Arrival& arrival, Time now);
  void part_with(std::uint64_t session, Parting parting, Time now);
  void grant_arrived(Time now);
  void grant(WaitingStep& waiting, Time now);
  [[nodiscard]] bool answer_if_due(const WaitingStep& waiting, Time now);
  void answer(const Arrival& arrival, Reason reason, std::uint64_t missing_stepper = 0);
  void show_steppers();

  const BenchClock& clock_;
  const CommandFrames& frames_;
  Masters& masters_;
  Requests& requests_;
  RequestAnswers& answers_;
  BenchEvents& events_;
  Counters& counters_;
  StepperTable steppers_;
  std::deque<WaitingStep> waiting_;
};

}  // namespace vdrive::service
