// SPDX-License-Identifier: Apache-2.0
#include "core/support/allocation_guard.hpp"
#include "publish/event_text.hpp"
#include "service/engine_under_test.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

namespace vdrive::test {
namespace {

/// A bench on which Alice owns axes 1 and 2.
struct OwnedBench : EngineUnderTest {
  OwnedBench() {
    acquire(kAlice, {1, 2});
    static_cast<void>(events({}));
  }
};

TEST(CommandFrame, AppliesMembersBeforeTheControlword) {
  OwnedBench bench;
  auto frame = bench.make_frame(kAlice);
  auto& command = add_command(frame, 1);
  command.members = msg::HAS_OP_MODE_CMD | msg::HAS_POSITION_USER_TARGET_VALUE |
                    msg::HAS_PROFILE_VELOCITY | msg::HAS_PROFILE_ACC | msg::HAS_PROFILE_DEC |
                    msg::HAS_POSITIONING_OPTION_CODE;
  command.op_mode_cmd = 1;
  command.position_user_target_value = 10'000;
  command.profile_velocity = 1'000;
  command.profile_acc = 6'000;
  command.profile_dec = 6'001;
  command.positioning_option_code = 1;
  set_controlword(command, 0x0F);
  bench.receive(frame);
  const auto reply = bench.command_reply();
  ASSERT_TRUE(reply);
  EXPECT_TRUE(reply->refusals.empty());
  EXPECT_EQ(reply->tick, 1U);
  EXPECT_EQ(reply->sequence_number, frame.sequence_number);
  bench.steps(1);
  EXPECT_EQ(bench.value(1, 0x6061), 1);
  EXPECT_EQ(bench.value(1, 0x607A), 10'000);
  EXPECT_EQ(bench.value(1, 0x6081), 1'000);
  EXPECT_EQ(bench.value(1, 0x6083), 6'000);
  EXPECT_EQ(bench.value(1, 0x6084), 6'001);
  EXPECT_EQ(bench.value(1, 0x60F2), 1);
  EXPECT_EQ(bench.value(1, 0x6041) & 0x6F, 0x27);
  EXPECT_EQ(bench.counters.commands_applied.get(), 1U);
}

TEST(CommandFrame, IsAnsweredOnlyOnRequestOrRefusal) {
  OwnedBench bench;
  auto frame = bench.make_frame(kAlice);
  frame.flags = 0;
  set_controlword(add_command(frame, 1), 0x06);
  bench.receive(frame);
  EXPECT_FALSE(bench.command_reply());
}

TEST(CommandFrame, WithoutAxesIsAKeepAlive) {
  OwnedBench bench;
  for (int round = 0; round < 10; ++round) {
    bench.steps(90);
    bench.receive(bench.make_frame(kAlice));
    EXPECT_TRUE(bench.command_reply()->refusals.empty());
  }
  EXPECT_EQ(bench.counters.master_losses.get(), 0U);
}

TEST(CommandFrame, OfAnotherIncarnationIsRefused) {
  OwnedBench bench;
  auto frame = bench.make_frame(kAlice);
  frame.incarnation = kIncarnation - 1;
  bench.receive(frame);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::wrong_incarnation);
  EXPECT_EQ(bench.events(msg::EventKind::refused).size(), 1U);
}

TEST(CommandFrame, WithoutSessionOrEpochIsRefused) {
  OwnedBench bench;
  auto frame = bench.make_frame(kAlice);
  frame.session = 0;
  bench.receive(frame);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::bad_session);
  bench.receive(bench.make_frame(kBob));
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::not_owner);
  auto guessed = bench.make_frame(kBob);
  guessed.epoch = 1;
  bench.receive(guessed);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::stale_epoch);
}

TEST(CommandFrame, IsRefusedWhenItsNumberIsZero) {
  OwnedBench bench;
  auto zero = bench.make_frame(kAlice);
  zero.sequence_number = 0;
  bench.receive(zero);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::too_late);
}

TEST(CommandFrame, WithUnknownFlagsIsRefused) {
  OwnedBench bench;
  auto frame = bench.make_frame(kAlice);
  frame.flags = 0x80000000;
  bench.receive(frame);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::unknown_flags);
}

