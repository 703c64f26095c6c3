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

/// The bench without clock and network: takes what arrived, steps the axes, and puts answers,
/// events and images into the outbox. Belongs to one thread. Once warm it allocates nothing and
/// takes no lock. It owns the classes that do the work and calls them in the order of a tick; none
/// of them knows it.
class BenchEngine {
 public:
  /// The last completed tick is 0 until `start_at`.
  /// @throws std::invalid_argument when the bank refuses the axes
  BenchEngine(const Configuration& configuration, const BenchIdentity& identity, Outbox& outbox,
              Counters& counters);

  /// Before the first step: the first tick is the one after `last_tick`.
  void start_at(std::uint64_t last_tick) {
    clock_.start_at(last_tick);
    axes_.start_at(last_tick);
  }

  /// Before the first arrival: records into `journal`, which outlives this engine.
  /// @throws std::system_error when the journal cannot be begun
  void record_to(Journal& journal) { axes_.record_to(journal, clock_.tick()); }

  /// Before the first arrival: stores parameters with `saver`, which outlives this engine. Without
  /// one nothing can be stored.
  void store_with(ParameterSaver& saver) { stores_.store_with(saver); }

  /// Last completed tick.
  [[nodiscard]] std::uint64_t tick() const noexcept { return clock_.tick(); }

  [[nodiscard]] const AxisBank& bank() const noexcept { return axes_.bank(); }

  /// For the thread that sends replies: it reads windows that are held.
  [[nodiscard]] BlackBox& black_box() noexcept { return axes_.black_box(); }

  /// Realtime: drive time over wall time, 0 = paused. Requests change it. 0 in other clock modes.
  [[nodiscard]] double rate() const noexcept { return clock_.rate(); }

  /// @return whether no tick comes by itself: lock-step, or paused.
  [[nodiscard]] bool time_stands() const noexcept { return clock_.time_stands(); }

  /// @return whether there is room for the answer to one more arrival and to every frame that
  ///         waits, which one request may cancel.
  [[nodiscard]] bool can_answer() const noexcept;

  /// Carries a command frame or a request out, or refuses it. Those of `steps` are refused: in
  /// other clock modes nobody may let time pass.
  void handle(Arrival& arrival);

  /// The thread that will step calls it once it has its schedule: the threads that step with it get
  /// the same one (StepPool).
  void schedule_as_caller() noexcept { axes_.schedule_as_caller(); }

  /// One tick.
  void step();

  /// Puts the status image of the last tick into the outbox.
  /// @param repeated the image was published before; it is sent again for clients that joined later
  void queue_status(bool repeated = false) { output_.queue_status(repeated); }

  /// Puts what has changed into the outbox: parameter sets, full queues, the state of the journal;
  /// also part of every step.
  void queue_changes() { output_.queue_changes(); }

  /// Gives the axes the parameters that have become durable and answers the requests that wait for
  /// them; also part of every step.
  /// @return whether there was anything.
  bool answer_stores() { return stores_.answer(); }

  /// The tick number jumps forward and the state is held; the jump does not count as silence of a
  /// master.
  void jump(std::uint64_t ticks);

  /// Puts the event into the outbox, with the present tick.
  void report(EventRecord event) { events_.report(event); }

  /// The requests that let time pass in lock-step; `handle` refuses them.
  [[nodiscard]] StepRequests& steps() noexcept { return step_requests_; }

  /// The bench ends: from the first call on only reads are answered, masters may be silent, and
  /// every step switches off what has come to rest. Writes the controlwords that brake the axes
  /// that are still enabled; may be called again to brake harder.
  void shut_down(Braking braking) { brake_.engage(braking); }

  /// @return whether an axis is in any other state than Not ready to switch on, Switch on disabled
  ///         and Fault.
  [[nodiscard]] bool has_power() const noexcept { return brake_.has_power(); }

 private:
  // In the order of construction: each knows only what stands above it.
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
