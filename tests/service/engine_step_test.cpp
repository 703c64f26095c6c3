// SPDX-License-Identifier: Apache-2.0
#include "service/engine_under_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <vector>

namespace vdrive::test {
namespace {

using Time = service::StepRequests::Time;
using namespace std::chrono_literals;

const Time kStart{100s};

service::Arrival step_request(EngineUnderTest& bench, std::uint64_t session, std::uint64_t ticks,
                              msg::RequestKind kind = msg::RequestKind::step) {
  service::Arrival arrival;
  arrival.kind = service::Arrival::Kind::request;
  arrival.request = bench.make_request(kind, session);
  arrival.request.ticks = ticks;
  return arrival;
}

/// Handles the request and runs as many ticks as it allows. @return the answer due at `now`, if
/// any.
std::optional<msg::Reply> answer_at(EngineUnderTest& bench, service::Arrival arrival, Time now) {
  service::StepRequests& steps = bench.engine.steps();
  steps.handle(arrival, now);
  for (std::uint64_t ticks = steps.ticks_to_run(now); ticks > 0; --ticks) {
    steps.begin_tick();
    bench.engine.step();
  }
  steps.answer_due(now);
  return bench.reply();
}

/// @return the answer to a step that is answered immediately.
msg::Reply answer_to(EngineUnderTest& bench, const service::Arrival& arrival) {
  return answer_at(bench, arrival, kStart).value_or(msg::Reply{});
}

msg::Reply join(EngineUnderTest& bench, std::uint64_t session, Time now = kStart) {
  auto arrival = step_request(bench, session, 0, msg::RequestKind::join_clock);
  bench.engine.steps().handle(arrival, now);
  return bench.reply().value_or(msg::Reply{});
}

TEST(StepRequest, IsCheckedBeforeTheFirstTick) {
  EngineUnderTest bench;
  auto arrival = step_request(bench, kAlice, 1'000'001);
  EXPECT_EQ(answer_to(bench, arrival).reason, msg::Reason::too_many_ticks);
  arrival = step_request(bench, kAlice, 1);
  arrival.request.axes = {1, 42};
  const auto unknown = answer_to(bench, arrival);
  EXPECT_EQ(unknown.reason, msg::Reason::unknown_axis);
  EXPECT_EQ(unknown.refused_axis, 42U);
  arrival = step_request(bench, 0, 1);
  arrival.request.last_sequence = 1;
  EXPECT_EQ(answer_to(bench, arrival).reason, msg::Reason::bad_session);
  EXPECT_EQ(bench.engine.tick(), 0U) << "none of them let time pass";
  EXPECT_EQ(answer_to(bench, step_request(bench, 0, 1)).reason, msg::Reason::none)
      << "an observer may step";
  EXPECT_EQ(bench.engine.tick(), 1U);
}

TEST(StepRequest, IsCheckedForTicksAndAxesBeforeTheSessionThatJoins) {
  EngineUnderTest bench;
  auto arrival = step_request(bench, 0, 1'000'001, msg::RequestKind::join_clock);
  arrival.request.axes = {42};
  EXPECT_EQ(answer_to(bench, arrival).reason, msg::Reason::too_many_ticks);
  arrival = step_request(bench, 0, 65, msg::RequestKind::join_clock);
  arrival.request.axes = {42};
  EXPECT_EQ(answer_to(bench, arrival).reason, msg::Reason::unknown_axis);
  EXPECT_EQ(join(bench, 0).reason, msg::Reason::bad_session);
  arrival = step_request(bench, 0, 0, msg::RequestKind::leave_clock);
  EXPECT_EQ(answer_to(bench, arrival).reason, msg::Reason::not_a_stepper);
}

TEST(StepRequest, MayHaveAMillionTicks) {
  EngineUnderTest bench(bench_configuration(1));
  auto arrival = step_request(bench, kAlice, 1'000'000);
  bench.engine.steps().handle(arrival, kStart);
  EXPECT_EQ(bench.engine.steps().ticks_to_run(kStart), 1'000'000U);
}

TEST(StepRequest, IsRefusedInRealtime) {
  auto configuration = bench_configuration(1);
  configuration.clock = service::ClockMode::realtime;
  EngineUnderTest bench(configuration);
  EXPECT_EQ(answer_to(bench, step_request(bench, kAlice, 1)).reason, msg::Reason::wrong_clock_mode);
  EXPECT_EQ(bench.reply_to(bench.make_request(msg::RequestKind::step, kAlice)).reason,
            msg::Reason::wrong_clock_mode);
}

TEST(StepRequest, WaitsForTheFramesThatWereSentBeforeItAndHoldsLaterRequestsBack) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {1});
  const auto frame = bench.make_frame(kAlice);
  auto arrival = step_request(bench, kAlice, 3);
  arrival.request.last_sequence = frame.sequence_number;
  EXPECT_EQ(answer_at(bench, arrival, kStart), std::nullopt);
  service::StepRequests& steps = bench.engine.steps();
  EXPECT_TRUE(steps.holds_requests_back());
  bench.receive(frame);
  EXPECT_EQ(steps.ticks_to_run(kStart), 3U);
  bench.steps(3);
  steps.answer_due(kStart);
  const auto reply = bench.reply();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->reason, msg::Reason::none);
  EXPECT_EQ(reply->tick, 3U);
  EXPECT_FALSE(steps.holds_requests_back());
}

