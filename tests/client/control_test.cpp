// SPDX-License-Identifier: Apache-2.0
// Which session has control when programs end, hang or resume late; with real services and clients.
#include "client/session_options.hpp"
#include "service/probe.hpp"
#include "support/deadline.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <array>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::options;
using test::Probe;
using test::Process;
using test::RunningService;

constexpr std::uint64_t kWatchdog = 500;  // [ticks] of 1 ms, the default
constexpr std::uint16_t kConnectionLost = 0x8130;
// If the machine stalls for half a second, every session is lost and the run proves nothing.
constexpr int kAttempts = 5;

/// Ticks of a bench in real time are milliseconds since 1970.
std::uint64_t tick_now() {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::milliseconds>(
                                        std::chrono::system_clock::now().time_since_epoch())
                                        .count());
}

bool in_fault(const AxisSnapshot& axis) {
  return axis.state() == PowerState::fault_reaction_active || axis.state() == PowerState::fault;
}

/// Another program that enables axis 1.1 and moves it back and forth.
class Master {
 public:
  Master()
      : process_(VDRIVE_NETWORK_CLIENT,
                 {"--domain", std::to_string(test::test_domain()), "cycle", "1.1"}) {}

  void send(int signal) const { process_.send(signal); }

  /// Reads its output until a move has ended. @return whether the move succeeded.
  [[nodiscard]] bool has_moved() {
    for (std::string line = process_.read_line(); !line.empty(); line = process_.read_line()) {
      const auto printed = nlohmann::json::parse(line);
      if (printed.value("call", "") == "move") return printed["outcome"] == "ok";
    }
    return false;
  }

 private:
  Process process_;
};

/// Sessions that each own one axis, from 1.2 on.
class Bystanders {
 public:
  explicit Bystanders(int count) {
    for (int i = 0; i < count; ++i) {
      sessions_.push_back(std::make_unique<Session>(options()));
      auto axis = sessions_.back()->axis("1." + std::to_string(i + 2));
      if (!axis) throw std::runtime_error(axis.outcome().message());
      axes_.push_back(*axis);
    }
  }

  /// Enables the axes of all sessions. @return whether that succeeded.
  [[nodiscard]] bool enable() {
    for (Axis& axis : axes_) {
      if (!axis.reset_fault() || !axis.enable()) return false;
    }
    return true;
  }

  [[nodiscard]] bool are_unharmed() {
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const auto status = axes_[i].status();
      if (!status || status->state() != PowerState::operation_enabled ||
          status->owner_session != sessions_[i]->id()) {
        return false;
      }
    }
    return true;
  }

 private:
  std::vector<std::unique_ptr<Session>> sessions_;
  std::vector<Axis> axes_;
};

/// How the axis reacts to a signal sent to the master that moves it.
struct Loss {
  std::uint64_t signalled = 0;  ///< tick of the signal, or a later one
  AxisSnapshot fault;
  AxisSnapshot rest;
};

std::optional<Loss> lose(const Master& master, Axis& axis, int signal) {
  Loss loss;
  master.send(signal);
  loss.signalled = tick_now();
  const auto fault = axis.wait_until(in_fault, 5s);
  if (!fault) return std::nullopt;
  loss.fault = *fault;
  const auto rest = axis.wait_until(
      [](const AxisSnapshot& seen) {
        return seen.state() == PowerState::fault && seen.status.velocity_demand_value == 0;
      },
      5s);
  if (!rest) return std::nullopt;
  loss.rest = *rest;
  return loss;
}

/// @return whether the bystanders kept their axes and the reaction was in time; false may be due to
///         a busy machine.
bool lose_among_bystanders(int signal) {
  const RunningService service("--clock realtime --axes 6");
  Session observer(options());
  auto found = observer.axis("1.1");
  if (!found) throw std::runtime_error("observer " + found.outcome().message());
  Axis axis = *found;
  Bystanders bystanders(5);
  Master master;
  if (!bystanders.enable() || !master.has_moved()) return false;
  const auto loss = lose(master, axis, signal);
  EXPECT_TRUE(loss);
  if (!loss || !observer.wait(1, 200ms) || !bystanders.are_unharmed()) return false;
  EXPECT_EQ(loss->rest.status.error_code, kConnectionLost);
  EXPECT_EQ(loss->rest.owner_session, 0U);
  // The last message of the master precedes the signal. The reaction takes the time-out and two
  // ticks.
  const bool in_time = loss->fault.tick <= loss->signalled + kWatchdog + 2;
  // A session sends its keep-alive every 25 ms, so its last one was sent at most that long before.
  EXPECT_GE(loss->fault.tick, loss->signalled + kWatchdog - 50) << "a reaction without cause";
  // No axis resumes by itself while time passes and other sessions work.
  EXPECT_TRUE(observer.wait(1, 500ms));
  const auto later = axis.status();
  EXPECT_EQ(later->state(), PowerState::fault);
  EXPECT_EQ(later->status.load_position_actual_value, loss->rest.status.load_position_actual_value);
  return in_time;
}

class SilentMaster : public testing::TestWithParam<int> {};

TEST_P(SilentMaster, LosesItsAxisInTimeAndNoOtherMasterDoes) {
  bool passed = false;
  for (int attempt = 0; attempt < kAttempts && !passed; ++attempt) {
    passed = lose_among_bystanders(GetParam());
  }
  EXPECT_TRUE(passed) << "five times of five";
}

INSTANTIATE_TEST_SUITE_P(Signals, SilentMaster, testing::Values(SIGKILL, SIGSTOP),
                         [](const auto& value) {
                           return std::string(value.param == SIGKILL ? "Killed" : "Stopped");
                         });

