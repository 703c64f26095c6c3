// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "session/session_core.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

namespace vdrive::client {

/// The axes of a group, and the benches that they are on. A single axis is a group of one.
struct GroupLayout {
  struct Bench {
    std::uint32_t number = 0;
    std::vector<std::uint16_t> axes;
    std::vector<std::size_t> places;  ///< places of these axes in the group
  };

  std::vector<AxisId> axes;  ///< in the order of the group
  std::vector<Bench> benches;
};

/// Maximum number of axes that a message of a group names; further axes are only counted.
inline constexpr std::size_t kMostNamed = 4;

/// @param axes each once
[[nodiscard]] GroupLayout layout_of(std::span<const AxisId> axes);

[[nodiscard]] inline GroupLayout layout_of(const AxisId& axis) {
  return layout_of(std::span(&axis, 1));
}

/// Whether a call is for a single axis or for a group. While a bench is paused, a call for a single
/// axis fails and one for a group waits. Messages for a single axis do not list axes.
enum class Caller : std::uint8_t { axis, group };

/// The axes of one bench, as a call observes them.
struct BenchPart {
  const GroupLayout::Bench* bench = nullptr;
  Target target;
  std::shared_ptr<StatusFeed> feed;  ///< none in lock-step
  Observation seen;
  std::uint64_t skipped = 0;  ///< ticks jumped over since the first observation
  Outcome loss{};             ///< why the bench is lost, if it is

  [[nodiscard]] bool is_lost() const { return !loss; }
};

/// One or more axes on one or more benches, tick by tick: all benches show the same tick.
class ObservedAxes {
 public:
  using Progress = std::function<void(std::uint64_t tick, std::span<const AxisSnapshot>)>;

  /// @param progress called with each observed tick; may be empty
  ObservedAxes(std::shared_ptr<SessionCore> core, GroupLayout layout, Caller caller,
               Progress progress);

  /// Connects to every bench and starts receiving the status of the axes. Several calls can open()
  /// first and then wait in connect() together.
  Outcome open();

  /// Opens if not yet open, compares the clocks of the benches, and observes the axes for the first
  /// time.
  Outcome connect();

  /// Stops receiving the status of the axes, to relieve the receiving thread. Call nothing after
  /// this.
  void close() { parts_.clear(); }

  /// Advances to the next tick that all benches show; in lock-step, by `ticks` ticks.
  /// @param patience wall time for other steppers to grant the next tick
  /// @return timed_out, for an axis, if no sample arrived for a while.
  Outcome advance(std::uint64_t ticks, std::chrono::milliseconds patience = kStepPatience);

  /// Observes what has arrived so far, without waiting; in lock-step the present state.
  Outcome refresh();

  /// Observes the axes again, as they were when this call began or later. Samples may be delayed: a
  /// command of another session may already be answered, while the newest sample is older than its
  /// effect. So a call looks again before it is refused because of the state of the axes. Does
  /// nothing in lock-step, where every observation is the answer to a request.
  Outcome look_again();

  /// After a request to stop, a call that waits for a sample returns `failed`.
  void stop_by(std::stop_token stop) { stop_ = std::move(stop); }

  /// @return `outcome`; if it is `lost`, the part is lost from now on, and for a group the message
  ///         names the axes that are lost with it.
  Outcome note_lost(BenchPart& part, Outcome outcome) const;

  /// @return whether the bench of this axis is not lost.
  [[nodiscard]] bool is_present(const AxisSnapshot& axis) const;

  /// The newest tick that any bench has published.
  Result<std::uint64_t> newest_tick();

  /// The axes as last observed, in the order of the group.
  [[nodiscard]] const std::vector<AxisSnapshot>& snapshots() const noexcept { return snapshots_; }

  /// The tick of the first bench that is not lost.
  [[nodiscard]] std::uint64_t tick() const noexcept { return tick_; }

  /// tick() without the ticks that the tick number jumped over since the first observation: use it
  /// for durations and deadlines.
  [[nodiscard]] std::uint64_t driven_tick() const noexcept { return driven_tick_; }

  [[nodiscard]] std::chrono::microseconds period() const { return parts_.front().target.period; }

  [[nodiscard]] bool steps() const { return parts_.front().target.steps(); }

  [[nodiscard]] Caller caller() const noexcept { return caller_; }

  [[nodiscard]] const GroupLayout& layout() const noexcept { return *layout_; }

  [[nodiscard]] std::vector<BenchPart>& parts() noexcept { return parts_; }

  [[nodiscard]] const std::vector<BenchPart>& parts() const noexcept { return parts_; }

 private:
  [[nodiscard]] Outcome compare_clocks() const;
  Outcome first_sample(BenchPart& part);
  Outcome observe_first();
  Outcome await_common_ticks();
  Outcome catch_up(BenchPart& part);
  Outcome next(BenchPart& part);
  Outcome align();
  [[nodiscard]] Outcome require_a_bench() const;
  Outcome note(BenchPart& part, Result<Observation> sample) const;
  void publish();

  std::shared_ptr<SessionCore> core_;
  std::shared_ptr<const GroupLayout> layout_;
  Caller caller_;
  Progress progress_;
  bool is_open_ = false;
  std::vector<BenchPart> parts_;
  std::vector<AxisSnapshot> snapshots_;
  std::uint64_t tick_ = 0;
  std::uint64_t driven_tick_ = 0;
  std::stop_token stop_;
};

/// For a call that has ended. The refusal of a command frame with an outdated epoch does not say
/// who has taken the axes, but their status does. Waits for that status and for the name of the new
/// owner: while samples of the bench arrive, about a second at most.
/// @param axes that the call has commanded
/// @return for a refusal of this kind: the refusal with the session that holds one of the axes now,
///         if any; an outcome that has an owner without a name: with the name, if it is known; any
///         other outcome unchanged.
[[nodiscard]] Outcome explain_loss(SessionCore& core, Outcome outcome,
                                   std::span<const AxisId> axes);

/// As explain_loss(), for a call with one outcome per axis. Outcomes that have an owner stay
/// unchanged.
void explain_losses(SessionCore& core, std::span<Outcome> outcomes, std::span<const AxisId> axes);

}  // namespace vdrive::client
