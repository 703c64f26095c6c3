// SPDX-License-Identifier: Apache-2.0
// The wire of a bench ends, hangs or receives nothing, and the bench continues. With real
// processes.
#include "service/probe.hpp"
#include "support/deadline.hpp"
#include "support/dropped_by_sockets.hpp"
#include "support/local_http.hpp"
#include "support/process_tree.hpp"
#include "support/signals.hpp"
#include "support/temporary_directory.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "wire/attacker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// vdrived with its wire in a separate process.
class Bench {
 public:
  explicit Bench(std::vector<std::string> more = {})
      : process_(VDRIVE_SERVICE, with_wire_process(std::move(more))) {}

  [[nodiscard]] pid_t engine() const { return process_.id(); }

  [[nodiscard]] pid_t spawner() const { return child_of(engine()); }

  [[nodiscard]] pid_t wire() const { return wire_of(engine()); }

  /// For a bench with "--metrics 0" and log level info; call once. @return its metrics port.
  int metrics_port() {
    const std::string mark = "metrics=http://127.0.0.1:";
    std::string line = process_.read_error_line();
    while (!line.empty() && line.find(mark) == std::string::npos) line = process_.read_error_line();
    return line.empty() ? 0 : std::stoi(line.substr(line.find(mark) + mark.size()));
  }

  /// Sends SIGTERM. @return how the process ended, and after what time.
  std::pair<Finished, std::chrono::milliseconds> end() {
    const auto begin = Clock::now();
    process_.send(SIGTERM);
    Finished finished = process_.wait();
    return {std::move(finished),
            std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - begin)};
  }

 private:
  static std::vector<std::string> with_wire_process(std::vector<std::string> more) {
    std::vector<std::string> arguments{"--domain", std::to_string(test_domain()), "--wire",
                                       "process"};
    if (std::ranges::find(more, "--log-level") == more.end()) {
      arguments.insert(arguments.end(), {"--log-level", "warn"});
    }
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  Process process_;
};

// A wire looked up too early has process id 0, which addresses the complete process group of this
// run.
TEST(Signals, AreSentToNoGroupOfProcesses) {
  for (const pid_t group : {1, 0, -1, -getpgrp()}) {
    EXPECT_THROW(send_signal(group, 0), std::invalid_argument) << group;
    EXPECT_THROW(static_cast<void>(exists(group)), std::invalid_argument) << group;
  }
  EXPECT_TRUE(send_signal(getpid(), 0));
}

bool is_restart(const msg::Event& event) {
  return event.kind == msg::EventKind::wire && event.code == 2;
}

/// @return the time until a status arrives that is more than 50 ticks newer than the last one seen.
std::chrono::milliseconds time_to_next_status(Probe& probe) {
  const std::uint64_t tick = probe.status().value().tick;
  const auto begin = Clock::now();
  EXPECT_TRUE(probe.wait_until([&] {
    return probe.seen_status()->tick > tick + 50;
  }));
  return std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - begin);
}

TEST(Engine, SurvivesTheEndOfItsWireAndStartsAnother) {
  Bench bench({"--axes", "8"});
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  const std::uint64_t incarnation = probe.incarnation;
  const auto epoch = probe.acquire({1});
  ASSERT_TRUE(epoch.has_value());
  ASSERT_TRUE(probe.wait_until([&] {
    return probe.seen_status().has_value();
  }));
  for (std::uint64_t count = 1; count <= 3; ++count) {
    const pid_t wire = bench.wire();
    ASSERT_NE(wire, 0);
    send_signal(wire, count == 2 ? SIGABRT : SIGKILL);
    EXPECT_LT(time_to_next_status(probe), 5s);
    ASSERT_TRUE(probe.event(is_restart).has_value());
    ASSERT_TRUE(probe.wait_until([&] {
      return probe.seen_state() && probe.seen_state()->wire_starts == count + 1;
    }));
    ASSERT_NE(bench.wire(), wire);
  }
  EXPECT_EQ(probe.seen_state()->incarnation, incarnation);
  // If the machine stalls, the tick number jumps, too.
  EXPECT_LT(probe.seen_state()->jumps, 3U) << "each end of a wire stopped the ticks";
  ASSERT_TRUE(probe.find_bench());
  EXPECT_EQ(probe.incarnation, incarnation);
  EXPECT_TRUE(probe.read(1, 0x6041).has_value()) << "requests are answered through the new wire";
}

