// SPDX-License-Identifier: Apache-2.0
// Sessions whose bench loses its wire and gets another one in the same run. The engine is real; the
// test removes its wire.
#include "bench_messages.hpp"
#include "client/objects.hpp"
#include "client/session_options.hpp"
#include "engine/bench_engine.hpp"
#include "support/local_inbox.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/axis_group.hpp"
#include "vdrive/client/session.hpp"
#include "vdrive/wire/participant.hpp"
#include "vdrive/wire/publication.hpp"
#include "vdrive/wire/subscription.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::options;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kBench = 1;
constexpr std::uint64_t kIncarnation = 1'000;
constexpr auto kDeadline = 20s;

/// The DDS part of a bench. It can lose incoming and outgoing messages.
class Wire {
 public:
  explicit Wire(test::LocalInbox& inbox)
      : participant_(wire::make_participant({.domain = test::test_domain()}, "wire")),
        replies_(*participant_),
        command_replies_(*participant_),
        status_(*participant_),
        state_(*participant_),
        description_(*participant_),
        requests_(*participant_,
                  [&inbox, this](const msg::Request& request, const wire::Source& source) {
                    if (arrives()) inbox.receive(request, source);
                  }),
        frames_(*participant_,
                [&inbox, this](const msg::CommandFrame& frame, const wire::Source& source) {
                  if (frame.axes.empty() || arrives()) inbox.receive(frame, source);
                }) {}

  void announce(const msg::BenchDescription& description) { (void)description_.write(description); }

  /// Sends the messages of the engine to its clients.
  void deliver(service::Outbox& outbox) {
    for (; auto* const outgoing = outbox.replies.front(); outbox.replies.pop()) {
      if (!is_taken()) continue;
      (void)replies_.wait_for_match(outgoing->destination, 200ms);
      (void)replies_.write(outgoing->reply);
    }
    for (; const auto* const kept = outbox.command_replies.front(); outbox.command_replies.pop()) {
      msg::CommandReply reply;
      kept->show(reply);
      if (is_taken()) (void)command_replies_.write(reply);
    }
    for (; const auto* const image = outbox.status.front(); outbox.status.pop()) {
      msg::StatusFrame frame;
      frame.bench = kBench;
      frame.incarnation = kIncarnation;
      frame.tick = image->tick;
      frame.parts = 1;
      for (std::size_t axis = 0; axis < image->status.size(); ++axis) {
        wire::to_message(image->status[axis], {kBench, static_cast<std::uint16_t>(axis + 1)},
                         image->tick, image->owners[axis], frame.axes.emplace_back());
      }
      (void)status_.write(frame);
    }
  }

  void publish(const msg::BenchState& state) { (void)state_.write(state); }

  std::atomic<int> to_lose_in{0};   ///< further requests and commands to lose
  std::atomic<int> to_lose_out{0};  ///< further answers to lose
  std::atomic<int> lost{0};

 private:
  bool arrives() { return take(to_lose_in); }

  bool is_taken() { return take(to_lose_out); }

  bool take(std::atomic<int>& to_lose) {
    if (to_lose == 0) return true;
    --to_lose;
    ++lost;
    return false;
  }

  std::unique_ptr<wire::Participant> participant_;
  wire::Publication<msg::Reply> replies_;
  wire::Publication<msg::CommandReply> command_replies_;
  wire::Publication<msg::StatusFrame> status_;
  wire::Publication<msg::BenchState> state_;
  wire::Publication<msg::BenchDescription> description_;
  wire::Subscription<msg::Request> requests_;
  wire::Subscription<msg::CommandFrame> frames_;
};

service::Configuration configuration(service::ClockMode clock) {
  service::Configuration configuration;
  configuration.bench = kBench;
  configuration.clock = clock;
  configuration.axes = service::default_axes(2);
  configuration.watchdog = 5s;  // longer than any loss of a wire here
  return configuration;
}

