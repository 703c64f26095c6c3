// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/bench_identity.hpp"
#include "base/counters.hpp"
#include "configuration/configuration.hpp"
#include "engine/axis_events.hpp"
#include "engine/axis_requests.hpp"
#include "engine/axis_writer.hpp"
#include "engine/bench_axes.hpp"
#include "engine/bench_brake.hpp"
#include "engine/bench_clock.hpp"
#include "engine/bench_events.hpp"
#include "engine/bench_output.hpp"
#include "engine/command_frames.hpp"
#include "engine/frame_answers.hpp"
#include "engine/frame_application.hpp"
#include "engine/frame_schedule.hpp"
#include "engine/master_watch.hpp"
#include "engine/masters.hpp"
#include "engine/request_answers.hpp"
#include "engine/requests.hpp"
#include "engine/snapshots.hpp"
#include "engine/step_requests.hpp"
#include "engine/store_requests.hpp"
#include "engine/windows.hpp"
#include "journal/journal.hpp"
#include "seam/queues.hpp"
#include "store/parameter_saver.hpp"

#include <cstdint>

namespace vdrive::service {

/// The bench without clock and network: carries out arrivals, steps the axes, and puts answers,
/// events and images into the outbox. Belongs to one thread. It takes no lock and, once warm,
/// allocates only for some requests. It owns the classes that do the work and calls them in the
/// order of a tick; none of these classes knows the engine.
class BenchEngine {
 public:
  /// The last completed tick is 0 until `start_at`.
  /// @throws std::invalid_argument if the bank refuses the axes
  BenchEngine(const Configuration& configuration, const BenchIdentity& identity, Outbox& outbox,
              Counters& counters);

  /// Sets the last completed tick. Only before the first step.
  void start_at(std::uint64_t last_tick) {
    clock_.start_at(last_tick);
    axes_.start_at(last_tick);
  }

  /// Records to `journal`, which outlives this engine. Only before the first arrival.
  /// @throws std::system_error if the journal cannot be written
  void record_to(Journal& journal) { axes_.record_to(journal, clock_.tick()); }

  /// Stores parameters with `saver`, which outlives this engine; without a saver nothing can be
  /// stored. Only before the first arrival.
  void store_with(ParameterSaver& saver) { stores_.store_with(saver); }

  /// @return the last completed tick.
  [[nodiscard]] std::uint64_t tick() const noexcept { return clock_.tick(); }

  [[nodiscard]] const AxisBank& bank() const noexcept { return axes_.bank(); }

  /// For the thread that sends replies, which reads the windows that are held.
  [[nodiscard]] BlackBox& black_box() noexcept { return axes_.black_box(); }

  /// @return the ratio of drive time to wall time in realtime, 0 = paused; requests change it. 0 in
  ///         other clock modes.
  [[nodiscard]] double rate() const noexcept { return clock_.rate(); }

  /// @return whether time stands still without a request: lock-step, or paused.
  [[nodiscard]] bool time_stands() const noexcept { return clock_.time_stands(); }

  /// @return whether there is room for the answer to one more arrival and to all waiting frames,
  ///         which a single request may cancel.
  [[nodiscard]] bool can_answer() const noexcept;

  /// Carries out a command frame or a request, or refuses it. Requests that let time pass are
  /// refused: in lock-step they belong to `steps`, in other clock modes no client may make them.
  void handle(Arrival& arrival);

  /// Called by the thread that will step, once its scheduling is set: the threads that help it get
  /// the same scheduling (StepPool).
  void schedule_as_caller() noexcept { axes_.schedule_as_caller(); }

  /// Runs one tick.
  void step();

  /// Puts the status image of the last tick into the outbox.
  /// @param repeated the image was published before and is sent again for clients that joined since
  void queue_status(bool repeated = false) { output_.queue_status(repeated); }

  /// Puts changes into the outbox: parameter sets, overflows of queues, the state of the journal.
  /// Also part of every step.
  void queue_changes() { output_.queue_changes(); }

  /// Gives the axes the parameters that have become durable, and answers the requests that wait for
  /// them. Also part of every step.
  /// @return whether there was anything to do
  bool answer_stores() { return stores_.answer(); }

  /// Moves the tick number forward without running the ticks. The jump does not count as silence of
  /// a master.
  void jump(std::uint64_t ticks);

  /// Puts the event into the outbox, with the present tick.
  void report(EventRecord event) { events_.report(event); }

  /// @return the handler of requests that let time pass in lock-step; `handle` refuses them.
  [[nodiscard]] StepRequests& steps() noexcept { return step_requests_; }

  /// Ends the bench: writes the controlwords that brake the axes that are still enabled. From the
  /// first call on, only reads are answered, masters may be silent, and every step switches off the
  /// axes that have come to rest. May be called again to brake harder.
  void shut_down(Braking braking) { brake_.engage(braking); }

  /// @return whether any axis is in a state other than Not ready to switch on, Switch on disabled
  ///         and Fault.
  [[nodiscard]] bool has_power() const noexcept { return brake_.has_power(); }

 private:
  // In the order of construction: each member uses only members above it.
  Outbox& outbox_;
  BenchClock clock_;
  BenchAxes axes_;
  BenchEvents events_;
  FrameAnswers frame_answers_;
  FrameSchedule schedule_;
  AxisWriter writer_;
  BenchBrake brake_;
  Masters masters_;
  MasterWatch master_watch_;
  FrameApplication application_;
  CommandFrames frames_;
  AxisEvents axis_events_;
  BenchOutput output_;
  RequestAnswers request_answers_;
  StoreRequests stores_;
  AxisRequests axis_requests_;
  Snapshots snapshots_;
  Windows windows_;
  Requests requests_;
  StepRequests step_requests_;
};

}  // namespace vdrive::service