TEST(Engine, RepublishesEarlierEventsThroughANewWire) {
  Bench bench({"--axes", "2"});
  {
    Probe probe(test_domain());
    ASSERT_TRUE(probe.find_bench());
    ASSERT_TRUE(probe.acquire({1}).has_value());
  }
  send_signal(bench.wire(), SIGKILL);
  Probe late(test_domain());
  ASSERT_TRUE(late.find_bench());
  EXPECT_TRUE(late.event(is_restart).has_value());
  EXPECT_TRUE(late.event([](const msg::Event& event) {
                    return event.kind == msg::EventKind::control_changed;
                  })
                  .has_value())
      << "an earlier event";
  EXPECT_TRUE(late.wait_until([&] {
    return late.seen_parameters() >= 2;
  })) << "the parameters of both axes";
}

// A stopped process represents any thread that spins or waits for ever: its pumps make no round for
// 2 s. Two more seconds are for a slow machine.
TEST(Engine, EndsAWireThatHangs) {
  Bench bench({"--axes", "2"});
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  ASSERT_TRUE(probe.wait_until([&] {
    return probe.seen_status().has_value();
  }));
  const pid_t wire = bench.wire();
  send_signal(wire, SIGSTOP);
  EXPECT_LT(time_to_next_status(probe), 5s);
  EXPECT_TRUE(holds_soon([&] {
    return !exists(wire);
  }));
}

bool is_loss(const msg::Event& event) {
  return event.kind == msg::EventKind::wire && event.code == 1;
}

// The process of a killed wire exists until the kernel releases it: while a core dump is written,
// memory is freed, or, as here, a debugger holds it. It no longer runs any instruction of the wire.
TEST(Engine, ReplacesAKilledWireAtOnceWhileItsProcessIsStillThere) {
  Bench bench({"--axes", "2"});
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  const pid_t wire = bench.wire();
  ASSERT_NE(wire, 0);
  if (ptrace(PTRACE_SEIZE, wire, nullptr, PTRACE_O_TRACEEXIT) != 0) {
    GTEST_SKIP() << "this user may not hold a process of his";
  }
  send_signal(wire, SIGKILL);
  int status = 0;
  ASSERT_EQ(waitpid(wire, &status, __WALL), wire);
  ASSERT_EQ(status >> 8, SIGTRAP | (PTRACE_EVENT_EXIT << 8));
  const auto loss = probe.event(is_loss);
  ASSERT_TRUE(loss.has_value());
  EXPECT_THAT(loss->text, testing::HasSubstr("ended by signal 9")) << "it was not found hung";
  EXPECT_TRUE(probe.event(is_restart).has_value());
  EXPECT_TRUE(exists(wire));
  ptrace(PTRACE_DETACH, wire, nullptr, nullptr);
  EXPECT_TRUE(holds_soon([&] {
    return !exists(wire);
  })) << "and it is reaped";
}

/// @return how often `part` occurs in `text`.
std::size_t count_of(const std::string& part, const std::string& text) {
  std::size_t count = 0;
  for (auto place = text.find(part); place != std::string::npos; place = text.find(part, place + 1))
    ++count;
  return count;
}

/// A bench whose wire hangs and whose spawner is stopped, so nothing can end the wire.
class StoppedProcesses : public testing::Test {
 protected:
  StoppedProcesses() {
    EXPECT_TRUE(probe_.find_bench());  // its wire runs from here on
    spawner_ = bench_.spawner();
    wire_ = bench_.wire();
    for (const pid_t process : {bench_.engine(), spawner_, wire_}) send_signal(process, SIGSTOP);
    send_signal(bench_.engine(), SIGCONT);
  }

