// SPDX-License-Identifier: Apache-2.0
// A repeated message takes effect once and gets the same answer again: requests of every kind, and
// command frames.
#include "core/support/allocation_guard.hpp"
#include "service/engine_under_test.hpp"
#include "store/parameter_saver.hpp"
#include "support/temporary_directory.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

namespace vdrive::test {
namespace {

constexpr std::uint16_t kWindow = 0x6067;

msg::ObjectAccess& add_write(msg::Request& request, std::uint16_t axis, std::uint16_t index,
                             std::int64_t value) {
  auto& object = request.objects.emplace_back();
  object.axis = axis;
  object.index = index;
  object.value = value;
  return object;
}

/// A bench on which Alice has acquired axes 1 and 2.
struct OwnedBench : EngineUnderTest {
  explicit OwnedBench(const service::Configuration& with = bench_configuration(3))
      : EngineUnderTest(with) {
    epoch = acquire(kAlice, {1, 2}).epoch;
    static_cast<void>(events({}));
  }

  /// @return frame `sequence` of Alice without a command, which keeps her session alive.
  [[nodiscard]] msg::CommandFrame frame(std::uint64_t sequence) const {
    msg::CommandFrame frame;
    frame.bench = kBench;
    frame.incarnation = kIncarnation;
    frame.session = kAlice;
    frame.epoch = epoch;
    frame.sequence_number = sequence;
    frame.flags = msg::FRAME_WANT_REPLY;
    return frame;
  }

  /// @return a frame that writes 6067h of axis 1.
  [[nodiscard]] msg::CommandFrame command(std::uint64_t sequence, std::int64_t value) const {
    auto result = frame(sequence);
    auto& object = add_command(result, 1).objects.emplace_back();
    object.index = kWindow;
    object.value = value;
    return result;
  }

