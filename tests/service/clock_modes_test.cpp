// SPDX-License-Identifier: Apache-2.0
// The clock modes over real DDS: steppers of a lock-step bench, the rate of realtime, freerun.
#include "program/service.hpp"
#include "service/bench_configuration.hpp"
#include "service/probe.hpp"
#include "support/test_domain.hpp"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <future>
#include <utility>

namespace vdrive::test {
namespace {

/// A lock-step service and two clients that found it.
struct TwoClients {
  TwoClients()
      : service(configuration(service::ClockMode::lockstep, 2)),
        alice(test_domain()),
        bob(test_domain()) {
    alice.client = alice.session = 0xA11CE;
    bob.client = bob.session = 0xB0B;
    service.start();
    found = alice.find_bench() && bob.find_bench();
  }

  static std::optional<msg::Reply> join(Probe& who) {
    return who.exchange(who.make_request(msg::RequestKind::join_clock));
  }

  /// @return whether both have found the service and have joined its clock.
  bool join_both() {
    const auto has_joined = [](Probe& who) {
      const auto reply = join(who);
      return reply && reply->reason == msg::Reason::none;
    };
    return found && has_joined(alice) && has_joined(bob);
  }

  static std::optional<msg::Reply> leave(Probe& who) {
    return who.exchange(who.make_request(msg::RequestKind::leave_clock));
  }

  /// Steps without waiting for the answer.
  static std::future<std::optional<msg::Reply>> begin_step(Probe& who, std::uint64_t ticks) {
    return std::async(std::launch::async, [&who, ticks] {
      return who.step(ticks, {1, 2});
    });
  }

  service::Service service;
  Probe alice;
  Probe bob;
  bool found = false;
};

TEST(Steppers, AdvanceTimeToTheSmallestGrant) {
  TwoClients two;
  ASSERT_TRUE(two.join_both());
  auto alices = two.begin_step(two.alice, 10);
  const auto bobs = two.bob.step(4);
  ASSERT_TRUE(bobs);
  EXPECT_EQ(bobs->reason, msg::Reason::none);
  EXPECT_EQ(bobs->tick, 4U) << "answered in its tick";
  const auto last = two.bob.step(6);
  const auto first = alices.get();
  ASSERT_TRUE(first && last);
  EXPECT_EQ(first->reason, msg::Reason::none);
  EXPECT_EQ(first->tick, 10U);
  EXPECT_EQ(last->tick, 10U);
  EXPECT_EQ(first->statuses.size(), 2U);
}

TEST(Steppers, ThatWaitReceiveTheTickReachedWhenTheServiceEnds) {
  TwoClients two;
  ASSERT_TRUE(two.join_both());
  auto alices = two.begin_step(two.alice, 10);
  ASSERT_TRUE(two.bob.step(4));
  two.service.stop();
  const auto answer = alices.get();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->reason, msg::Reason::shutting_down);
  EXPECT_EQ(answer->tick, 4U) << "bob has granted 4 of the 10";
}

TEST(Steppers, ReceiveTheMissingSessionAfterASecondAndKeepTheirGrant) {
  TwoClients two;
  ASSERT_TRUE(two.join_both());
  ASSERT_TRUE(two.bob.wait_until([&] {
    const auto& state = two.bob.seen_state();
    return state && state->steppers == 2;
  }));
  auto waiting = two.begin_step(two.alice, 10);
  EXPECT_TRUE(two.bob.read(1, 0x6041)) << "others are answered meanwhile";
  const auto missing = waiting.get();
  ASSERT_TRUE(missing);
  EXPECT_EQ(missing->reason, msg::Reason::missing_stepper);
  EXPECT_EQ(missing->missing_stepper, two.bob.session);
  EXPECT_EQ(missing->tick, 0U);
  EXPECT_TRUE(two.bob.wait_until([&] {
    return two.bob.seen_state()->slowest_stepper == two.bob.session;
  }));
  auto again = two.begin_step(two.alice, 0);
  EXPECT_EQ(two.bob.step(10)->tick, 10U);
  EXPECT_EQ(again.get()->tick, 10U) << "the ten ticks were granted before";
}

TEST(Steppers, ControlTheClockExclusivelyUntilTheyLeave) {
  TwoClients two;
  ASSERT_TRUE(two.found);
  ASSERT_TRUE(two.join(two.alice));
  EXPECT_EQ(two.bob.step(1)->reason, msg::Reason::not_a_stepper);
  EXPECT_EQ(two.bob.step(0, {1})->statuses.size(), 1U) << "any session may observe";
  EXPECT_EQ(two.leave(two.bob)->reason, msg::Reason::not_a_stepper);
  EXPECT_EQ(two.alice.step(3)->tick, 3U);
  EXPECT_EQ(two.leave(two.alice)->reason, msg::Reason::none);
  EXPECT_EQ(two.bob.step(2)->tick, 5U);
  EXPECT_TRUE(two.bob.event([](const auto& event) {
    return event.kind == msg::EventKind::clock_changed &&
           event.code == wire::number(msg::RequestKind::leave_clock) &&
           event.text.to_string().find("left the clock") != std::string::npos;
  }));
}

TEST(Steppers, ContinueWhenTheMissingStepperLeaves) {
  TwoClients two;
  ASSERT_TRUE(two.join_both());
  auto waiting = two.begin_step(two.alice, 5);
  ASSERT_TRUE(two.leave(two.bob));
  EXPECT_EQ(waiting.get()->tick, 5U);
}

TEST(Steppers, WaitForTheFramesOfEachSession) {
  TwoClients two;
  ASSERT_TRUE(two.found);
  ASSERT_TRUE(two.join(two.alice));
  ASSERT_TRUE(two.alice.acquire({1}));
  two.alice.last_sequence = 3;  // never sent
  const auto reply = two.alice.step(1);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->reason, msg::Reason::missing_commands);
  two.alice.last_sequence = 0;
  EXPECT_EQ(two.alice.step(1)->tick, 1U) << "the other step has granted nothing";
}