  [[nodiscard]] bool is_down() const {
    return http_get(port_, "/metrics").find("\nvdrive_wire_up{bench=\"1\"} 0\n") !=
           std::string::npos;
  }

  Bench bench_{{"--metrics", "0", "--log-level", "info"}};
  int port_ = bench_.metrics_port();
  Probe probe_{test_domain()};
  pid_t spawner_ = 0;
  pid_t wire_ = 0;
};

TEST_F(StoppedProcesses, MakeABenchUnreadyThatIsAlive) {
  EXPECT_TRUE(holds_soon([&] {
    return http_get(port_, "/readyz")
        .ends_with("bench 1 has no network: the network process is down\n");
  }));
  EXPECT_THAT(http_get(port_, "/livez"), testing::StartsWith("HTTP/1.1 200"));
  send_signal(spawner_, SIGCONT);
  EXPECT_TRUE(holds_soon([&] {
    return http_get(port_, "/readyz").ends_with("bench 1 is on the network\n");
  }));
}

TEST_F(StoppedProcesses, DoNotKeepTheServiceFromEnding) {
  EXPECT_TRUE(holds_soon([&] {
    return is_down();
  }));
  const auto [finished, time] = bench_.end();
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_LE(time, 2s);
  EXPECT_EQ(count_of("the wire (network process) failed", finished.errors), 1U) << finished.errors;
  EXPECT_TRUE(holds_soon([&] {
    return !exists(wire_) && !exists(spawner_);
  })) << "the kernel ends what is stopped";
}

TEST_F(StoppedProcesses, AreReportedOnceAndReplacedWhenTheSpawnerGoesOn) {
  EXPECT_TRUE(holds_soon([&] {
    return is_down();
  }));
  send_signal(spawner_, SIGCONT);
  EXPECT_TRUE(probe_.event(is_restart).has_value());
  EXPECT_TRUE(holds_soon([&] {
    return !is_down() && !exists(wire_);
  }));
  const auto [finished, time] = bench_.end();
  EXPECT_EQ(count_of("the wire (network process) failed", finished.errors), 1U) << finished.errors;
}

/// A subscriber to `status` that counts the frames it receives.
class Subscriber {
 public:
  explicit Subscriber(std::uint16_t parts)
      : parts_(parts),
        participant_(wire::make_participant({.domain = test_domain(), .role = wire::Role::client},
                                            "vdrive subscriber")),
        status_(*participant_, [this](const msg::StatusFrame& frame, const wire::Source&) {
          take(frame);
        }) {}

  struct Seen {
    std::uint64_t tick = 0;    ///< newest
    std::uint64_t frames = 0;  ///< received
    std::uint64_t missed = 0;  ///< between the first one and the newest
  };

  [[nodiscard]] Seen seen() {
    const std::lock_guard lock(mutex_);
    return seen_of();
  }

  /// Waits for a frame of a tick later than `tick`. @return the counts; nothing after 10 s.
  [[nodiscard]] std::optional<Seen> seen_after(std::uint64_t tick) {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, 10s, [&] {
          return tick_ > tick;
        })) {
      return std::nullopt;
    }
    return seen_of();
  }

 private:
  [[nodiscard]] Seen seen_of() const {
    const std::uint64_t sent = tick_ == 0 ? 0 : (tick_ - first_) * parts_;
    return {.tick = tick_, .frames = frames_, .missed = sent - before_tick_};
  }

  void take(const msg::StatusFrame& frame) {
    const std::lock_guard lock(mutex_);
    if (tick_ == 0) first_ = frame.tick;
    if (frame.tick != tick_) {
      before_tick_ = frames_;
      tick_ = frame.tick;
    }
    ++frames_;
    changed_.notify_all();
  }

  std::uint16_t parts_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t first_ = 0;
  std::uint64_t tick_ = 0;
  std::uint64_t frames_ = 0;
  std::uint64_t before_tick_ = 0;  ///< frames of the ticks before the newest
  std::unique_ptr<wire::Participant> participant_;
  wire::Subscription<msg::StatusFrame> status_;
};