  std::uint32_t epoch = 0;
};

// ---- requests ---------------------------------------------------------------------------------

TEST(RepeatedRequest, WritesOnceAndHasTheSameAnswer) {
  EngineUnderTest bench;
  auto write = bench.make_request(msg::RequestKind::write, kAlice);
  add_write(write, 1, kWindow, 50);
  const auto first = bench.reply_to(write);
  bench.write(kAlice, 1, kWindow, 60);
  bench.steps(3);
  EXPECT_EQ(bench.reply_to(write), first) << "its tick is that of the first answer";
  EXPECT_EQ(bench.value(1, kWindow), 60) << "the repeat does not write";
}

TEST(RepeatedRequest, ReturnsTheValuesOfTheFirstRead) {
  EngineUnderTest bench;
  auto read = bench.make_request(msg::RequestKind::read, 0);
  add_write(read, 1, kWindow, 0);
  const auto first = bench.reply_to(read);
  bench.write(kAlice, 1, kWindow, 61);
  EXPECT_EQ(bench.reply_to(read), first);
}

TEST(RepeatedRequest, DoesNotAcquireAReleasedAxisAgain) {
  EngineUnderTest bench;
  const auto acquire = bench.make_request(msg::RequestKind::acquire, kAlice, {1});
  const auto first = bench.reply_to(acquire);
  ASSERT_EQ(first.reason, msg::Reason::none);
  const auto release = bench.make_request(msg::RequestKind::release, kAlice, {});
  const auto released = bench.reply_to(release);
  EXPECT_EQ(bench.reply_to(acquire), first);
  EXPECT_EQ(bench.acquire(kBob, {1}).reason, msg::Reason::none) << "the axis is free";
  EXPECT_EQ(bench.reply_to(release), released);
  EXPECT_EQ(bench.reply_to(bench.make_request(msg::RequestKind::release, kAlice)).reason,
            msg::Reason::nothing_done);
}

TEST(RepeatedRequest, TakesOverOnce) {
  EngineUnderTest bench;
  const auto take = bench.make_request(msg::RequestKind::take_over, kAlice, {1});
  const auto first = bench.reply_to(take);
  ASSERT_EQ(bench.reply_to(bench.make_request(msg::RequestKind::take_over, kBob, {1})).reason,
            msg::Reason::none);
  EXPECT_EQ(bench.reply_to(take), first);
  const auto others = bench.write(kAlice, 1, kWindow, 5);
  EXPECT_EQ(others.owner_session, kBob) << "Bob still has it";
}

TEST(RepeatedRequest, CyclesThePowerOnce) {
  EngineUnderTest bench;
  bench.write(kAlice, 1, kWindow, 70);
  const auto cycle = bench.make_request(msg::RequestKind::power_cycle, kAlice, {1});
  const auto first = bench.reply_to(cycle);
  bench.write(kAlice, 1, kWindow, 71);
  EXPECT_EQ(bench.reply_to(cycle), first);
  EXPECT_EQ(bench.value(1, kWindow), 71);
}

TEST(RepeatedRequest, TakesRestoresAndDropsASnapshotOnce) {
  EngineUnderTest bench;
  bench.write(kAlice, 1, kWindow, 80);
  const auto take = bench.make_request(msg::RequestKind::take_snapshot, kAlice);
  const auto first = bench.reply_to(take);
  EXPECT_EQ(bench.reply_to(take), first);
  EXPECT_EQ(bench.counters.snapshots.get(), 1U);
  auto restore = bench.make_request(msg::RequestKind::restore_snapshot, kAlice);
  restore.snapshot = first.snapshot;
  const auto restored = bench.reply_to(restore);
  bench.write(kAlice, 1, kWindow, 81);
  EXPECT_EQ(bench.reply_to(restore), restored);
  EXPECT_EQ(bench.value(1, kWindow), 81);
  auto drop = bench.make_request(msg::RequestKind::drop_snapshot, kAlice);
  drop.snapshot = first.snapshot;
  EXPECT_EQ(bench.reply_to(drop).reason, msg::Reason::none);
  EXPECT_EQ(bench.reply_to(drop).reason, msg::Reason::none) << "the first answer";
}

TEST(RepeatedRequest, SetsTheRateOnce) {
  auto configuration = bench_configuration(1);
  configuration.clock = service::ClockMode::realtime;
  EngineUnderTest bench(configuration);
  auto faster = bench.make_request(msg::RequestKind::set_rate, kAlice);
  faster.rate = 2.0;
  const auto first = bench.reply_to(faster);
  auto usual = bench.make_request(msg::RequestKind::set_rate, kAlice);
  usual.rate = 1.0;
  bench.reply_to(usual);
  EXPECT_EQ(bench.reply_to(faster), first);
  EXPECT_EQ(bench.engine.rate(), 1.0);
}

TEST(RepeatedRequest, IsRefusedAgainWithOneEvent) {
  EngineUnderTest bench;
  const auto release = bench.make_request(msg::RequestKind::release, kAlice);
  const auto first = bench.reply_to(release);
  EXPECT_EQ(first.reason, msg::Reason::nothing_done);
  EXPECT_EQ(bench.events(msg::EventKind::refused).size(), 1U);
  bench.acquire(kAlice, {1});
  EXPECT_EQ(bench.reply_to(release), first);
  EXPECT_EQ(bench.events(msg::EventKind::refused).size(), 0U);
  EXPECT_EQ(bench.read(1, kWindow).reason, msg::Reason::none);
}

TEST(RepeatedRequest, OfAnotherClientIsANewRequest) {
  EngineUnderTest bench;
  auto write = bench.make_request(msg::RequestKind::write, kAlice);
  add_write(write, 1, kWindow, 50);
  bench.reply_to(write);
  write.client = 2;
  write.objects.front().value = 51;
  EXPECT_EQ(bench.reply_to(write).reason, msg::Reason::none);
  EXPECT_EQ(bench.value(1, kWindow), 51);
}

TEST(RepeatedRequest, WithAnOldIncarnationIsNotARepetition) {
  EngineUnderTest bench;
  auto write = bench.make_request(msg::RequestKind::write, kAlice);
  add_write(write, 1, kWindow, 50);
  write.incarnation = kIncarnation - 1;
  EXPECT_EQ(bench.reply_to(write).reason, msg::Reason::wrong_incarnation);
  write.incarnation = kIncarnation;
  EXPECT_EQ(bench.reply_to(write).reason, msg::Reason::none);
  EXPECT_EQ(bench.value(1, kWindow), 50);
}

// Threads of a program may send their requests in a different order from their numbers.
TEST(RepeatedRequest, IsDistinguishedFromAnOvertakenRequest) {
  EngineUnderTest bench;
  auto late = bench.make_request(msg::RequestKind::write, kAlice);
  add_write(late, 1, kWindow, 90);
  bench.write(kAlice, 2, kWindow, 91);
  EXPECT_EQ(bench.reply_to(late).reason, msg::Reason::none);
  EXPECT_EQ(bench.value(1, kWindow), 90);
}

TEST(RepeatedRequest, CountsAsASignOfLife) {
  OwnedBench bench;
  const auto read = bench.make_request(msg::RequestKind::read, kAlice);
  for (int round = 0; round < 10; ++round) {
    bench.steps(90);
    bench.reply_to(read);
  }
  EXPECT_EQ(bench.counters.master_losses.get(), 0U);
}

TEST(RepeatedRequest, IsIgnoredWhileTheFirstWaitsForTheDisk) {
  EngineUnderTest bench;
  const TemporaryDirectory directory;
  service::ParameterSaver saver(std::make_unique<service::ParameterStore>(directory.path(), kBench),
                                {});
  bench.engine.store_with(saver);
  const auto store = bench.make_request(msg::RequestKind::store, kAlice, {1});
  bench.receive(store);
  bench.receive(store);
  EXPECT_EQ(bench.outbox.replies.size(), 0U);
  saver.save_waiting();
  while (bench.engine.answer_stores()) {
  }
  ASSERT_EQ(bench.outbox.replies.size(), 1U) << "one store, one answer";
  const auto first = bench.outbox.replies.front()->reply;
  bench.outbox.replies.pop();
  EXPECT_EQ(bench.reply_to(store), first);
  EXPECT_FALSE(saver.save_waiting()) << "stored once";
}

service::Arrival step_request(EngineUnderTest& bench, std::uint64_t ticks) {
  service::Arrival arrival;
  arrival.kind = service::Arrival::Kind::request;
  arrival.request = bench.make_request(msg::RequestKind::step, kAlice, {2});
  arrival.request.ticks = ticks;
  return arrival;
}

const service::StepRequests::Time kNow{};

TEST(RepeatedRequest, OfAStepReturnsItsTickAndThePresentStatuses) {
  EngineUnderTest bench;
  const auto step = step_request(bench, 5);
  service::StepRequests& steps = bench.engine.steps();
  auto first = step;
  EXPECT_TRUE(steps.handle(first, kNow));
  ASSERT_EQ(steps.ticks_to_run(kNow), 5U);
  auto second = step;
  EXPECT_FALSE(steps.handle(second, kNow));
  EXPECT_EQ(bench.outbox.replies.size(), 0U) << "it is in progress";
  bench.steps(5);
  steps.answer_due(kNow);
  ASSERT_TRUE(bench.reply());
  bench.steps(2);
  auto third = step;
  EXPECT_FALSE(steps.handle(third, kNow));
  EXPECT_EQ(steps.ticks_to_run(kNow), 0U);
  const auto reply = bench.reply();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->tick, 5U);
  ASSERT_EQ(reply->statuses.size(), 1U);
  EXPECT_EQ(reply->statuses[0].axis, 2U);
  EXPECT_EQ(reply->statuses[0].tick, 7U);
}

TEST(RepeatedRequest, OfAStepWithOtherAxesIsAnsweredWithoutStatuses) {
  EngineUnderTest bench;
  const auto step = step_request(bench, 0);
  service::StepRequests& steps = bench.engine.steps();
  auto first = step;
  EXPECT_TRUE(steps.handle(first, kNow));
  ASSERT_EQ(steps.ticks_to_run(kNow), 0U);
  steps.answer_due(kNow);
  ASSERT_TRUE(bench.reply());
  auto other = step;
  other.request.axes = {99};
  EXPECT_FALSE(steps.handle(other, kNow));
  EXPECT_EQ(bench.reply().value_or(msg::Reply{}).statuses.size(), 0U);
}

/// Sends `count` further requests of the client, each of which is answered.
void answer_more(EngineUnderTest& bench, std::uint64_t client, std::uint64_t count) {
  auto read = bench.make_request(msg::RequestKind::read, 0);
  add_write(read, 1, kWindow, 0);
  read.client = client;
  for (std::uint64_t number = 1; number <= count; ++number) {
    read.request_id = 1'000'000 + number;
    bench.reply_to(read);
  }
}

// 128 answers of a client are kept: the 128th further answer replaces the first.
TEST(RepeatedRequest, WithADiscardedAnswerIsRefusedAndNotExecutedAgain) {
  EngineUnderTest bench;
  auto write = bench.make_request(msg::RequestKind::write, kAlice);
  add_write(write, 1, kWindow, 50);
  const auto first = bench.reply_to(write);
  auto read = bench.make_request(msg::RequestKind::read, 0);
  add_write(read, 1, kWindow, 0);
  for (std::uint64_t more = 1; more < 128; ++more) {
    read.request_id = write.request_id + more;
    bench.reply_to(read);
  }
  EXPECT_EQ(bench.reply_to(write), first);
  read.request_id = write.request_id + 128;
  bench.reply_to(read);
  EXPECT_EQ(bench.reply_to(write).reason, msg::Reason::too_late);
}

// The engine cannot tell a number 1,024 below the highest from one that never arrived.
TEST(RepeatedRequest, IsRefusedWithANumberFarBelowTheHighest) {
  EngineUnderTest bench;
  auto late = bench.make_request(msg::RequestKind::write, kAlice);
  add_write(late, 1, kWindow, 50);
  auto newest = bench.make_request(msg::RequestKind::read, 0);
  add_write(newest, 1, kWindow, 0);
  newest.request_id = late.request_id + 1'024;
  bench.reply_to(newest);
  EXPECT_EQ(bench.reply_to(late).reason, msg::Reason::too_late);
  EXPECT_EQ(bench.value(1, kWindow), 100) << "6067h has its default";
}

// Eight clients with 128 answers each fill the 1,024 places; an answer to a ninth replaces the
// oldest.
TEST(RepeatedRequest, DiscardsTheOldestAnswersOfManyClientsFirst) {
  EngineUnderTest bench;
  auto write = bench.make_request(msg::RequestKind::write, kAlice);
  write.client = 100;
  write.request_id = 1'000'000;
  add_write(write, 1, kWindow, 50);
  const auto first = bench.reply_to(write);
  answer_more(bench, 100, 127);
  for (std::uint64_t client = 101; client < 108; ++client) answer_more(bench, client, 128);
  EXPECT_EQ(bench.reply_to(write), first);
  answer_more(bench, 108, 1);
  EXPECT_EQ(bench.reply_to(write).reason, msg::Reason::too_late);
}

// 1,024 clients are remembered: the 1,024th new client replaces the first.
TEST(RepeatedRequest, OfAForgottenClientIsANewRequest) {
  EngineUnderTest bench;
  auto write = bench.make_request(msg::RequestKind::write, 0);
  add_write(write, 1, kWindow, 50);
  write.client = 99;
  bench.reply_to(write);
  bench.write(kAlice, 1, kWindow, 60);  // the second client
  for (std::uint64_t client = 0; client < 1'022; ++client) answer_more(bench, 100 + client, 1);
  bench.reply_to(write);
  EXPECT_EQ(bench.engine.bank().read(0, {kWindow, 0}).value, 60);
  answer_more(bench, 2'000, 1);
  bench.reply_to(write);
  EXPECT_EQ(bench.engine.bank().read(0, {kWindow, 0}).value, 50);
}

// ---- command frames ---------------------------------------------------------------------------

TEST(RepeatedFrame, ActsOnceAndHasTheSameAnswer) {
  OwnedBench bench;
  const auto frame = bench.command(1, 50);
  bench.receive(frame);
  const auto first = bench.command_reply();
  ASSERT_TRUE(first);
  bench.receive(bench.command(2, 60));
  ASSERT_TRUE(bench.command_reply());
  bench.steps(1);
  bench.receive(frame);
  EXPECT_EQ(bench.command_reply(), first);
  EXPECT_EQ(bench.value(1, kWindow), 60);
  EXPECT_EQ(bench.events(msg::EventKind::refused).size(), 0U);
}

TEST(RepeatedFrame, IsRefusedAgainWithOneEvent) {
  OwnedBench bench;
  auto frame = bench.command(1, 50);
  frame.epoch = bench.epoch + 1;
  bench.receive(frame);
  const auto first = bench.command_reply();
  ASSERT_TRUE(first);
  bench.receive(frame);
  EXPECT_EQ(bench.command_reply(), first);
  EXPECT_EQ(bench.events(msg::EventKind::refused).size(), 1U);
}

TEST(RepeatedFrame, IsIgnoredWhileTheFirstWaitsForItsTick) {
  OwnedBench bench;
  auto frame = bench.command(1, 50);
  frame.apply_at_tick = 5;
  bench.receive(frame);
  bench.receive(frame);
  EXPECT_FALSE(bench.command_reply());
  bench.steps(5);
  const auto first = bench.command_reply();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->tick, 5U);
  EXPECT_FALSE(bench.command_reply()) << "it was taken once";
  bench.receive(frame);
  EXPECT_EQ(bench.command_reply(), first);
}

TEST(RepeatedFrame, IsIgnoredWhileTheFirstWaitsEvenWithANumberFarBelowTheHighest) {
  OwnedBench bench;
  auto frame = bench.command(1, 50);
  frame.apply_at_tick = 5;
  bench.receive(frame);
  bench.receive(bench.frame(1'025));
  ASSERT_TRUE(bench.command_reply());
  bench.receive(frame);
  EXPECT_FALSE(bench.command_reply());
}

TEST(RepeatedFrame, StaysUnansweredIfNoAnswerWasRequested) {
  OwnedBench bench;
  auto frame = bench.command(1, 50);
  frame.flags = 0;
  bench.receive(frame);
  bench.receive(bench.command(2, 60));
  static_cast<void>(bench.command_reply());
  bench.receive(frame);
  EXPECT_FALSE(bench.command_reply());
  EXPECT_EQ(bench.value(1, kWindow), 60);
}

TEST(OvertakenFrame, IsExecutedAfterLaterKeepAlives) {
  OwnedBench bench;
  bench.receive(bench.frame(3));
  EXPECT_TRUE(bench.command_reply()->refusals.empty());
  bench.receive(bench.command(1, 50));
  EXPECT_TRUE(bench.command_reply()->refusals.empty());
  bench.receive(bench.command(2, 60));
  EXPECT_TRUE(bench.command_reply()->refusals.empty());
  EXPECT_EQ(bench.value(1, kWindow), 60);
}

TEST(OvertakenFrame, IsRefusedAfterALaterCommand) {
  OwnedBench bench;
  bench.receive(bench.command(2, 60));
  EXPECT_TRUE(bench.command_reply()->refusals.empty());
  bench.receive(bench.command(1, 50));
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::too_late);
  EXPECT_EQ(bench.value(1, kWindow), 60);
}

TEST(OvertakenFrame, IsRefusedAfterALaterCancellingFrame) {
  OwnedBench bench;
  auto cancel = bench.frame(2);
  cancel.flags = msg::FRAME_CANCEL_PENDING;
  bench.receive(cancel);
  auto late = bench.command(1, 50);
  late.apply_at_tick = 5;
  bench.receive(late);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::too_late);
}

TEST(OvertakenFrame, IsExecutedAfterARefusedLaterCommand) {
  OwnedBench bench;
  auto refused = bench.command(2, 60);
  refused.epoch = bench.epoch + 1;
  bench.receive(refused);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::stale_epoch);
  bench.receive(bench.command(1, 50));
  EXPECT_TRUE(bench.command_reply()->refusals.empty());
  EXPECT_EQ(bench.value(1, kWindow), 50);
}

TEST(RepeatedFrame, WithADiscardedAnswerIsRefusedAndNotExecutedAgain) {
  OwnedBench bench;
  bench.receive(bench.command(1, 50));
  ASSERT_TRUE(bench.command_reply());
  for (std::uint64_t sequence = 2; sequence <= 129; ++sequence) {  // 128 answers are kept
    bench.receive(bench.command(sequence, 60));
    ASSERT_TRUE(bench.command_reply());
  }
  bench.receive(bench.command(2, 70));
  EXPECT_TRUE(bench.command_reply()->refusals.empty()) << "the first answer";
  bench.receive(bench.command(1, 50));
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::too_late);
  EXPECT_EQ(bench.value(1, kWindow), 60);
}

TEST(Repeats, AllocateNothingAfterTheFirstMessages) {
  OwnedBench bench;
  auto write = bench.make_request(msg::RequestKind::write, kAlice);
  for (int count = 0; count < 64; ++count) add_write(write, 1, kWindow, count);
  std::uint64_t allocations = 0;
  for (std::uint64_t round = 0; round < 600; ++round) {
    write.request_id = write.request_id + (round % 2);  // each twice
    bench.inbox.receive(write, {});
    bench.inbox.receive(bench.command(1 + round / 2, 50), {});  // the receive thread may allocate
    const AllocationGuard guard;
    while (service::Arrival* const arrival = bench.inbox.front()) {
      bench.engine.handle(*arrival);
      bench.inbox.pop();
    }
    bench.engine.step();
    while (bench.outbox.command_replies.front() != nullptr) bench.outbox.command_replies.pop();
    while (bench.outbox.replies.front() != nullptr) bench.outbox.replies.pop();
    allocations += guard.count();
  }
  EXPECT_EQ(allocations, 0U);
}

}  // namespace
}  // namespace vdrive::test
