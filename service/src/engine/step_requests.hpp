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

/// Whether the participant that sent a request is on the network.
enum class ReaderState : std::uint8_t {
  unknown,  ///< not discovered yet
  matched,  ///< it reads replies
  gone,     ///< it used to read replies and has left
};

/// The requests that let time pass on a lock-step bench: `step`, and joining and leaving its clock.
/// Handles each from its arrival to its answer. The thread that runs the ticks asks `ticks_to_run`
/// how many may pass.
///
/// While no session has joined the clock, a step waits for the command frames that were sent before
/// it, and then lets its ticks pass; later requests are carried out after it. With steppers, time
/// passes as far as all of them have granted it, once the awaited number of them has joined. A step
/// is answered in the tick that its session waits for; other requests are carried out in the
/// meantime.
///
/// The caller passes the wall time. Not thread-safe.
class StepRequests {
 public:
  using Time = StepperTable::Time;

  static constexpr std::uint64_t kMaxTicksPerStep = 1'000'000;

  /// If the frames of a step have not arrived in this time, it is refused with
  /// REASON_MISSING_COMMANDS.
  static constexpr std::chrono::seconds kLongestWaitForCommands{1};

  /// If another stepper has not granted the ticks of a step in this time, the step is refused with
  /// REASON_MISSING_STEPPER.
  static constexpr std::chrono::seconds kLongestWaitForSteppers{1};

  static constexpr std::size_t kMostWaiting = 1'024;

  StepRequests(const Configuration& configuration, const BenchClock& clock,
               const CommandFrames& frames, Masters& masters, Requests& requests,
               RequestAnswers& answers, BenchEvents& events, Counters& counters);

  /// @return whether requests of this kind let time pass, or join or leave the clock.
  [[nodiscard]] static constexpr bool is_for(msg::RequestKind kind) noexcept {
    const wire::RequestKindRow* const row = wire::request_kind_row(kind);
    return row != nullptr && row->caller == wire::RequestCaller::stepper;
  }

  /// @return whether the arrival is a request of such a kind.
  [[nodiscard]] static bool is_for(const Arrival& arrival) noexcept {
    return arrival.kind == Arrival::Kind::request && is_for(arrival.request.kind);
  }

  /// Answers the request, or takes the content of a step and keeps it until `answer_due` answers
  /// it. Precondition: the queue of answers has room.
  /// @return false if it has arrived before
  bool handle(Arrival& arrival, Time now);

  /// Notes that a message of the session, stepper or not, has arrived.
  void note_message(std::uint64_t session, Time now) noexcept {
    steppers_.note_message(session, now);
  }

  /// @return whether requests have to wait until the step that waits for its frames is answered.
  [[nodiscard]] bool holds_requests_back() const noexcept {
    return !waiting_.empty() && waiting_.back().is_alone;
  }

  /// @return how many ticks may pass before the next step has to be answered.
  [[nodiscard]] std::uint64_t ticks_to_run(Time now);

  /// Call it before each tick that `ticks_to_run` has allowed: notes that the sessions that step
  /// are alive.
  void begin_tick();

  /// Answers each step whose tick is reached or that has waited too long.
  /// @return false if the queue of answers is full and steps may be left: empty it and call again
  bool answer_due(Time now);

  /// Removes absent steppers from the clock: a program that died must not stop the time of the
  /// others for good.
  void remove_absent(Time now, const std::function<ReaderState(const wire::Source&)>& reader_of);

  /// Refuses the waiting steps when the bench ends, because no tick will answer them.
  /// @return as answer_due()
  bool refuse_waiting();

 private:
  /// A step. It first waits for its command frames; then it is granted and waits for its tick.
  struct WaitingStep {
    Arrival arrival;
    Time deadline;
    bool is_alone = false;       ///< it arrived while there was no stepper
    bool is_granted = false;     ///< its command frames have arrived
    bool is_of_stepper = false;  ///< valid if `is_granted`
    std::uint64_t aim = 0;       ///< the tick it is answered in; valid if `is_granted`
  };

  [[nodiscard]] Reason check(const Arrival& arrival) const;
  [[nodiscard]] Reason keep(Arrival& arrival, Time now);
  [[nodiscard]] Reason change_steppers(const Arrival& arrival, Time now);
  [[nodiscard]] Reason join(const Arrival& arrival, Time now);
  [[nodiscard]] Reason leave(const Arrival& arrival, Time now);
  void remove_stepper(std::uint64_t session, StepperRemoval parting, Time now);
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
