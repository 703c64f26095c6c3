// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/bench_identity.hpp"
#include "base/counters.hpp"
#include "base/event_limiter.hpp"
#include "configuration/configuration.hpp"
#include "publish/session_names.hpp"
#include "seam/queues.hpp"
#include "seam/wire_link.hpp"
#include "vdrive/axis_bank.hpp"
#include "vdrive/token_bucket.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <vector>

namespace vdrive::service {

/// Publishes what is not on the path of a command: the bench's description and state, parameters,
/// events, names of sessions. Used by one thread.
class ReportPublisher {
 public:
  /// A client takes a bench for silent after 250 ms: a lost state is no silence.
  static constexpr std::chrono::milliseconds kStateInterval{50};
  /// When all axes change at once, their parameters must not hold up events and states, which take
  /// the same lane.
  static constexpr TokenBucket::Rate kParameterSamples{.per_second = 2'000.0, .burst = 256.0};

  /// A program may say anything about itself, as often as it likes.
  static constexpr TokenBucket::Rate kSessionSamples{.per_second = 100.0, .burst = 256.0};

  /// Reads the descriptions of the axes from `bank`: before it is stepped.
  /// @param link outlives this
  ReportPublisher(WireLink& link, const Configuration& configuration, const BenchIdentity& identity,
                  const AxisBank& bank, Counters& counters);

  /// Announces this bench, or its end.
  void announce(bool alive);

  /// Publishes what waits, and the bench's state every 50 ms of wall time and when the wire knows
  /// of a new reader. A wire that is new gets the history first: descriptions, parameters of all
  /// axes, the last events, names of sessions.
  void publish(Inbox& inbox, Outbox& outbox);

  /// Publishes one event past the queue.
  void publish_event(const CountedEvent& counted);

  /// Takes what a program has said about its session; the next `publish` passes it on.
  void note_session(std::span<const std::byte> sample);

 private:
  using Clock = std::chrono::steady_clock;

  void describe_axes(const Configuration& configuration, const AxisBank& bank);
  void publish_events(Outbox& outbox);
  void publish_parameters(Outbox& outbox);
  void publish_sessions();
  void publish_state(Clock::time_point now);
  [[nodiscard]] double measured_rate(std::uint64_t tick, Clock::time_point now);
  void meet_wire();
  template <typename Message>
  void write(const Message& message);

  WireLink& link_;
  std::uint32_t met_ = 0;       ///< the wire that has the descriptions, 0 = none
  bool is_lane_stuck_ = false;  ///< the last message found no room in time
  bool has_history_ = false;    ///< it has parameters and events too
  BenchIdentity identity_;
  std::chrono::nanoseconds period_;
  Counters& counters_;
  EventLimiter limiter_;
  std::chrono::nanoseconds next_flush_{0};
  std::vector<CountedEvent> passed_;
  std::vector<msg::BenchDescription> parts_;
  std::vector<msg::AxisParameters> parameters_;  ///< the newest of each axis
  std::vector<std::uint16_t> indices_;           ///< in `parameters_`, by number of an axis
  std::deque<msg::Event> history_;               ///< the last kEventsKept
  SessionNames sessions_;
  msg::SessionName said_;  ///< the newest
  TokenBucket session_samples_{kSessionSamples};
  msg::BenchState state_;
  msg::Event event_;
  Clock::time_point next_state_{};
  TokenBucket parameter_samples_{kParameterSamples};
  std::uint64_t rate_tick_ = 0;
  Clock::time_point rate_time_{};
  double measured_rate_ = 0.0;
};

}  // namespace vdrive::service