TEST(CommandFrame, BeyondTheBoundsIsRefused) {
  OwnedBench bench;
  auto axes = bench.make_frame(kAlice);
  axes.axes.resize(msg::MAX_AXES_PER_FRAME + 1);
  bench.receive(axes);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::too_many_axes);
  auto objects = bench.make_frame(kAlice);
  add_command(objects, 1).objects.resize(msg::MAX_OBJECTS_PER_AXIS + 1);
  bench.receive(objects);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::too_many_objects);
}

TEST(CommandFrame, RefusesBadCommandsAndAppliesTheOthers) {
  OwnedBench bench;
  auto frame = bench.make_frame(kAlice);
  set_controlword(add_command(frame, 1), 0x06);
  set_controlword(add_command(frame, 99), 0x06);  // no such axis
  set_controlword(add_command(frame, 3), 0x06);   // not hers
  set_controlword(add_command(frame, 1), 0x0F);   // twice
  auto& unknown = add_command(frame, 2);
  unknown.members = 0x8000;
  bench.receive(frame);
  const auto reply = bench.command_reply();
  ASSERT_TRUE(reply);
  ASSERT_EQ(reply->refusals.size(), 4U);
  EXPECT_EQ(reply->refusals[0].axis, 99U);
  EXPECT_EQ(reply->refusals[0].reason, msg::Reason::unknown_axis);
  EXPECT_EQ(reply->refusals[1].axis, 3U);
  EXPECT_EQ(reply->refusals[1].reason, msg::Reason::not_owner);
  EXPECT_EQ(reply->refusals[2].axis, 1U);
  EXPECT_EQ(reply->refusals[2].reason, msg::Reason::axis_twice);
  EXPECT_EQ(reply->refusals[3].axis, 2U);
  EXPECT_EQ(reply->refusals[3].reason, msg::Reason::unknown_members);
  bench.steps(1);
  EXPECT_EQ(bench.value(1, 0x6041) & 0x6F, 0x21) << "the first of the two counts";
}

TEST(CommandFrame, IsRefusedWithTheRefusedObject) {
  OwnedBench bench;
  auto frame = bench.make_frame(kAlice);
  auto& command = add_command(frame, 1);
  auto& bad = command.objects.emplace_back();
  bad.index = 0x6080;
  bad.value = std::numeric_limits<std::int64_t>::max();
  auto& good = command.objects.emplace_back();
  good.index = 0x6067;
  good.value = 55;
  auto& controlword = command.objects.emplace_back();
  controlword.index = 0x6040;
  controlword.value = 6;
  bench.receive(frame);
  const auto reply = bench.command_reply();
  ASSERT_EQ(reply->refusals.size(), 2U);
  EXPECT_EQ(reply->refusals[0].index, 0x6080U);
  EXPECT_EQ(reply->refusals[0].reason, msg::Reason{0x06090031});
  EXPECT_EQ(reply->refusals[1].index, 0x6040U) << "the controlword has its member";
  EXPECT_EQ(reply->refusals[1].reason, msg::Reason{0x06040041});
  EXPECT_EQ(bench.value(1, 0x6067), 55);
}