TEST(StepRequest, IsRefusedWhenItsFramesDoNotComeWithinASecond) {
  EngineUnderTest bench;
  join(bench, kAlice);
  bench.acquire(kAlice, {1});
  const auto frame = bench.make_frame(kAlice);
  bench.receive(frame);
  auto arrival = step_request(bench, kAlice, 3);
  arrival.request.last_sequence = frame.sequence_number + 4;
  EXPECT_EQ(answer_at(bench, arrival, kStart), std::nullopt);
  service::StepRequests& steps = bench.engine.steps();
  steps.answer_due(kStart + 999ms);
  EXPECT_EQ(bench.reply(), std::nullopt);
  steps.answer_due(kStart + 1s);
  const auto refused = bench.reply().value_or(msg::Reply{});
  EXPECT_EQ(refused.reason, msg::Reason::missing_commands);
  EXPECT_EQ(refused.last_sequence, frame.sequence_number);
  EXPECT_EQ(bench.engine.tick(), 0U);
  EXPECT_EQ(answer_at(bench, step_request(bench, kAlice, 1), kStart + 1s).value().tick, 1U)
      << "the refused step has granted nothing";
}

TEST(StepRequest, WaitsUntilAsManyHaveJoinedAsTheBenchAwaits) {
  auto configuration = bench_configuration(1);
  configuration.steppers = 2;
  EngineUnderTest bench(configuration);
  EXPECT_EQ(answer_to(bench, step_request(bench, kAlice, 1)).reason, msg::Reason::not_a_stepper)
      << "time waits for those that join";
  EXPECT_EQ(answer_to(bench, step_request(bench, kAlice, 0)).reason, msg::Reason::none)
      << "reads the status";
  EXPECT_EQ(join(bench, kAlice).reason, msg::Reason::none);
  EXPECT_EQ(answer_at(bench, step_request(bench, kAlice, 3), kStart), std::nullopt);
  bench.engine.steps().answer_due(kStart + 1s);
  const auto late = bench.reply().value_or(msg::Reply{});
  EXPECT_EQ(late.reason, msg::Reason::missing_stepper);
  EXPECT_EQ(late.missing_stepper, 0U) << "not a session that is there";
  EXPECT_EQ(bench.counters.slowest_stepper.get(), 0U);
  EXPECT_EQ(bench.engine.tick(), 0U);
  EXPECT_EQ(join(bench, kBob).reason, msg::Reason::none);
  EXPECT_EQ(answer_at(bench, step_request(bench, kBob, 3), kStart + 2s).value().tick, 3U)
      << "what was granted stays granted";
}

TEST(StepRequest, WaitsUntilAsManyHaveJoinedAsAStepperAwaits) {
  EngineUnderTest bench;
  auto joining = step_request(bench, kAlice, 2, msg::RequestKind::join_clock);
  bench.engine.steps().handle(joining, kStart);
  EXPECT_EQ(bench.reply().value().reason, msg::Reason::none);
  EXPECT_EQ(answer_at(bench, step_request(bench, kAlice, 3), kStart), std::nullopt);
  EXPECT_EQ(bench.engine.tick(), 0U);
  EXPECT_EQ(join(bench, kBob).reason, msg::Reason::none);
  EXPECT_EQ(answer_at(bench, step_request(bench, kBob, 3), kStart).value().tick, 3U);
}

TEST(StepRequest, MayNotAwaitMoreThanAClockHas) {
  EngineUnderTest bench;
  auto joining = step_request(bench, kAlice, msg::MAX_STEPPERS + 1, msg::RequestKind::join_clock);
  bench.engine.steps().handle(joining, kStart);
  EXPECT_EQ(bench.reply().value().reason, msg::Reason::too_many_steppers);
  for (std::uint64_t session = 1; session <= msg::MAX_STEPPERS; ++session) {
    EXPECT_EQ(join(bench, session).reason, msg::Reason::none);
  }
  EXPECT_EQ(join(bench, kAlice).reason, msg::Reason::too_many_steppers);
}

