// SPDX-License-Identifier: Apache-2.0
#include "vdrive/client/axis_group.hpp"

#include "client/objects.hpp"
#include "client/session_options.hpp"
#include "support/bench_on_wire.hpp"
#include "support/effort.hpp"
#include "vdrive/cia402/statusword.hpp"
#include "vdrive_messages.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <functional>
#include <limits>
#include <map>
#include <mutex>
#include <numbers>
#include <optional>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::BenchOnWire;
using test::options_on_wire;
using test::patient;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> names(std::uint32_t bench, int first, int count) {
  std::vector<std::string> axes;
  for (int i = 0; i < count; ++i) {
    axes.push_back(std::to_string(bench) + "." + std::to_string(first + i));
  }
  return axes;
}

/// @return options of a call that returns as soon as the move has started.
GroupMoveOptions at_start() {
  GroupMoveOptions move;
  move.call.until = Until::in_force;
  return move;
}

Eigen::VectorXd vector(std::initializer_list<double> values) {
  Eigen::VectorXd result(static_cast<Eigen::Index>(values.size()));
  Eigen::Index i = 0;
  for (const double value : values) result[i++] = value;
  return result;
}

/// Checks every observation of a call: how far the axes are from the line, and when each reaches
/// its target.
class Watch {
 public:
  Watch(Eigen::VectorXd starts, Eigen::VectorXd targets)
      : starts_(std::move(starts)), targets_(std::move(targets)) {}

  GroupCallOptions options() {
    GroupCallOptions call;
    call.progress = [this](const GroupProgress& seen) {
      note(seen);
    };
    return call;
  }

  /// The largest distance of any axis from the line [UU of demand].
  [[nodiscard]] double deviation() const { return deviation_; }

  /// The ticks between the first and the last arrival of the axes that moved.
  [[nodiscard]] std::uint64_t spread() const {
    std::uint64_t first = UINT64_MAX;
    std::uint64_t last = 0;
    for (const auto& [axis, tick] : arrivals_) {
      first = std::min(first, tick);
      last = std::max(last, tick);
    }
    return arrivals_.empty() ? 0 : last - first;
  }

  [[nodiscard]] std::size_t arrived() const { return arrivals_.size(); }

  [[nodiscard]] std::uint64_t observations() const { return observations_; }

  [[nodiscard]] std::uint64_t longest_gap() const { return longest_gap_; }

  [[nodiscard]] double fraction() const { return fraction_; }

 private:
  void note(const GroupProgress& seen) {
    longest_gap_ = last_tick_ == 0 ? 0 : std::max(longest_gap_, seen.tick - last_tick_);
    last_tick_ = seen.tick;
    ++observations_;
    fraction_ = seen.fraction;
    const Eigen::VectorXd way = targets_ - starts_;
    Eigen::Index longest = 0;
    way.cwiseAbs().maxCoeff(&longest);
    const auto demand = [&](Eigen::Index axis) {
      return static_cast<double>(
          seen.axes[static_cast<std::size_t>(axis)].status.position_demand_value);
    };
    const double done =
        way[longest] == 0.0 ? 0.0 : (demand(longest) - starts_[longest]) / way[longest];
    for (Eigen::Index axis = 0; axis < way.size(); ++axis) {
      const double on_line = starts_[axis] + done * way[axis];
      deviation_ = std::max(deviation_, std::abs(demand(axis) - on_line));
      const bool rests =
          seen.axes[static_cast<std::size_t>(axis)].status.velocity_demand_value == 0;
      // An axis with a short way shows its target early and never a speed, so it is not judged.
      if (std::abs(way[axis]) < 1000.0) continue;
      if (rests && demand(axis) == targets_[axis]) arrivals_.emplace(axis, seen.tick);
    }
  }

  Eigen::VectorXd starts_;
  Eigen::VectorXd targets_;
  double deviation_ = 0.0;
  double fraction_ = 0.0;
  std::uint64_t observations_ = 0;
  std::uint64_t last_tick_ = 0;
  std::uint64_t longest_gap_ = 0;
  std::map<Eigen::Index, std::uint64_t> arrivals_;
};

class Group : public testing::Test {
 protected:
  explicit Group(const std::string& words = "--clock lockstep --axes 4") : bench_(words) {}

  /// Creates a group of axes, from 1.1 on, and enables it.
  AxisGroup enabled(int count) {
    auto group = AxisGroup::create(session_, names(1, 1, count));
    if (!group) throw std::runtime_error(group.outcome().message());
    if (const Outcome outcome = group->enable_all(); !outcome) {
      throw std::runtime_error(outcome.message());
    }
    return *group;
  }

  void write(const std::string& axis, ObjectAddress object, std::int64_t value) {
    auto found = session_.axis(axis);
    ASSERT_TRUE(found) << found.outcome().message();
    const auto written = found->write(object, value);
    ASSERT_TRUE(written) << written.outcome().message();
  }

  std::uint64_t tick() { return *session_.step(1, 0); }

  BenchOnWire bench_;
  Session session_{options_on_wire()};
};

using LockStepGroup = Group;

TEST_F(LockStepGroup, IsCreatedFromAddressesAndNamesAndRefusesInvalidSelections) {
  const std::string name = session_.find_bench()->axes[1].name;
  const auto group = AxisGroup::create(session_, std::vector<std::string>{"1.1", name});
  ASSERT_TRUE(group) << group.outcome().message();
  EXPECT_THAT(group->axes(), ElementsAre(AxisId{1, 1}, AxisId{1, 2}));
  EXPECT_EQ(group->status()->state, GroupState::disabled);

  const auto twice = AxisGroup::create(session_, std::vector<std::string>{"1.1", name, "1.1"});
  EXPECT_EQ(twice.outcome().kind(), OutcomeKind::refused);
  EXPECT_THAT(twice.outcome().message(), HasSubstr("axis 1.1 appears twice"));
  const auto nobody = AxisGroup::create(session_, std::vector<std::string>{"1.1", "1.77"});
  EXPECT_EQ(nobody.outcome().kind(), OutcomeKind::not_found);
  EXPECT_THAT(nobody.outcome().message(), HasSubstr("1.77"));
  EXPECT_EQ(AxisGroup::create(session_, std::vector<std::string>{}).outcome().kind(),
            OutcomeKind::not_found);
  Session other(options_on_wire());
  const std::vector<Axis> strangers{*other.axis("1.1")};
  EXPECT_THAT(AxisGroup::create(session_, strangers).outcome().message(),
              HasSubstr("axis 1.1 belongs to another session"));
}

TEST_F(LockStepGroup, EnablesAndDisablesEveryAxisFromAnyState) {
  write("1.2", {0x6040, 0}, 0x06);
  ASSERT_TRUE(session_.axis("1.3")->enable());
  auto group = AxisGroup::create(session_, names(1, 1, 4));
  const std::uint64_t before = tick();
  ASSERT_TRUE(group->enable_all());
  EXPECT_EQ(tick(), before + 1) << "in one tick";
  EXPECT_EQ(group->status()->state, GroupState::standby);
  ASSERT_TRUE(group->disable_all());
  EXPECT_EQ(group->status()->state, GroupState::disabled);
  const auto seen = group->status();
  for (const AxisSnapshot& axis : seen->axes) {
    EXPECT_EQ(axis.state(), PowerState::ready_to_switch_on);
  }
}