TEST(CommandFrame, WithAllOrNothingChangesNothingWhenOneIsRefused) {
  OwnedBench bench;
  auto frame = bench.make_frame(kAlice);
  frame.flags = msg::FRAME_ALL_OR_NOTHING;
  auto& first = add_command(frame, 1);
  first.members = msg::HAS_PROFILE_VELOCITY;
  first.profile_velocity = 123;
  set_controlword(first, 0x0F);
  auto& second = add_command(frame, 2);
  second.members = msg::HAS_OP_MODE_CMD;
  second.op_mode_cmd = 99;
  bench.receive(frame);
  EXPECT_EQ(bench.command_reply()->refusals.size(), 1U);
  bench.steps(1);
  EXPECT_EQ(bench.value(1, 0x6081), 68'267);
  EXPECT_EQ(bench.value(1, 0x6041), 0x250);
  EXPECT_EQ(bench.counters.commands_refused.get(), 2U);
}

/// An all-or-nothing frame of Alice to axis 1 that writes `value`.
/// @param is_refused whether the frame then also writes 6041h, which is read-only
msg::CommandFrame whole_frame(OwnedBench& bench, ObjectAddress address, std::int64_t value,
                              bool is_refused) {
  auto frame = bench.make_frame(kAlice);
  frame.flags = msg::FRAME_ALL_OR_NOTHING | msg::FRAME_WANT_REPLY;
  auto& objects = add_command(frame, 1).objects;
  auto& object = objects.emplace_back();
  object.index = address.index;
  object.subindex = address.subindex;
  object.value = value;
  if (is_refused) objects.emplace_back().index = 0x6041;
  return frame;
}

// The writes of this test act immediately: their effect would stay even if the register got its old
// value back.
TEST(CommandFrame, WithAllOrNothingDoesWhatActsAtOnceOnlyWhenNoneIsRefused) {
  struct ActingWrite {
    ObjectAddress address;
    std::int64_t value;
    std::int64_t before;
  };

  for (const ActingWrite& write :
       {ActingWrite{{0x5E0A, 0}, 1, 0}, ActingWrite{{0x5E0B, 0}, 1, 0},
        ActingWrite{{0x60C1, 1}, 1, 0}, ActingWrite{{0x60C4, 2}, 2, 1},
        ActingWrite{{0x60C4, 6}, 1, 0}, ActingWrite{{0x60B8, 0}, 0x0011, 0}}) {
    SCOPED_TRACE(address_text(write.address));
    OwnedBench bench;
    for (const bool is_refused : {true, false}) {
      bench.receive(whole_frame(bench, write.address, write.value, is_refused));
      EXPECT_EQ(bench.command_reply()->refusals.size(), is_refused ? 1U : 0U);
      EXPECT_EQ(bench.value(1, write.address.index, write.address.subindex),
                is_refused ? write.before : write.value);
      const bool has_probe = !is_refused && write.address.index == 0x60B8;
      EXPECT_EQ(bench.value(1, 0x60B9), has_probe ? 1 : 0);
    }
  }
}

// The first write of a set-point makes the axis follow the register. If the write of a refused
// frame was only undone, the axis would follow the old value.
TEST(CommandFrame, WithAllOrNothingBeginsNoStreamWhenOneIsRefused) {
  struct OldSetPoint {
    int mode;
    std::uint16_t object;
    std::int64_t value;
  };

  for (const OldSetPoint& old : {OldSetPoint{7, 0x60C1, 5'000}, OldSetPoint{8, 0x607A, 5'000},
                                 OldSetPoint{9, 0x60FF, 5'000}, OldSetPoint{10, 0x6071, 500}}) {
    SCOPED_TRACE(old.mode);
    OwnedBench bench;
    const std::uint8_t subindex = old.object == 0x60C1 ? 1 : 0;
    bench.write(kAlice, 1, old.object, old.value, subindex);
    bench.write(kAlice, 1, 0x6060, old.mode);
    bench.write(kAlice, 1, 0x6040, old.mode == 7 ? 0x1F : 0x0F);
    bench.steps(10);
    ASSERT_EQ(bench.value(1, 0x6061), old.mode);
    bench.receive(whole_frame(bench, {old.object, subindex}, 2 * old.value, true));
    ASSERT_EQ(bench.command_reply()->refusals.size(), 1U);
    EXPECT_EQ(bench.value(1, old.object, subindex), old.value);
    bench.steps(50);
    EXPECT_EQ(bench.value(1, 0x6064), 0);
    EXPECT_EQ(bench.value(1, 0x606B), 0);
  }
}

TEST(CommandFrame, WithAllOrNothingGivesNoTargetBehindALimitSwitchWhenOneIsRefused) {
  OwnedBench bench;
  bench.write(kAlice, 1, 0x6060, 3);
  bench.write(kAlice, 1, 0x60FF, 1'000);
  bench.write(kAlice, 1, 0x6040, 0x0F);
  bench.steps(50);
  ASSERT_EQ(bench.value(1, 0x606B), 1'000);
  bench.write(kAlice, 1, 0x5E06, 1);  // the positive limit switch
  bench.steps(50);
  ASSERT_EQ(bench.value(1, 0x606B), 0);
  bench.receive(whole_frame(bench, {0x60FF, 0}, -1'000, true));
  ASSERT_EQ(bench.command_reply()->refusals.size(), 1U);
  bench.write(kAlice, 1, 0x5E06, 0);
  bench.steps(50);
  EXPECT_EQ(bench.value(1, 0x606B), 0) << "60FFh waits for its next write";
}

TEST(CommandFrame, WithAllOrNothingKeepsTheErrorHistoryWhenOneIsRefused) {
  OwnedBench bench;
  bench.write(kAlice, 1, 0x5E02, 1);  // over-current
  bench.steps(1);
  ASSERT_EQ(bench.value(1, 0x1003), 1);
  bench.receive(whole_frame(bench, {0x1003, 0}, 0, true));
  EXPECT_EQ(bench.value(1, 0x1003), 1);
}

// 607Bh decides which values of 60F2h are valid, and 5E20h:05 which values of 6060h. All writes of
// an all-or-nothing frame are judged before any is made, so 60F2h or 6060h would be judged by the
// old value.
TEST(CommandFrame, WithAllOrNothingRefusesObjectsThatDecideOnOthers) {
  OwnedBench bench;
  for (const ObjectAddress address :
       {ObjectAddress{0x607B, 1}, ObjectAddress{0x607B, 2}, ObjectAddress{0x5E20, 5}}) {
    SCOPED_TRACE(address_text(address));
    bench.receive(whole_frame(bench, address, 1, false));
    const auto reply = bench.command_reply();
    ASSERT_TRUE(reply);
    ASSERT_EQ(reply->refusals.size(), 1U);
    EXPECT_EQ(reply->refusals[0].reason, msg::Reason{0x06040041});
    EXPECT_EQ(bench.value(1, address.index, address.subindex), 0);
  }
}

TEST(CommandFrame, WithAllOrNothingAppliesAllWhenNoneIsRefused) {
  OwnedBench bench;
  auto frame = bench.make_frame(kAlice);
  frame.flags = msg::FRAME_ALL_OR_NOTHING;
  set_controlword(add_command(frame, 1), 0x0F);
  set_controlword(add_command(frame, 2), 0x0F);
  bench.receive(frame);
  EXPECT_FALSE(bench.command_reply());
  bench.steps(1);
  EXPECT_EQ(bench.value(1, 0x6041) & 0x6F, 0x27);
  EXPECT_EQ(bench.value(2, 0x6041) & 0x6F, 0x27);
}

TEST(CommandFrame, WaitsForItsTick) {
  OwnedBench bench;
  auto frame = bench.make_frame(kAlice);
  frame.apply_at_tick = 5;
  set_controlword(add_command(frame, 1), 0x0F);
  bench.receive(frame);
  EXPECT_FALSE(bench.command_reply()) << "answered when it is applied";
  bench.steps(4);
  EXPECT_EQ(bench.value(1, 0x6041), 0x250);
  bench.steps(1);
  EXPECT_EQ(bench.value(1, 0x6041) & 0x6F, 0x27);
  EXPECT_EQ(bench.command_reply()->tick, 5U);
}

TEST(CommandFrame, IsRefusedTooLateTooFarAheadAndPastItsValidity) {
  OwnedBench bench;
  bench.steps(50);
  auto late = bench.make_frame(kAlice);
  late.apply_at_tick = 50;
  bench.receive(late);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::too_late);
  auto far = bench.make_frame(kAlice);
  far.apply_at_tick = 50 + 10'001;
  bench.receive(far);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::too_far_ahead);
  auto endless = bench.make_frame(kAlice);
  endless.apply_at_tick = std::numeric_limits<std::uint64_t>::max();
  bench.receive(endless);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::too_far_ahead);
  auto expired = bench.make_frame(kAlice);
  expired.valid_until_tick = 50;
  bench.receive(expired);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::too_late);
  auto in_time = bench.make_frame(kAlice);
  in_time.valid_until_tick = 51;
  bench.receive(in_time);
  EXPECT_TRUE(bench.command_reply()->refusals.empty());
}

// The next tick is 51, so a frame for tick 45 is 6 ticks late.
TEST(CommandFrame, IsRefusedWithItsDelayWhenLate) {
  OwnedBench bench;
  bench.steps(50);
  auto late = bench.make_frame(kAlice);
  late.apply_at_tick = 45;
  bench.receive(late);
  const auto reply = bench.command_reply();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->refusals.at(0).reason, msg::Reason::too_late);
  EXPECT_EQ(reply->tick - late.apply_at_tick, 6U);
  const auto events = bench.events(msg::EventKind::refused);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(std::get<service::RefusedMessage>(events[0].detail).late_by, 6U);
  EXPECT_NE(service::words_of(events[0]).find("late by 6 ticks"), std::string::npos);
}

TEST(CommandFrame, IsRefusedWithoutADelayWhenOvertaken) {
  OwnedBench bench;
  bench.steps(50);
  const auto overtaken = bench.make_frame(kAlice);
  auto command = overtaken;
  command.sequence_number = overtaken.sequence_number + 1;
  set_controlword(add_command(command, 1), 0x06);
  bench.receive(command);
  static_cast<void>(bench.command_reply());
  bench.receive(overtaken);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::too_late);
  const auto events = bench.events(msg::EventKind::refused);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(std::get<service::RefusedMessage>(events[0].detail).late_by, 0U);
}

TEST(CommandFrame, IsAcceptedUpToTenSecondsAhead) {
  OwnedBench bench;
  bench.steps(50);
  auto farthest = bench.make_frame(kAlice);
  farthest.apply_at_tick = 50 + 10'000;
  bench.receive(farthest);
  EXPECT_FALSE(bench.command_reply()) << "it waits";
  auto beyond = bench.make_frame(kAlice);
  beyond.apply_at_tick = 50 + 10'001;
  bench.receive(beyond);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::too_far_ahead);
}

