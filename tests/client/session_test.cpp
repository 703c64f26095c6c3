// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/session.hpp"

#include "client/objects.hpp"
#include "client/session_options.hpp"
#include "support/bench_on_wire.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/step_clock.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <future>
#include <mutex>
#include <optional>
#include <vector>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::BenchOnWire;
using test::options_on_wire;
using test::patient;
using testing::HasSubstr;
using testing::SizeIs;

MoveOptions slow() {
  return {.velocity = 1000, .acceleration = 6000, .deceleration = 6000, .queue = false, .call = {}};
}

class LockStep : public testing::Test {
 protected:
  void SetUp() override {
    auto found = sut_.axis("1.1");
    ASSERT_TRUE(found) << found.outcome().message();
    axis_.emplace(*found);
  }

  BenchOnWire bench_{"--clock lockstep"};
  Session sut_{options_on_wire()};
  std::optional<Axis> axis_;
};

TEST_F(LockStep, StepsTheGivenNumberOfTicks) {
  EXPECT_EQ(*sut_.step(1, 0), 0U);
  EXPECT_EQ(*sut_.step(1, 5000), 5000U);
  EXPECT_EQ(*sut_.wait(1, 1500us), 5002U) << "rounded up to ticks";
  EXPECT_EQ(*sut_.wait_for_tick(1, 5010), 5010U);
  EXPECT_EQ(*sut_.wait_for_tick(1, 1), 5010U) << "which is past";
}

