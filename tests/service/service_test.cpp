// SPDX-License-Identifier: Apache-2.0
// The service over real DDS, in this process, with clients made of bare topics.
#include "program/service.hpp"

#include "service/bench_configuration.hpp"
#include "service/probe.hpp"
#include "support/test_domain.hpp"

#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <limits>
#include <random>
#include <utility>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;

/// A running service and a client that has found it.
struct Running {
  explicit Running(service::Configuration with) : service(std::move(with)), probe(test_domain()) {
    service.start();
    found = probe.find_bench();
  }

  service::Service service;
  Probe probe;
  bool found = false;
};

TEST(LockstepService, EnablesAnAxisInOneStep) {
  Running bench(configuration(service::ClockMode::lockstep, 2));
  ASSERT_TRUE(bench.found);
  const auto written = bench.probe.write(1, 0x6040, 0x0F);
  ASSERT_TRUE(written);
  EXPECT_EQ(written->objects.at(0).abort_code, msg::Reason::none);
  EXPECT_EQ(written->tick, 1U);
  const auto stepped = bench.probe.step(1, {1, 2});
  ASSERT_TRUE(stepped);
  EXPECT_EQ(stepped->reason, msg::Reason::none);
  EXPECT_EQ(stepped->tick, 1U);
  ASSERT_EQ(stepped->statuses.size(), 2U);
  EXPECT_EQ(stepped->statuses[0].ds402_statusword & 0x6F, 0x27);
  EXPECT_EQ(stepped->statuses[0].owner_session, bench.probe.session);
  EXPECT_EQ(stepped->statuses[1].ds402_statusword, 0x250);
}

TEST(LockstepService, StepsOnlyWithTheFramesThatWereSentBefore) {
  Running bench(configuration(service::ClockMode::lockstep, 1));
  ASSERT_TRUE(bench.found);
  ASSERT_TRUE(bench.probe.acquire({1}));
  for (int round = 0; round < 200; ++round) {
    auto frame = bench.probe.make_frame();
    frame.flags = 0;
    auto& command = frame.axes.emplace_back();
    command.axis = 1;
    command.members = msg::HAS_POSITION_USER_TARGET_VALUE;
    command.position_user_target_value = round;
    ASSERT_TRUE(bench.probe.send(frame));
    const auto reply = bench.probe.step(1, {1});
    ASSERT_TRUE(reply);
    ASSERT_EQ(reply->reason, msg::Reason::none);
    ASSERT_EQ(reply->statuses.at(0).last_sequence, frame.sequence_number);
  }
}