TEST(PendingFrame, ReceivedLaterTakesPrecedenceInTheSameTick) {
  OwnedBench bench;
  for (const std::uint32_t velocity : {111U, 222U}) {
    auto frame = bench.make_frame(kAlice);
    frame.apply_at_tick = 20;
    auto& command = add_command(frame, 1);
    command.members = msg::HAS_PROFILE_VELOCITY;
    command.profile_velocity = velocity;
    bench.receive(frame);
  }
  bench.steps(20);
  EXPECT_EQ(bench.value(1, 0x6081), 222);
  EXPECT_EQ(bench.command_reply()->sequence_number, 1U);
  EXPECT_EQ(bench.command_reply()->sequence_number, 2U);
}

TEST(PendingFrame, IsRefusedWhenAJumpCarriesTheTickPastItsValidity) {
  OwnedBench bench;
  auto frame = bench.make_frame(kAlice);
  frame.apply_at_tick = 20;
  frame.valid_until_tick = 25;
  set_controlword(add_command(frame, 1), 0x0F);
  bench.receive(frame);
  bench.engine.jump(30);  // the next tick is 31, six after the last valid one
  bench.steps(1);
  const auto reply = bench.command_reply();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->refusals.at(0).reason, msg::Reason::too_late);
  const auto events = bench.events(msg::EventKind::refused);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(std::get<service::RefusedMessage>(events[0].detail).late_by, 11U)
      << "since its tick: 31 - 20";
  EXPECT_EQ(bench.value(1, 0x6041), 0x250);
}