TEST_F(LockStepGroup, SwitchesItsAxesOffAndOnAgainAndDropsTheQueue) {
  AxisGroup group = enabled(3);
  ASSERT_TRUE(group.queue_move(vector({1000, 1000, 1000})));
  const Outcome cycled = group.command(EachCommand::power_cycle);
  ASSERT_TRUE(cycled) << cycled.message();
  const auto seen = group.status();
  EXPECT_EQ(seen->queued, 0U);
  for (const AxisSnapshot& axis : seen->axes) {
    EXPECT_EQ(axis.state(), PowerState::switch_on_disabled) << to_string(axis.id);
  }
}

TEST_F(LockStepGroup, EnablesNoAxisWhenOneHasAFaultAndDisablesTheOthers) {
  AxisGroup group = enabled(3);
  ASSERT_TRUE(session_.axis("1.2")->disturb(Disturbance::over_current));
  ASSERT_TRUE(session_.step(1, 100));
  const Outcome disabled = group.disable_all();
  ASSERT_TRUE(disabled) << disabled.message();
  const Outcome refused = group.enable_all();
  EXPECT_EQ(refused.code(), kRefusedInState);
  EXPECT_THAT(refused.message(), HasSubstr("axis 1.2 shows error 0x2310 "));
  EXPECT_THAT(refused.message(), HasSubstr("; enabling needs a fault reset first"));
  EXPECT_EQ(group.status()->axes[0].state(), PowerState::ready_to_switch_on);
  EXPECT_EQ(group.halt_all().code(), kRefusedInState) << "no axis can halt";
}

