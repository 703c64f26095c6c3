// SPDX-License-Identifier: Apache-2.0
//
// Seeds of the simulation, and the proof that each of its checks can fail.
#include "simulation/simulation.hpp"

#include "simulation/probe_watch.hpp"
#include "support/effort.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cstddef>
#include <optional>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

namespace vdrive::simulation {
namespace {

/// Disks fail in many seeds, so logging is off.
const bool kIsQuiet = [] {
  spdlog::set_level(spdlog::level::off);
  return true;
}();

/// The number of seeds: `full` in an optimised build with --full, a sixth of it in an ordinary run.
/// Sanitizer builds and builds without optimisation are slow and use `debug`. Nightly runs have 20
/// times as many.
std::uint64_t count_of(std::uint64_t full, std::uint64_t debug) {
#if defined(NDEBUG) && !defined(VDRIVE_SANITIZED)
  static_cast<void>(debug);
  const std::uint64_t usual = full / 6;
#else
  full = debug;
  const std::uint64_t usual = debug;
#endif
  return test::number_of<std::uint64_t>({.usual = usual, .full = full, .nightly = 20 * full});
}

std::string words_of(const Report& report) {
  std::ostringstream words;
  words << "seed " << report.seed << ' ';
  if (report.violation) {
    const Violation& violation = *report.violation;
    words << "tick " << violation.tick << " axis " << violation.axis << " violated "
          << violation.invariant << ", expected " << violation.expected << ", seen "
          << violation.seen;
  }
  return words.str();
}

Report play_all(Options options, std::uint64_t seeds) {
  Report sum;
  for (options.seed = 1; options.seed <= seeds; ++options.seed) {
    const Report report = simulate(options);
    EXPECT_FALSE(report.violation) << words_of(report);
    sum.add(report);
    if (report.violation) break;
  }
  return sum;
}

TEST(Simulation, KeepsEveryInvariantForAMinuteOfSixteenAxesInEverySeed) {
  const Report sum = play_all({}, count_of(20, 1));
  EXPECT_GT(sum.commands, 500U);
  EXPECT_GT(sum.refused_frames, 50U);
  EXPECT_GT(sum.lost_masters, 5U);
  EXPECT_GT(sum.restarts, 2U);
  EXPECT_GT(sum.stores, 10U);
  EXPECT_GT(sum.failed_stores, 2U);
  EXPECT_GT(sum.cut_saves, 0U);
}

// A hundred ticks are enough for several changes of owner: a master acts every 2 ms on average, and
// one action in eight takes axes over.
TEST(Simulation, NeverExecutesACommandOfARevokedEpochOfTwoCompetingMasters) {
  const Report sum = play_all(
      {.seconds = 0.1, .axes = 2, .play = Play::fight, .clock = service::ClockMode::lockstep},
      count_of(5'000, 200));
  EXPECT_GT(sum.commands, count_of(1'000, 40));
  EXPECT_GT(sum.refused_frames, count_of(1'000, 40));
}

TEST(Simulation, GivesTheSameRunForTheSameSeed) {
  for (std::uint64_t seed = 1; seed <= count_of(12, 4); ++seed) {
    const Options options{.seed = seed, .seconds = 2.0};
    EXPECT_EQ(simulate(options).hash, simulate(options).hash) << "seed " << seed;
  }
}

TEST(Simulation, GivesTheSameRunForAnyNumberOfThreads) {
  for (std::uint64_t seed = 1; seed <= count_of(6, 2); ++seed) {
    const Report one = simulate({.seed = seed, .seconds = 1.0, .axes = 40});
    const Report four = simulate({.seed = seed, .seconds = 1.0, .axes = 40, .threads = 4});
    EXPECT_EQ(one.hash, four.hash) << "seed " << seed;
  }
}

TEST(Simulation, GivesDifferentRunsForDifferentSeeds) {
  EXPECT_NE(simulate({.seed = 1, .seconds = 1.0}).hash, simulate({.seed = 2, .seconds = 1.0}).hash);
}

TEST(Simulation, WritesATraceWithoutAnEffectOnTheRun) {
  std::ostringstream trace;
  const Report report = simulate({.seed = 3, .seconds = 1.0, .trace = &trace});
  EXPECT_EQ(report.hash, simulate({.seed = 3, .seconds = 1.0}).hash);
  EXPECT_NE(trace.str().find("sends frame"), std::string::npos);
  EXPECT_NE(trace.str().find("answers frame"), std::string::npos);
}

struct SabotageRow {
  const char* name;
  Sabotage sabotage;
  std::vector<std::string_view> noticed_as;  ///< any of these
};

std::ostream& operator<<(std::ostream& stream, const SabotageRow& row) {
  return stream << row.name;
}

class BrokenService : public testing::TestWithParam<SabotageRow> {};

TEST_P(BrokenService, IsDetectedInTheSameTickOfEachRun) {
  Report noticed;
  for (std::uint64_t seed = 1; seed <= 20 && !noticed.violation; ++seed) {
    noticed = simulate({.seed = seed,
                        .seconds = 5.0,
                        .clock = service::ClockMode::realtime,
                        .sabotage = GetParam().sabotage});
  }
  ASSERT_TRUE(noticed.violation);
  EXPECT_THAT(GetParam().noticed_as, testing::Contains(noticed.violation->invariant));
  const Report again = simulate({.seed = noticed.seed,
                                 .seconds = 5.0,
                                 .clock = service::ClockMode::realtime,
                                 .stop_at_tick = noticed.violation->tick,
                                 .sabotage = GetParam().sabotage});
  ASSERT_TRUE(again.violation);
  EXPECT_EQ(again.violation->tick, noticed.violation->tick);
  EXPECT_EQ(again.hash, noticed.hash);
}

INSTANTIATE_TEST_SUITE_P(
    Each, BrokenService,
    testing::Values(
        SabotageRow{"MotionWithoutPower", Sabotage::motion_without_power, {Invariant::kDemand}},
        SabotageRow{"PushWithoutPower", Sabotage::push_without_power, {Invariant::kNoMotion}},
        SabotageRow{"PositionJump", Sabotage::position_jump, {Invariant::kNoJump}},
        SabotageRow{"SpeedBeyondLimit", Sabotage::speed_beyond_limit, {Invariant::kSpeed}},
        SabotageRow{"TorqueBeyondLimit", Sabotage::torque_beyond_limit, {Invariant::kTorque}},
        SabotageRow{
            "ErrorCodeWithoutFault", Sabotage::error_code_without_fault, {Invariant::kErrorCode}},
        SabotageRow{"WrongState", Sabotage::wrong_state, {Invariant::kState}},
        SabotageRow{"BitsOfAnotherMode", Sabotage::bits_of_another_mode, {Invariant::kModeBits}},
        SabotageRow{"CountsBack", Sabotage::counts_back, {Invariant::kProbe}},
        SabotageRow{"RestoresOtherwise", Sabotage::restores_otherwise, {Invariant::kRepeat}},
        SabotageRow{"ResumesByItself",
                    Sabotage::resumes_by_itself,
                    {Invariant::kResume, Invariant::kCommanded}},
        SabotageRow{"TwoOwners", Sabotage::two_owners, {Invariant::kOwner}},
        SabotageRow{"AcceptsStaleEpochs",
                    Sabotage::accepts_stale_epochs,
                    {Invariant::kRevoked, Invariant::kOwner, Invariant::kAnswered,
                     Invariant::kResume, Invariant::kTransition, Invariant::kCommanded}},
        SabotageRow{
            "AcceptsOldIncarnations",
            Sabotage::accepts_old_incarnations,
            {Invariant::kRevoked, Invariant::kOwner, Invariant::kAnswered, Invariant::kTransition}},
        SabotageRow{"ExecutesDoubles",
                    Sabotage::executes_doubles,
                    {Invariant::kOwner, Invariant::kAnswered, Invariant::kTransition}},
        SabotageRow{"ForgetsAnAnswer", Sabotage::forgets_an_answer, {Invariant::kAnswered}},
        SabotageRow{"AnswersTwice", Sabotage::answers_twice, {Invariant::kAnswered}},
        SabotageRow{"WatchdogSleeps",
                    Sabotage::watchdog_sleeps,
                    {Invariant::kWatchdog, Invariant::kOwner, Invariant::kReaction}},
        SabotageRow{"WatchdogBitesEarly",
                    Sabotage::watchdog_bites_early,
                    {Invariant::kWatchdog, Invariant::kOwner}},
        SabotageRow{"NoReactionToALoss", Sabotage::no_reaction_to_a_loss, {Invariant::kReaction}},
        SabotageRow{"StoresHalf", Sabotage::stores_half, {Invariant::kStored}},
        SabotageRow{"HidesStoreFailures", Sabotage::hides_store_failures, {Invariant::kAnswered}},
        SabotageRow{"SyncsNothing", Sabotage::syncs_nothing, {Invariant::kStored}}),
    [](const auto& row) {
      return std::string(row.param.name);
    });

constexpr std::chrono::milliseconds kTick{1};

AxisStatus enabled() {
  AxisStatus status;
  status.ds402_statusword = 0x0237;  // Operation enabled
  status.motor_op_status = 1;
  status.op_mode_actual = 1;
  return status;
}

// The demand starts at rest at 0 and moves 50 UU per tick of 1 ms: it exceeds 1000 in the 21st.
TEST(AxisWatch, DetectsADemandOutsideTheRange) {
  test::AxisWatch watch({.has_range = true, .lower = -1'000, .upper = 1'000}, kTick);
  AxisStatus status = enabled();
  watch.begin(status, PowerState::operation_enabled);
  std::int32_t position = 0;
  for (; !watch.violation() && position < 5'000; position += 50) {
    status.position_demand_value = position;
    status.load_position_actual_value = position;
    status.velocity_demand_value = position == 0 ? 0 : 50'000;
    status.load_velocity_actual_value = status.velocity_demand_value;
    watch.check(status, PowerState::operation_enabled, {});
  }
  ASSERT_TRUE(watch.violation());
  EXPECT_EQ(watch.violation()->invariant, Invariant::kRange);
  EXPECT_EQ(position, 1'100) << "one step after 1050";
}

/// A drive whose axis was driven to 1,000,000 UU/s takes control and brakes by 1000 UU/s per tick
/// of 1 ms: after 800 ticks it is at 200,000 UU/s, still more than a quarter above 136,533 UU/s.
std::optional<test::Violation> brake_with(std::int16_t torque) {
  test::AxisWatch watch({.positive_torque = 1'000, .negative_torque = 1'000}, kTick);
  AxisStatus status = enabled();
  status.load_velocity_actual_value = 1'000'000;
  watch.begin(status, PowerState::operation_enabled);
  for (int tick = 0; tick < 800; ++tick) {
    status.load_velocity_actual_value -= 1'000;
    status.load_position_actual_value += status.load_velocity_actual_value / 1'000;
    status.torque_demand = torque;
    status.torque_actual_value = torque;
    watch.check(status, PowerState::operation_enabled, {});
  }
  return watch.violation();
}

TEST(AxisWatch, AllowsAnAxisThatIsTooFastWhileItBrakesWithFullTorque) {
  const auto violation = brake_with(-1'000);
  EXPECT_FALSE(violation) << violation->invariant;
}

TEST(AxisWatch, DetectsAnAxisThatStaysTooFastWithUnusedTorque) {
  for (const int torque : {-900, 0, 1'000}) {
    const auto violation = brake_with(static_cast<std::int16_t>(torque));
    ASSERT_TRUE(violation) << torque;
    EXPECT_EQ(violation->invariant, Invariant::kSpeed) << torque;
  }
}

/// A demand in profile position that rests for five ticks of 1 ms and then changes its speed by
/// `changes` [UU/s], under a jerk of 4,000,000 UU/s³: from tick to tick the change may differ by 4
/// UU/s, plus 3 for rounding.
/// @param causes of the last change
std::optional<test::Violation> speed_up_by(const std::vector<std::int32_t>& changes,
                                           std::uint8_t inputs = 0,
                                           const test::AxisCauses& causes = {}) {
  test::AxisWatch watch({.positive_torque = 1'000, .negative_torque = 1'000, .jerk = 4.0e6}, kTick);
  AxisStatus status = enabled();
  watch.begin(status, PowerState::operation_enabled);
  std::vector<std::int32_t> all(5, 0);
  all.insert(all.end(), changes.begin(), changes.end());
  for (std::size_t tick = 0; tick < all.size(); ++tick) {
    const std::int32_t change = all[tick];
    status.digital_inputs = inputs;
    status.velocity_demand_value += change;
    status.load_velocity_actual_value = status.velocity_demand_value;
    status.position_demand_value += status.velocity_demand_value / 1'000;
    status.load_position_actual_value = status.position_demand_value;
    const bool is_last = tick + 1 == all.size();
    watch.check(status, PowerState::operation_enabled, is_last ? causes : test::AxisCauses{});
  }
  return watch.violation();
}

TEST(AxisWatch, AllowsADemandOfLimitedJerk) {
  const auto violation = speed_up_by({2, 6, 10, 14, 18, 16, 12, 8, 4, 0, -4, -8, -4, 0});
  EXPECT_FALSE(violation) << violation->invariant;
}

TEST(AxisWatch, DetectsAJerkBeyondTheLimit) {
  const std::vector<std::vector<std::int32_t>> jerky{{8}, {4, 8, 16}, {4, 8, 4, -4}, {-410}};
  for (const std::vector<std::int32_t>& changes : jerky) {
    const auto violation = speed_up_by(changes);
    ASSERT_TRUE(violation) << changes.back();
    EXPECT_EQ(violation->invariant, Invariant::kJerk) << changes.back();
  }
}

// The demand is at 4 + 8 + 12 + 12 = 36 UU/s when it jumps to rest, where transition 4 begins.
TEST(AxisWatch, AllowsAnAxisThatIsEnabledAgainBetweenTwoTicksToBeginAtRest) {
  const std::vector<std::int32_t> changes{4, 8, 12, 12, -36};
  for (const test::AxisCauses& causes : {test::AxisCauses{.commanded = true, .switched_off = true},
                                         test::AxisCauses{.commanded = true, .cycled = true}}) {
    const auto violation = speed_up_by(changes, 0, causes);
    EXPECT_FALSE(violation) << violation->invariant;
  }
}

// 6007h is 1 in this axis: losing the master does not switch it off.
TEST(AxisWatch, DetectsADemandThatJumpsToRestWithoutASwitchedOffPowerStage) {
  const std::vector<std::int32_t> changes{4, 8, 12, 12, -36};
  for (const test::AxisCauses& causes :
       {test::AxisCauses{.commanded = true}, test::AxisCauses{.commanded = true, .lost = true}}) {
    const auto violation = speed_up_by(changes, 0, causes);
    ASSERT_TRUE(violation);
    EXPECT_EQ(violation->invariant, Invariant::kJerk);
  }
}

TEST(AxisWatch, AllowsAnyJerkAtALimitSwitch) {
  const auto violation = speed_up_by({400, 400, -800}, 0x02);
  EXPECT_FALSE(violation) << violation->invariant;
}

/// A modulo axis of 0 to 1000 in Operation enabled whose positions go through `places` at 100 UU
/// per tick of 1 ms.
std::optional<test::Violation> turn_through(const std::vector<std::int32_t>& places) {
  test::AxisWatch watch({.positive_torque = 1'000, .negative_torque = 1'000, .range_span = 1'000},
                        kTick);
  AxisStatus status = enabled();
  status.velocity_demand_value = status.load_velocity_actual_value = 100'000;
  status.position_demand_value = status.load_position_actual_value = places.front();
  watch.begin(status, PowerState::operation_enabled);
  for (const std::int32_t place : places) {
    status.position_demand_value = status.load_position_actual_value = place;
    watch.check(status, PowerState::operation_enabled, {});
  }
  return watch.violation();
}

TEST(AxisWatch, AllowsAModuloAxisToPassTheEndOfItsRange) {
  const auto violation = turn_through({800, 900, 0, 100, 0, 900});
  EXPECT_FALSE(violation) << violation->invariant;
}

TEST(AxisWatch, DetectsAModuloAxisOutsideOfItsRange) {
  for (const std::int32_t outside : {1'000, -1}) {
    const std::int32_t before = outside < 0 ? 99 : 900;
    const auto violation = turn_through({before, outside});
    ASSERT_TRUE(violation) << outside;
    EXPECT_EQ(violation->invariant, Invariant::kModulo) << outside;
  }
}

TEST(AxisWatch, DetectsAModuloAxisThatJumps) {
  // From 900 to 400 it is 500 UU either way round the range. The speed allows 100 UU, the strongest
  // acceleration 14 and blur 6.
  const auto violation = turn_through({900, 400});
  ASSERT_TRUE(violation);
  EXPECT_EQ(violation->invariant, Invariant::kNoJump);
}

// 16 ticks have at most 272 edges.
TEST(ProbeWatch, AllowsCountersThatOverflowOrStartAgain) {
  struct Counts {
    std::uint16_t before;
    std::uint16_t now;
  };

  for (const Counts& counts :
       {Counts{65'500, 65'535}, Counts{65'500, 30}, Counts{40'000, 0}, Counts{40'000, 272}}) {
    ProbeWatch watch(1, {});
    Happenings happenings(nullptr);
    ProbeWatch::Look look;
    look.function = 0x0013;
    look.status = 0x0003;
    look.counters.front() = counts.before;
    watch.check(look, 16, happenings);
    look.counters.front() = counts.now;
    watch.check(look, 16, happenings);
    EXPECT_FALSE(happenings.violation()) << counts.now;
  }
}

TEST(ProbeWatch, DetectsWhatNoProbeCanHaveSeen) {
  test::AxisLimits limits;
  limits.range_span = 4'096;
  ProbeWatch::Look counted;
  counted.counters.back() = 10'000;
  ProbeWatch::Look disabled;
  disabled.status = 0x0001;  // 60B8h is 0
  ProbeWatch::Look enabled;
  enabled.function = 0x0100;  // and 60B9h is 0
  ProbeWatch::Look unsampled;
  unsampled.function = 0x0011;
  unsampled.status = 0x0005;  // a negative edge
  ProbeWatch::Look outside;
  outside.positions.front() = 4'096;
  for (const ProbeWatch::Look& look : {counted, disabled, enabled, unsampled, outside}) {
    ProbeWatch watch(1, limits);
    Happenings happenings(nullptr);
    watch.check({}, 16, happenings);
    watch.check(look, 16, happenings);
    ASSERT_TRUE(happenings.violation()) << look.function << ' ' << look.status;
    EXPECT_EQ(happenings.violation()->invariant, Invariant::kProbe);
  }
}

// A command that the engine would execute although its epoch has ended, seen in the registers
// alone.
TEST(ControlModel, DetectsACommandOfARevokedEpochInTheRegisters) {
  service::Configuration configuration;
  configuration.clock = service::ClockMode::lockstep;
  configuration.axes = service::default_axes(1);
  Happenings happenings(nullptr);
  ControlModel model(configuration, 5, happenings);
  const std::vector<ControlModel::Stamped> stamps{{.incarnation = 5, .session = 9, .epoch = 1}};
  ControlModel::Revocations revocations;
  model.use(stamps, revocations);
  msg::Request acquire;
  acquire.client = 1;
  acquire.request_id = 1;
  acquire.session = 9;
  acquire.kind = msg::RequestKind::acquire;
  acquire.axes.push_back(1);
  model.arrive(acquire);
  acquire.request_id = 2;
  acquire.session = 10;
  acquire.kind = msg::RequestKind::take_over;
  model.arrive(acquire);
  msg::AxisParameters parameters;
  parameters.axis = 1;
  parameters.position_target_reached_window = kFirstStamp;
  parameters.profile_velocity = 68'267;
  model.check(parameters);
  ASSERT_TRUE(happenings.violation());
  EXPECT_EQ(happenings.violation()->invariant, Invariant::kRevoked);
}

TEST(ControlModel, DetectsACommandForAnOldIncarnationInTheRegisters) {
  service::Configuration configuration;
  configuration.clock = service::ClockMode::lockstep;
  configuration.axes = service::default_axes(1);
  Happenings happenings(nullptr);
  ControlModel model(configuration, 5, happenings);
  const std::vector<ControlModel::Stamped> stamps{{.incarnation = 4, .session = 9, .epoch = 1}};
  ControlModel::Revocations revocations;
  model.use(stamps, revocations);
  msg::AxisParameters parameters;
  parameters.axis = 1;
  parameters.position_target_reached_window = kFirstStamp;
  model.check(parameters);
  ASSERT_TRUE(happenings.violation());
  EXPECT_EQ(happenings.violation()->invariant, Invariant::kRevoked);
}

}  // namespace
}  // namespace vdrive::simulation