TEST(StepRequest, OfAStepperRunsAsFarAsAllOfThemGrant) {
  EngineUnderTest bench;
  EXPECT_EQ(join(bench, kAlice).reason, msg::Reason::none);
  EXPECT_EQ(join(bench, kBob).reason, msg::Reason::none);
  EXPECT_EQ(bench.counters.steppers.get(), 2U);
  EXPECT_EQ(answer_at(bench, step_request(bench, kAlice, 5), kStart), std::nullopt);
  EXPECT_EQ(bench.engine.tick(), 0U) << "Bob has granted nothing";
  const auto bob = answer_at(bench, step_request(bench, kBob, 2), kStart);
  ASSERT_TRUE(bob);
  EXPECT_EQ(bob->tick, 2U);
  EXPECT_EQ(bench.reply(), std::nullopt) << "Alice waits for tick 5";
  const auto first = answer_at(bench, step_request(bench, kBob, 3), kStart);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->tick, 5U);
  const auto second = bench.reply();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->tick, 5U);
}

TEST(StepRequest, ReportsAMissingStepperAndThePresentStatus) {
  EngineUnderTest bench;
  join(bench, kAlice);
  join(bench, kBob);
  auto arrival = step_request(bench, kAlice, 5);
  arrival.request.axes = {2};
  EXPECT_EQ(answer_at(bench, arrival, kStart), std::nullopt);
  EXPECT_FALSE(bench.engine.steps().holds_requests_back()) << "others are answered meanwhile";
  bench.engine.steps().answer_due(kStart + 1s);
  const auto reply = bench.reply();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->reason, msg::Reason::missing_stepper);
  EXPECT_EQ(reply->missing_stepper, kBob);
  EXPECT_EQ(bench.counters.slowest_stepper.get(), kBob);
  EXPECT_EQ(reply->tick, 0U);
  EXPECT_EQ(reply->statuses.size(), 1U);
}

TEST(StepRequest, OfANonStepperMayOnlyObserve) {
  EngineUnderTest bench;
  join(bench, kAlice);
  EXPECT_EQ(answer_to(bench, step_request(bench, kBob, 1)).reason, msg::Reason::not_a_stepper);
  EXPECT_EQ(answer_to(bench, step_request(bench, kBob, 0)).reason, msg::Reason::none);
}

TEST(StepRequest, OfASessionThatLeavesTheClockIsRefusedWhenTheOthersHaveNotGrantedItsTicks) {
  EngineUnderTest bench;
  join(bench, kAlice);
  join(bench, kBob);
  EXPECT_EQ(answer_at(bench, step_request(bench, kAlice, 5), kStart), std::nullopt);
  auto leave = step_request(bench, kAlice, 0, msg::RequestKind::leave_clock);
  bench.engine.steps().handle(leave, kStart);
  EXPECT_EQ(bench.reply().value_or(msg::Reply{}).reason, msg::Reason::none);
  bench.engine.steps().answer_due(kStart);
  EXPECT_EQ(bench.reply().value_or(msg::Reply{}).reason, msg::Reason::not_a_stepper);
}

TEST(StepRequest, IsAnsweredWhenTheBenchEnds) {
  EngineUnderTest bench;
  join(bench, kAlice);
  join(bench, kBob);
  EXPECT_EQ(answer_at(bench, step_request(bench, kAlice, 5), kStart), std::nullopt);
  EXPECT_TRUE(bench.engine.steps().refuse_waiting());
  EXPECT_EQ(bench.reply().value_or(msg::Reply{}).reason, msg::Reason::shutting_down);
}

TEST(StepRequest, IsNotLostWhenTheQueueOfAnswersIsFull) {
  EngineUnderTest bench;
  auto arrival = step_request(bench, kAlice, 1);
  service::StepRequests& steps = bench.engine.steps();
  steps.handle(arrival, kStart);
  while (bench.outbox.replies.size() < bench.outbox.replies.capacity()) {
    bench.receive(bench.make_request(msg::RequestKind::read, kAlice));
  }
  ASSERT_EQ(steps.ticks_to_run(kStart), 1U);
  bench.steps(1);
  EXPECT_FALSE(steps.answer_due(kStart));
  while (bench.reply()) {
  }
  EXPECT_TRUE(steps.answer_due(kStart));
  EXPECT_EQ(bench.reply().value_or(msg::Reply{}).tick, 1U);
}