TEST_F(LockStepGroup, AResetSeesAFaultThatComesWhileItWaitsForAnotherAxis) {
  AxisGroup group = enabled(2);
  ASSERT_TRUE(session_.axis("1.1")->run_at(20'000, {.call = {.until = Until::in_force}}));
  ASSERT_TRUE(session_.step(1, 100));
  ASSERT_TRUE(session_.axis("1.1")->disturb(Disturbance::over_current));
  ASSERT_TRUE(session_.step(1, 2));
  ASSERT_EQ(group.status()->axes[0].state(), PowerState::fault_reaction_active);
  ASSERT_TRUE(session_.axis("1.1")->end_disturbances());
  Session other(options_on_wire());
  bool has_come = false;
  const Outcome reset = group.reset_all({.progress = [&](const auto& /*progress*/) {
    if (std::exchange(has_come, true)) return;
    EXPECT_TRUE(other.axis("1.2")->disturb(Disturbance::over_current));
  }});
  EXPECT_TRUE(has_come);
  EXPECT_EQ(reset.code(), kRefusedInState);
  EXPECT_THAT(reset.message(), HasSubstr("axis 1.2 shows error 0x2310 "));
  EXPECT_EQ(group.status()->axes[0].state(), PowerState::switch_on_disabled);
}

TEST_F(LockStepGroup, MovesTogetherScaledToTheSlowest) {
  AxisGroup group = enabled(3);
  write("1.2", kVelocity, 10'000);
  const Eigen::VectorXd starts = group.status()->demand();
  const Eigen::VectorXd targets = vector({20'000, -10'000, 5000});
  Watch watch(starts, targets);
  const std::uint64_t before = tick();
  const Outcome moved = group.move_together(targets, {.call = watch.options()});
  ASSERT_TRUE(moved) << moved.message();
  EXPECT_EQ(group.status()->demand(), targets);
  EXPECT_LE(watch.deviation(), 1.0);
  EXPECT_EQ(watch.spread(), 0U);
  EXPECT_EQ(watch.arrived(), 3U);
  EXPECT_EQ(watch.longest_gap(), 1U) << "every tick was observed";
  EXPECT_EQ(watch.fraction(), 1.0);
  // Axis 2 moves at 10000 UU/s. The path has the ramps of axis 1: 409600/20000 = 20.48 /s², so
  // 1/20.48 s = 48.83 ms up and down. A path from 0 to 1 at 1 /s takes 1048.83 ms, which is 1049
  // ticks from `before`; then follows the window time of at most 20 ms.
  EXPECT_GE(tick(), before + 1049);
  EXPECT_LE(tick(), before + 1049 + 21);
}

TEST_F(LockStepGroup, SharesTheJerkTimeOfAnAxisWithLimitedJerk) {
  AxisGroup group = enabled(3);
  write("1.2", kProfileType, 3);
  const Eigen::VectorXd starts = group.status()->demand();
  const Eigen::VectorXd targets = vector({20'000, -10'000, 5000});
  Watch watch(starts, targets);
  const std::uint64_t before = tick();
  const Outcome moved = group.move_together(targets, {.call = watch.options()});
  ASSERT_TRUE(moved) << moved.message();
  EXPECT_EQ(group.status()->demand(), targets);
  EXPECT_LE(watch.deviation(), 1.0);
  EXPECT_EQ(watch.spread(), 0U);
  EXPECT_EQ(watch.arrived(), 3U);
  // The path has the speed and the ramps of axis 1: 68267/20000 = 3.41 /s and 20.48 /s². It has the
  // jerk of axis 2: 4096000/10000 = 409.6 /s³, which adds 50 ms to each ramp of 166.7 ms. A path
  // from 0 to 1 at 3.41 /s takes 293 ms + 216.7 ms = 509.6 ms, counted as above.
  EXPECT_GE(tick(), before + 510);
  EXPECT_LE(tick(), before + 510 + 21);
  EXPECT_NEAR(static_cast<double>(*session_.axis("1.1")->read(kMoveJerkTime)), 50'000.0, 10.0);
}

TEST_F(LockStepGroup, ResetsTheTimesOfASynchronousMoveBeforeAnOrdinaryMove) {
  AxisGroup group = enabled(2);
  ASSERT_TRUE(group.move_together(vector({1000, 2000})));
  EXPECT_EQ(*session_.axis("1.1")->read(kMoveDuration), 0);
  ASSERT_TRUE(session_.axis("1.1")->move_to(5000));
  ASSERT_TRUE(group.move_by(vector({-1000, 500})));
  EXPECT_EQ(group.status()->demand(), vector({4000, 2500}));
}

TEST_F(LockStepGroup, ScalesSpeedAndAccelerationByItsFactors) {
  AxisGroup group = enabled(2);
  const std::uint64_t before = tick();
  // At 68267 UU/s · 0.1 and 409600 UU/s² · 0.1: 20000 / 6826.7 + 6826.7 / 40960 = 3.0963 s.
  ASSERT_TRUE(group.move_together(vector({20'000, 100}), {.velocity_factor = 0.1,
                                                          .acceleration_factor = 0.1,
                                                          .deceleration_factor = 0.1,
                                                          .call = {}}));
  EXPECT_GE(tick(), before + 3097);
  EXPECT_LE(tick(), before + 3097 + 22);
  const Outcome refused = group.move_together(vector({0, 0}), {.velocity_factor = 1.5, .call = {}});
  EXPECT_EQ(refused.kind(), OutcomeKind::refused);
}

TEST_F(LockStepGroup, RefusesPositionsThatAreMissingNotFiniteOrOutOfRange) {
  AxisGroup group = enabled(2);
  EXPECT_THAT(group.move_together(vector({1, 2, 3})).message(),
              HasSubstr("3 positions for 2 axes"));
  EXPECT_THAT(group.move_together(vector({1, std::numeric_limits<double>::quiet_NaN()})).message(),
              HasSubstr("axis 1.2"));
  EXPECT_THAT(group.move_together(vector({3e9, 0})).message(), HasSubstr("axis 1.1"));
  EXPECT_EQ(group.status()->demand(), vector({0, 0}));
}

TEST_F(LockStepGroup, ARefusedStartNamesTheAxisAndNothingMoves) {
  AxisGroup group = enabled(3);
  // Raised while enabled: the group reads the new limits, but the old ones remain in force, because
  // 607Fh and 6080h take effect at the next enabling. 400000 UU in the time that axis 1 needs for
  // its 1000 UU require 1e6 UU/s; 136533 UU/s are allowed.
  write("1.2", kVelocity, 1'000'000);
  write("1.2", kSpeedLimit, 1'000'000);
  write("1.2", {0x6080, 0}, 100'000);
  write("1.1", kVelocity, 136'000);
  write("1.2", kAcceleration, 4'000'000'000);
  write("1.2", kDeceleration, 4'000'000'000);
  const Outcome ignored = group.move_together(vector({1000, 400'000, 1000}));
  EXPECT_EQ(ignored.kind(), OutcomeKind::refused) << ignored.message();
  EXPECT_EQ(ignored.code(), kRefusedInState);
  EXPECT_THAT(ignored.message(), HasSubstr("axis 1.2 ignored the set-point"));
  ASSERT_TRUE(session_.step(1, 500));
  EXPECT_EQ(group.status()->demand(), vector({0, 0, 0}));
  EXPECT_EQ(group.status()->state, GroupState::standby);
  // A later resume must not restart the withdrawn move.
  ASSERT_TRUE(group.resume_all());
  EXPECT_EQ(group.status()->demand(), vector({0, 0, 0}));
}

TEST_F(LockStepGroup, MovesNoAxisWhenOneAxisCannotStart) {
  AxisGroup group = enabled(3);
  ASSERT_TRUE(session_.axis("1.2")->disable());
  const Outcome disabled = group.move_together(vector({1000, 1000, 1000}));
  EXPECT_EQ(disabled.code(), kRefusedInState);
  EXPECT_THAT(disabled.message(), HasSubstr("axis 1.2 is in Ready to switch on"));
  ASSERT_TRUE(group.enable_all());
  write("1.3", {0x3535, 0}, 1);
  write("1.3", {0x607D, 2}, 500);
  const Outcome beyond = group.move_together(vector({1000, 1000, 1000}));
  EXPECT_THAT(beyond.message(), HasSubstr("axis 1.3"));
  EXPECT_THAT(beyond.message(), HasSubstr("software limits"));
  write("1.3", {0x3535, 0}, 0);
  write("1.1", kVelocity, 0);
  EXPECT_THAT(group.move_together(vector({1000, 1000, 1000})).message(),
              HasSubstr("axis 1.1: profile_velocity (6081h) is 0: the axis cannot move"));
  write("1.1", kVelocity, 1);
  EXPECT_THAT(group.move_together(vector({5000, 1000, 1000})).message(),
              HasSubstr("axis 1.1 would take longer"));
  ASSERT_TRUE(session_.step(1, 100));
  EXPECT_EQ(group.status()->demand(), vector({0, 0, 0}));
}

// A rotary table of 4096 UU a turn, with positions from 0 to below 4096.
TEST_F(LockStepGroup, MovesAModuloAxisWithinItsRangeAndByNoDirection) {
  AxisGroup group = enabled(3);
  write("1.3", {0x607B, 2}, 4'096);
  const Outcome beyond = group.move_together(vector({1000, 1000, 5000}));
  EXPECT_EQ(beyond.kind(), OutcomeKind::refused);
  EXPECT_THAT(beyond.message(),
              HasSubstr("axis 1.3: the target 5000 UU (439.45 deg) is outside of its "
                        "position range (607Bh), from 0 UU (0.00 deg) to below "
                        "4096 UU (360.00 deg)"));
  write("1.3", kPositioningOption, 2 + 128);
  EXPECT_THAT(group.move_together(vector({1000, 1000, 1000})).message(),
              HasSubstr("axis 1.3: positioning_option_code (60F2h) selects a direction"));
  EXPECT_EQ(group.status()->demand(), vector({0, 0, 0}));
  write("1.3", kPositioningOption, 2);
  ASSERT_TRUE(group.move_together(vector({1000, 1000, 4'000})));
  EXPECT_EQ(group.status()->demand(), vector({1000, 1000, 4'000}));
}

TEST_F(LockStepGroup, EnablesNoAxisWhenAnotherSessionHoldsOne) {
  Session other(options_on_wire());
  auto theirs = other.axis("1.3");
  ASSERT_TRUE(theirs->enable());
  auto group = AxisGroup::create(session_, names(1, 1, 3));
  const Outcome refused = group->enable_all();
  EXPECT_EQ(refused.kind(), OutcomeKind::refused);
  EXPECT_THAT(refused.message(), HasSubstr("axis 1.3 is controlled by "));
  EXPECT_EQ(group->status()->axes[0].state(), PowerState::switch_on_disabled);
}

TEST_F(LockStepGroup, HaltsQuickStopsAndTakesOverAxesOfAnotherSession) {
  Session other(options_on_wire());
  auto theirs = other.axis("1.3");
  ASSERT_TRUE(theirs->enable());
  auto ours = session_.axis("1.1");
  ASSERT_TRUE(ours->enable());
  MoveOptions move;
  move.call.until = Until::in_force;
  ASSERT_TRUE(theirs->move_to(1'000'000, move));
  ASSERT_TRUE(ours->move_to(1'000'000, move));
  auto group = AxisGroup::create(session_, std::vector<std::string>{"1.1", "1.3"});
  const Outcome halted = group->halt_all();
  ASSERT_TRUE(halted) << halted.message();
  const auto seen = group->status();
  ASSERT_TRUE(seen);
  for (const AxisSnapshot& axis : seen->axes) {
    EXPECT_EQ(axis.status.velocity_demand_value, 0) << to_string(axis.id);
  }
  EXPECT_EQ(theirs->status()->owner_session, other.id());
  const Outcome stopped = group->quick_stop_all();
  ASSERT_TRUE(stopped) << stopped.message();
  EXPECT_EQ(group->status()->axes[1].state(), PowerState::switch_on_disabled);
  EXPECT_EQ(group->enable_all().kind(), OutcomeKind::refused);
  ASSERT_TRUE(group->take_over());
  EXPECT_TRUE(group->enable_all());
  EXPECT_EQ(theirs->status()->owner_session, session_.id());
}

TEST_F(LockStepGroup, AFaultOfOneAxisStopsTheOthersWithinTwoTicksOfItsStatus) {
  AxisGroup group = enabled(4);
  std::uint64_t fault = 0;
  std::map<std::uint16_t, std::uint64_t> stopped;
  GroupCallOptions call;
  call.progress = [&](const GroupProgress& seen) {
    if (seen.fraction > 0.3 && fault == 0 && stopped.empty()) write("1.3", kOverCurrent, 1);
    for (const AxisSnapshot& axis : seen.axes) {
      const bool is_fault =
          axis.state() == PowerState::fault || axis.state() == PowerState::fault_reaction_active;
      if (is_fault && fault == 0) fault = seen.tick;
      if (axis.state() == PowerState::quick_stop_active) stopped.emplace(axis.id.axis, seen.tick);
    }
  };
  const Outcome failed =
      group.move_together(vector({200'000, 100'000, 50'000, -100'000}), {.call = call});
  EXPECT_EQ(failed.kind(), OutcomeKind::failed) << failed.message();
  EXPECT_THAT(failed.message(), HasSubstr("axis 1.3"));
  EXPECT_THAT(failed.message(), HasSubstr("0x2310"));
  ASSERT_NE(fault, 0U);
  ASSERT_EQ(stopped.size(), 3U) << "1.1, 1.2 and 1.4";
  for (const auto& [axis, when] : stopped) {
    EXPECT_GE(when, fault) << axis;
    EXPECT_LE(when, fault + 2) << axis;
  }
  // The axes are at rest when the call returns; with 605Ah = 2 they are in Switch on disabled.
  const auto seen = group.status();
  for (const AxisSnapshot& axis : seen->axes) {
    EXPECT_EQ(axis.status.velocity_demand_value, 0);
    EXPECT_NE(axis.state(), PowerState::operation_enabled);
  }
  EXPECT_EQ(group.status()->state, GroupState::error_stop);
  const Outcome persists = group.reset_all();
  EXPECT_EQ(persists.code(), kRefusedInState);
  EXPECT_THAT(persists.message(), HasSubstr("axis 1.3"));
  write("1.3", kOverCurrent, 0);
  ASSERT_TRUE(group.reset_all());
  ASSERT_TRUE(group.enable_all());
  EXPECT_EQ(group.status()->state, GroupState::standby);
}

/// Another session that takes over axis 1.2 in the middle of a group move.
class Taker {
 public:
  /// @return the options for the call that observes the move.
  GroupCallOptions options() {
    GroupCallOptions call;
    call.progress = [this](const GroupProgress& seen) {
      if (seen.fraction < 0.3 || has_taken_) return;
      has_taken_ = true;
      EXPECT_TRUE(axis_.take_over());
    };
    return call;
  }

  void take() { EXPECT_TRUE(axis_.take_over()); }

  /// @return whether the outcome names this session as the one that has taken the axis.
  [[nodiscard]] testing::AssertionResult is_named_by(const Outcome& outcome) const {
    const AxisOwner* const owner = outcome.owner();
    const bool is_named = outcome.kind() == OutcomeKind::refused &&
                          outcome.code() == wire::number(msg::Reason::not_owner) &&
                          owner != nullptr && owner->axis == AxisId{1, 2} &&
                          owner->session == session_.id() && owner->name.has_value();
    return (is_named ? testing::AssertionSuccess() : testing::AssertionFailure())
           << outcome.message();
  }

 private:
  Session session_{options_on_wire()};
  Axis axis_ = session_.axis("1.2").value();
  bool has_taken_ = false;
};

TEST_F(LockStepGroup, AMoveEndsAndStopsItsOtherAxesWhenAnotherSessionTakesOne) {
  AxisGroup group = enabled(3);
  Taker taker;
  const Outcome ended =
      group.move_together(vector({200'000, 100'000, 50'000}), {.call = taker.options()});
  EXPECT_TRUE(taker.is_named_by(ended));
  EXPECT_THAT(ended.message(), HasSubstr("another session has taken an axis of the group"));
  const auto seen = group.status();
  ASSERT_TRUE(seen) << seen.outcome().message();
  EXPECT_EQ(seen->axes[1].state(), PowerState::operation_enabled) << "it is left to the other one";
  for (const std::size_t place : {0U, 2U}) {
    EXPECT_NE(seen->axes[place].state(), PowerState::operation_enabled) << place;
    EXPECT_EQ(seen->axes[place].status.velocity_demand_value, 0) << place;
  }
  EXPECT_LT(seen->axes[0].status.position_demand_value, 200'000) << "not at its end";
}

TEST_F(LockStepGroup, AWaitEndsAndDropsTheQueueWhenAnotherSessionTakesOneAxis) {
  AxisGroup group = enabled(2);
  ASSERT_TRUE(group.move_together(vector({200'000, 100'000}), at_start()));
  ASSERT_TRUE(group.queue_move(vector({0, 0})));
  Taker taker;
  EXPECT_TRUE(taker.is_named_by(group.wait_all(taker.options())));
  const auto seen = group.status();
  ASSERT_TRUE(seen) << seen.outcome().message();
  EXPECT_EQ(seen->queued, 0U);
  EXPECT_NE(seen->axes[0].state(), PowerState::operation_enabled);
  EXPECT_EQ(seen->axes[1].state(), PowerState::operation_enabled);
}

TEST_F(LockStepGroup, APollStopsTheOtherAxesWhenAnotherSessionHasTakenOne) {
  AxisGroup group = enabled(2);
  ASSERT_TRUE(group.move_together(vector({200'000, 100'000}), at_start()));
  ASSERT_TRUE(session_.step(1, 200));
  Taker taker;
  taker.take();
  EXPECT_TRUE(taker.is_named_by(group.poll().outcome()));
  ASSERT_TRUE(session_.step(1, 1));
  const auto seen = group.status();
  ASSERT_TRUE(seen) << seen.outcome().message();
  EXPECT_EQ(seen->axes[0].state(), PowerState::quick_stop_active);
  EXPECT_EQ(seen->axes[1].state(), PowerState::operation_enabled);
}

TEST_F(LockStepGroup, APollStopsTheOtherAxesWhileNoCallWaits) {
  AxisGroup group = enabled(3);
  ASSERT_TRUE(group.move_together(vector({300'000, 200'000, 100'000}), at_start()));
  ASSERT_TRUE(session_.step(1, 200));
  EXPECT_EQ(group.poll()->state, GroupState::moving);
  write("1.2", kOverCurrent, 1);
  ASSERT_TRUE(session_.step(1, 1));
  const std::uint64_t fault = tick();
  const auto polled = group.poll();
  EXPECT_EQ(polled.outcome().kind(), OutcomeKind::failed);
  EXPECT_THAT(polled.outcome().message(), HasSubstr("axis 1.2"));
  EXPECT_EQ(tick(), fault) << "a poll steps nothing";
  ASSERT_TRUE(session_.step(1, 1));
  EXPECT_EQ(group.status()->axes[0].state(), PowerState::quick_stop_active);
  EXPECT_EQ(group.status()->axes[2].state(), PowerState::quick_stop_active);
}

TEST_F(LockStepGroup, HaltAndResumeKeepTheAxesOnTheirStraightLine) {
  AxisGroup group = enabled(3);
  const Eigen::VectorXd targets = vector({100'000, -50'000, 33'333});
  Watch watch(group.status()->demand(), targets);
  GroupCallOptions start = watch.options();
  start.until = Until::in_force;
  ASSERT_TRUE(group.move_together(targets, {.call = start}));
  ASSERT_TRUE(session_.step(1, 500));
  ASSERT_TRUE(group.halt_all(watch.options()));
  const Eigen::VectorXd halted = group.status()->demand();
  EXPECT_GT(halted[0], 1000.0);
  EXPECT_LT(halted[0], 99'000.0);
  EXPECT_EQ(group.status()->state, GroupState::standby);
  const Outcome resumed = group.resume_all(watch.options());
  ASSERT_TRUE(resumed) << resumed.message();
  EXPECT_EQ(group.status()->demand(), targets);
  EXPECT_LE(watch.deviation(), 1.0);
  EXPECT_EQ(watch.spread(), 0U);
  EXPECT_EQ(watch.arrived(), 3U);
}

TEST_F(LockStepGroup, GoesOnAlongItsLineWithLimitedJerkWhileItSpeedsUp) {
  AxisGroup group = enabled(3);
  for (const char* axis : {"1.1", "1.2", "1.3"}) write(axis, kProfileType, 3);
  const Eigen::VectorXd further = vector({40'000, -20'000, 10'000});
  Watch watch(group.status()->demand(), further);
  const std::uint64_t before = tick();
  ASSERT_TRUE(group.move_together(vector({20'000, -10'000, 5'000}), at_start()));
  ASSERT_TRUE(session_.step(1, 60));
  const Outcome moved = group.move_together(further, {.call = watch.options()});
  ASSERT_TRUE(moved) << moved.message();
  EXPECT_EQ(group.status()->demand(), further);
  EXPECT_LE(watch.deviation(), 1.0);
  EXPECT_EQ(watch.arrived(), 3U);
  // The last speeds of the shorter ways are rounded to 0 earlier than that of the longest.
  EXPECT_LE(watch.spread(), 2U);
  // Axis 1 has the limits of both lines: it needs 68267/409600 s + 409600/4096000 s = 266.7 ms and
  // 9102 UU to reach 68267 UU/s. The ramp continues, so the time is that of a start from rest:
  // 40000/68267 s = 585.9 ms and 266.7 ms. Rounding the ramps up to microseconds may add another
  // tick; then the window time follows.
  EXPECT_GE(tick(), before + 852);
  EXPECT_LE(tick(), before + 855 + 21);
  EXPECT_EQ(*session_.axis("1.1")->read(kMoveReferenceWay), 0) << "an ordinary move follows";
}

TEST_F(LockStepGroup, StopsOnItsLineBeforeItsEndAndTurnsBack) {
  AxisGroup group = enabled(3);
  const Eigen::VectorXd starts = group.status()->demand();
  ASSERT_TRUE(group.move_together(vector({100'000, -50'000, 33'000}), at_start()));
  ASSERT_TRUE(session_.step(1, 500));
  const Eigen::VectorXd before = vector({60'000, -30'000, 19'800});
  Watch stop(starts, before);
  GroupMoveOptions on_the_way{.call = stop.options()};
  on_the_way.call.until = Until::in_force;
  ASSERT_TRUE(group.move_together(before, on_the_way));
  ASSERT_TRUE(session_.step(1, 100));
  // The axes are still too fast: they stop first, then return.
  Watch back(starts, before);
  const Outcome moved = group.move_together(starts, {.call = back.options()});
  ASSERT_TRUE(moved) << moved.message();
  EXPECT_EQ(group.status()->demand(), starts);
  EXPECT_LE(stop.deviation(), 1.0);
  EXPECT_LE(back.deviation(), 1.0);
}

TEST_F(LockStepGroup, ATargetOffTheLineIsRefusedAndTheAxesGoOn) {
  AxisGroup group = enabled(2);
  const Eigen::VectorXd targets = vector({100'000, 50'000});
  ASSERT_TRUE(group.move_together(targets, at_start()));
  ASSERT_TRUE(session_.step(1, 300));
  const Outcome refused = group.move_together(vector({100'000, 0}));
  EXPECT_EQ(refused.code(), kRefusedInState);
  EXPECT_THAT(refused.message(),
              HasSubstr("axis 1.2: its target (607Ah) is 0 UU (0.00 deg), but the present line "
                        "needs 50000 UU (4394.53 deg), give or take 1 UU"));
  const Outcome arrived = group.wait_all();
  ASSERT_TRUE(arrived) << arrived.message();
  EXPECT_EQ(group.status()->demand(), targets);
}

TEST_F(LockStepGroup, ALineDoesNotStartWhileAnAxisMovesWithoutOne) {
  AxisGroup group = enabled(2);
  MoveOptions move;
  move.call.until = Until::in_force;
  ASSERT_TRUE(session_.axis("1.2")->move_to(100'000, move));
  ASSERT_TRUE(session_.step(1, 100));
  const Outcome refused = group.move_together(vector({0, 200'000}));
  EXPECT_EQ(refused.code(), kRefusedInState);
  EXPECT_THAT(refused.message(),
              HasSubstr("axis 1.2 is still moving: its velocity demand (606Bh) is "));
}

TEST_F(LockStepGroup, QuickStopEndsInSwitchOnDisabledAndDropsTheQueue) {
  AxisGroup group = enabled(2);
  ASSERT_TRUE(group.move_together(vector({100'000, 100'000}), at_start()));
  ASSERT_TRUE(group.queue_move(vector({0, 0})));
  ASSERT_TRUE(session_.step(1, 300));
  ASSERT_TRUE(group.quick_stop_all());
  const auto status = group.status();
  EXPECT_EQ(status->queued, 0U);
  for (const AxisSnapshot& axis : status->axes) {
    EXPECT_EQ(axis.state(), PowerState::switch_on_disabled);
  }
}

TEST_F(LockStepGroup, ATimeOutNamesTheAxisThatWasLate) {
  AxisGroup group = enabled(3);
  GroupCallOptions call;
  call.timeout = 100ms;
  const std::uint64_t before = tick();
  const Outcome late = group.move_together(vector({100'000, 0, 0}), {.call = call});
  EXPECT_EQ(late.kind(), OutcomeKind::timed_out);
  EXPECT_THAT(late.message(), HasSubstr("target reached"));
  EXPECT_THAT(late.message(), HasSubstr("axis 1.1"));
  EXPECT_EQ(tick(), before + 100);
  EXPECT_EQ(group.status()->state, GroupState::moving) << "the motion continues";
  EXPECT_THAT(group.move_together(vector({0, 500, 0})).message(),
              HasSubstr("axis 1.2: its target (607Ah) is 500 UU"));
  const Outcome halted = group.halt_all();
  ASSERT_TRUE(halted) << halted.message();
}

TEST_F(LockStepGroup, RunsQueuedMovesWithoutATickOfRestBetweenThem) {
  AxisGroup group = enabled(2);
  write("1.1", {0x6067, 0}, 0);  // in position means the exact unit only, some ms after the demand
  const std::vector<Eigen::VectorXd> corners{vector({10'000, 0}), vector({10'000, 10'000}),
                                             vector({0, 0})};
  for (const Eigen::VectorXd& corner : corners) ASSERT_TRUE(group.queue_move(corner));
  EXPECT_EQ(group.status()->queued, 3U);
  EXPECT_EQ(group.status()->demand(), vector({0, 0})) << "nothing starts by itself";
  std::vector<std::uint64_t> passed;
  std::uint64_t longest_rest = 0;
  std::uint64_t rest = 0;
  GroupCallOptions call;
  call.progress = [&](const GroupProgress& seen) {
    const bool rests = seen.axes[0].status.velocity_demand_value == 0 &&
                       seen.axes[1].status.velocity_demand_value == 0;
    rest = rests ? rest + 1 : 0;
    if (passed.size() == corners.size()) return;
    if (!passed.empty()) longest_rest = std::max(longest_rest, rest);
    const Eigen::VectorXd& corner = corners[passed.size()];
    if (rests && seen.axes[0].status.position_demand_value == corner[0] &&
        seen.axes[1].status.position_demand_value == corner[1]) {
      passed.push_back(seen.tick);
    }
  };
  const Outcome done = group.wait_all(call);
  ASSERT_TRUE(done) << done.message();
  ASSERT_EQ(passed.size(), 3U) << "in their order";
  EXPECT_EQ(longest_rest, 1U) << "the tick of the arrival";
  EXPECT_EQ(group.status()->demand(), vector({0, 0}));
}

// The profile of a line may end slightly (a rounding of its time, or a part of a millisecond) after
// the tick in which 6062h and 606Bh show its target. The drive must take the next line in that
// tick.
TEST_F(LockStepGroup, RunsALineThatIsQueuedAfterAnyLine) {
  AxisGroup group = enabled(2);
  std::minstd_rand random(48);
  const auto position = [&random] {
    return static_cast<double>(random() % 100'000) - 50'000.0;
  };
  // The speed is below 0.5 UU/s for the last half tick of a line, so 606Bh already shows 0.
  write("1.2", kDeceleration, 1'000);
  // Over DDS a tick takes some twenty times as long.
  const int share = test::runs_over_dds() ? 20 : 1;
  const int pairs = test::number_of<int>({.usual = 60, .full = 600, .nightly = 6'000}) / share;
  for (int pair = 0; pair < pairs; ++pair) {
    // Every other pair leaves the slow axis at rest.
    const double slow = pair % 2 == 0 ? 0.0 : static_cast<double>(random() % 200);
    const Eigen::VectorXd first = vector({position(), slow});
    const Eigen::VectorXd second = vector({position(), 0.0});
    ASSERT_TRUE(group.queue_move(first));
    ASSERT_TRUE(group.queue_move(second));
    const Outcome done = group.wait_all();
    ASSERT_TRUE(done) << "pair " << pair << ": " << first.transpose() << ", then "
                      << second.transpose() << ": " << done.message();
    ASSERT_EQ(group.status()->demand(), second) << pair;
  }
}

TEST_F(LockStepGroup, APollStartsTheQueuedMovesOfAProgramWithItsOwnLoop) {
  AxisGroup group = enabled(2);
  ASSERT_TRUE(group.queue_move(vector({1000, 500})));
  ASSERT_TRUE(group.queue_move(vector({0, 0})));
  int ticks = 0;
  bool passed = false;
  while (ticks < 2000) {
    const auto status = group.poll();
    ASSERT_TRUE(status) << status.outcome().message();
    passed = passed || status->demand() == vector({1000, 500});
    if (passed && status->queued == 0 && status->state == GroupState::standby) break;
    ASSERT_TRUE(session_.step(1, 1));
    ++ticks;
  }
  EXPECT_TRUE(passed);
  EXPECT_EQ(group.status()->demand(), vector({0, 0}));
}

TEST_F(LockStepGroup, StreamsACircle) {
  AxisGroup group = enabled(2);
  ASSERT_TRUE(group.start_streaming());
  constexpr double kRadius = 4096.0;
  double worst = 0.0;
  const std::uint64_t before = tick();
  for (int step = 1; step <= 2000; ++step) {
    const double angle = 2.0 * std::numbers::pi * step / 2000.0;
    const Eigen::VectorXd wanted =
        vector({kRadius * (std::cos(angle) - 1.0), kRadius * std::sin(angle)});
    const auto seen = group.stream(wanted);
    ASSERT_TRUE(seen) << seen.outcome().message();
    ASSERT_THAT(seen->not_following(), IsEmpty());
    ASSERT_LE((seen->demand() - wanted).cwiseAbs().maxCoeff(), 0.5) << "6062h is the position";
    // The first position demands full speed immediately; after 100 ms the servo has settled.
    if (step > 100) worst = std::max(worst, (seen->actual() - wanted).norm());
  }
  EXPECT_EQ(tick(), before + 2000);
  // The speed on the circle is 2·pi·4096 UU in 2 s = 12868 UU/s, 12.9 UU a tick: the error of a
  // servo that is a tick late.
  EXPECT_LE(worst, 12.9);
  ASSERT_TRUE(group.stop_streaming());
  ASSERT_TRUE(group.move_together(vector({500, 500}))) << "profile position is back";
}

// 606Bh is the velocity at the end of the tick.
TEST_F(LockStepGroup, StreamsVelocitiesOfThreeAxes) {
  AxisGroup group = enabled(3);
  ASSERT_TRUE(group.start_streaming({.what = Streamed::velocities}));
  const std::uint64_t before = tick();
  for (int step = 1; step <= 100; ++step) {
    const auto seen = group.stream(vector({100.0 * step, -50.0 * step, 0.0}));
    ASSERT_TRUE(seen) << seen.outcome().message();
    ASSERT_THAT(seen->not_following(), IsEmpty());
    ASSERT_EQ(seen->axes[0].status.velocity_demand_value, 100 * step);
    ASSERT_EQ(seen->axes[1].status.velocity_demand_value, -50 * step);
    ASSERT_EQ(seen->axes[2].status.velocity_demand_value, 0);
  }
  EXPECT_EQ(tick(), before + 100);
  ASSERT_TRUE(group.stop_streaming());
  EXPECT_EQ(group.status()->state, GroupState::standby);
  ASSERT_TRUE(group.move_together(vector({0, 0, 0}))) << "profile position is back";
}

// 6074h is the command of the last of 8 servo cycles, an eighth of a tick before the end of the
// tick.
TEST_F(LockStepGroup, StreamsTorquesOfThreeAxes) {
  AxisGroup group = enabled(3);
  ASSERT_TRUE(group.start_streaming({.what = Streamed::torques}));
  const std::uint64_t before = tick();
  for (int step = 1; step <= 10; ++step) {
    const auto seen = group.stream(vector({8.0 * step, -16.0 * step, 0.0}));
    ASSERT_TRUE(seen) << seen.outcome().message();
    ASSERT_THAT(seen->not_following(), IsEmpty());
    ASSERT_EQ(seen->axes[0].status.torque_demand, 8 * step - 1);
    ASSERT_EQ(seen->axes[1].status.torque_demand, -16 * step + 2);
    ASSERT_EQ(seen->axes[2].status.torque_demand, 0);
  }
  EXPECT_EQ(tick(), before + 10);
  ASSERT_TRUE(group.stop_streaming());
  EXPECT_EQ(group.status()->state, GroupState::standby);
}

TEST_F(LockStepGroup, AStreamReportsTheAxesThatDoNotFollow) {
  AxisGroup group = enabled(2);
  ASSERT_TRUE(group.start_streaming({.pace = Pace::observe}));
  const std::uint64_t before = tick();
  ASSERT_TRUE(group.stream(vector({10, 5000})));  // 5000 UU in 1 ms: above 607Fh
  EXPECT_EQ(tick(), before) << "the caller steps";
  ASSERT_TRUE(session_.step(1, 1));
  EXPECT_THAT(group.status()->not_following(), ElementsAre(AxisId{1, 2}));
  write("1.1", kOverCurrent, 1);
  ASSERT_TRUE(session_.step(1, 1));
  const auto failed = group.stream(vector({10, 5000}));
  EXPECT_EQ(failed.outcome().kind(), OutcomeKind::failed);
  EXPECT_THAT(failed.outcome().message(), HasSubstr("axis 1.1"));
  EXPECT_NE(group.status()->axes[1].state(), PowerState::operation_enabled);
}

TEST_F(LockStepGroup, RefusesAMonitorInLockStep) {
  AxisGroup group = enabled(2);
  EXPECT_EQ(group.monitor(true).kind(), OutcomeKind::refused);
}

// A sanitizer takes many times as long, and finds the same with fewer moves.
#ifdef VDRIVE_SANITIZED
constexpr int kRandomMoves = 20;
#else
constexpr int kRandomMoves = 400;
#endif

class BigGroup : public Group {
 protected:
  BigGroup() : Group("--clock lockstep --axes 64") {}

  /// Sets random limits, so that any axis may be the slowest, and position windows so wide that no
  /// move ends late.
  void prepare(std::mt19937_64& random) {
    const auto between = [&](double low, double high) {
      return static_cast<std::int64_t>(
          std::pow(10.0, std::uniform_real_distribution<double>(low, high)(random)));
    };
    for (int axis = 1; axis <= 64; ++axis) {
      const std::string name = "1." + std::to_string(axis);
      write(name, {0x6065, 0}, 4294967295);
      write(name, {0x6067, 0}, 4294967295);
      write(name, kSpeedLimit, 4294967295);
      write(name, {0x6080, 0}, 4294967295);
      write(name, kVelocity, between(9.0, 9.6));
      write(name, kAcceleration, between(9.0, 9.6));
      write(name, kDeceleration, between(9.0, 9.6));
    }
  }
};

TEST_F(BigGroup, KeepsAStraightLineAndArrivesTogetherInRandomMovesOf2To64Axes) {
  const int moves = test::number_of<int>(
      {.usual = kRandomMoves, .full = kRandomMoves, .nightly = 500 * kRandomMoves});
  std::mt19937_64 random(11);
  prepare(random);
  const auto uniform = [&](std::int64_t low, std::int64_t high) {
    return std::uniform_int_distribution<std::int64_t>(low, high)(random);
  };
  for (int move = 0; move < moves; ++move) {
    const int count = static_cast<int>(uniform(2, 64));
    SCOPED_TRACE("move " + std::to_string(move) + " of " + std::to_string(count) + " axes");
    AxisGroup group = enabled(count);
    const double reach = std::pow(10.0, std::uniform_real_distribution<double>(0.0, 9.0)(random));
    const Eigen::VectorXd starts = group.status()->demand();
    Eigen::VectorXd targets = starts;
    for (double& target : targets) {
      const double towards_zero = target > 0 ? -1.0 : 1.0;
      target += towards_zero * static_cast<double>(uniform(0, static_cast<std::int64_t>(reach)));
    }
    Watch watch(starts, targets);
    const Outcome moved = group.move_together(targets, {.call = watch.options()});
    ASSERT_TRUE(moved) << moved.message();
    ASSERT_EQ(group.status()->demand(), targets);
    ASSERT_LE(watch.deviation(), 1.0);
    ASSERT_EQ(watch.spread(), 0U);
    ASSERT_LE(watch.longest_gap(), 1U);
  }
}

TEST(TwoServices, FormOneGroupInLockStep) {
  const BenchOnWire left("--clock lockstep --axes 2");
  const BenchOnWire right("--clock lockstep --bench 2 --axes 2");
  Session session(options_on_wire());
  ASSERT_TRUE(session.step(2, 777)) << "their ticks need not be the same";
  auto group = AxisGroup::create(session, std::vector<std::string>{"2.1", "1.1", "1.2", "2.2"});
  ASSERT_TRUE(group) << group.outcome().message();
  ASSERT_TRUE(group->enable_all());
  const Eigen::VectorXd targets = vector({20'000, 10'000, -30'000, 7});
  const std::uint64_t first = *session.step(1, 0);
  const std::uint64_t second = *session.step(2, 0);
  Watch watch(group->status()->demand(), targets);
  const Outcome moved = group->move_together(targets, {.call = watch.options()});
  ASSERT_TRUE(moved) << moved.message();
  EXPECT_LE(watch.deviation(), 1.0);
  EXPECT_EQ(watch.spread(), 0U);
  EXPECT_EQ(group->status()->demand(), targets);
  EXPECT_EQ(*session.step(1, 0) - first, *session.step(2, 0) - second) << "they step together";

  // A fault of an axis of one bench stops the axes of the other.
  ASSERT_TRUE(group->move_together(vector({100'000, 100'000, 100'000, 100'000}), at_start()));
  ASSERT_TRUE(session.axis("2.2")->write(kBlockedLoad, 1));
  const Outcome failed = group->wait_all();
  EXPECT_EQ(failed.kind(), OutcomeKind::failed);
  EXPECT_THAT(failed.message(), HasSubstr("axis 2.2"));
  const auto seen = group->status();
  for (const AxisSnapshot& axis : seen->axes) {
    EXPECT_NE(axis.state(), PowerState::operation_enabled) << to_string(axis.id);
  }
}

TEST(TwoServices, ARefusedStartOnOneServiceMovesNoAxisOfTheOther) {
  const BenchOnWire left("--clock lockstep --axes 1");
  const BenchOnWire right("--clock lockstep --bench 2 --axes 1");
  Session session(options_on_wire());
  auto group = AxisGroup::create(session, std::vector<std::string>{"1.1", "2.1"});
  ASSERT_TRUE(group->enable_all());
  auto axis = session.axis("2.1");
  ASSERT_TRUE(axis->write(kVelocity, 1'000'000));
  ASSERT_TRUE(axis->write(kSpeedLimit, 1'000'000));  // takes effect at the next enabling only
  ASSERT_TRUE(axis->write({0x6080, 0}, 100'000));
  ASSERT_TRUE(session.axis("1.1")->write(kVelocity, 136'000));
  const Outcome refused = group->move_together(vector({100'000, 400'000}));
  EXPECT_EQ(refused.kind(), OutcomeKind::refused);
  EXPECT_THAT(refused.message(), HasSubstr("axis 2.1"));
  ASSERT_TRUE(session.step(1, 100));
  ASSERT_TRUE(session.step(2, 100));
  EXPECT_EQ(group->status()->demand(), vector({0, 0}));
}

TEST(TwoServices, WithDifferentClocksCannotFormAGroup) {
  const BenchOnWire left("--clock lockstep --axes 1");
  const BenchOnWire right("--clock realtime --bench 2 --axes 1");
  const BenchOnWire slow("--clock lockstep --bench 3 --axes 1 --period 2000");
  Session session(options_on_wire());
  const auto mixed = AxisGroup::create(session, std::vector<std::string>{"1.1", "2.1"});
  EXPECT_THAT(mixed.outcome().message(), HasSubstr("bench 1 and bench 2 have different clock"));
  const auto periods = AxisGroup::create(session, std::vector<std::string>{"1.1", "3.1"});
  EXPECT_THAT(periods.outcome().message(), HasSubstr("bench 1 and bench 3 have different periods"));
}

/// The demands of two axes in a move, by tick. On a busy machine some ticks are missed.
class DemandByTick {
 public:
  GroupCallOptions options() {
    GroupCallOptions call;
    call.progress = [this](const GroupProgress& seen) {
      for (const AxisSnapshot& axis : seen.axes) {
        demands_[axis.id].emplace(axis.tick, axis.status.position_demand_value);
      }
    };
    return call;
  }

  /// @return the demands of both axes in every tick in which both were seen.
  [[nodiscard]] std::vector<std::pair<std::int32_t, std::int32_t>> in_both() const {
    std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
    const auto& other = demands_.rbegin()->second;
    for (const auto& [tick, demand] : demands_.begin()->second) {
      if (const auto found = other.find(tick); found != other.end()) {
        pairs.emplace_back(demand, found->second);
      }
    }
    return pairs;
  }

 private:
  std::map<AxisId, std::map<std::uint64_t, std::int32_t>> demands_;
};

/// Counts the jumps of the tick number on the benches of a session. In a jump drive time stands
/// still, so the moves of two benches are no longer synchronous.
class Jumps {
 public:
  explicit Jumps(Session& session) : session_(session) {
    session_.on_event([this](const Event& event) {
      const std::scoped_lock lock(mutex_);
      count_ += event.kind == EventKind::tick_jumped ? 1 : 0;
      changed_.notify_all();
    });
  }

  ~Jumps() { session_.on_event({}); }

  Jumps(const Jumps&) = delete;
  Jumps& operator=(const Jumps&) = delete;

  [[nodiscard]] int count() {
    const std::scoped_lock lock(mutex_);
    return count_;
  }

  /// @return whether there are more than `count` jumps; waits for events that are still on their
  ///         way.
  [[nodiscard]] bool exceed(int count) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, 2s, [&] {
      return count_ > count;
    });
  }

 private:
  Session& session_;
  std::mutex mutex_;
  std::condition_variable changed_;
  int count_ = 0;
};

// If equal axes that move equally far do not have equal demands in each tick, they did not start in
// the same tick. If the machine stalls for longer than frames are sent ahead, one bench may refuse
// its frame after the other has taken its own. The start is then withdrawn, and the next move
// brings both to the same position.
TEST(TwoServices, StartInTheSameTickInRealTime) {
  const BenchOnWire left(patient("--clock realtime --axes 1"));
  const BenchOnWire right(patient("--clock realtime --bench 2 --axes 1"));
  Session session(options_on_wire());
  Jumps jumps(session);
  auto group = AxisGroup::create(session, std::vector<std::string>{"1.1", "2.1"});
  ASSERT_TRUE(group) << group.outcome().message();
  const Outcome enabled = group->enable_all();
  ASSERT_TRUE(enabled) << enabled.message();
  int judged = 0;
  bool is_from_one_place = true;
  for (int move = 0; move < 40 && judged < 3; ++move) {
    const double target = move % 2 == 0 ? 20'000.0 : 0.0;
    const int before = jumps.count();
    DemandByTick seen;
    const Outcome moved = group->move_together(vector({target, target}), {.call = seen.options()});
    if (moved.code() == wire::number(msg::Reason::too_late)) {
      is_from_one_place = false;
      for (const char* axis : {"1.1", "2.1"}) {
        EXPECT_EQ(session.axis(axis)->read(kMoveDuration).value(), 0) << axis;
      }
      continue;
    }
    ASSERT_TRUE(moved) << moved.message();
    EXPECT_EQ(group->status()->demand(), vector({target, target}));
    if (!std::exchange(is_from_one_place, true)) continue;
    const auto pairs = seen.in_both();
    const bool is_moving_seen = std::ranges::any_of(pairs, [](const auto& pair) {
      return pair.first > 0 && pair.first < 20'000;
    });
    const bool is_equal = std::ranges::all_of(pairs, [](const auto& pair) {
      return pair.first == pair.second;
    });
    if (!is_moving_seen || (!is_equal && jumps.exceed(before))) continue;
    EXPECT_TRUE(is_equal) << "move " << move << " to " << target;
    ++judged;
  }
  EXPECT_EQ(judged, 3) << "moves of which both benches were seen, without a jump";
}

/// Streams 1,000 set-points. @return whether each arrived in time.
testing::AssertionResult stream_a_thousand(
    AxisGroup& group, Streamed what, const std::function<Eigen::VectorXd(int)>& set_points_of) {
  // On a busy machine this thread may not run for more than 10 ms at a time.
  const Outcome started = group.start_streaming({.lead = 400ms, .what = what});
  if (!started) return testing::AssertionFailure() << started.message();
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  Outcome streamed;
  for (int step = 1; step <= 1'000 && streamed; ++step) {
    const auto seen = group.stream(set_points_of(step));
    streamed = seen.outcome();
    if (!seen) break;
    first = first == 0 ? seen->tick : first;
    last = seen->tick;
  }
  const Outcome stopped = group.stop_streaming();
  if (streamed) streamed = stopped;
  if (!streamed) return testing::AssertionFailure() << streamed.message();
  EXPECT_GE(last - first, 500U) << "paced by the clock: 1,000 set-points, 400 of them ahead";
  return testing::AssertionSuccess();
}

/// Two enabled axes in real time, in a session that sends no keep-alive but its set-points.
class RealtimeStream {
 public:
  RealtimeStream() {
    if (!group_) throw std::runtime_error(group_.outcome().message());
    if (const Outcome enabled = group_->enable_all(); !enabled) {
      throw std::runtime_error(enabled.message());
    }
  }

  /// Streams until no set-point was late; after a stall longer than the lead, it starts again.
  /// @param set_points_of returns the set-points of steps 1 to 1000, given the demand at the start
  /// @return the change of 6062h; nothing if a set-point was late in each of 10 attempts.
  std::optional<Eigen::VectorXd> way_of(
      Streamed what,
      const std::function<Eigen::VectorXd(const Eigen::VectorXd&, int)>& set_points_of) {
    for (int attempt = 0; attempt < 10; ++attempt) {
      const Eigen::VectorXd from = group_->status().value().demand();
      const auto is_in_time = stream_a_thousand(*group_, what, [&](int step) {
        return set_points_of(from, step);
      });
      if (is_in_time) return group_->status().value().demand() - from;
      EXPECT_THAT(is_in_time.message(), HasSubstr("too late")) << "attempt " << attempt;
      if (testing::Test::HasFailure()) break;
    }
    return std::nullopt;
  }

 private:
  static SessionOptions options() {
    SessionOptions streaming = options_on_wire();
    streaming.keep_alive = KeepAlive::user_frames;
    return streaming;
  }

  BenchOnWire bench_{patient("--clock realtime --axes 2")};
  Session session_{options()};
  Result<AxisGroup> group_ = AxisGroup::create(session_, names(1, 1, 2));
};

TEST(RealtimeGroup, StreamsAheadOfTheClock) {
  RealtimeStream stream;
  const auto way = stream.way_of(Streamed::positions, [](const Eigen::VectorXd& from, int step) {
    return Eigen::VectorXd(from + vector({step * 2.0, -step * 1.0}));
  });
  ASSERT_TRUE(way) << "a position was late in each of 10 attempts";
  EXPECT_EQ(*way, vector({2'000, -1'000}));
}

// Up to 20000 UU/s in half a second and back: 20000 / 2 UU. The position loop is open, so 6062h is
// the actual position.
TEST(RealtimeGroup, StreamsVelocitiesAheadOfTheClock) {
  RealtimeStream stream;
  const auto way =
      stream.way_of(Streamed::velocities, [](const Eigen::VectorXd& /*from*/, int step) {
        const double speed = 40.0 * std::min(step, 1'000 - step);
        return vector({speed, -speed / 2.0});
      });
  ASSERT_TRUE(way) << "a velocity was late in each of 10 attempts";
  EXPECT_NEAR((*way)[0], 10'000, 10);
  EXPECT_NEAR((*way)[1], -5'000, 10);
}

TEST(RealtimeGroup, AMonitorStopsTheOtherAxesWhileNoCallWaits) {
  const BenchOnWire bench(patient("--clock realtime --axes 2"));
  Session session(options_on_wire());
  auto group = AxisGroup::create(session, names(1, 1, 2));
  ASSERT_TRUE(group->enable_all());
  ASSERT_TRUE(group->monitor(true));
  ASSERT_TRUE(session.axis("1.2")->write(kOverCurrent, 1));
  const auto stopped = session.axis("1.1")->wait_until(
      [](const AxisSnapshot& axis) {
        return axis.state() == PowerState::switch_on_disabled;
      },
      10s);
  EXPECT_TRUE(stopped) << stopped.outcome().message();
  EXPECT_TRUE(group->monitor(false));
}

// The other axes would move for 1 s more when the second axis reaches the switch and leaves the
// common line.
TEST_F(Group, StopsWhenALimitSwitchStopsOneAxis) {
  AxisGroup group = enabled(3);
  ASSERT_TRUE(group.move_together(vector({60'000, 60'000, 60'000}), at_start()));
  ASSERT_TRUE(session_.step(1, 100));
  write("1.2", kPositiveLimit, 1);
  const std::uint64_t start = tick();
  const Outcome ended = group.wait_all();
  EXPECT_EQ(ended.kind(), OutcomeKind::failed);
  EXPECT_THAT(
      ended.message(),
      HasSubstr("axis 1.2: the positive limit switch (60FDh bit 1) ended the move to 60000"));
  EXPECT_LT(tick(), start + 1'000);
  const auto status = group.status();
  ASSERT_TRUE(status);
  for (const AxisSnapshot& axis : status->axes) {
    EXPECT_EQ(axis.status.velocity_demand_value, 0) << to_string(axis.id);
    EXPECT_LT(axis.status.position_demand_value, 60'000) << to_string(axis.id);
  }
}

}  // namespace
}  // namespace vdrive::client