msg::BenchState state_after(Probe& probe, std::uint64_t tick) {
  msg::BenchState state;
  EXPECT_TRUE(probe.wait_until([&] {
    if (!probe.seen_state() || probe.seen_state()->tick <= tick) return false;
    state = *probe.seen_state();
    return true;
  }));
  return state;
}

void let_it_stand(pid_t wire) {
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable never;
  send_signal(wire, SIGSTOP);
  static_cast<void>(never.wait_until(lock, Clock::now() + 150ms, [] {
    return false;
  }));
  send_signal(wire, SIGCONT);
}

// 150 ticks of 512 axes are 300 frames of 28.7 kB, 8.6 MB; the engine keeps 250 ms of them. On a
// busy machine a thread may be held up for longer, so one of twenty attempts must pass. The socket
// buffers may be small here; frames that they drop are not counted.
TEST(Engine, LosesNoStatusWhileItsWireIsStoppedFor150Milliseconds) {
  constexpr std::uint16_t kParts = 2;
  constexpr int kAttempts = 20;
  Bench bench({"--axes", "512"});
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  Subscriber subscriber(kParts);
  ASSERT_TRUE(subscriber.seen_after(0).has_value());
  const pid_t wire = bench.wire();
  ASSERT_NE(wire, 0);
  std::string why;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const auto begin = subscriber.seen();
    const auto dropped = dropped_by_sockets();
    const msg::BenchState before = state_after(probe, begin.tick);
    let_it_stand(wire);
    // By then all waiting frames have arrived, and 50 more ticks.
    const auto end = subscriber.seen_after(before.tick + 200);
    ASSERT_TRUE(end.has_value());
    const msg::BenchState after = state_after(probe, end->tick);
    const auto late = subscriber.seen_after(after.tick);
    ASSERT_TRUE(late.has_value());
    const auto lost = after.queue_overflows - before.queue_overflows;
    const auto missed = late->missed - begin.missed;
    const auto excused = dropped_by_sockets() - dropped;
    if (after.jumps == before.jumps && lost == 0 && missed <= excused) return;
    why += std::to_string(lost) + " lost by the service, " + std::to_string(missed) +
           " missed by the subscriber, " + std::to_string(excused) + " dropped by sockets; ";
  }
  FAIL() << why;
}

/// @return the text of the next event that reports the loss of a wire, with the reason.
std::string reason_of_the_loss(Probe& probe) {
  const auto lost = probe.event([](const msg::Event& event) {
    return event.kind == msg::EventKind::wire && event.code == 1;
  });
  return lost ? lost->text.to_string() : "";
}

TEST(Engine, SurvivesADatagramThatEndsItsWire) {
  Bench bench({"--without-guard"});
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  ASSERT_TRUE(probe.wait_until([&] {
    return probe.seen_status().has_value();
  }));
  Attacker().send_to_discovery(statistics_with_more_behind({1, 15, 1}));
  EXPECT_LT(time_to_next_status(probe), 5s);
  EXPECT_NE(reason_of_the_loss(probe).find("signal 6"), std::string::npos);
}

// The discovery thread spins and consumes memory; whichever limit is reached first ends the wire.
TEST(Engine, EndsAWireWhoseDiscoveryHasFailed) {
  Bench bench({"--without-guard"});
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  const auto begin = Clock::now();
  Attacker().send_to_discovery(gap_without_end(probe.source().participant));
  const std::string reason = reason_of_the_loss(probe);
  // 4 s without a probe arriving, or 512 MiB; two more seconds are for a slow machine.
  EXPECT_LT(Clock::now() - begin, 7s);
  EXPECT_TRUE(reason.find("no test sample arrived") != std::string::npos ||
              reason.find("memory") != std::string::npos)
      << reason;
  EXPECT_TRUE(Probe(test_domain()).find_bench()) << "and the next wire discovers";
}

