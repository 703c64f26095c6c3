// SPDX-License-Identifier: Apache-2.0
// Calls, moves and reports whose service ends, freezes or restarts.
#include "client/reports.hpp"
#include "client/session_options.hpp"
#include "tool/process.hpp"
#include "vdrive/client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <vector>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::options;
using test::options_of_a_loss;
using test::RunningService;
using testing::HasSubstr;

TEST(LostService, EndsAWaitingCall) {
  RunningService service("--clock realtime");
  Session sut(options_of_a_loss());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis->enable());
  auto moving = std::async(std::launch::async, [&] {
    return axis->move_to(1'000'000, {.velocity = 1, .call = {}});
  });
  ASSERT_TRUE(axis->wait_until(
      [](const AxisSnapshot& seen) {
        return seen.status.velocity_demand_value != 0;
      },
      20s));
  service.kill();
  EXPECT_EQ(moving.get().kind(), OutcomeKind::lost);
}

TEST(ServiceThatShutsDown, IsTheReasonWhyAMoveOfAGroupFails) {
  RunningService service("--clock realtime --axes 2");
  Session session(options());
  auto group = AxisGroup::create(session, std::vector<std::string>{"1.1", "1.2"});
  ASSERT_TRUE(group->enable_all());
  std::future<void> stopped;
  GroupCallOptions call;
  call.progress = [&](const GroupProgress& seen) {
    if (seen.fraction == 0.0 || stopped.valid()) return;
    stopped = std::async(std::launch::async, [&service] {
      service.stop();
    });
  };
  const Outcome lost = group->move_together(Eigen::Vector2d(300'000, 300'000), {.call = call});
  EXPECT_EQ(lost.kind(), OutcomeKind::lost);
  EXPECT_THAT(lost.message(),
              testing::AnyOf(HasSubstr("bench 1 is shutting down: its service brakes the axes"),
                             HasSubstr("bench 1 went offline: its service has ended")));
  EXPECT_THAT(lost.message(), testing::Not(HasSubstr("did not stop")));
}

TEST(RestartedService, IsADifferentServiceToTheSession) {
  auto service = std::make_unique<RunningService>("--clock lockstep");
  Session sut(options());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis->enable());
  service->stop();
  service = std::make_unique<RunningService>("--clock lockstep");
  const auto status = axis->status();
  ASSERT_TRUE(status) << status.outcome().message();
  EXPECT_EQ(status->state(), PowerState::switch_on_disabled);
  EXPECT_TRUE(axis->enable()) << "control is taken anew";
}

TEST(TwoServices, ALostServiceStopsTheAxesOfTheOther) {
  const RunningService left("--clock lockstep --axes 1");
  RunningService right("--clock lockstep --bench 2 --axes 1");
  Session session(options_of_a_loss());
  auto group = AxisGroup::create(session, std::vector<std::string>{"1.1", "2.1"});
  ASSERT_TRUE(group->enable_all());
  GroupCallOptions call;
  bool killed = false;
  call.progress = [&](const GroupProgress& seen) {
    if (seen.fraction > 0.3 && !killed) {
      killed = true;
      right.kill();
    }
  };
  const Outcome lost = group->move_together(Eigen::Vector2d(300'000, 300'000), {.call = call});
  EXPECT_EQ(lost.kind(), OutcomeKind::lost) << lost.message();
  EXPECT_THAT(lost.message(), HasSubstr("bench 2"));
  const auto other = session.axis("1.1")->status();
  EXPECT_NE(other->state(), PowerState::operation_enabled);
  EXPECT_EQ(other->status.velocity_demand_value, 0);
}

// The service freezes during the jog, and the program ends before the service continues.
TEST(EndOfAJog, OfALostBenchLeavesTheAxisToTheWatchdog) {
  const RunningService service("");
  {
    Session session(options());
    Axis axis = session.axis("1.1").value();
    ASSERT_TRUE(axis.enable());
    const Outcome lost = axis.jog(10'000, [&](const AxisSnapshot& seen) {
      if (seen.status.velocity_demand_value == 10'000) service.freeze();
      return true;
    });
    EXPECT_EQ(lost.kind(), OutcomeKind::lost) << lost.message();
  }
  service.thaw();
  Session watcher(options());
  const auto stopped = watcher.axis("1.1").value().wait_until(
      [](const AxisSnapshot& seen) {
        return seen.state() == PowerState::fault && seen.status.velocity_demand_value == 0;
      },
      20s);
  EXPECT_TRUE(stopped) << stopped.outcome().message();
}

TEST(OnStatus, ContinuesAfterARestartOfTheService) {
  RunningService service("");
  Session session(options());
  test::Reports reports;
  const std::vector<AxisId> axes{{1, 1}};
  ASSERT_TRUE(session.on_status(axes, 5ms, reports.keeper()));
  ASSERT_TRUE(reports.wait_for(3));
  service.kill();
  const std::size_t before = reports.count();
  const RunningService again("");
  // At most one report of the first run may still have been on its way.
  EXPECT_TRUE(reports.wait_for(before + 5));
}

}  // namespace
}  // namespace vdrive::client