/// @return whether this session kept its axis; false may be due to a busy machine.
bool wake_the_old_master() {
  const RunningService service("--clock realtime --axes 1");
  Session sut(options());
  Axis axis = *sut.axis("1.1");
  Master old;
  if (!old.has_moved()) return false;
  if (!lose(old, axis, SIGSTOP)) return false;
  if (!axis.reset_fault() || !axis.enable() || !axis.move_to(12'345)) return false;
  const auto before = axis.status();
  old.send(SIGCONT);
  // It resumes where it stopped: with old messages, new messages, and a request for the axis.
  const auto disturbed = axis.wait_until(
      [&](const AxisSnapshot& seen) {
        return seen.owner_session != sut.id() || seen.status.position_demand_value != 12'345 ||
               seen.state() != PowerState::operation_enabled;
      },
      1s);
  if (disturbed && disturbed->status.error_code == kConnectionLost) return false;
  EXPECT_EQ(disturbed.outcome().kind(), OutcomeKind::timed_out) << "the old master moved the axis";
  EXPECT_EQ(axis.status()->owner_epoch, before->owner_epoch);
  return true;
}

TEST(OldMaster, ChangesNothingWhenItResumes) {
  bool passed = false;
  for (int attempt = 0; attempt < kAttempts && !passed; ++attempt) passed = wake_the_old_master();
  EXPECT_TRUE(passed) << "five times of five";
}

TEST(OldMaster, ChangesNothingAfterARestartOfTheService) {
  auto service = std::make_unique<RunningService>("--clock lockstep --axes 1");
  Probe old(test::test_domain());
  ASSERT_TRUE(old.find_bench());
  ASSERT_TRUE(old.acquire({1}));
  const std::uint64_t first_run = old.incarnation;
  service->kill();
  service = std::make_unique<RunningService>("--clock lockstep --axes 1");
  auto present = std::make_unique<Probe>(test::test_domain());
  ASSERT_TRUE(present->find_bench());
  ASSERT_NE(present->incarnation, first_run);
  // A new run starts counting epochs again, so the epoch of the old session may be in force again.
  present->session = 0x9999;
  ASSERT_TRUE(present->acquire({1}));
  EXPECT_EQ(present->epoch, old.epoch);
  for (const std::uint16_t word : std::array<std::uint16_t, 3>{0x06, 0x07, 0x0F}) {
    auto frame = old.make_frame();
    auto& command = frame.axes.emplace_back();
    command.axis = 1;
    command.members = msg::HAS_DS402_CONTROLWORD;
    command.ds402_controlword = word;
    ASSERT_TRUE(old.send(frame));
    const auto reply = old.reply_to(frame.sequence_number);
    ASSERT_TRUE(reply) << "a refusal is answered";
    ASSERT_FALSE(reply->refusals.empty());
    EXPECT_EQ(reply->refusals[0].reason, msg::Reason::wrong_incarnation);
  }
  ASSERT_TRUE(present->step(3));
  const auto statusword = present->read(1, 0x6041);
  ASSERT_TRUE(statusword);
  EXPECT_EQ(statusword->objects[0].value, 0x250) << "after a restart axes are disabled";
}

/// Records the changes of services that a session reports, in order.
class News {
 public:
  void operator()(const ServiceChange& change) {
    const std::scoped_lock lock(mutex_);
    told_.push_back(change);
    changed_.notify_all();
  }

  /// Waits for the next such change. @return nothing after 10 s.
  std::optional<ServiceChange> next(ServiceNews wanted) {
    std::unique_lock lock(mutex_);
    constexpr auto kPatience = 10s;
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (true) {
      for (; looked_ < told_.size(); ++looked_) {
        if (told_[looked_].news == wanted) return told_[looked_++];
      }
      if (changed_.wait_until(lock, deadline) == std::cv_status::timeout) {
        test::report_missed_deadline("the news did not come", kPatience);
        return std::nullopt;
      }
    }
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<ServiceChange> told_;
  std::size_t looked_ = 0;
};

/// @return whether a silence was reported in time.
bool watch_a_service_die(Session& session, News& news, std::unique_ptr<RunningService>& service) {
  service->kill();
  const auto silent = news.next(ServiceNews::fell_silent);
  EXPECT_TRUE(silent);
  const bool in_time = silent && silent->silence <= 100ms;
  service = std::make_unique<RunningService>("--clock realtime --axes 1");
  const auto back = std::chrono::steady_clock::now();
  EXPECT_TRUE(news.next(ServiceNews::restarted));
  auto axis = session.axis("1.1");
  EXPECT_TRUE(axis && axis->enable());
  EXPECT_LT(std::chrono::steady_clock::now() - back, 2s);
  return in_time;
}

TEST(WatchedService, IsReportedLostWithin100MillisecondsAndFoundAgainWithin2Seconds) {
  auto service = std::make_unique<RunningService>("--clock realtime --axes 1");
  News news;
  Session sut(options());
  sut.watch_services(std::ref(news));
  ASSERT_TRUE(news.next(ServiceNews::found));
  bool in_time = false;
  for (int attempt = 0; attempt < kAttempts && !in_time; ++attempt) {
    in_time = watch_a_service_die(sut, news, service);
  }
  EXPECT_TRUE(in_time) << "reported late in five of five attempts";
  service->stop();
  EXPECT_TRUE(news.next(ServiceNews::went_offline));
}

}  // namespace
}  // namespace vdrive::client