TEST(LockstepService, KeepsTheOrderOfRequestsAroundALongStep) {
  Running bench(configuration(service::ClockMode::lockstep, 4));
  ASSERT_TRUE(bench.found);
  const auto first = bench.probe.step(50'000);
  const auto second = bench.probe.read(1, 0x6041);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->tick, 50'000U);
  EXPECT_EQ(second->tick, 50'000U);
}

TEST(LockstepService, PublishesTheLastTickOfEveryStep) {
  Running bench(configuration(service::ClockMode::lockstep, 300));
  ASSERT_TRUE(bench.found);
  ASSERT_TRUE(bench.probe.step(2'000));
  ASSERT_TRUE(bench.probe.step(7));
  EXPECT_TRUE(bench.probe.wait_until([&] {
    const auto& last = bench.probe.seen_status();
    return last && last->tick == 2'007 && last->parts == 2 && last->part == 1;
  }));
}

TEST(RealtimeService, PublishesEveryTick) {
  Running bench(configuration(service::ClockMode::realtime, 2));
  ASSERT_TRUE(bench.found);
  ASSERT_TRUE(bench.probe.wait_until([&] {
    return bench.probe.seen_status().has_value();
  }));
  const auto first = bench.probe.status();
  EXPECT_EQ(first->incarnation, bench.service.identity().incarnation);
  EXPECT_EQ(first->axes.size(), 2U);
  EXPECT_EQ(first->time_ns, static_cast<std::int64_t>(first->tick) * 1'000'000);
  EXPECT_TRUE(bench.probe.wait_until([&] {
    return bench.probe.seen_status()->tick >= first->tick + 100;
  }));
}

TEST(Service, DescribesTheBenchInParts) {
  Running bench(configuration(service::ClockMode::realtime, 600));
  ASSERT_TRUE(bench.found);
  ASSERT_TRUE(bench.probe.wait_until([&] {
    return bench.probe.seen_descriptions().size() >= 3;
  }));
  std::size_t axes = 0;
  for (const auto& part : bench.probe.descriptions()) {
    EXPECT_EQ(part.parts, 3U);
    EXPECT_EQ(part.axis_count, 600U);
    EXPECT_EQ(part.period_us, 1'000U);
    EXPECT_TRUE(part.alive);
    EXPECT_EQ(part.clock_mode, msg::ClockMode::realtime);
    EXPECT_EQ(part.axes.front().axis, part.part * 256 + 1);
    EXPECT_EQ(part.axes.front().unit_kind, msg::UnitKind::rotary);
    EXPECT_EQ(part.axes.front().unit_name.to_string(), "deg");
    EXPECT_EQ(part.axes.front().unit_size, 4'096.0);
    axes += part.axes.size();
  }
  EXPECT_EQ(axes, 600U);
}

TEST(Service, PublishesTheParametersOfEveryAxisAndTheirChanges) {
  Running bench(configuration(service::ClockMode::lockstep, 50));
  ASSERT_TRUE(bench.found);
  ASSERT_TRUE(bench.probe.wait_until([&] {
    return bench.probe.seen_parameters() >= 50;
  }));
  ASSERT_TRUE(bench.probe.write(7, 0x6081, 4'321));
  EXPECT_TRUE(bench.probe.wait_until([&] {
    return bench.probe.seen_parameters() >= 51;
  }));
}

TEST(Service, PublishesItsStateTwentyTimesASecond) {
  Running bench(configuration(service::ClockMode::lockstep, 1));
  ASSERT_TRUE(bench.found);
  ASSERT_TRUE(bench.probe.step(123));
  EXPECT_TRUE(bench.probe.wait_until([&] {
    const auto& state = bench.probe.seen_state();
    return state && state->tick == 123 && state->requests_answered >= 1;
  }));
}

TEST(Service, GoesOfflineWhenItStops) {
  Running bench(configuration(service::ClockMode::realtime, 1));
  ASSERT_TRUE(bench.found);
  bench.service.stop();
  EXPECT_TRUE(bench.probe.wait_until([&] {
    return bench.probe.seen_offline();
  }));
  bench.service.stop();  // a second stop is harmless
}

TEST(Service, RefusesAConfigurationOutsideItsLimits) {
  auto with = configuration(service::ClockMode::realtime, 1);
  with.period = 1us;
  EXPECT_THROW(service::Service{with}, service::ConfigurationError);
}

TEST(Service, EndsWhenAnOlderServiceHasItsBenchNumber) {
  Running older(configuration(service::ClockMode::lockstep, 1));
  ASSERT_TRUE(older.found);
  service::Service younger(configuration(service::ClockMode::lockstep, 1));
  EXPECT_THROW(younger.start(), service::BenchNumberTaken);
  EXPECT_FALSE(older.service.conflict());
  EXPECT_TRUE(older.probe.step(1));
}

// ---- invalid messages ------------------------------------------------------------------------

/// Integers at the ends of their range.
template <typename Integer>
Integer edge(std::mt19937_64& random) {
  switch (random() % 5) {
    case 0:
      return 0;
    case 1:
      return 1;
    case 2:
      return std::numeric_limits<Integer>::max();
    case 3:
      return std::numeric_limits<Integer>::min();
    default:
      return static_cast<Integer>(random());
  }
}

msg::CommandFrame garbage_frame(std::mt19937_64& random, const Probe& probe) {
  msg::CommandFrame frame;
  frame.bench = 1;
  frame.incarnation = random() % 2 == 0 ? probe.incarnation : edge<std::uint64_t>(random);
  frame.session = random() % 2 == 0 ? probe.session : edge<std::uint64_t>(random);
  frame.epoch = random() % 2 == 0 ? probe.epoch : edge<std::uint32_t>(random);
  frame.sequence_number = edge<std::uint64_t>(random);
  frame.apply_at_tick = edge<std::uint64_t>(random);
  frame.valid_until_tick = edge<std::uint64_t>(random);
  frame.flags = edge<std::uint32_t>(random);
  frame.axes.resize(random() % 4 == 0 ? random() % 300 : random() % 4);
  for (auto& axis : frame.axes) {
    axis.axis = edge<std::uint16_t>(random);
    axis.members = edge<std::uint16_t>(random);
    axis.ds402_controlword = edge<std::uint16_t>(random);
    axis.op_mode_cmd = edge<std::int8_t>(random);
    axis.position_user_target_value = edge<std::int32_t>(random);
    axis.profile_velocity = edge<std::uint32_t>(random);
    axis.profile_acc = edge<std::uint32_t>(random);
    axis.profile_dec = edge<std::uint32_t>(random);
    axis.positioning_option_code = edge<std::uint16_t>(random);
    axis.objects.resize(random() % 8 == 0 ? random() % 20 : random() % 3);
    for (auto& object : axis.objects) {
      object.index = edge<std::uint16_t>(random);
      object.subindex = edge<std::uint8_t>(random);
      object.value = edge<std::int64_t>(random);
    }
  }
  return frame;
}

msg::Request garbage_request(std::mt19937_64& random, Probe& probe) {
  msg::Request request = probe.make_request(msg::RequestKind{edge<std::uint32_t>(random)});
  if (random() % 2 == 0) request.kind = static_cast<msg::RequestKind>(random() % 10);
  request.incarnation = random() % 2 == 0 ? 0 : edge<std::uint64_t>(random);
  request.session = edge<std::uint64_t>(random);
  const auto ticks = edge<std::uint64_t>(random);  // keeps valid steps short, to get through many
  request.ticks = ticks <= 1'000'000 ? ticks % 10 : ticks;
  request.last_sequence = 0;
  request.axes.resize(random() % 4 == 0 ? random() % 300 : random() % 4);
  for (auto& axis : request.axes) axis = edge<std::uint16_t>(random);
  request.objects.resize(random() % 4 == 0 ? random() % 80 : random() % 4);
  for (auto& object : request.objects) {
    object.axis = edge<std::uint16_t>(random);
    object.index = edge<std::uint16_t>(random);
    object.subindex = edge<std::uint8_t>(random);
    object.value = edge<std::int64_t>(random);
  }
  return request;
}

class ServiceUnderInvalidMessages : public testing::TestWithParam<service::ClockMode> {};

TEST_P(ServiceUnderInvalidMessages, AnswersEveryRequestAndContinues) {
  Running bench(configuration(GetParam(), 3));
  ASSERT_TRUE(bench.found);
  ASSERT_TRUE(bench.probe.acquire({1, 2}));
  std::mt19937_64 random(20'260'101);
  constexpr int kRounds = 1'000;
  for (int round = 0; round < kRounds; ++round) {
    ASSERT_TRUE(bench.probe.send(garbage_frame(random, bench.probe)));
    const auto reply = bench.probe.exchange(garbage_request(random, bench.probe));
    ASSERT_TRUE(reply) << "request " << round << " was not answered";
  }
  EXPECT_TRUE(bench.probe.event([](const auto& event) {
    return event.kind == msg::EventKind::refused;
  }));
  EXPECT_EQ(bench.service.counters().frames_received.get(), static_cast<std::uint64_t>(kRounds));
  const auto reply = bench.probe.read(1, 0x6081);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->objects.at(0).abort_code, msg::Reason::none);
}

INSTANTIATE_TEST_SUITE_P(ClockModes, ServiceUnderInvalidMessages,
                         testing::Values(service::ClockMode::realtime,
                                         service::ClockMode::lockstep),
                         [](const auto& mode) {
                           return std::string(to_string(mode.param));
                         });

TEST(Service, AnswersEveryRefusedFrame) {
  Running bench(configuration(service::ClockMode::lockstep, 2));
  ASSERT_TRUE(bench.found);
  ASSERT_TRUE(bench.probe.acquire({1}));
  auto wrong = bench.probe.make_frame();
  wrong.incarnation = 1;
  ASSERT_TRUE(bench.probe.send(wrong));
  const auto reply = bench.probe.reply_to(wrong.sequence_number);
  ASSERT_TRUE(reply);
  ASSERT_EQ(reply->refusals.size(), 1U);
  EXPECT_EQ(reply->refusals[0].reason, msg::Reason::wrong_incarnation);
  auto large = bench.probe.make_frame();
  large.axes.resize(300);
  ASSERT_TRUE(bench.probe.send(large));
  EXPECT_EQ(bench.probe.reply_to(large.sequence_number)->refusals[0].reason,
            msg::Reason::too_many_axes);
}

}  // namespace
}  // namespace vdrive::test