// 100 ms without a message would release the axes: a stepper counts as alive in each granted tick.
TEST(Steppers, CountAsAliveInEachGrantedTick) {
  TwoClients two;
  ASSERT_TRUE(two.join_both());
  ASSERT_TRUE(two.alice.acquire({1}));
  ASSERT_TRUE(two.bob.acquire({2}));
  auto alices = two.begin_step(two.alice, 1'000);
  ASSERT_EQ(two.bob.step(1'000)->tick, 1'000U);
  ASSERT_TRUE(alices.get());
  EXPECT_EQ(two.service.counters().master_losses.get(), 0U);
}

/// Enables the client's axis in profile position mode and names the frame that starts its move.
msg::CommandFrame aim(Probe& who, std::uint16_t axis, std::uint64_t tick) {
  auto frame = who.make_frame();
  frame.apply_at_tick = tick;
  auto& command = frame.axes.emplace_back();
  command.axis = axis;
  command.members = msg::HAS_POSITION_USER_TARGET_VALUE | msg::HAS_DS402_CONTROLWORD;
  command.position_user_target_value = 10'000;
  command.ds402_controlword = 0x3F;
  return frame;
}

// Both start at tick 50 from rest: the demand velocity is 0 through tick 49 and not in tick 50.
TEST(TwoClientsWithAnAxisEach, StartInTheTickThatBothAimAt) {
  TwoClients two;
  ASSERT_TRUE(two.found);
  ASSERT_TRUE(two.alice.acquire({1}));
  ASSERT_TRUE(two.bob.acquire({2}));
  for (const auto& [who, axis] : {std::pair(&two.alice, 1), std::pair(&two.bob, 2)}) {
    const auto number = static_cast<std::uint16_t>(axis);
    ASSERT_TRUE(who->write(number, 0x6060, 1));
    ASSERT_TRUE(who->write(number, 0x6040, 0x0F));
  }
  ASSERT_EQ(two.alice.step(10)->tick, 10U);
  ASSERT_TRUE(two.alice.send(aim(two.alice, 1, 50)));
  ASSERT_TRUE(two.bob.send(aim(two.bob, 2, 50)));
  ASSERT_EQ(two.bob.step(0)->reason, msg::Reason::none) << "his frame has arrived";
  const auto before = two.alice.step(39, {1, 2});
  ASSERT_EQ(before->tick, 49U);
  EXPECT_EQ(before->statuses.at(0).velocity_demand_value, 0);
  EXPECT_EQ(before->statuses.at(1).velocity_demand_value, 0);
  const auto begun = two.alice.step(1, {1, 2});
  EXPECT_GT(begun->statuses.at(0).velocity_demand_value, 0);
  EXPECT_EQ(begun->statuses.at(0).velocity_demand_value,
            begun->statuses.at(1).velocity_demand_value);
}

TEST(FreerunService, RunsFasterThanRealTimeAndShowsIt) {
  service::Service service(configuration(service::ClockMode::freerun, 2));
  Probe probe(test_domain());
  service.start();
  ASSERT_TRUE(probe.find_bench());
  ASSERT_TRUE(probe.wait_until([&] {
    const auto& state = probe.seen_state();
    return state && state->clock_mode == msg::ClockMode::freerun && state->measured_rate > 1.0;
  }));
  ASSERT_TRUE(probe.wait_until([&] {
    return probe.seen_status().has_value();
  }));
  EXPECT_EQ(probe.read(1, 0x6041)->objects.at(0).value, 0x250);
  EXPECT_EQ(probe.step(1)->reason, msg::Reason::wrong_clock_mode);
  ASSERT_TRUE(probe.write(1, 0x6040, 0x0F));
  const auto tick = probe.status()->tick;
  ASSERT_TRUE(probe.wait_until([&] {
    return probe.seen_status()->tick > tick + 10'000;
  }));
  EXPECT_EQ(service.counters().master_losses.get(), 0U) << "no watchdog";
}

TEST(RealtimeService, PausesForAllSessionsAndNamesTheRequester) {
  service::Service service(configuration(service::ClockMode::realtime, 1));
  Probe probe(test_domain());
  service.start();
  ASSERT_TRUE(probe.find_bench());
  auto pause = probe.make_request(msg::RequestKind::set_rate);
  pause.rate = 0.0;
  const auto paused = probe.exchange(pause);
  ASSERT_TRUE(paused);
  EXPECT_EQ(paused->reason, msg::Reason::none);
  ASSERT_TRUE(probe.wait_until([&] {
    const auto& state = probe.seen_state();
    return state && state->rate == 0.0;
  }));
  EXPECT_EQ(service.counters().tick.get(), paused->tick);
  const auto event = probe.event([](const auto& seen) {
    return seen.kind == msg::EventKind::clock_changed;
  });
  ASSERT_TRUE(event);
  EXPECT_EQ(event->session, probe.session);
  EXPECT_NE(event->text.to_string().find("paused"), std::string::npos);
  auto resume = probe.make_request(msg::RequestKind::set_rate);
  resume.rate = 1.0;
  ASSERT_EQ(probe.exchange(resume)->reason, msg::Reason::none);
  EXPECT_TRUE(probe.wait_until([&] {
    return probe.seen_state()->rate == 1.0 && probe.seen_state()->tick > paused->tick;
  }));
}

}  // namespace
}  // namespace vdrive::test