/// An engine that runs once a millisecond, with its wire.
class Bench {
 public:
  explicit Bench(service::ClockMode clock)
      : configuration_(configuration(clock)),
        inbox_(kBench, counters_),
        outbox_(configuration_.axes.size()),
        engine_(configuration_, {.bench = kBench, .incarnation = kIncarnation}, outbox_,
                counters_) {
    connect();
    thread_ = std::jthread([this](const std::stop_token& stop) {
      run(stop);
    });
  }

  void connect() {
    auto wire = std::make_unique<Wire>(inbox_);
    wire->announce(description());
    const std::scoped_lock lock(mutex_);
    wire_ = std::move(wire);
  }

  void disconnect() {
    std::unique_ptr<Wire> gone;
    const std::scoped_lock lock(mutex_);
    gone = std::move(wire_);
  }

  void lose_in(int count) { lose(&Wire::to_lose_in, count); }

  void lose_out(int count) { lose(&Wire::to_lose_out, count); }

  /// @return whether that many messages were lost before the deadline.
  bool await_lost(int count) {
    return await([&] {
      return wire_->lost >= count;
    });
  }

  bool await_tick(std::uint64_t tick) {
    return await([&] {
      return engine_.tick() >= tick;
    });
  }

  std::uint64_t tick() {
    const std::scoped_lock lock(mutex_);
    return engine_.tick();
  }

  std::int64_t value(std::size_t axis, ObjectAddress object) {
    const std::scoped_lock lock(mutex_);
    return engine_.bank().read(axis, object).value;
  }

  const service::Counters& counters() const { return counters_; }

 private:
  void lose(std::atomic<int> Wire::*what, int count) {
    const std::scoped_lock lock(mutex_);
    (*wire_).*what = count;
  }

  template <typename Condition>
  bool await(const Condition& condition) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kDeadline, condition);
  }

  [[nodiscard]] msg::BenchDescription description() const {
    auto message = client::description(kBench, kIncarnation);
    message.clock_mode = configuration_.clock == service::ClockMode::lockstep
                             ? msg::ClockMode::lockstep
                             : msg::ClockMode::realtime;
    message.axes.clear();
    for (const auto& axis : configuration_.axes) {
      auto& described = message.axes.emplace_back();
      described.axis = axis.number;
      described.name = axis.name;
    }
    message.axis_count = static_cast<std::uint32_t>(message.axes.size());
    message.user_units_per_revolution = 4096;
    return message;
  }

  void run(const std::stop_token& stop) {
    constexpr int kStateEvery = 50;
    auto next = Clock::now();
    for (int round = 0; !stop.stop_requested(); ++round) {
      {
        std::unique_lock lock(mutex_);
        while (service::Arrival* const arrival = inbox_.front()) {
          handle(*arrival);
          inbox_.pop();
        }
        if (configuration_.clock == service::ClockMode::realtime) {
          engine_.step();
          engine_.queue_status();
        }
        if (wire_) {
          wire_->deliver(outbox_);
          if (round % kStateEvery == 0) wire_->publish(state(kBench, kIncarnation, engine_.tick()));
        } else {
          // As in the service, the next wire starts with empty rings.
          while (outbox_.status.front() != nullptr) outbox_.status.pop();
        }
        while (outbox_.events.front() != nullptr) outbox_.events.pop();
        while (outbox_.parameters.front() != nullptr) outbox_.parameters.pop();
        changed_.notify_all();
        next += 1ms;
        changed_.wait_until(lock, stop, next, [] {
          return false;
        });
      }
    }
  }

  void handle(service::Arrival& arrival) {
    service::StepRequests& steps = engine_.steps();
    if (!service::StepRequests::is_for(arrival)) {
      engine_.handle(arrival);
      return;
    }
    const auto now = std::chrono::steady_clock::now();
    steps.handle(arrival, now);
    while (steps.ticks_to_run(now) > 0) {
      steps.begin_tick();
      engine_.step();
    }
    steps.answer_due(now);
  }

  service::Configuration configuration_;
  service::Counters counters_;
  test::LocalInbox inbox_;
  service::Outbox outbox_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  service::BenchEngine engine_;
  std::unique_ptr<Wire> wire_;
  std::jthread thread_;
};

