// SPDX-License-Identifier: Apache-2.0
#include "service/engine_under_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace vdrive::test {
namespace {

service::Arrival step_request(EngineUnderTest& bench, std::uint64_t session, std::uint64_t ticks) {
  service::Arrival arrival;
  arrival.kind = service::Arrival::Kind::request;
  arrival.request = bench.make_request(msg::REQUEST_STEP, session);
  arrival.request.ticks(ticks);
  return arrival;
}

TEST(StepRequest, IsCheckedBeforeTheFirstTick) {
  EngineUnderTest bench;
  auto arrival = step_request(bench, kAlice, 1'000'000);
  EXPECT_EQ(bench.engine.check_step(arrival), msg::REASON_NONE);
  arrival.request.ticks(1'000'001);
  EXPECT_EQ(bench.engine.check_step(arrival), msg::REASON_TOO_MANY_TICKS);
  arrival.request.ticks(0);
  arrival.request.axes({1, 42});
  EXPECT_EQ(bench.engine.check_step(arrival), msg::REASON_UNKNOWN_AXIS);
  arrival.request.axes({});
  arrival.request.session(0);
  EXPECT_EQ(bench.engine.check_step(arrival), msg::REASON_NONE) << "an observer may step";
  arrival.request.last_sequence(1);
  EXPECT_EQ(bench.engine.check_step(arrival), msg::REASON_BAD_SESSION);
}

TEST(StepRequest, IsRefusedInRealtime) {
  auto configuration = bench_configuration(1);
  configuration.clock = service::ClockMode::realtime;
  EngineUnderTest bench(configuration);
  EXPECT_EQ(bench.engine.check_step(step_request(bench, kAlice, 1)), msg::REASON_WRONG_CLOCK_MODE);
  EXPECT_EQ(bench.reply_to(bench.make_request(msg::REQUEST_STEP, kAlice)).reason(),
            msg::REASON_WRONG_CLOCK_MODE);
}

TEST(StepRequest, ReportsAMissingStepperAndThePresentStatus) {
  EngineUnderTest bench;
  bench.steps(2);
  auto arrival = step_request(bench, kAlice, 5);
  arrival.request.axes({2});
  bench.engine.answer_step(arrival, msg::REASON_MISSING_STEPPER, kBob);
  const auto& reply = bench.outbox.replies.front()->reply;
  EXPECT_EQ(reply.reason(), msg::REASON_MISSING_STEPPER);
  EXPECT_EQ(reply.missing_stepper(), kBob);
  EXPECT_EQ(reply.tick(), 2U);
  ASSERT_EQ(reply.statuses().size(), 1U);
}

TEST(StepRequest, ChecksWhichFramesHaveArrived) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {1});
  EXPECT_TRUE(bench.engine.has_arrived(kAlice, 0));
  EXPECT_FALSE(bench.engine.has_arrived(kAlice, 1));
  bench.receive(bench.make_frame(kAlice));
  EXPECT_TRUE(bench.engine.has_arrived(kAlice, 1));
  EXPECT_FALSE(bench.engine.has_arrived(kBob, 1));
}

TEST(StepRequest, IsAnsweredWithTheStatusOfTheRequestedAxes) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {3});
  bench.steps(4);
  auto arrival = step_request(bench, kAlice, 0);
  arrival.request.axes({3, 1});
  bench.engine.answer_step(arrival, msg::REASON_NONE);
  const auto& reply = bench.outbox.replies.front()->reply;
  EXPECT_EQ(reply.tick(), 4U);
  ASSERT_EQ(reply.statuses().size(), 2U);
  EXPECT_EQ(reply.statuses()[0].axis(), 3U);
  EXPECT_EQ(reply.statuses()[0].owner_session(), kAlice);
  EXPECT_EQ(reply.statuses()[0].tick(), 4U);
  EXPECT_EQ(reply.statuses()[1].axis(), 1U);
  EXPECT_EQ(reply.statuses()[1].ds402_statusword(), 0x250U);
}