TEST(PendingFrame, IsCancelledByAFlag) {
  OwnedBench bench;
  auto waiting = bench.make_frame(kAlice);
  waiting.apply_at_tick = 20;
  set_controlword(add_command(waiting, 1), 0x0F);
  bench.receive(waiting);
  auto cancel = bench.make_frame(kAlice);
  cancel.flags = msg::FRAME_CANCEL_PENDING;
  bench.receive(cancel);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::cancelled);
  bench.steps(30);
  EXPECT_EQ(bench.value(1, 0x6041), 0x250);
}

TEST(PendingFrame, IsDroppedWithTheEpoch) {
  OwnedBench bench;
  auto waiting = bench.make_frame(kAlice);
  waiting.apply_at_tick = 20;
  set_controlword(add_command(waiting, 1), 0x0F);
  bench.receive(waiting);
  bench.reply_to(bench.make_request(msg::RequestKind::take_over, kBob, {2}));
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::cancelled);
}

TEST(PendingFrame, IsDroppedByAHaltAndByAFault) {
  OwnedBench bench;
  bench.write(kAlice, 1, 0x6040, 0x0F);
  bench.write(kAlice, 2, 0x6040, 0x0F);
  bench.steps(2);
  for (const std::uint16_t axis : kFirstTwo) {
    auto waiting = bench.make_frame(kAlice);
    waiting.apply_at_tick = 60;
    set_controlword(add_command(waiting, axis), 0x1F);
    bench.receive(waiting);
  }
  bench.write(kAlice, 1, 0x6040, 0x10F);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::cancelled);
  EXPECT_FALSE(bench.command_reply());
  bench.write(kBob, 2, 0x5E02, 1);  // over-current
  bench.steps(3);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::cancelled);
}

