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

/// Publishes everything outside the command path: the bench's description and state, parameters,
/// events, names of sessions. Used by one thread.
class ReportPublisher {
 public:
  /// A client regards a bench as silent after 250 ms, so it tolerates the loss of a few states.
  static constexpr std::chrono::milliseconds kStateInterval{50};
  /// If all axes change at the same time, their parameters must not delay events and states, which
  /// use the same lane.
  static constexpr TokenBucket::Rate kParameterSamples{.per_second = 2'000.0, .burst = 256.0};

  /// Limits session names, because a program may send as many as it likes.
  static constexpr TokenBucket::Rate kSessionSamples{.per_second = 100.0, .burst = 256.0};

  /// Reads the descriptions of the axes from `bank`, so construct this before the first step.
  /// @param link outlives this
  ReportPublisher(WireLink& link, const Configuration& configuration, const BenchIdentity& identity,
                  const AxisBank& bank, Counters& counters);

  /// Announces this bench, or its end.
  void announce(bool alive);

  /// Publishes waiting reports, and the bench's state every 50 ms of wall time and when a new
  /// reader waits for it. A new wire first gets the history: descriptions, parameters of all axes,
  /// the last events, names of sessions.
  void publish(Inbox& inbox, Outbox& outbox);

  /// Publishes an event immediately, bypassing the queue.
  void publish_event(const CountedEvent& counted);

  /// Takes the name that a program has sent for its session; the next `publish` passes it on.
  void note_session(std::span<const std::byte> sample);

 private:
  using Clock = std::chrono::steady_clock;

  void describe_axes(const Configuration& configuration, const AxisBank& bank);
  void publish_events(Outbox& outbox);
  void publish_parameters(Outbox& outbox);
  void publish_sessions();
  void publish_state(Clock::time_point now);
  [[nodiscard]] double measured_rate(std::uint64_t tick, Clock::time_point now);
  void send_history();
  template <typename Message>
  void write(const Message& message);

  WireLink& link_;
  std::uint32_t met_ = 0;       ///< the wire that has the descriptions, 0 = none
  bool is_lane_stuck_ = false;  ///< the last message found no room in time
  bool has_history_ = false;    ///< the wire has parameters and events, too
  BenchIdentity identity_;
  std::chrono::nanoseconds period_;
  Counters& counters_;
  EventLimiter limiter_;
  std::chrono::nanoseconds next_flush_{0};
  std::vector<CountedEvent> passed_;
  std::vector<msg::BenchDescription> parts_;
  std::vector<msg::AxisParameters> parameters_;  ///< the latest ones of each axis
  std::vector<std::uint16_t> indices_;           ///< in `parameters_`, by axis number
  std::deque<msg::Event> history_;               ///< the last kEventsKept
  SessionNames sessions_;
  msg::SessionName received_name_;  ///< the latest name received
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