TEST(Watchdog, ReleasesTheAxesOfALostMasterAndFaultsTheEnabledOnes) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {1, 2});
  bench.write(kAlice, 1, 0x6040, 0x0F);
  bench.steps(100);
  EXPECT_EQ(bench.counters.master_losses.get(), 0U) << "100 ms are allowed";
  bench.steps(2);
  EXPECT_EQ(bench.counters.master_losses.get(), 1U);
  EXPECT_EQ(bench.value(1, 0x603F), 0x8130);
  EXPECT_EQ(bench.value(2, 0x603F), 0) << "was not enabled";
  const auto events = bench.events(msg::EVENT_MASTER_LOST);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].session, kAlice);
  EXPECT_EQ(events[0].detail, (service::EventDetail{service::LostAxes{2, 101}}))
      << "the first tick beyond the 100 ms";
  EXPECT_EQ(events[0].code, 101U);
  EXPECT_EQ(bench.counters.longest_silence_us.get(), 101'000U);
  EXPECT_EQ(bench.acquire(kBob, {1, 2}).reason(), msg::REASON_NONE);
}

// A reliable write may be delivered long after it was sent: 0Fh in Switch on disabled would enable.
TEST(Watchdog, ALateWriteDoesNotRegainALostAxis) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {1, 2});
  bench.steps(102);
  ASSERT_EQ(bench.counters.master_losses.get(), 1U);
  const auto late = bench.write(kAlice, 1, 0x6040, 0x0F);
  EXPECT_EQ(late.objects()[0].abort_code(), msg::REASON_STALE_EPOCH);
  EXPECT_EQ(late.epoch(), 0U);
  EXPECT_EQ(bench.value(1, 0x6040), 0) << "nothing was written";
  EXPECT_EQ(bench.write(kBob, 2, 0x6040, 0x0F).objects()[0].abort_code(), 0U) << "lost nothing";
  EXPECT_EQ(bench.acquire(kAlice, {1}).reason(), msg::REASON_NONE);
  EXPECT_EQ(bench.write(kAlice, 1, 0x6040, 0x0F).objects()[0].abort_code(), 0U);
}

TEST(Watchdog, ALateWriteDoesNotRegainAnAxisThatWasTakenOver) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {1});
  bench.reply_to(bench.make_request(msg::REQUEST_TAKE_OVER, kBob, {1}));
  bench.reply_to(bench.make_request(msg::REQUEST_RELEASE, kBob));
  EXPECT_EQ(bench.write(kAlice, 1, 0x6040, 0x0F).objects()[0].abort_code(),
            msg::REASON_STALE_EPOCH);
}

TEST(Watchdog, AcceptsRequestsAndStepsAsSignsOfLife) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {1});
  bench.steps(90);
  bench.reply_to(bench.make_request(msg::REQUEST_READ, kAlice));
  bench.steps(90);
  for (int tick = 0; tick < 500; ++tick) {  // the owner steps: it counts in each tick
    bench.engine.note_message(kAlice);
    bench.steps(1);
  }
  EXPECT_EQ(bench.counters.master_losses.get(), 0U);
}