TEST(StepRequest, TakesASilentStepperOffTheClock) {
  EngineUnderTest bench;
  join(bench, kAlice);
  join(bench, kBob);
  EXPECT_EQ(answer_at(bench, step_request(bench, kAlice, 5), kStart), std::nullopt);
  service::StepRequests& steps = bench.engine.steps();
  const auto is_here = [](const wire::Source&) {
    return service::ReaderState::matched;
  };
  steps.remove_absent(kStart + 9'999ms, is_here);
  EXPECT_EQ(bench.counters.steppers.get(), 2U);
  steps.remove_absent(kStart + 10s, is_here);
  EXPECT_EQ(bench.counters.steppers.get(), 1U);
  EXPECT_EQ(steps.ticks_to_run(kStart + 10s), 5U) << "nobody else has to grant";
}

TEST(StepRequest, TakesAStepperOffTheClockWhoseParticipantIsGone) {
  EngineUnderTest bench;
  join(bench, kAlice);
  service::StepRequests& steps = bench.engine.steps();
  const auto is_gone = [](const wire::Source&) {
    return service::ReaderState::gone;
  };
  steps.remove_absent(kStart, is_gone);
  EXPECT_EQ(bench.counters.steppers.get(), 1U) << "it has not been seen yet";
  steps.remove_absent(kStart, [](const wire::Source&) {
    return service::ReaderState::matched;
  });
  steps.remove_absent(kStart, is_gone);
  EXPECT_EQ(bench.counters.steppers.get(), 0U);
  const auto events = bench.events(msg::EventKind::clock_changed);
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[1].detail, service::EventDetail{service::StepperRemoval::gone});
}

TEST(StepRequest, IsAnsweredWithTheStatusOfTheRequestedAxes) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {3});
  bench.steps(4);
  auto arrival = step_request(bench, kAlice, 0);
  arrival.request.axes = {3, 1};
  const msg::Reply reply = answer_to(bench, arrival);
  EXPECT_EQ(reply.tick, 4U);
  ASSERT_EQ(reply.statuses.size(), 2U);
  EXPECT_EQ(reply.statuses[0].axis, 3U);
  EXPECT_EQ(reply.statuses[0].owner_session, kAlice);
  EXPECT_EQ(reply.statuses[0].tick, 4U);
  EXPECT_EQ(reply.statuses[1].axis, 1U);
  EXPECT_EQ(reply.statuses[1].ds402_statusword, 0x250U);
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
  const auto events = bench.events(msg::EventKind::master_lost);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].session, kAlice);
  EXPECT_EQ(events[0].detail, (service::EventDetail{service::LostAxes{2, 101}}))
      << "the first tick beyond the 100 ms";
  EXPECT_EQ(events[0].code, 101U);
  EXPECT_EQ(bench.counters.longest_silence_us.get(), 101'000U);
  EXPECT_EQ(bench.acquire(kBob, {1, 2}).reason, msg::Reason::none);
}

// A reliable write may be delivered long after it was sent: 0Fh would enable an axis that is in
// Switch on disabled.
TEST(Watchdog, ALateWriteDoesNotRegainALostAxis) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {1, 2});
  bench.steps(102);
  ASSERT_EQ(bench.counters.master_losses.get(), 1U);
  const auto late = bench.write(kAlice, 1, 0x6040, 0x0F);
  EXPECT_EQ(late.objects[0].abort_code, msg::Reason::stale_epoch);
  EXPECT_EQ(late.epoch, 0U);
  EXPECT_EQ(bench.value(1, 0x6040), 0) << "nothing was written";
  EXPECT_EQ(bench.write(kBob, 2, 0x6040, 0x0F).objects[0].abort_code, msg::Reason::none)
      << "lost nothing";
  EXPECT_EQ(bench.acquire(kAlice, {1}).reason, msg::Reason::none);
  EXPECT_EQ(bench.write(kAlice, 1, 0x6040, 0x0F).objects[0].abort_code, msg::Reason::none);
}

TEST(Watchdog, ALateWriteDoesNotRegainAnAxisThatWasTakenOver) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {1});
  bench.reply_to(bench.make_request(msg::RequestKind::take_over, kBob, {1}));
  bench.reply_to(bench.make_request(msg::RequestKind::release, kBob));
  EXPECT_EQ(bench.write(kAlice, 1, 0x6040, 0x0F).objects[0].abort_code, msg::Reason::stale_epoch);
}

