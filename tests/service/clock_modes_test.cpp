// SPDX-License-Identifier: Apache-2.0
// The clock modes over real DDS: steppers of a lock-step bench, the rate of realtime, freerun.
#include "program/service.hpp"
#include "service/bench_configuration.hpp"
#include "service/probe.hpp"
#include "support/test_domain.hpp"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <future>
#include <optional>

namespace vdrive::test {
namespace {

/// A lock-step service and two clients that have found it.
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

  /// @return whether both have found the service and joined its clock.
  bool join_both() {
    const auto has_joined = [](Probe& who) {
      const auto reply = who.exchange(who.make_request(msg::RequestKind::join_clock));
      return reply && reply->reason == msg::Reason::none;
    };
    return found && has_joined(alice) && has_joined(bob);
  }

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