// At rate 10 the time-out of 100 ms of wall time is 1000 ticks of 1 ms.
TEST(Watchdog, CountsWallTimeWhereDriveTimeRunsFaster) {
  auto configuration = bench_configuration(1);
  configuration.clock = service::ClockMode::realtime;
  configuration.rate = 10.0;
  EngineUnderTest bench(configuration);
  bench.acquire(kAlice, {1});
  bench.steps(1'000);
  EXPECT_EQ(bench.counters.master_losses.get(), 0U);
  bench.steps(2);
  EXPECT_EQ(bench.counters.master_losses.get(), 1U);
}

TEST(Watchdog, CanBeTurnedOff) {
  auto configuration = bench_configuration(1);
  configuration.watchdog.reset();
  EngineUnderTest bench(configuration);
  bench.acquire(kAlice, {1});
  bench.steps(100'000);
  EXPECT_EQ(bench.counters.master_losses.get(), 0U);
}

TEST(Watchdog, CountsDriveTimeNotTicks) {
  auto configuration = bench_configuration(1);
  configuration.period = std::chrono::microseconds{10'000};
  EngineUnderTest bench(configuration);
  bench.acquire(kAlice, {1});
  bench.steps(10);
  EXPECT_EQ(bench.counters.master_losses.get(), 0U);
  bench.steps(2);
  EXPECT_EQ(bench.counters.master_losses.get(), 1U);
}

TEST(Events, ReportStatesFaultsAndResets) {
  EngineUnderTest bench;
  bench.write(kAlice, 1, 0x6040, 0x0F);
  bench.steps(1);
  const auto enabled = bench.events(msg::EVENT_STATE_CHANGED);
  ASSERT_EQ(enabled.size(), 1U);
  EXPECT_EQ(enabled[0].axis, 1U);
  EXPECT_EQ(enabled[0].code & 0x6FU, 0x27U);
  EXPECT_EQ(enabled[0].tick, 1U);
  bench.write(kBob, 1, 0x5E02, 1);
  bench.steps(1);
  const auto faults = bench.events(msg::EVENT_FAULT);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].code, 0x2310U);
  bench.write(kBob, 1, 0x5E02, 0);
  bench.steps(50);
  bench.write(kAlice, 1, 0x6040, 0x80);
  bench.steps(1);
  EXPECT_EQ(bench.events(msg::EVENT_FAULT_RESET).size(), 1U);
}

TEST(Parameters, ArePublishedOnceForEveryAcceptedWrite) {
  EngineUnderTest bench;
  bench.write(kAlice, 2, 0x6081, 5);
  bench.write(kAlice, 2, 0x6083, 6);
  bench.write(kAlice, 2, 0x6080, 0);  // refused
  bench.steps(1);
  ASSERT_EQ(bench.outbox.parameters.size(), 1U);
  EXPECT_EQ(bench.outbox.parameters.front()->axis(), 2U);
  EXPECT_EQ(bench.outbox.parameters.front()->profile_velocity(), 5U);
  EXPECT_EQ(bench.outbox.parameters.front()->profile_acc(), 6U);
}

TEST(Parameters, WaitForRoomAndLoseNothing) {
  constexpr std::uint16_t kAxes = 600;
  EngineUnderTest bench(bench_configuration(kAxes));
  for (std::uint16_t axis = 1; axis <= kAxes; ++axis) bench.write(kAlice, axis, 0x6081, axis);
  std::vector<bool> seen(kAxes + 1);
  for (int tick = 0; tick < 100; ++tick) {
    bench.steps(1);
    while (tick > 50 && bench.outbox.parameters.front() != nullptr) {
      seen[bench.outbox.parameters.front()->axis()] = true;
      bench.outbox.parameters.pop();
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), kAxes);
}

TEST(Outbox, ReportsTheCountOfDroppedImages) {
  EngineUnderTest bench;
  for (std::size_t count = 0; count < bench.outbox.status.capacity() + 5; ++count) {
    bench.engine.post_status();
  }
  EXPECT_EQ(bench.counters.queue_overflows.get(), 5U);
  bench.steps(1);
  const auto events = bench.events(msg::EVENT_QUEUE_OVERFLOW);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].detail, service::EventDetail{service::Count{5}});
}