// The frame for tick 60 is cancelled. The halting frame is applied, and its reply keeps its own
// error.
TEST(PendingFrame, DroppedByAHaltDoesNotChangeTheAnswerToTheHalt) {
  OwnedBench bench;
  bench.write(kAlice, 1, 0x6040, 0x0F);
  bench.steps(2);
  auto waiting = bench.make_frame(kAlice);
  waiting.apply_at_tick = 60;
  set_controlword(add_command(waiting, 1), 0x1F);
  bench.receive(waiting);
  auto halt = bench.make_frame(kAlice);
  set_controlword(add_command(halt, 1), 0x10F);
  auto& wrong = add_command(halt, 2).objects.emplace_back();
  wrong.index = 0x6041;  // read only
  bench.receive(halt);
  const auto cancelled = bench.command_reply();
  ASSERT_TRUE(cancelled);
  EXPECT_EQ(cancelled->sequence_number, waiting.sequence_number);
  EXPECT_EQ(cancelled->refusals.at(0).reason, msg::Reason::cancelled);
  const auto reply = bench.command_reply();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->sequence_number, halt.sequence_number);
  ASSERT_EQ(reply->refusals.size(), 1U);
  EXPECT_EQ(reply->refusals[0].axis, 2);
  EXPECT_EQ(reply->refusals[0].reason,
            msg::Reason{wire_code(AbortCode::write_of_read_only_object)});
}

TEST(PendingFrame, StaysWhenItsSessionGainsAnAxis) {
  OwnedBench bench;
  auto waiting = bench.make_frame(kAlice);
  waiting.apply_at_tick = 20;
  auto& command = add_command(waiting, 1);
  command.members = msg::HAS_PROFILE_VELOCITY;
  command.profile_velocity = 111;
  bench.receive(waiting);
  const auto reply = bench.acquire(kAlice, {3});
  EXPECT_GT(reply.epoch, waiting.epoch) << "renewed, not revoked";
  bench.steps(20);
  EXPECT_TRUE(bench.command_reply()->refusals.empty());
  EXPECT_EQ(bench.value(1, 0x6081), 111);
}