TEST_F(LockStep, ArrivesInTheTickThatTheProfileGives) {
  ASSERT_TRUE(axis_->enable());
  const std::uint64_t enabled = axis_->status()->tick;
  EXPECT_EQ(enabled, 1U) << "enabling takes one tick";
  ASSERT_TRUE(axis_->write(kMode, 1));
  ASSERT_TRUE(sut_.step(1, 1));
  ASSERT_TRUE(axis_->move_to(10'000, slow()));
  const auto status = axis_->status();
  EXPECT_EQ(status->status.position_demand_value, 10'000);
  EXPECT_EQ(status->status.ds402_statusword, 0x637);
  // The profile takes 10.16667 s; bit 4 drops in one more tick.
  EXPECT_EQ(status->tick, enabled + 1 + 10'167 + 1);
}

TEST_F(LockStep, MovesByADistance) {
  ASSERT_TRUE(axis_->enable());
  ASSERT_TRUE(axis_->move_by(-500, slow()));
  EXPECT_EQ(*axis_->read(kDemand), -500);
}

TEST_F(LockStep, StartsAMoveWhileBit4IsStillSet) {
  ASSERT_TRUE(axis_->enable());
  ASSERT_TRUE(axis_->move_to(1000, slow()));
  ASSERT_TRUE(axis_->write(kControlword, 0x3F));
  ASSERT_TRUE(sut_.step(1, 1));
  ASSERT_TRUE(axis_->move_to(2000, slow()));
  EXPECT_EQ(*axis_->read(kDemand), 2000);
}

TEST_F(LockStep, RefusesAMoveThatIsNotEnabledAndChangesNothing) {
  const Outcome refused = axis_->move_to(10);
  EXPECT_EQ(refused.kind(), OutcomeKind::refused);
  EXPECT_EQ(refused.code(), kRefusedInState);
  EXPECT_THAT(refused.message(), HasSubstr("Switch on disabled"));
  EXPECT_EQ(*axis_->read(kTarget), 0);
}

TEST_F(LockStep, QueuesASecondSetPointAndRefusesAThird) {
  ASSERT_TRUE(axis_->enable());
  MoveOptions move = slow();
  move.call.until = Until::in_force;
  ASSERT_TRUE(axis_->move_to(1000, move));
  move.queue = true;
  ASSERT_TRUE(axis_->move_to(2000, move));
  EXPECT_EQ(axis_->move_to(3000, move).code(), kRefusedInState);
  const auto there = axis_->wait_until(
      [](const AxisSnapshot& axis) {
        return axis.shows(Statusword::kTargetReached);
      },
      10s);
  ASSERT_TRUE(there) << there.outcome().message();
  EXPECT_EQ(there->status.position_demand_value, 2000);
}

TEST_F(LockStep, HaltsAndResumes) {
  ASSERT_TRUE(axis_->enable());
  MoveOptions move = slow();
  move.call.until = Until::in_force;
  ASSERT_TRUE(axis_->move_to(5000, move));
  ASSERT_TRUE(sut_.step(1, 1000));
  ASSERT_TRUE(axis_->halt());
  EXPECT_EQ(axis_->status()->status.velocity_demand_value, 0);
  EXPECT_LT(axis_->status()->status.position_demand_value, 2000);
  ASSERT_TRUE(axis_->resume());
  EXPECT_EQ(*axis_->read(kDemand), 5000);
}

TEST_F(LockStep, TimesOutInDriveTime) {
  ASSERT_TRUE(axis_->enable());
  MoveOptions move = slow();
  move.call.timeout = 1s;
  const std::uint64_t before = axis_->status()->tick;
  const Outcome late = axis_->move_to(100'000, move);
  EXPECT_EQ(late.kind(), OutcomeKind::timed_out);
  EXPECT_THAT(late.message(), HasSubstr("target reached"));
  EXPECT_EQ(axis_->status()->tick, before + 1000);
}

TEST_F(LockStep, QuickStopEndsInSwitchOnDisabled) {
  ASSERT_TRUE(axis_->enable());
  MoveOptions move = slow();
  move.call.until = Until::in_force;
  ASSERT_TRUE(axis_->move_to(5000, move));
  ASSERT_TRUE(sut_.step(1, 1000));
  ASSERT_TRUE(axis_->quick_stop());
  EXPECT_EQ(axis_->status()->state(), PowerState::switch_on_disabled);
}

TEST_F(LockStep, EndsAMoveWithTheFaultThatInterruptsIt) {
  ASSERT_TRUE(axis_->enable());
  ASSERT_TRUE(axis_->write({0x5E01, 0}, 1));  // blocked load
  const Outcome ended = axis_->move_to(1'000'000);
  EXPECT_EQ(ended.kind(), OutcomeKind::failed);
  EXPECT_THAT(ended.message(), HasSubstr("0x8611"));
}

TEST_F(LockStep, ResetsAFaultOnceItsCauseIsGone) {
  ASSERT_TRUE(axis_->enable());
  ASSERT_TRUE(axis_->write(kOverCurrent, 1));
  ASSERT_TRUE(sut_.step(1, 2));
  EXPECT_EQ(axis_->enable().code(), kRefusedInState);
  const Outcome persists = axis_->reset_fault();
  EXPECT_EQ(persists.code(), kRefusedInState);
  EXPECT_THAT(persists.message(), HasSubstr("persists"));
  ASSERT_TRUE(axis_->write(kOverCurrent, 0));
  ASSERT_TRUE(axis_->reset_fault());
  EXPECT_EQ(axis_->status()->state(), PowerState::switch_on_disabled);
  ASSERT_TRUE(axis_->enable());
}

TEST_F(LockStep, PowerCyclesToTheFactoryState) {
  ASSERT_TRUE(axis_->enable());
  ASSERT_TRUE(axis_->move_to(1000, slow()));
  ASSERT_TRUE(axis_->power_cycle());
  const auto status = axis_->status();
  EXPECT_EQ(status->status.ds402_statusword, 0x250);
  EXPECT_EQ(status->status.load_position_actual_value, 1000) << "the position is kept";
  EXPECT_EQ(*axis_->read({0x6081, 0}), 68267);
}

TEST_F(LockStep, ReadsManyObjectsOfOneTick) {
  std::vector<ObjectAddress> addresses;
  for (const ObjectDescription& row : kObjectTable) addresses.push_back(row.address);
  addresses.push_back({0x9999, 0});
  const auto readings = axis_->read(addresses);
  ASSERT_TRUE(readings) << readings.outcome().message();
  ASSERT_THAT(readings->objects, SizeIs(addresses.size()));
  EXPECT_EQ(readings->objects.back().code, AbortCode::object_does_not_exist);
  EXPECT_EQ(readings->objects.front().value, 0x00020192);
}

TEST_F(LockStep, ExecutesEachOfSeveralWritesBetweenTwoSteps) {
  for (const std::int64_t word : {0x06, 0x07, 0x0F}) {
    const auto in_force = axis_->write(kControlword, word);
    ASSERT_TRUE(in_force);
    EXPECT_EQ(*in_force, 1U);
  }
  ASSERT_TRUE(sut_.step(1, 1));
  EXPECT_EQ(axis_->status()->state(), PowerState::operation_enabled);
}

TEST_F(LockStep, SendsSetPointsWithAnyObjects) {
  ASSERT_TRUE(axis_->enable());
  SetPointFrame frame;
  frame.axes.push_back({.axis = 1,
                        .objects = {{.object = {0x6081, 0}, .value = 4'321},
                                    {.object = {0x6083, 0}, .value = 54'321}}});
  ASSERT_TRUE(sut_.send_set_points(1, {&frame, 1}));
  ASSERT_TRUE(sut_.step(1, 1));
  EXPECT_EQ(axis_->read(ObjectAddress{0x6081, 0}).value(), 4'321);
  EXPECT_EQ(axis_->read(ObjectAddress{0x6083, 0}).value(), 54'321);
}

// In lock-step a bench handles arrived messages only when somebody waits for it; its queue has
// 1,024 places.
TEST_F(LockStep, LosesNoSetPointOfMoreThanItsQueueTakes) {
  constexpr std::int64_t kFrames = 3'000;
  ASSERT_TRUE(axis_->enable());
  SetPointFrame frame;
  frame.axes.push_back({.axis = 1, .objects = {{.object = {0x6067, 0}, .value = 0}}});
  for (std::int64_t value = 1; value <= kFrames; ++value) {
    frame.axes.front().objects.front().value = value;
    ASSERT_TRUE(sut_.send_set_points(1, {&frame, 1}));
  }
  const auto stepped = sut_.step(1, 1);
  ASSERT_TRUE(stepped) << stepped.outcome().message();
  EXPECT_EQ(axis_->read(ObjectAddress{0x6067, 0}).value(), kFrames);
}

// The drive has no mode 50, so 6060h = 50 is refused: CiA 301, 06090030h.
TEST_F(LockStep, ReportsEachValueOfASetPointThatTheDriveRefuses) {
  ASSERT_TRUE(axis_->enable());
  std::promise<SetPointRefusal> reported;
  sut_.on_set_point_refusal([&reported](const SetPointRefusal& refusal) {
    reported.set_value(refusal);
  });
  SetPointFrame frame;
  frame.axes.push_back(
      {.axis = 1,
       .objects = {{.object = {0x6081, 0}, .value = 4'321}, {.object = {0x6060, 0}, .value = 50}}});
  ASSERT_TRUE(sut_.send_set_points(1, {&frame, 1}));
  ASSERT_TRUE(sut_.step(1, 1));
  std::future<SetPointRefusal> refusal = reported.get_future();
  ASSERT_EQ(refusal.wait_for(60s), std::future_status::ready);
  sut_.on_set_point_refusal({});
  const SetPointRefusal refused = refusal.get();
  EXPECT_EQ(refused.axis, (AxisId{1, 1}));
  EXPECT_EQ(refused.object, (ObjectAddress{0x6060, 0}));
  EXPECT_EQ(refused.code, AbortCode::value_range_exceeded);
  EXPECT_EQ(axis_->read(ObjectAddress{0x6081, 0}).value(), 4'321) << "the other one is in force";
}

// A refusal that a call waits for is the outcome of the call.
TEST_F(LockStep, ReportsNoRefusalThatACallReturns) {
  std::atomic<int> reports = 0;
  sut_.on_set_point_refusal([&reports](const SetPointRefusal& /*refusal*/) {
    ++reports;
  });
  EXPECT_FALSE(axis_->write(ObjectAddress{0x6060, 0}, 50));
  ASSERT_TRUE(sut_.step(1, 1));
  sut_.on_set_point_refusal({});
  EXPECT_EQ(reports.load(), 0);
}

TEST_F(LockStep, SendsNoSetPointWithMoreObjectsThanAFrameCarries) {
  SetPointFrame frame;
  frame.axes.push_back({.axis = 1, .velocity = 1, .torque = 1});
  frame.axes.front().objects.assign(kMostObjectsOfSetPoint - 1, {.object = {0x6081, 0}});
  const Outcome refused = sut_.send_set_points(1, {&frame, 1});
  EXPECT_EQ(refused.kind(), OutcomeKind::failed);
  EXPECT_THAT(refused.message(), HasSubstr("axis 1 has 9 objects; at most 8"));
}

TEST_F(LockStep, HoldsItsAxisExclusivelyAndReleasesItAtTheEnd) {
  Session other(options_on_wire());
  auto theirs = other.axis("1.1");
  {
    Session owner(options_on_wire());
    auto ours = owner.axis("1.1");
    ASSERT_TRUE(ours->enable());
    EXPECT_EQ(theirs->status()->owner_session, owner.id());
    const Outcome refused = theirs->enable();
    EXPECT_EQ(refused.kind(), OutcomeKind::refused);
    EXPECT_EQ(theirs->write(kTarget, 5).outcome().code(), 0x08000021U);
    EXPECT_TRUE(theirs->write(kOverCurrent, 0)) << "test-bench inputs are everybody's";
    EXPECT_TRUE(theirs->read(kTarget)) << "so are reads";
  }
  EXPECT_EQ(theirs->status()->owner_session, 0U);
  EXPECT_EQ(theirs->status()->state(), PowerState::operation_enabled) << "a release is no loss";
  EXPECT_TRUE(theirs->disable());
}

/// Another session owns axis 1.1 and moves it slowly to a distant target.
class AxisOfAnotherSession : public testing::Test {
 protected:
  void SetUp() override {
    axis_.emplace(*sut_.axis("1.1"));
    theirs_.emplace(*owner_.axis("1.1"));
    ASSERT_TRUE(theirs_->enable());
    MoveOptions move = slow();
    move.call.until = Until::in_force;
    ASSERT_TRUE(theirs_->move_to(1'000'000, move));
    ASSERT_TRUE(sut_.step(1, 500));
  }

  BenchOnWire bench_{patient("--clock lockstep --axes 2")};
  Session sut_{options_on_wire()};
  Session owner_{options_on_wire()};
  std::optional<Axis> axis_;
  std::optional<Axis> theirs_;
};

TEST_F(AxisOfAnotherSession, IsHaltedAndKeepsItsOwner) {
  const Outcome halted = axis_->halt();
  ASSERT_TRUE(halted) << halted.message();
  const auto status = axis_->status();
  EXPECT_EQ(status->status.velocity_demand_value, 0);
  EXPECT_EQ(status->state(), PowerState::operation_enabled);
  EXPECT_EQ(status->owner_session, owner_.id());
  EXPECT_EQ(axis_->resume().code(), 0x08000021U) << "going on is a command";
  CallOptions at_once;
  at_once.until = Until::in_force;
  EXPECT_TRUE(theirs_->resume(at_once));
  ASSERT_TRUE(sut_.step(1, 100));
  EXPECT_NE(axis_->status()->status.velocity_demand_value, 0);
}

TEST_F(AxisOfAnotherSession, IsQuickStoppedAndKeepsItsOwner) {
  const Outcome stopped = axis_->quick_stop();
  ASSERT_TRUE(stopped) << stopped.message();
  EXPECT_EQ(axis_->status()->state(), PowerState::switch_on_disabled);
  EXPECT_EQ(axis_->status()->owner_session, owner_.id());
  EXPECT_TRUE(theirs_->enable()) << "by its owner";
}

TEST_F(AxisOfAnotherSession, IsStoppedByAWriteThatOnlyStops) {
  EXPECT_EQ(axis_->write(kControlword, 0x06).outcome().code(), 0x08000021U);
  ASSERT_TRUE(axis_->write(kControlword, 0x02));
  ASSERT_TRUE(sut_.step(1, 1));
  EXPECT_EQ(axis_->status()->state(), PowerState::quick_stop_active);
}

TEST_F(AxisOfAnotherSession, IsTakenOver) {
  EXPECT_EQ(axis_->acquire().kind(), OutcomeKind::refused);
  const Outcome taken = axis_->take_over();
  ASSERT_TRUE(taken) << taken.message();
  EXPECT_EQ(axis_->status()->owner_session, sut_.id());
  EXPECT_NE(axis_->status()->status.velocity_demand_value, 0) << "it continues";
  EXPECT_TRUE(axis_->disable());
  EXPECT_EQ(theirs_->enable().code(), 0x08000021U);
}

TEST_F(AxisOfAnotherSession, IsStoppedWithAllAxesOfItsBench) {
  auto ours = sut_.axis("1.2");
  ASSERT_TRUE(ours->enable());
  const Outcome stopped = sut_.quick_stop(1);
  ASSERT_TRUE(stopped) << stopped.message();
  const std::array ids{AxisId{1, 1}, AxisId{1, 2}};
  const auto seen = sut_.observe(ids);
  ASSERT_TRUE(seen);
  for (const AxisSnapshot& axis : seen->axes) {
    EXPECT_EQ(axis.state(), PowerState::switch_on_disabled) << to_string(axis.id);
  }
  EXPECT_EQ(axis_->status()->owner_session, owner_.id());
}

/// Collects events in the order in which a session reports them.
class Reported {
 public:
  void add(const Event& event) {
    const std::scoped_lock lock(mutex_);
    events_.push_back(event);
    arrived_.notify_all();
  }

  /// @return the first event of this kind; nothing after 10 s without one.
  std::optional<Event> await(EventKind kind) {
    std::unique_lock lock(mutex_);
    std::optional<Event> found;
    arrived_.wait_for(lock, 10s, [&] {
      const auto event = std::ranges::find(events_, kind, &Event::kind);
      if (event != events_.end()) found = *event;
      return found.has_value();
    });
    return found;
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<Event> events_;
};

TEST_F(AxisOfAnotherSession, NamesToItsOwnerTheSessionThatStoppedIt) {
  Reported reported;
  owner_.on_event([&reported](const Event& event) {
    reported.add(event);
  });
  const Outcome quick_stop = axis_->quick_stop();
  const auto stopped = reported.await(EventKind::stopped);
  owner_.on_event({});  // the session outlives `reported`
  ASSERT_TRUE(quick_stop);
  ASSERT_TRUE(stopped);
  EXPECT_EQ((AxisId{stopped->bench, stopped->axis}), (AxisId{1, 1}));
  EXPECT_EQ(stopped->session, sut_.id());
  EXPECT_EQ(stopped->code, 0x0002U);
  EXPECT_THAT(stopped->text, HasSubstr("quick stop by session"));
}

TEST_F(LockStep, AnObserverOfEventsMayCommandAxes) {
  Reported reported;
  auto other = sut_.axis("1.2");
  ASSERT_TRUE(axis_->enable());
  ASSERT_TRUE(other->enable());
  sut_.on_event([&](const Event& event) {
    if (event.kind == EventKind::fault && event.axis == 1) (void)other->quick_stop();
    reported.add(event);
  });
  const auto written = axis_->write(kOverCurrent, 1);
  const bool has_stepped = static_cast<bool>(sut_.step(1, 1));
  const auto fault = reported.await(EventKind::fault);
  sut_.on_event({});  // the session outlives `reported`
  ASSERT_TRUE(written && has_stepped);
  ASSERT_TRUE(fault);
  EXPECT_EQ(other->status()->state(), PowerState::switch_on_disabled);
}

TEST_F(LockStep, AwaitsAMoveThatWasStartedEarlier) {
  ASSERT_TRUE(axis_->enable());
  EXPECT_EQ(sut_.axis("1.2")->start_move(5).outcome().code(), kRefusedInState);
  const auto motion = axis_->start_move(2000, slow());
  ASSERT_TRUE(motion) << motion.outcome().message();
  EXPECT_NE(*axis_->read(kDemand), 2000);
  EXPECT_FALSE(*motion->has_ended());
  EXPECT_EQ(motion->wait(10ms).kind(), OutcomeKind::timed_out) << "it is on the way";
  EXPECT_TRUE(motion->wait());
  EXPECT_TRUE(*motion->has_ended());
  EXPECT_EQ(*axis_->read(kDemand), 2000);
}

TEST_F(LockStep, ReportsAHaltedMoveAsFailed) {
  ASSERT_TRUE(axis_->enable());
  const auto motion = axis_->start_move(1'000'000, slow());
  ASSERT_TRUE(sut_.step(1, 100));
  ASSERT_TRUE(axis_->halt());
  EXPECT_THAT(motion->wait().message(), HasSubstr("was halted"));
  EXPECT_EQ(motion->has_ended().outcome().kind(), OutcomeKind::failed);
  ASSERT_TRUE(axis_->disable());
  EXPECT_EQ(motion->has_ended().outcome().kind(), OutcomeKind::failed);
}

TEST_F(LockStep, DisturbsAnAxisAndRemovesTheDisturbance) {
  for (const DisturbanceRow& row : kDisturbances) {
    const Result<std::uint64_t> disturbed = axis_->disturb(row.disturbance);
    ASSERT_TRUE(disturbed) << row.name << disturbed.outcome().message();
  }
  for (std::uint16_t index = 0x5E00; index <= 0x5E0C; ++index) {
    EXPECT_EQ(*axis_->read({index, 0}), 1) << std::hex << index;
  }
  ASSERT_TRUE(axis_->disturb(Disturbance::load_torque, -250));
  EXPECT_EQ(*axis_->read({0x5E00, 0}), -250);
  ASSERT_TRUE(axis_->end_disturbances());
  for (std::uint16_t index = 0x5E00; index <= 0x5E0C; ++index) {
    EXPECT_EQ(*axis_->read({index, 0}), 0) << std::hex << index;
  }
}

TEST_F(LockStep, EachDisturbanceCausesTheFaultThatItsRowNames) {
  ASSERT_TRUE(axis_->write({0x6065, 0}, 1'000)) << "following error window [UU]";
  ASSERT_TRUE(axis_->write({0x6066, 0}, 1)) << "following error time-out [ms]";
  // In reverse order: the load torque, which comes first, would keep the axis moving for a long
  // time.
  for (auto next = kDisturbances.rbegin(); next != kDisturbances.rend(); ++next) {
    const DisturbanceRow& row = *next;
    SCOPED_TRACE(row.name);
    ASSERT_TRUE(axis_->enable());
    const bool is_load = row.disturbance == Disturbance::load_torque;
    ASSERT_TRUE(axis_->disturb(row.disturbance, is_load ? 50'000 : 1));
    const bool is_blocked = row.disturbance == Disturbance::blocked_load;
    if (is_blocked) {
      const auto motion = axis_->start_move(1'000'000, slow());
      ASSERT_TRUE(motion) << motion.outcome().message();
    }
    ASSERT_TRUE(sut_.step(1, 2'000));
    EXPECT_EQ(axis_->status()->status.error_code, static_cast<std::uint16_t>(row.fault));
    ASSERT_TRUE(axis_->end_disturbances());
    if (row.fault != ErrorCode::none) {
      ASSERT_TRUE(axis_->reset_fault());
    }
    ASSERT_TRUE(axis_->disable());
  }
}

TEST_F(LockStep, ABlockedLoadCausesNoFaultInAMoveShorterThanTheWindow) {
  ASSERT_TRUE(axis_->write({0x6065, 0}, 1'000));
  ASSERT_TRUE(axis_->write({0x6066, 0}, 1));
  ASSERT_TRUE(axis_->enable());
  ASSERT_TRUE(axis_->disturb(Disturbance::blocked_load));
  ASSERT_TRUE(axis_->start_move(900, slow()));
  ASSERT_TRUE(sut_.step(1, 5'000));
  EXPECT_EQ(axis_->status()->status.error_code, 0);
}

TEST_F(LockStep, AFaultOfTheDriveNeedsNoPower) {
  for (const Disturbance disturbance :
       {Disturbance::over_current, Disturbance::over_temperature, Disturbance::encoder_failure}) {
    ASSERT_TRUE(axis_->disturb(disturbance));
    ASSERT_TRUE(sut_.step(1, 10));
    EXPECT_EQ(axis_->status()->state(), PowerState::fault);
    ASSERT_TRUE(axis_->end_disturbances());
    ASSERT_TRUE(axis_->reset_fault());
  }
}

TEST_F(LockStep, ADcLinkLossWithoutPowerIsNoFault) {
  ASSERT_TRUE(axis_->disturb(Disturbance::dc_link_loss));
  ASSERT_TRUE(sut_.step(1, 10));
  EXPECT_EQ(axis_->status()->status.error_code, 0);
  EXPECT_EQ(axis_->status()->state(), PowerState::switch_on_disabled);
}

TEST_F(LockStep, APowerDropEndsAMotionWithoutAFault) {
  ASSERT_TRUE(axis_->enable());
  const auto motion = axis_->start_move(1'000'000, slow());
  ASSERT_TRUE(motion) << motion.outcome().message();
  ASSERT_TRUE(sut_.step(1, 100));
  ASSERT_TRUE(axis_->disturb(Disturbance::power_drop));
  ASSERT_TRUE(sut_.step(1, 10));
  EXPECT_EQ(axis_->status()->state(), PowerState::switched_on);
  EXPECT_EQ(axis_->status()->status.error_code, 0);
  EXPECT_THAT(motion->wait().message(), HasSubstr("Switched on"));
  ASSERT_TRUE(axis_->enable()) << "the input is still 1";
  EXPECT_EQ(axis_->status()->state(), PowerState::operation_enabled);
}

TEST_F(LockStep, FrozenFeedbackShowsAMoveThatArrivesElsewhere) {
  ASSERT_TRUE(axis_->enable());
  ASSERT_TRUE(axis_->disturb(Disturbance::frozen_feedback));
  const std::int32_t shown = axis_->status()->status.load_position_actual_value;
  ASSERT_TRUE(axis_->move_to(shown + 2'000)) << "bit 10 has the true position";
  EXPECT_EQ(axis_->status()->status.load_position_actual_value, shown);
  EXPECT_EQ(axis_->status()->status.load_position_error_value, 2'000);
  ASSERT_TRUE(axis_->end_disturbances());
  ASSERT_TRUE(sut_.step(1, 1));
  EXPECT_NEAR(axis_->status()->status.load_position_actual_value, shown + 2'000, 10);
}

TEST_F(LockStep, AQuickStopAcquiresNothing) {
  ASSERT_TRUE(axis_->quick_stop());
  EXPECT_EQ(axis_->status()->owner_session, 0U);
}

TEST_F(LockStep, AllowsStopsAfterAnInterrupt) {
  ASSERT_TRUE(axis_->enable());
  MoveOptions move = slow();
  move.call.until = Until::in_force;
  ASSERT_TRUE(axis_->move_to(1'000'000, move));
  sut_.interrupt();
  EXPECT_TRUE(sut_.is_interrupted());
  EXPECT_EQ(axis_->resume().kind(), OutcomeKind::failed) << "as every other call";
  const Outcome halted = axis_->halt();
  EXPECT_TRUE(halted) << halted.message();
  EXPECT_EQ(axis_->status()->status.velocity_demand_value, 0);
  EXPECT_TRUE(axis_->quick_stop());
  EXPECT_TRUE(sut_.quick_stop(1));
}

TEST_F(LockStep, AnAxisObjectCommandsNothingAfterItsSessionEnded) {
  std::optional<Axis> left;
  {
    Session ended(options_on_wire());
    left.emplace(*ended.axis("1.2"));
    ASSERT_TRUE(left->enable());
  }
  const Outcome outcome = left->disable();
  EXPECT_EQ(outcome.kind(), OutcomeKind::failed);
  EXPECT_THAT(outcome.message(), HasSubstr("the session has ended"));
  EXPECT_FALSE(left->write(kTarget, 5));
  EXPECT_FALSE(left->take_over());
  const auto status = sut_.axis("1.2")->status();
  EXPECT_EQ(status->owner_session, 0U) << "it was released at the end of the session";
  EXPECT_EQ(status->state(), PowerState::operation_enabled);
}

TEST_F(LockStep, ObservesSeveralAxesInOneCall) {
  const std::array ids{AxisId{1, 2}, AxisId{1, 1}};
  const auto seen = sut_.observe(ids);
  ASSERT_TRUE(seen) << seen.outcome().message();
  EXPECT_EQ(seen->axes[0].id, ids[0]);
  EXPECT_EQ(seen->axes[1].id, ids[1]);
}

TEST_F(LockStep, ReceivesStatusWhileAnotherSessionSteps) {
  auto follower = sut_.follow({{1, 1}}, Pace::observe);
  ASSERT_TRUE(follower);
  Session stepper(options_on_wire());
  // Matching takes some time. Step until a sample arrives; from then on none may be missing.
  Result<Observation> sample = Outcome::timed_out("");
  const auto deadline = std::chrono::steady_clock::now() + 10s;
  while (!sample) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    ASSERT_TRUE(stepper.step(1, 1));
    sample = follower->next(20ms);
  }
  ASSERT_TRUE(stepper.step(1, 10));
  Observation kept = *sample;  // a copy, because its memory is reused
  const auto last = *stepper.step(1, 0);
  while (kept.tick < last) {
    const std::uint64_t before = kept.tick;
    const Outcome seen = follower->next(2s, kept);
    ASSERT_TRUE(seen) << seen.message();
    EXPECT_EQ(kept.tick, before + 1 + kept.missed);
    ASSERT_EQ(kept.axes.size(), 1U);
    EXPECT_EQ(kept.axes[0].tick, kept.tick);
  }
}

TEST_F(LockStep, ASessionThatReceivesEvery8MsMissesNoStatus) {
  SessionOptions options = options_on_wire();
  options.receive_coalescing = 8ms;
  Session observer(options);
  auto follower = observer.follow({{1, 1}}, Pace::observe);
  ASSERT_TRUE(follower);
  Observation kept;
  const auto deadline = std::chrono::steady_clock::now() + 10s;
  while (!follower->next(20ms, kept)) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    ASSERT_TRUE(sut_.step(1, 1));
  }
  // The last 64 samples are kept (StatusFrame: live).
  for (int i = 0; i < 60; ++i) ASSERT_TRUE(sut_.step(1, 1));
  const auto last = *sut_.step(1, 0);
  while (kept.tick < last) {
    ASSERT_TRUE(follower->next(2s, kept));
    EXPECT_EQ(kept.missed, 0U) << "before tick " << kept.tick;
  }
}

// Ticks take 1 ms, so a sample that waits is as many ms old as ticks have been run after it.
TEST_F(LockStep, AFollowerMeasuresHowFarItsSamplesAreBehindTheBench) {
  auto follower = sut_.follow({{1, 1}}, Pace::observe);
  ASSERT_TRUE(follower);
  Session stepper(options_on_wire());
  Observation kept;
  const auto deadline = std::chrono::steady_clock::now() + 10s;
  while (!follower->next(20ms, kept)) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    ASSERT_TRUE(stepper.step(1, 1));
  }
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(stepper.step(1, 1));
  const auto last = *stepper.step(1, 0);
  const std::array ids{AxisId{1, 1}};
  ASSERT_EQ(sut_.observe(ids)->tick, last);  // from here on the session knows the bench's time
  const Lateness before = follower->lateness();
  std::uint64_t late = 0;
  std::chrono::nanoseconds longest = before.longest;
  while (kept.tick < last) {
    ASSERT_TRUE(follower->next(2s, kept));
    const std::chrono::milliseconds behind(static_cast<std::int64_t>(last - kept.tick));
    EXPECT_EQ(follower->lateness().last, behind);
    longest = std::max<std::chrono::nanoseconds>(longest, behind);
    if (behind > 0ms) ++late;
  }
  const Lateness after = follower->lateness();
  EXPECT_EQ(after.late - before.late, late);
  EXPECT_EQ(after.longest, longest);
  EXPECT_EQ(after.last, 0ms);
  EXPECT_GT(after.samples, before.samples);
}

TEST_F(LockStep, AFollowerHasEachAxisOnce) {
  const Outcome refused = sut_.follow({{1, 1}, {1, 2}, {1, 1}}, Pace::drive).outcome();
  EXPECT_EQ(refused.kind(), OutcomeKind::refused);
  EXPECT_THAT(refused.message(), HasSubstr("axis 1.1 is named twice"));
}

TEST_F(LockStep, ASampleThatIsAStepIsNeverLate) {
  auto follower = sut_.follow({{1, 1}}, Pace::drive);
  ASSERT_TRUE(follower);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(follower->next(10s));
  EXPECT_EQ(follower->lateness().samples, 3U);
  EXPECT_EQ(follower->lateness().late, 0U);
  EXPECT_EQ(follower->lateness().longest, 0ms);
}

TEST_F(LockStep, ASessionThatStepsAloneStepsAtOnceAsFarAsOneRequestDoes) {
  constexpr std::uint64_t kTicksOfARequest = 2000;
  const std::uint64_t before = *sut_.step(1, 0);
  EXPECT_TRUE(sut_.steps_at_once(1, kTicksOfARequest));
  EXPECT_FALSE(sut_.steps_at_once(1, kTicksOfARequest + 1));
  EXPECT_FALSE(sut_.steps_at_once(2, 1)) << "there is no such bench";
  {
    const auto clock = StepClock::join(sut_, std::array<std::uint32_t, 1>{1});
    ASSERT_TRUE(clock);
    EXPECT_FALSE(sut_.steps_at_once(1, 1));
  }
  EXPECT_TRUE(sut_.steps_at_once(1, 1));
  EXPECT_EQ(*sut_.step(1, 0), before);
}

TEST_F(LockStep, AFollowerHasANextSampleWhileItsSessionStepsAlone) {
  auto follower = sut_.follow({{1, 1}}, Pace::drive);
  ASSERT_TRUE(follower);
  const std::uint64_t before = *sut_.step(1, 0);
  EXPECT_TRUE(follower->has_next());
  const auto clock = StepClock::join(sut_, std::array<std::uint32_t, 1>{1});
  ASSERT_TRUE(clock);
  EXPECT_FALSE(follower->has_next());
  EXPECT_EQ(*sut_.step(1, 0), before);
}

TEST_F(LockStep, AnObserverHasANextSampleWhileOneWaits) {
  auto follower = sut_.follow({{1, 1}}, Pace::observe);
  ASSERT_TRUE(follower);
  EXPECT_FALSE(follower->has_next());
  Session stepper(options_on_wire());
  // Matching takes some time, so step until a sample arrives.
  const auto deadline = std::chrono::steady_clock::now() + 10s;
  while (!follower->has_next()) {
    ASSERT_LT(std::chrono::steady_clock::now(), deadline);
    ASSERT_TRUE(stepper.step(1, 1));
  }
  while (follower->has_next()) ASSERT_TRUE(follower->next(0ms));
}

TEST_F(LockStep, StoresASampleInMemoryOfTheProgram) {
  auto follower = sut_.follow({{1, 2}, {1, 1}}, Pace::drive);
  ASSERT_TRUE(follower);
  Observation kept;
  ASSERT_TRUE(follower->next(10s, kept));
  const std::uint64_t first = kept.tick;
  ASSERT_TRUE(follower->next(10s, kept));
  EXPECT_EQ(kept.tick, first + 1);
  ASSERT_EQ(kept.axes.size(), 2U);
  EXPECT_EQ(kept.axes[0].id, (AxisId{1, 2}));
}

TEST_F(LockStep, AnInterruptEndsAWaitingCall) {
  ASSERT_TRUE(axis_->enable());
  auto moving = std::async(std::launch::async, [&] {
    MoveOptions move = slow();
    move.velocity = 1;
    move.call.timeout = 24h;
    return axis_->move_to(1'000'000, move);
  });
  sut_.interrupt();
  EXPECT_EQ(moving.get().kind(), OutcomeKind::failed);
}

TEST(SessionForOneBench, NamesTheBenchesThatAreThereWhereItsOwnIsNot) {
  const BenchOnWire first("--clock lockstep --axes 1");
  const BenchOnWire second("--clock lockstep --bench 2 --axes 1");
  SessionOptions one = options_on_wire();
  one.find_timeout = 2s;
  one.bench = 9;
  Session sut(one);
  const Outcome nobody = sut.find_bench().outcome();
  EXPECT_EQ(nobody.kind(), OutcomeKind::not_found);
  EXPECT_THAT(nobody.message(), HasSubstr("no bench 9 on "));
  EXPECT_THAT(nobody.message(), HasSubstr(", found benches 1, 2"));
  EXPECT_THAT(sut.axis("1.1").outcome().message(),
              HasSubstr("no bench 1, this session finds bench 9 only"));
}

TEST(RealtimeSession, MovesHaltsAndKeepsControlOfItsAxis) {
  const BenchOnWire bench("--clock realtime");
  Session sut(options_on_wire());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis) << axis.outcome().message();
  ASSERT_TRUE(axis->enable());
  ASSERT_TRUE(axis->move_to(2000));
  EXPECT_EQ(*axis->read(kDemand), 2000);
  ASSERT_TRUE(axis->move_by(500));
  // Three times the watchdog's time-out without a message from this thread.
  ASSERT_TRUE(sut.wait(1, 1500ms));
  EXPECT_EQ(axis->status()->state(), PowerState::operation_enabled);
  EXPECT_EQ(axis->status()->owner_session, sut.id());
  EXPECT_EQ(sut.step(1, 1).outcome().kind(), OutcomeKind::refused);
}

TEST(RealtimeSession, AMoveFailsWhenAnotherSessionHaltsTheAxis) {
  const BenchOnWire bench(patient("--clock realtime --axes 2"));
  Session owner(options_on_wire());
  Session other(options_on_wire());
  auto ours = owner.axis("1.1");
  auto theirs = other.axis("1.1");
  ASSERT_TRUE(ours->enable());
  auto moving = std::async(std::launch::async, [&] {
    return ours->move_to(1'000'000, slow());
  });
  ASSERT_TRUE(theirs->wait_until(
      [](const AxisSnapshot& seen) {
        return seen.status.velocity_demand_value != 0;
      },
      20s));
  const Outcome halted = theirs->halt();
  ASSERT_TRUE(halted) << halted.message();
  const Outcome moved = moving.get();
  EXPECT_EQ(moved.kind(), OutcomeKind::failed);
  EXPECT_THAT(moved.message(), HasSubstr("was halted before it reached its target"));
  EXPECT_EQ(*theirs->read(kControlword) & 0x0100, 0x0100) << "the halt is still in force";
}

TEST(RealtimeSession, AnInterruptedMoveReportsThatTheAxisStillMoves) {
  const BenchOnWire bench(patient("--clock realtime --axes 2"));
  Session sut(options_on_wire());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis->enable());
  auto moving = std::async(std::launch::async, [&] {
    return axis->move_to(1'000'000, slow());
  });
  ASSERT_TRUE(axis->wait_until(
      [](const AxisSnapshot& seen) {
        return seen.status.velocity_demand_value >= 500;  // long after the acknowledgement
      },
      20s));
  sut.interrupt();
  EXPECT_EQ(moving.get().message(),
            "interrupted; axis 1.1 was not stopped: it continues to its target while its bench "
            "runs");
}

TEST(RealtimeSession, WithoutAutomaticKeepAliveLosesItsAxisWhenTheProgramSendsNothing) {
  const BenchOnWire bench("--clock realtime");
  SessionOptions streaming = options_on_wire();
  streaming.keep_alive = KeepAlive::user_frames;
  Session sut(streaming);
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis->enable());
  const auto lost = axis->wait_until(
      [](const AxisSnapshot& seen) {
        return seen.state() == PowerState::fault;
      },
      5s);
  ASSERT_TRUE(lost) << lost.outcome().message();
  EXPECT_EQ(lost->status.error_code, 0x8130);
  EXPECT_EQ(lost->owner_session, 0U);
  ASSERT_TRUE(axis->reset_fault()) << "control is taken anew";
}

TEST(RealtimeSession, ReachesATargetWhereTheAxisAlreadyIs) {
  const BenchOnWire bench("--clock realtime");
  Session sut(options_on_wire());
  auto axis = sut.axis("1.1");
  ASSERT_TRUE(axis->enable());
  ASSERT_TRUE(axis->move_to(300));
  for (int i = 0; i < 5; ++i) {
    const Outcome again = axis->move_to(300);
    EXPECT_TRUE(again) << again.message();
  }
}

}  // namespace
}  // namespace vdrive::client
