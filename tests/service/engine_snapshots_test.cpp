// SPDX-License-Identifier: Apache-2.0
#include "base/event_codes.hpp"
#include "service/engine_under_test.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace vdrive::test {
namespace {

service::Configuration standing_bench() {
  auto configuration = bench_configuration(3);
  configuration.watchdog.reset();
  return configuration;
}

std::uint64_t take(EngineUnderTest& bench) {
  const auto reply = bench.reply_to(bench.make_request(msg::RequestKind::take_snapshot, kAlice));
  EXPECT_EQ(reply.reason, msg::Reason::none);
  return reply.snapshot;
}

msg::Reply reply_about(EngineUnderTest& bench, msg::RequestKind kind, std::uint64_t snapshot,
                       std::uint64_t session = kAlice) {
  auto request = bench.make_request(kind, session);
  request.snapshot = snapshot;
  return bench.reply_to(request);
}

msg::Reply restore(EngineUnderTest& bench, std::uint64_t snapshot, std::uint64_t session = kAlice) {
  return reply_about(bench, msg::RequestKind::restore_snapshot, snapshot, session);
}

/// Moves axis 1 to `target`. @return the status hash of every tick.
std::vector<std::uint64_t> move(EngineUnderTest& bench, std::int32_t target) {
  bench.write(kAlice, 1, 0x607A, target);
  bench.write(kAlice, 1, 0x6040, 0x0F);
  bench.write(kAlice, 1, 0x6040, 0x3F);
  std::vector<std::uint64_t> hashes;
  for (int tick = 0; tick < 500; ++tick) {
    bench.steps(1);
    hashes.push_back(bench.engine.bank().status_hash());
  }
  return hashes;
}

TEST(SnapshotRequest, MakesIdenticalBranches) {
  EngineUnderTest bench(standing_bench());
  bench.write(kAlice, 1, 0x6060, 1);
  bench.write(kAlice, 1, 0x6040, 0x0F);
  bench.steps(10);
  static_cast<void>(move(bench, 70));
  const std::uint64_t number = take(bench);
  const auto first = move(bench, 5'000);
  EXPECT_EQ(restore(bench, number).reason, msg::Reason::none);
  const auto other = move(bench, -300);
  EXPECT_EQ(restore(bench, number).reason, msg::Reason::none);
  EXPECT_NE(first, other);
  EXPECT_EQ(move(bench, 5'000), first);
}

TEST(SnapshotRequest, RestoresTheAxesAndNotTheTime) {
  EngineUnderTest bench(standing_bench());
  bench.steps(10);
  bench.write(kAlice, 1, 0x6081, 1'234);
  const std::uint64_t number = take(bench);
  bench.write(kAlice, 1, 0x6081, 4'321);
  bench.write(kAlice, 2, 0x6040, 0x0F);
  bench.steps(10);
  static_cast<void>(bench.events({}));
  EXPECT_EQ(restore(bench, number).tick, 20U);
  EXPECT_EQ(bench.engine.tick(), 20U);
  EXPECT_EQ(bench.value(1, 0x6081), 1'234);
  EXPECT_EQ(bench.value(2, 0x6041), 0x250);
  const auto news = bench.events(msg::EventKind::snapshot);
  ASSERT_EQ(news.size(), 1U);
  EXPECT_EQ(news[0].code, service::SnapshotCode::kRestored);
  EXPECT_EQ(news[0].detail, service::EventDetail{service::Label{number}});
  EXPECT_EQ(bench.read(2, 0x6041).owner_session, 0U);
  bench.steps(1);
  EXPECT_EQ(bench.events(msg::EventKind::state_changed).size(), 1U) << "axis 2 is disabled again";
}

TEST(SnapshotRequest, KeepsOwnersAndEpochs) {
  EngineUnderTest bench(standing_bench());
  const std::uint64_t number = take(bench);
  const auto epoch = bench.acquire(kAlice, {1}).epoch;
  EXPECT_EQ(restore(bench, number).epoch, epoch);
  EXPECT_EQ(bench.write(kBob, 1, 0x6081, 1).objects[0].abort_code, msg::Reason{0x08000021});
}

TEST(SnapshotRequest, DropsPendingFrames) {
  EngineUnderTest bench(standing_bench());
  bench.acquire(kAlice, {1});
  const std::uint64_t number = take(bench);
  auto frame = bench.make_frame(kAlice);
  frame.apply_at_tick = 100;
  add_command(frame, 1);
  bench.receive(frame);
  ASSERT_FALSE(bench.command_reply());
  EXPECT_EQ(restore(bench, number).reason, msg::Reason::none);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::cancelled);
  EXPECT_EQ(bench.counters.pending_frames.get(), 0U);
}

TEST(SnapshotRequest, IsNotRestoredOverAxesOfAnotherSession) {
  EngineUnderTest bench(standing_bench());
  const std::uint64_t number = take(bench);
  bench.acquire(kBob, {2});
  const auto reply = restore(bench, number);
  EXPECT_EQ(reply.reason, msg::Reason{0x08000021});
  EXPECT_EQ(reply.refused_axis, 2U);
  EXPECT_EQ(reply.owner_session, kBob);
  EXPECT_EQ(restore(bench, number, kBob).reason, msg::Reason::none) << "all others are free";
}

TEST(SnapshotRequest, KeepsUpToSixteenSnapshotsAndDropsThemOnRequest) {
  EngineUnderTest bench(standing_bench());
  for (std::uint64_t number = 1; number <= 16; ++number) EXPECT_EQ(take(bench), number);
  EXPECT_EQ(bench.counters.snapshots.get(), 16U);
  const auto full = bench.reply_to(bench.make_request(msg::RequestKind::take_snapshot, kAlice));
  EXPECT_EQ(full.reason, msg::Reason::too_many_snapshots);
  EXPECT_EQ(full.snapshot, 0U);
  EXPECT_EQ(reply_about(bench, msg::RequestKind::drop_snapshot, 5).reason, msg::Reason::none);
  EXPECT_EQ(reply_about(bench, msg::RequestKind::drop_snapshot, 5).reason,
            msg::Reason::unknown_snapshot);
  EXPECT_EQ(restore(bench, 5).reason, msg::Reason::unknown_snapshot);
  EXPECT_EQ(restore(bench, 0).reason, msg::Reason::unknown_snapshot);
  EXPECT_EQ(take(bench), 17U) << "a number is never used again";
}

// Three snapshots are taken, in ticks 0, 10 and 10, and the second is dropped.
TEST(SnapshotRequest, ListsTheKeptSnapshotsOneAfterTheOther) {
  EngineUnderTest bench(standing_bench());
  const auto next = [&bench](std::uint64_t after) {
    const auto reply = reply_about(bench, msg::RequestKind::next_snapshot, after);
    EXPECT_EQ(reply.reason, msg::Reason::none);
    return std::pair(reply.snapshot, reply.tick);
  };
  EXPECT_EQ(next(0).first, 0U) << "none is kept";
  EXPECT_EQ(take(bench), 1U);
  bench.steps(10);
  EXPECT_EQ(take(bench), 2U);
  EXPECT_EQ(take(bench), 3U);
  ASSERT_EQ(reply_about(bench, msg::RequestKind::drop_snapshot, 2).reason, msg::Reason::none);
  bench.steps(5);
  EXPECT_EQ(next(0), std::pair(1UL, 0UL));
  EXPECT_EQ(next(1), std::pair(3UL, 10UL));
  EXPECT_EQ(next(3).first, 0U) << "there is no further one";
}

TEST(SnapshotRequest, NeedsAClockThatStandsStill) {
  auto configuration = standing_bench();
  configuration.clock = service::ClockMode::realtime;
  EngineUnderTest running(configuration);
  for (const auto kind : {msg::RequestKind::take_snapshot, msg::RequestKind::restore_snapshot,
                          msg::RequestKind::drop_snapshot}) {
    EXPECT_EQ(reply_about(running, kind, 1).reason, msg::Reason::time_passes);
  }
  configuration.rate = 0.0;
  EngineUnderTest paused(configuration);
  EXPECT_EQ(restore(paused, take(paused)).reason, msg::Reason::none);
  EXPECT_EQ(reply_about(running, msg::RequestKind::next_snapshot, 0).reason, msg::Reason::none)
      << "the list of snapshots is available at any time";
}

}  // namespace
}  // namespace vdrive::test