TEST(Reconnect, ResendsALostRequestToTheNextNetworkProcess) {
  Bench bench(service::ClockMode::realtime);
  Session sut(options());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  bench.lose_in(1);
  auto written = std::async(std::launch::async, [&] {
    return axis->write(kWindow, 55).outcome().message();
  });
  ASSERT_TRUE(bench.await_lost(1));
  bench.disconnect();
  bench.connect();
  EXPECT_EQ(written.get(), "");
  EXPECT_EQ(bench.value(0, kWindow), 55);
}

TEST(Reconnect, ExecutesARequestOnceWhenItsAnswerIsLost) {
  Bench bench(service::ClockMode::lockstep);
  Session sut(options());
  ASSERT_TRUE(sut.step(1, 1));
  bench.lose_out(1);
  auto stepped = std::async(std::launch::async, [&] {
    return sut.step(1, 5);
  });
  ASSERT_TRUE(bench.await_lost(1));
  bench.disconnect();
  bench.connect();
  const auto reached = stepped.get();
  ASSERT_TRUE(reached) << reached.outcome().message();
  EXPECT_EQ(*reached, 6U);
  EXPECT_EQ(bench.tick(), 6U);
}

TEST(Reconnect, ResendsALostRequestToALivingBenchAfterASecond) {
  Bench bench(service::ClockMode::realtime);
  Session sut(options());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  ASSERT_TRUE(axis->write(kWindow, 54));
  bench.lose_in(1);
  const auto begin = Clock::now();
  const Outcome written = axis->write(kWindow, 55).outcome();
  EXPECT_TRUE(written) << written.message();
  EXPECT_GE(Clock::now() - begin, 1s);
  EXPECT_EQ(bench.value(0, kWindow), 55);
}