// The library allocates memory for each sequence number of an RTPS GAP, so the memory limit is
// reached long before a probe is missed.
TEST(Engine, EndsAWireThatLeaks) {
  const TemporaryDirectory directory;
  const auto configuration = directory.path() / "bench.yaml";
  std::ofstream(configuration) << "wire: {memory_limit_mib: 64}\n";
  Bench bench({"--without-guard", "--config", configuration.string()});
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  const auto begin = Clock::now();
  Attacker().send_to_discovery(gap_without_end(probe.source().participant));
  EXPECT_THAT(reason_of_the_loss(probe), testing::HasSubstr("memory"));
  EXPECT_LT(Clock::now() - begin, 5s);
  EXPECT_TRUE(Probe(test_domain()).find_bench()) << "and the next wire discovers";
}

// Each client has its own limit of waiting answers. The hanging programs would use up a common one.
TEST(Engine, AnswersOtherClientsWhileEightProgramsHang) {
  constexpr std::uint64_t kRequests = 3'000;
  Bench bench({"--axes", "2"});
  std::vector<std::unique_ptr<Process>> programs;
  for (int number = 0; number < 8; ++number) {
    programs.push_back(std::make_unique<Process>(
        VDRIVE_TOOL, std::vector<std::string>{"--domain", std::to_string(test_domain()), "--json",
                                              "watch", "1.1"}));
  }
  for (const auto& program : programs) ASSERT_NE(program->read_line(), "") << "it is in";
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  for (const auto& program : programs) program->send(SIGSTOP);
  for (std::uint64_t number = 0; number < kRequests; ++number) {
    ASSERT_TRUE(probe.read(1, 0x6041).has_value()) << "request " << number;
  }
}

TEST(Engine, StepsThroughANewWireInLockStep) {
  Bench bench({"--axes", "2", "--clock", "lockstep"});
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  ASSERT_TRUE(probe.step(5).has_value());
  send_signal(bench.wire(), SIGKILL);
  ASSERT_TRUE(probe.event(is_restart).has_value());
  ASSERT_TRUE(probe.find_bench());
  const auto reply = probe.step(1);
  ASSERT_TRUE(reply.has_value());
  EXPECT_EQ(reply->tick, 6U);
}

TEST(Engine, HasNoNetworkAccessAndItsWireNoFileAccess) {
  Bench bench;
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  const auto is_filtered = [](pid_t process) {
    return text_of("/proc/" + std::to_string(process) + "/status").find("Seccomp:\t2") !=
           std::string::npos;
  };
  EXPECT_TRUE(is_filtered(bench.engine()));
  EXPECT_TRUE(is_filtered(bench.wire()));
  EXPECT_FALSE(is_filtered(bench.spawner())) << "it starts the next wire";
}

TEST(Engine, LeavesNoProcessBehindAndEndsInTimeWhenItsWireHangs) {
  Bench bench;
  Probe probe(test_domain());
  ASSERT_TRUE(probe.find_bench());
  const pid_t spawner = bench.spawner();
  const pid_t wire = bench.wire();
  send_signal(wire, SIGSTOP);
  const auto [finished, time] = bench.end();
  EXPECT_EQ(finished.code, 0) << finished.errors;
  EXPECT_LE(time, 2s);
  EXPECT_TRUE(holds_soon([&] {
    return !exists(wire) && !exists(spawner);
  }));
}

TEST(Engine, EndsItsWireWhenItIsKilled) {
  pid_t spawner = 0;
  pid_t wire = 0;
  {
    Bench bench;
    Probe probe(test_domain());
    ASSERT_TRUE(probe.find_bench());
    spawner = bench.spawner();
    wire = bench.wire();
  }
  EXPECT_TRUE(holds_soon([&] {
    return !exists(wire) && !exists(spawner);
  }));
}

}  // namespace
}  // namespace vdrive::test
