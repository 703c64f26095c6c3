// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vdrive/axis_bank.hpp"
#include "vdrive/service/bench_engine.hpp"
#include "vdrive/service/configuration.hpp"
#include "vdrive/service/counters.hpp"
#include "vdrive/service/event_limiter.hpp"
#include "vdrive/service/queues.hpp"
#include "vdrive/wire/publication.hpp"

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace vdrive::service {

/// Publishes what is not on the path of a command: the bench's description and state, parameters,
/// events. Used by one thread.
class ReportPublisher {
 public:
  static constexpr std::chrono::milliseconds kStateInterval{50};

  /// Reads the descriptions of the axes from `bank`: before it is stepped.
  ReportPublisher(wire::Participant& participant, const Configuration& configuration,
                  const BenchIdentity& identity, const AxisBank& bank, Counters& counters);

  /// Tells the world that this bench is here, or goes.
  void announce(bool alive);

  /// Publishes the first set of parameters of every axis.
  void publish_first_parameters();

  /// Publishes what waits, and the bench's state every 50 ms of wall time.
  void publish(Inbox& inbox, Outbox& outbox);

  /// Publishes one event past the queue.
  void publish_event(const CountedEvent& counted);

  /// Waits until the subscribers have what was announced.
  void wait_for_readers(std::chrono::milliseconds timeout);

 private:
  using Clock = std::chrono::steady_clock;

  void describe_axes(const Configuration& configuration, const AxisBank& bank);
  void publish_events(Outbox& outbox);
  void publish_parameters(Outbox& outbox);
  void publish_state(const Inbox& inbox, const Outbox& outbox, Clock::time_point now);
  [[nodiscard]] double measured_rate(std::uint64_t tick, Clock::time_point now);
  template <typename Message>
  void write(wire::Publication<Message>& publication, const Message& message);

  wire::Publication<msg::BenchDescription> descriptions_;
  wire::Publication<msg::BenchState> states_;
  wire::Publication<msg::AxisParameters> parameters_;
  wire::Publication<msg::Event> events_;
  BenchIdentity identity_;
  std::chrono::nanoseconds period_;
  Counters& counters_;
  EventLimiter limiter_;
  std::chrono::nanoseconds next_flush_{0};
  std::vector<CountedEvent> passed_;
  std::vector<msg::BenchDescription> parts_;
  std::vector<msg::AxisParameters> first_parameters_;
  msg::BenchState state_;
  msg::Event event_;
  Clock::time_point next_state_{};
  double parameter_budget_ = 0.0;
  Clock::time_point budgeted_{};
  std::uint64_t rate_tick_ = 0;
  Clock::time_point rate_time_{};
  double measured_rate_ = 0.0;
};

}  // namespace vdrive::service