TEST(Reconnect, ResendsLostCommandsInTheirOrder) {
  Bench bench(service::ClockMode::realtime);
  Session sut(options());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  ASSERT_TRUE(axis->enable());
  ASSERT_TRUE(axis->disable());
  bench.lose_in(1'000);  // every message
  auto enabled = std::async(std::launch::async, [&] {
    return axis->enable().message();
  });
  ASSERT_TRUE(bench.await_lost(1));
  bench.disconnect();
  bench.connect();
  EXPECT_EQ(enabled.get(), "");
  EXPECT_EQ(bench.counters().master_losses.get(), 0U);
}

TEST(Reconnect, AGroupMoveContinuesToItsEnd) {
  Bench bench(service::ClockMode::realtime);
  Session sut(options());
  const std::vector<std::string> names{"1.1", "1.2"};
  auto group = AxisGroup::create(sut, names);
  ASSERT_TRUE(group) << group.outcome().message();
  const Outcome enabled = group->enable_all();
  ASSERT_TRUE(enabled) << enabled.message();
  // At 2,000 UU/s the farther axis takes 4 s plus its ramps.
  for (const std::string& name : names) {
    ASSERT_TRUE(sut.axis(name)->write({0x6081, 0}, 2'000));
  }
  auto moved = std::async(std::launch::async, [&] {
    return group->move_together(Eigen::Vector2d(8'000, -4'000)).message();
  });
  ASSERT_TRUE(bench.await_tick(bench.tick() + 500));
  for (int round = 0; round < 2; ++round) {
    bench.disconnect();
    ASSERT_TRUE(bench.await_tick(bench.tick() + 250));
    bench.connect();
    ASSERT_TRUE(bench.await_tick(bench.tick() + 700));
  }
  EXPECT_EQ(moved.get(), "");
  EXPECT_EQ(bench.value(0, {0x6062, 0}), 8'000);
  EXPECT_EQ(bench.value(1, {0x6062, 0}), -4'000);
  EXPECT_EQ(bench.counters().master_losses.get(), 0U);
}

TEST(Reconnect, AFollowerContinuesAndReportsTheGap) {
  Bench bench(service::ClockMode::realtime);
  Session sut(options());
  auto follower = sut.follow({{1, 1}}, Pace::observe);
  ASSERT_TRUE(follower) << follower.outcome().message();
  ASSERT_TRUE(follower->next(5s));
  bench.disconnect();
  ASSERT_TRUE(bench.await_tick(bench.tick() + 250));
  bench.connect();
  std::uint64_t missed = 0;
  const auto give_up = Clock::now() + kDeadline;
  while (missed < 200 && Clock::now() < give_up) {
    const auto seen = follower->next(5s);
    ASSERT_TRUE(seen) << seen.outcome().message();
    missed += seen->missed;
  }
  EXPECT_GE(missed, 200U);
}

/// Collects the reports of on_status().
struct SeenReports {
  std::mutex mutex;
  std::condition_variable changed;
  std::uint64_t newest = 0;   ///< tick
  std::uint64_t skipped = 0;  ///< most ticks between two consecutive reports
  std::string end;            ///< why the reports ended

  void on_report(const Observation& seen) {
    const std::scoped_lock lock(mutex);
    if (newest != 0) skipped = std::max(skipped, seen.tick - newest);
    newest = seen.tick;
    changed.notify_all();
  }

  void on_end(const Outcome& why) {
    const std::scoped_lock lock(mutex);
    end = why.message();
    changed.notify_all();
  }

  template <typename Condition>
  bool await(const Condition& condition) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, kDeadline, condition);
  }
};

Outcome report_to(SeenReports& reports, Session& session) {
  const std::vector<AxisId> axes{{1, 1}};
  return session.on_status(
      axes, 5ms,
      [&reports](const Observation& seen) {
        reports.on_report(seen);
      },
      [&reports](const Outcome& why) {
        reports.on_end(why);
      });
}

// A wire that hangs is replaced after more than 2 s, which is longer than a call tolerates silence.
TEST(Reconnect, WhatFollowsABenchContinuesWhereACallIsLost) {
  Bench bench(service::ClockMode::realtime);
  SeenReports reports;
  Session sut(test::options_of_a_loss());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  auto follower = sut.follow({{1, 1}}, Pace::observe);
  ASSERT_TRUE(follower) << follower.outcome().message();
  ASSERT_TRUE(follower->next(5s));
  ASSERT_TRUE(report_to(reports, sut));
  ASSERT_TRUE(reports.await([&] {
    return reports.newest != 0;
  }));
  const std::uint64_t begin = bench.tick();
  auto waited = std::async(std::launch::async, [&] {
    return sut.wait_for_tick(1, begin + 4'000).outcome().message();
  });
  bench.disconnect();
  EXPECT_EQ(axis->read(kWindow).outcome().kind(), OutcomeKind::lost);
  ASSERT_TRUE(bench.await_tick(begin + 2'500));
  bench.connect();
  std::uint64_t missed = 0;
  for (const auto give_up = Clock::now() + kDeadline; missed < 2'400 && Clock::now() < give_up;) {
    const auto seen = follower->next(10s);
    ASSERT_TRUE(seen) << seen.outcome().message();
    missed += seen->missed;
  }
  EXPECT_GE(missed, 2'400U) << "the gap is counted";
  EXPECT_EQ(waited.get(), "");
  EXPECT_TRUE(reports.await([&] {
    return reports.newest > begin + 2'500;
  }));
  EXPECT_GE(reports.skipped, 2'400U);
  EXPECT_EQ(reports.end, "");
  EXPECT_TRUE(axis->read(kWindow)) << "a call acts again";
}

TEST(Reconnect, ASilenceBeyondThePatienceEndsWhatFollowsABenchWithItsReason) {
  Bench bench(service::ClockMode::realtime);
  SeenReports reports;
  SessionOptions impatient = options();
  impatient.silence = 500ms;
  impatient.patience = 2s;
  Session sut(impatient);
  auto follower = sut.follow({{1, 1}}, Pace::observe);
  ASSERT_TRUE(follower) << follower.outcome().message();
  ASSERT_TRUE(follower->next(5s));
  ASSERT_TRUE(report_to(reports, sut));
  ASSERT_TRUE(reports.await([&] {
    return reports.newest != 0;
  }));
  auto waited = std::async(std::launch::async, [&] {
    return sut.wait_for_tick(1, 1'000'000).outcome();
  });
  bench.disconnect();
  while (follower->next(0ms)) {
  }
  const auto begin = Clock::now();
  const Outcome lost = follower->next(kDeadline).outcome();
  EXPECT_EQ(lost.kind(), OutcomeKind::lost);
  EXPECT_GE(Clock::now() - begin, 1500ms) << "later than the silence of a call";
  const testing::Matcher<std::string> reason =
      testing::AllOf(testing::HasSubstr("bench 1 stopped sending or ended: its newest sample is"),
                     testing::HasSubstr("the limit is 2000 ms"));
  EXPECT_THAT(lost.message(), reason);
  EXPECT_THAT(waited.get().message(), reason);
  EXPECT_TRUE(reports.await([&] {
    return !reports.end.empty();
  }));
  EXPECT_THAT(reports.end, reason);
}

// After the pause, either thread may run first: the one that waits or the one that receives.
TEST(Reconnect, APauseOfTheProgramItselfIsNoSilenceOfTheBench) {
  const test::RunningService service("--axes 1");
  Session sut(options());
  const auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  auto follower = sut.follow({{1, 1}}, Pace::observe);
  ASSERT_TRUE(follower) << follower.outcome().message();
  const auto first = follower->next(5s);
  ASSERT_TRUE(first);
  std::atomic<bool> has_ended = false;
  std::atomic<int> silences = 0;
  sut.watch_services([&](const ServiceChange& change) {
    if (change.news == ServiceNews::fell_silent) ++silences;
  });
  auto waited = std::async(std::launch::async, [&] {
    const auto outcome = sut.wait_for_tick(1, first->tick + 5'000).outcome();
    has_ended = true;
    return outcome.message();
  });
  const std::string self = std::to_string(getpid());
  test::Process stopper("/bin/sh", {"-c", "kill -STOP " + self + "; sleep 4; kill -CONT " + self});
  while (!has_ended) {
    const auto seen = follower->next(5s);
    ASSERT_TRUE(seen) << seen.outcome().message();
  }
  EXPECT_EQ(waited.get(), "");
  EXPECT_EQ(stopper.wait().code, 0);
  EXPECT_EQ(silences, 0) << "reported";
  EXPECT_TRUE(axis->status());
}

// The wire is away for 700 ms and must be discovered again, which the limit of a second of silence
// allows.
TEST(Reconnect, ACallSurvivesASecondOfSilence) {
  Bench bench(service::ClockMode::realtime);
  Session sut(options());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  bench.lose_in(1);
  auto written = std::async(std::launch::async, [&] {
    return axis->write(kWindow, 55).outcome().message();
  });
  ASSERT_TRUE(bench.await_lost(1));
  bench.disconnect();
  ASSERT_TRUE(bench.await_tick(bench.tick() + 700));
  bench.connect();
  EXPECT_EQ(written.get(), "");
}

// A killed participant does not announce its end: it stays matched until its lease expires, but has
// no reader.
TEST(Reconnect, ResendsARequestAfterTheNetworkProcessWasKilled) {
  const auto wire = [](const char* answer) {
    return std::make_unique<test::Process>(
        VDRIVE_WIRE_DOUBLE,
        std::vector<std::string>{std::to_string(test::test_domain()), "1000", answer});
  };
  auto first = wire("0");
  Session sut(options());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  auto read = std::async(std::launch::async, [&] {
    return axis->read(kWindow);
  });
  ASSERT_EQ(first->read_line(), "received 1");
  first->send(SIGKILL);
  const auto next = wire("77");
  EXPECT_EQ(next->read_line(), "received 1") << "the same request";
  const auto value = read.get();
  ASSERT_TRUE(value) << value.outcome().message();
  EXPECT_EQ(*value, 77);
}

}  // namespace
}  // namespace vdrive::client