TEST(Watchdog, AcceptsRequestsAndStepsAsSignsOfLife) {
  EngineUnderTest bench;
  bench.acquire(kAlice, {1});
  bench.steps(90);
  bench.reply_to(bench.make_request(msg::RequestKind::read, kAlice));
  bench.steps(90);
  for (int tick = 0; tick < 500; ++tick) {  // the owner steps, so each tick is a sign of life
    auto step = step_request(bench, kAlice, 1);
    bench.engine.steps().handle(step, kStart);
    ASSERT_EQ(bench.engine.steps().ticks_to_run(kStart), 1U);
    bench.engine.steps().begin_tick();
    bench.steps(1);
    bench.engine.steps().answer_due(kStart);
    bench.reply();
  }
  bench.acquire(kBob, {2});
  join(bench, kAlice);
  join(bench, kBob);
  EXPECT_EQ(answer_at(bench, step_request(bench, kAlice, 500), kStart), std::nullopt);
  EXPECT_TRUE(answer_at(bench, step_request(bench, kBob, 500), kStart));
  EXPECT_EQ(bench.counters.master_losses.get(), 0U) << "steppers count in each granted tick";
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
  const auto enabled = bench.events(msg::EventKind::state_changed);
  ASSERT_EQ(enabled.size(), 1U);
  EXPECT_EQ(enabled[0].axis, 1U);
  EXPECT_EQ(enabled[0].code & 0x6FU, 0x27U);
  EXPECT_EQ(enabled[0].tick, 1U);
  bench.write(kBob, 1, 0x5E02, 1);
  bench.steps(1);
  const auto faults = bench.events(msg::EventKind::fault);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].code, 0x2310U);
  bench.write(kBob, 1, 0x5E02, 0);
  bench.steps(50);
  bench.write(kAlice, 1, 0x6040, 0x80);
  bench.steps(1);
  EXPECT_EQ(bench.events(msg::EventKind::fault_reset).size(), 1U);
}

TEST(Parameters, ArePublishedOnceForEveryAcceptedWrite) {
  EngineUnderTest bench;
  bench.write(kAlice, 2, 0x6081, 5);
  bench.write(kAlice, 2, 0x6083, 6);
  bench.write(kAlice, 2, 0x6080, 0);  // refused
  bench.steps(1);
  ASSERT_EQ(bench.outbox.parameters.size(), 1U);
  EXPECT_EQ(bench.outbox.parameters.front()->axis, 2U);
  EXPECT_EQ(bench.outbox.parameters.front()->profile_velocity, 5U);
  EXPECT_EQ(bench.outbox.parameters.front()->profile_acc, 6U);
}

TEST(Parameters, WaitForRoomAndLoseNothing) {
  constexpr std::uint16_t kAxes = 600;
  EngineUnderTest bench(bench_configuration(kAxes));
  for (std::uint16_t axis = 1; axis <= kAxes; ++axis) bench.write(kAlice, axis, 0x6081, axis);
  std::vector<bool> seen(kAxes + 1);
  for (int tick = 0; tick < 100; ++tick) {
    bench.steps(1);
    while (tick > 50 && bench.outbox.parameters.front() != nullptr) {
      seen[bench.outbox.parameters.front()->axis] = true;
      bench.outbox.parameters.pop();
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), kAxes);
}

TEST(Outbox, ReportsTheCountOfDroppedImages) {
  EngineUnderTest bench;
  for (std::size_t count = 0; count < bench.outbox.status.capacity() + 5; ++count) {
    bench.engine.queue_status();
  }
  EXPECT_EQ(bench.counters.queue_overflows.get(), 5U);
  bench.steps(1);
  const auto events = bench.events(msg::EventKind::queue_overflow);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].detail, service::EventDetail{service::Count{5}});
}

// 24.9 and 49.7 days of milliseconds, where a 32-bit count would turn negative or wrap.
TEST(BenchEngine, KeepsTimesAndCountsAcross2To31And2To32Ticks) {
  for (const std::uint64_t border : {std::uint64_t{1} << 31U, std::uint64_t{1} << 32U}) {
    EngineUnderTest bench;
    bench.engine.start_at(border - 50);
    bench.acquire(kAlice, {1});
    bench.write(kAlice, 1, 0x6040, 0x0F);
    msg::CommandFrame frame = bench.make_frame(kAlice);
    frame.apply_at_tick = border + 5;
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

// From 1,024 axes on, the threads also share the work after the step: finding the changes of each
// axis and copying the status to publish.
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
    for (const auto& event : bench.events(msg::EventKind::state_changed))
      axes.push_back(event.axis);
    bench.engine.queue_status();
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