// 24.9 and 49.7 days of milliseconds: where a count of 32 bits would turn negative or wrap.
TEST(BenchEngine, KeepsTimesAndCountsAcross2To31And2To32Ticks) {
  for (const std::uint64_t border : {std::uint64_t{1} << 31U, std::uint64_t{1} << 32U}) {
    EngineUnderTest bench;
    bench.engine.start_at(border - 50);
    bench.acquire(kAlice, {1});
    bench.write(kAlice, 1, 0x6040, 0x0F);
    msg::CommandFrame frame = bench.make_frame(kAlice);
    frame.apply_at_tick(border + 5);
    set_controlword(add_command(frame, 1), 0x06);
    bench.receive(frame);

    bench.steps(54);
    EXPECT_EQ(bench.engine.tick(), border + 4);
    EXPECT_EQ(bench.value(1, 0x6041), 0x0237) << "enabled, not shut down yet";
    bench.steps(1);
    EXPECT_EQ(bench.value(1, 0x6041), 0x0231) << "in its tick";
    bench.steps(45);
    EXPECT_EQ(bench.counters.master_losses.get(), 0U) << "100 ms are allowed";
    bench.steps(2);
    EXPECT_EQ(bench.counters.master_losses.get(), 1U);
    EXPECT_EQ(bench.engine.tick(), border + 52);
  }
}

TEST(BenchEngine, GivesTheSameBitsForAnyNumberOfThreads) {
  std::uint64_t expected = 0;
  for (const std::uint32_t threads : {1U, 2U, 3U, 7U}) {
    auto configuration = bench_configuration(200);
    configuration.threads = threads;
    configuration.watchdog.reset();
    EngineUnderTest bench(configuration);
    for (std::uint16_t axis = 1; axis <= 200; ++axis) {
      bench.write(kAlice, axis, 0x6040, 0x0F);
      bench.write(kAlice, axis, 0x6060, 1);
    }
    bench.steps(2);
    for (std::uint16_t axis = 1; axis <= 200; ++axis) {
      bench.write(kAlice, axis, 0x607A, axis * 97 - 9'000);
      bench.write(kAlice, axis, 0x6040, 0x3F);
    }
    bench.steps(300);
    ASSERT_GE(bench.engine.bank().group_count(), threads) << "a thread has nothing to do";
    const std::uint64_t hash = bench.engine.bank().status_hash();
    if (threads == 1) expected = hash;
    EXPECT_EQ(hash, expected) << threads << " threads";
    EXPECT_NE(bench.value(1, 0x6062), 0);
  }
}

// From 1,024 axes on the threads also share what follows the step: what has changed on which axis,
// and the copy that is published.
TEST(BenchEngine, GivesTheSameReportsAndStatusForAnyNumberOfThreads) {
  constexpr std::uint16_t kMany = 1'100;
  std::vector<std::uint16_t> expected_axes;
  std::vector<std::uint16_t> expected_words;
  for (const std::uint32_t threads : {1U, 2U, 5U}) {
    auto configuration = bench_configuration(kMany);
    configuration.threads = threads;
    configuration.watchdog.reset();
    EngineUnderTest bench(configuration);
    for (std::uint16_t axis = 1; axis <= kMany; axis += 3) bench.write(kAlice, axis, 0x6040, 0x0F);
    bench.steps(1);
    std::vector<std::uint16_t> axes;
    for (const auto& event : bench.events(msg::EVENT_STATE_CHANGED)) axes.push_back(event.axis);
    bench.engine.post_status();
    const auto* const image = bench.outbox.status.front();
    ASSERT_NE(image, nullptr);
    std::vector<std::uint16_t> words;
    for (const AxisStatus& status : image->status) words.push_back(status.ds402_statusword);
    EXPECT_EQ(image->owners[0].session, kAlice);
    EXPECT_EQ(image->owners[1].session, 0U) << "axis 2 has no owner";
    EXPECT_EQ(image->owners[1'098].session, kAlice) << "1,099 = 1 + 3 x 366";
    if (threads == 1) {
      expected_axes = axes;
      expected_words = words;
      EXPECT_EQ(axes.size(), 367U) << "axes 1, 4, ... 1,099";
      EXPECT_TRUE(std::ranges::is_sorted(axes));
    }
    EXPECT_EQ(axes, expected_axes) << threads << " threads";
    EXPECT_EQ(words, expected_words) << threads << " threads";
  }
}

}  // namespace
}  // namespace vdrive::test