TEST(PendingFrame, IsAnsweredWhenAllAreDroppedAtOnce) {
  OwnedBench bench;
  for (std::size_t count = 0; count < service::PendingFrames::kCapacity; ++count) {
    auto waiting = bench.make_frame(kAlice);
    waiting.apply_at_tick = 100;
    bench.receive(waiting);
  }
  bench.reply_to(bench.make_request(msg::RequestKind::release, kAlice));
  for (std::size_t count = 1; count <= service::PendingFrames::kCapacity; ++count) {
    const auto reply = bench.command_reply();
    ASSERT_TRUE(reply) << count;
    EXPECT_EQ(reply->sequence_number, count);
    EXPECT_EQ(reply->refusals.at(0).reason, msg::Reason::cancelled);
  }
  EXPECT_EQ(bench.counters.queue_overflows.get(), 0U);
}

TEST(PendingFrame, IsRefusedWhenTooManyArePending) {
  OwnedBench bench;
  for (std::size_t count = 0; count < service::PendingFrames::kCapacity; ++count) {
    auto waiting = bench.make_frame(kAlice);
    waiting.apply_at_tick = 100;
    bench.receive(waiting);
  }
  EXPECT_FALSE(bench.command_reply());
  auto one_more = bench.make_frame(kAlice);
  one_more.apply_at_tick = 100;
  bench.receive(one_more);
  EXPECT_EQ(bench.frame_refusal(), msg::Reason::queue_full);
}

TEST(CommandFrame, IsAnsweredWithTheAxesThatIgnoredTheirSetPoint) {
  OwnedBench bench;
  auto frame = bench.make_frame(kAlice);
  set_controlword(add_command(frame, 1), 0x1F);  // not in Operation enabled
  bench.receive(frame);
  const auto reply = bench.command_reply();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->ignored_set_points, std::vector<std::uint16_t>{1});
  bench.steps(1);
  EXPECT_EQ(bench.events(msg::EventKind::set_point_ignored).size(), 1U);
  EXPECT_EQ(bench.counters.set_points_ignored.get(), 1U);
}

TEST(CommandFrame, IsNumberedInTheStatusOfItsAxes) {
  OwnedBench bench;
  auto frame = bench.make_frame(kAlice);
  set_controlword(add_command(frame, 2), 0x06);
  bench.receive(frame);
  bench.steps(1);
  bench.engine.queue_status();
  const auto* const image = bench.outbox.status.front();
  ASSERT_NE(image, nullptr);
  EXPECT_EQ(image->owners[1].last_sequence, frame.sequence_number);
  EXPECT_EQ(image->owners[1].session, kAlice);
  EXPECT_EQ(image->owners[0].last_sequence, 0U);
  EXPECT_EQ(image->owners[2].session, 0U);
}

TEST(CommandFrame, AllocatesNothingAfterTheFirstFrames) {
  OwnedBench bench;
  std::vector<msg::CommandFrame> frames;
  for (int count = 0; count < 40; ++count) {
    auto frame = bench.make_frame(kAlice);
    frame.sequence_number = static_cast<std::uint64_t>(count) + 1;
    for (const std::uint16_t axis : kFirstTwo) {
      auto& command = add_command(frame, axis);
      command.members = msg::HAS_POSITION_USER_TARGET_VALUE;
      command.position_user_target_value = count;
      set_controlword(command, 0x0F);
    }
    set_controlword(add_command(frame, 99), 0x06);  // refused: the reply allocates nothing either
    frame.apply_at_tick = count % 4 == 0 ? static_cast<std::uint64_t>(count) + 3 : 0;
    frames.push_back(frame);
  }
  std::uint64_t allocations = 0;
  for (std::size_t count = 0; count < frames.size(); ++count) {
    bench.inbox.receive(frames[count], {});  // the receive thread may allocate
    const AllocationGuard guard;
    bench.engine.handle(*bench.inbox.front());
    bench.inbox.pop();
    bench.engine.step();
    bench.engine.queue_status();
    bench.outbox.status.pop();
    while (bench.outbox.command_replies.front() != nullptr) bench.outbox.command_replies.pop();
    allocations += guard.count();
  }
  EXPECT_EQ(allocations, 0U);
}

}  // namespace
}  // namespace vdrive::test
