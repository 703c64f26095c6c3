// SPDX-License-Identifier: Apache-2.0
// Homing mode (6060h = 6): the home position, its status bits, its interruptions.
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

namespace vdrive {
namespace {

using std::chrono::microseconds;
using test::AxisUnderTest;

constexpr double kNowhere = 1.0e12;
constexpr std::uint64_t kDeadline = 20'000;
constexpr std::int32_t kLowest = std::numeric_limits<std::int32_t>::min();
constexpr std::int32_t kHighest = std::numeric_limits<std::int32_t>::max();

// Statusword bits 13, 12 and 10 (CiA 402-2, homing mode).
constexpr std::uint16_t kPhase = 0x3400;
constexpr std::uint16_t kRunning = 0x0000;       // 000
constexpr std::uint16_t kIdle = 0x0400;          // 001 not started or interrupted
constexpr std::uint16_t kAttained = 0x1000;      // 010 attained, target not reached
constexpr std::uint16_t kDone = 0x1400;          // 011
constexpr std::uint16_t kErrorMoving = 0x2000;   // 100
constexpr std::uint16_t kErrorStopped = 0x2400;  // 101

constexpr std::array<int, 8> kMethods{1, 2, 17, 18, 33, 34, 35, 37};

bool uses_limit(int method) {
  return method == 1 || method == 2 || method == 17 || method == 18;
}

bool uses_index(int method) {
  return method == 1 || method == 2 || method == 33 || method == 34;
}

/// An axis on its test bench: limit switches at fixed mechanical positions, and the true position
/// of the load, whatever the frame of 6064h.
class Bench {
 public:
  explicit Bench(const AxisConfiguration& configuration = {},
                 microseconds period = AxisUnderTest::kDefaultPeriod)
      : axis(configuration, period), place(configuration.initial_position) {}

  /// One tick, after which the switches are set according to the position of the axis.
  void tick() {
    const bool attained = (axis.statusword() & kAttained) != 0 && axis.status().op_mode_actual == 6;
    const std::int32_t before = axis.actual();
    axis.step();
    const bool attains = (axis.statusword() & kAttained) != 0 && axis.status().op_mode_actual == 6;
    if (attains && !attained) {
      place += axis.velocity() * axis.seconds_per_tick();  // 6064h has jumped to the new frame
    } else {
      place += static_cast<std::int32_t>(static_cast<std::uint32_t>(axis.actual()) -
                                         static_cast<std::uint32_t>(before));
    }
    set("test_negative_limit_input", place <= negative_switch, negative_);
    set("test_positive_limit_input", place >= positive_switch, positive_);
  }

  void ticks(std::uint64_t count) {
    for (std::uint64_t i = 0; i < count; ++i) tick();
  }

  template <std::predicate Predicate>
  bool tick_until(Predicate done, std::uint64_t deadline = kDeadline) {
    for (std::uint64_t i = 0; i < deadline; ++i) {
      tick();
      if (done()) return true;
    }
    return false;
  }

  [[nodiscard]] std::uint16_t phase() const { return axis.statusword() & kPhase; }

  bool tick_until_phase(std::uint16_t wanted, std::uint64_t deadline = kDeadline) {
    return tick_until(
        [this, wanted] {
          return phase() == wanted;
        },
        deadline);
  }

  void switches_at(double negative, double positive) {
    negative_switch = negative;
    positive_switch = positive;
    set("test_negative_limit_input", place <= negative_switch, negative_);
    set("test_positive_limit_input", place >= positive_switch, positive_);
  }

  /// Long enough to settle.
  void settle() { ticks(static_cast<std::uint64_t>(0.2 / axis.seconds_per_tick())); }

  /// Moves in profile position to `target`, a position in the first frame.
  void move_to(double target) {
    axis.write("op_mode_cmd", 1);
    axis.command(0x000F);
    tick();
    axis.write("profile_velocity", 100'000);
    axis.write("position_user_target_value", std::lround(target - place));
    axis.write("positioning_option_code", 1);
    axis.controlword(0x007F);
    ASSERT_TRUE(tick_until([this] {
      return axis.reached();
    }));
    axis.controlword(0x000F);
    settle();
  }

  /// Mode 6, Operation enabled, at rest.
  void enter(int method, std::int32_t offset = 0) {
    axis.write("homing_method", method);
    axis.write("home_offset", offset);
    axis.write("op_mode_cmd", 6);
    axis.controlword(0x000F);
    ticks(2);
    ASSERT_EQ(axis.read("op_mode_actual"), 6);
    ASSERT_EQ(phase(), kIdle);
  }

  void start() {
    axis.controlword(0x001F);
    tick();
  }

  /// A complete run to 011, with time to settle.
  void home(int method, std::int32_t offset = 0) {
    ASSERT_NO_FATAL_FAILURE(enter(method, offset));
    start();
    ASSERT_EQ(phase(), kRunning);
    ASSERT_TRUE(tick_until_phase(kDone))
        << "method " << method << ", status " << std::hex << axis.statusword();
    axis.controlword(0x000F);
    settle();
    ASSERT_EQ(phase(), kDone);
  }

  AxisUnderTest axis;
  double place;  ///< of the load in the frame of the first power-up [UU]
  double negative_switch = -kNowhere;
  double positive_switch = kNowhere;

 private:
  void set(const char* name, bool active, bool& known) {
    if (active != known) {
      axis.write(name, active ? 1 : 0);
      known = active;
    }
  }

  bool negative_ = false;
  bool positive_ = false;
};

/// Distance to the nearest index mark; there is one per motor revolution, counted from position 0.
double from_mark(double place, double marks = 4096.0) {
  return place - marks * std::round(place / marks);
}

// ---- result ------------------------------------------------------------------------------------

class HomingMethod : public testing::TestWithParam<int> {};

TEST_P(HomingMethod, EndsWithDemandAndActualPositionAtTheHomeOffset) {
  for (const std::int32_t offset : {0, 1, -12'345, kHighest, kLowest}) {
    SCOPED_TRACE(offset);
    Bench bench;
    bench.switches_at(-20'000.0, 20'000.0);
    ASSERT_NO_FATAL_FAILURE(bench.home(GetParam(), offset));
    EXPECT_EQ(bench.axis.demand(), offset);
    EXPECT_EQ(bench.axis.actual(), offset);
    EXPECT_EQ(bench.axis.demand_velocity(), 0);
    EXPECT_EQ(bench.axis.state(), PowerState::operation_enabled);
  }
}

TEST_P(HomingMethod, FindsTheSamePlaceFromEveryStart) {
  const int method = GetParam();
  for (const double start : {-20'800.0, -19'000.0, -5'000.5, 100.0, 7'777.0, 18'500.0, 20'600.0}) {
    SCOPED_TRACE(start);
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.move_to(start));
    const double from = bench.place;
    bench.switches_at(-20'000.0, 20'000.0);
    const bool blocked_way =
        (method == 33 && from < -16'384.0) || (method == 34 && from > 16'384.0);
    if (blocked_way) {
      continue;  // the next mark lies beyond the switch
    }
    ASSERT_NO_FATAL_FAILURE(bench.home(method));
    // A tick at creep speed is 3.413 units; reading and rounding add one.
    switch (method) {
      case 1:  // first mark above -20000: -16384 = -4·4096
        EXPECT_NEAR(bench.place, -16'384.0, 1.5);
        break;
      case 2:
        EXPECT_NEAR(bench.place, 16'384.0, 1.5);
        break;
      case 17:
        EXPECT_NEAR(bench.place, -20'000.0 + 1.7, 1.7 + 2.0);
        break;
      case 18:
        EXPECT_NEAR(bench.place, 20'000.0 - 1.7, 1.7 + 2.0);
        break;
      case 33:
        EXPECT_NEAR(bench.place, 4096.0 * std::floor(from / 4096.0), 1.5);
        break;
      case 34:
        EXPECT_NEAR(bench.place, 4096.0 * std::ceil(from / 4096.0), 1.5);
        break;
      default:
        EXPECT_NEAR(bench.place, from, 1.5) << "the present position";
    }
  }
}

TEST_P(HomingMethod, SetsTheOriginForALaterMoveToZero) {
  const bool positive = GetParam() == 2 || GetParam() == 18;
  const std::int32_t offset = positive ? 3'000 : -3'000;  // zero lies away from the switch
  Bench bench;
  bench.switches_at(-20'000.0, 20'000.0);
  ASSERT_NO_FATAL_FAILURE(bench.home(GetParam(), offset));
  const double home = bench.place;
  bench.axis.write("op_mode_cmd", 1);
  bench.tick();
  bench.axis.write("position_user_target_value", 0);
  bench.axis.controlword(0x001F);
  ASSERT_TRUE(bench.tick_until([&bench] {
    return bench.axis.reached();
  }));
  bench.ticks(300);
  EXPECT_EQ(bench.axis.actual(), 0);
  EXPECT_NEAR(bench.place, home - offset, 1.0) << "zero lies 607Ch away from home";
}

TEST_P(HomingMethod, FindsTheSamePlaceWhenRepeated) {
  const int method = GetParam();
  Bench bench;
  bench.switches_at(-20'000.0, 20'000.0);
  ASSERT_NO_FATAL_FAILURE(bench.home(method, 1'000));
  const double home = bench.place;
  // These methods find the same mark again from below home, the others from above.
  const bool forward = method == 34 || method == 18;
  for (int round = 0; round < 4; ++round) {
    ASSERT_NO_FATAL_FAILURE(bench.move_to(home + (forward ? -500.0 : 500.0)));
    const double from = bench.place;
    ASSERT_NO_FATAL_FAILURE(bench.home(method, 1'000));
    const bool present = method == 35 || method == 37;
    EXPECT_NEAR(bench.place, present ? from : home, uses_index(method) ? 1.5 : 5.5) << round;
    EXPECT_EQ(bench.axis.actual(), 1'000);
  }
}

TEST_P(HomingMethod, NeverExceedsItsSpeedsAndAccelerations) {
  const int method = GetParam();
  Bench bench;
  bench.switches_at(-20'000.0, 20'000.0);
  bench.axis.write("homing_speed_search", 20'000);
  bench.axis.write("homing_speed_creep", 2'000);
  bench.axis.write("homing_acceleration", 300'000);
  bench.axis.write("app_acc_limit", 100'000);  // 60C5h and 60C6h are valid in homing
  bench.axis.write("app_dec_limit", 50'000);
  ASSERT_NO_FATAL_FAILURE(bench.enter(method));
  const int first = method == 1 || method == 17 ? -1 : 1;
  std::int32_t last = 0;
  std::int32_t fastest = 0;
  std::int32_t steepest = 0;
  bench.axis.controlword(0x001F);
  const bool done = bench.tick_until([&] {
    const std::int32_t now = bench.axis.demand_velocity();
    const std::int32_t most = uses_limit(method) && now * first > 0 ? 20'000 : 2'000;
    EXPECT_LE(std::abs(now), most);
    const bool faster = std::abs(now) > std::abs(last);
    const std::int32_t change = std::abs(now - last);
    EXPECT_LE(change, (faster ? 100 : 50) + 1) << last << " to " << now;
    steepest = std::max(steepest, change);
    fastest = std::max(fastest, std::abs(now));
    last = now;
    return testing::Test::HasFailure() || bench.phase() == kDone;
  });
  ASSERT_TRUE(done);
  if (uses_limit(method)) {
    EXPECT_EQ(fastest, 20'000) << "6099h:01";
    EXPECT_NEAR(steepest, 100, 1);
  } else if (uses_index(method)) {
    EXPECT_EQ(fastest, 2'000) << "6099h:02";
  } else {
    EXPECT_EQ(fastest, 0);
  }
}

TEST_P(HomingMethod, IsCappedInSpeedBy607Fh) {
  Bench bench;
  bench.switches_at(-6'000.0, 6'000.0);
  bench.axis.write("app_speed_limit", 3'000);
  ASSERT_NO_FATAL_FAILURE(bench.enter(GetParam()));
  bench.axis.controlword(0x001F);
  ASSERT_TRUE(bench.tick_until([&bench] {
    EXPECT_LE(std::abs(bench.axis.demand_velocity()), 3'000);
    return bench.phase() == kDone || testing::Test::HasFailure();
  }));
}

TEST_P(HomingMethod, ShowsEachPhaseInBits13To10) {
  const int method = GetParam();
  Bench bench;
  bench.switches_at(-10'000.0, 10'000.0);
  ASSERT_NO_FATAL_FAILURE(bench.enter(method, 77));
  EXPECT_EQ(bench.axis.statusword(), 0x0637) << "idle: bit 10 = 1";
  bench.axis.controlword(0x001F);
  bench.tick();
  EXPECT_EQ(bench.axis.statusword(), 0x0237) << "first status after the edge";
  std::uint64_t ticks = 1;
  ASSERT_TRUE(bench.tick_until([&] {
    ++ticks;
    return bench.phase() != kRunning;
  }));
  EXPECT_EQ(bench.phase(), kAttained);
  const std::uint64_t attained = ticks;
  ASSERT_TRUE(bench.tick_until([&] {
    ++ticks;
    return bench.phase() != kAttained;
  }));
  EXPECT_EQ(bench.phase(), kDone);
  EXPECT_GE(ticks - attained, 20U) << "the window time 6068h passes at home";
  for (int i = 0; i < 500; ++i) {
    bench.tick();
    ASSERT_EQ(bench.phase(), kDone);
  }
  bench.axis.controlword(0x000F);
  bench.tick();
  EXPECT_EQ(bench.axis.statusword() & ~0x0800, 0x1637) << "bit 4 may drop";

  bench.axis.controlword(0x001F);  // a new run: bits 10 and 12 are cleared in its first status
  bench.tick();
  EXPECT_EQ(bench.phase(), kRunning);
}

TEST_P(HomingMethod, IgnoresAndCountsASecondEdgeAndContinuesWhenBit4Drops) {
  Bench bench;
  Bench twin;
  for (Bench* const b : {&bench, &twin}) {
    b->switches_at(-10'000.0, 10'000.0);
    ASSERT_NO_FATAL_FAILURE(b->enter(GetParam()));
    b->start();
  }
  bench.axis.controlword(0x000F);
  bench.axis.controlword(0x001F);
  for (int i = 0; i < 4'000; ++i) {
    bench.tick();
    twin.tick();
    ASSERT_EQ(bench.axis.statusword(), twin.axis.statusword()) << i;
    ASSERT_EQ(bench.axis.actual(), twin.axis.actual()) << i;
  }
  EXPECT_EQ(bench.phase(), kDone);
  EXPECT_EQ(bench.axis.status().ignored_set_points, 1U);
  EXPECT_EQ(twin.axis.status().ignored_set_points, 0U);
}

INSTANTIATE_TEST_SUITE_P(Homing, HomingMethod, testing::ValuesIn(kMethods),
                         testing::PrintToStringParamName());

// ---- axes --------------------------------------------------------------------------------------

struct Machine {
  const char* name;
  Feedback feedback;
  Coupling coupling;
  bool geared;  // 3576h:3577h = 3:2
  std::int64_t period_us;
};

std::string machine_name(const testing::TestParamInfo<Machine>& machine) {
  return machine.param.name;
}

class HomingOn : public testing::TestWithParam<Machine> {};

TEST_P(HomingOn, EveryMethodFindsItsPlace) {
  const Machine& machine = GetParam();
  AxisConfiguration configuration;
  configuration.model.feedback = machine.feedback;
  configuration.model.coupling = machine.coupling;
  if (machine.geared) {
    configuration.parameters = {{AxisUnderTest::address_of("gear_ratio_numerator"), 3},
                                {AxisUnderTest::address_of("gear_ratio_denominator"), 2}};
  }
  // One motor revolution, in units of the encoder that 6064h shows.
  const bool at_load = machine.geared && machine.feedback == Feedback::dual_encoder;
  const double marks = at_load ? 6144.0 : 4096.0;
  for (const int method : kMethods) {
    SCOPED_TRACE(method);
    Bench bench(configuration, microseconds{machine.period_us});
    const double tick = 3'413.0 * bench.axis.seconds_per_tick();
    ASSERT_NO_FATAL_FAILURE(bench.move_to(1'000.0));
    bench.switches_at(-10'000.0, 10'000.0);
    ASSERT_NO_FATAL_FAILURE(bench.home(method, -500));
    EXPECT_EQ(bench.axis.demand(), -500);
    EXPECT_NEAR(bench.axis.actual(), -500, 1);
    const double from = 1'000.0;
    const std::vector<double> expected = {-marks * std::floor(10'000.0 / marks),
                                          marks * std::floor(10'000.0 / marks),
                                          -10'000.0,
                                          10'000.0,
                                          0.0,
                                          marks,
                                          from,
                                          from};
    const auto i = static_cast<std::size_t>(std::find(kMethods.begin(), kMethods.end(), method) -
                                            kMethods.begin());
    EXPECT_NEAR(bench.place, expected[i], uses_limit(method) && !uses_index(method) ? tick + 2 : 2);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Machines, HomingOn,
    testing::Values(
        Machine{"SingleEncoder", Feedback::single_encoder, Coupling::rigid, false, 1'000},
        Machine{"DualEncoder", Feedback::dual_encoder, Coupling::rigid, false, 1'000},
        Machine{"SingleEncoderGear", Feedback::single_encoder, Coupling::rigid, true, 1'000},
        Machine{"DualEncoderGear", Feedback::dual_encoder, Coupling::rigid, true, 1'000},
        Machine{"DualEncoderGearLongestPeriod", Feedback::dual_encoder, Coupling::rigid, true,
                10'000},
        Machine{"TwoInertia", Feedback::dual_encoder, Coupling::two_inertia, false, 1'000},
        Machine{"TwoInertiaGear", Feedback::dual_encoder, Coupling::two_inertia, true, 1'000},
        Machine{"ShortestPeriod", Feedback::dual_encoder, Coupling::rigid, false, 125},
        Machine{"LongestPeriod", Feedback::dual_encoder, Coupling::rigid, false, 10'000}),
    machine_name);

// ---- index -------------------------------------------------------------------------------------

TEST(HomingIndex, IgnoresTheMarkOnWhichTheMotorStands) {
  for (const int method : {33, 34}) {
    Bench bench;
    ASSERT_NO_FATAL_FAILURE(bench.home(method));
    EXPECT_NEAR(bench.place, method == 33 ? -4'096.0 : 4'096.0, 1.5);
  }
}

TEST(HomingIndex, AcceptsARisingInputAsAnIndexPulse) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(bench.enter(34));
  bench.start();
  ASSERT_TRUE(bench.tick_until([&bench] {
    return bench.place >= 1'500.0;
  }));
  const double pulse = bench.place;
  bench.axis.write("test_index_pulse_input", 1);
  ASSERT_TRUE(bench.tick_until_phase(kDone));
  EXPECT_NEAR(bench.place, pulse, 1.5);
}

TEST(HomingIndex, IgnoresAnInputThatIsHighFromTheStart) {
  Bench bench;
  bench.axis.write("test_index_pulse_input", 1);
  ASSERT_NO_FATAL_FAILURE(bench.home(34));
  EXPECT_NEAR(bench.place, 4'096.0, 1.5);
}

TEST(HomingIndex, IgnoresAPulseBeforeTheAxisLeavesTheLimitSwitch) {
  Bench bench;
  bench.switches_at(-10'000.0, kNowhere);
  ASSERT_NO_FATAL_FAILURE(bench.enter(1));
  bench.start();
  bench.ticks(50);
  bench.axis.write("test_index_pulse_input", 1);
  bench.ticks(5);
  bench.axis.write("test_index_pulse_input", 0);
  ASSERT_TRUE(bench.tick_until_phase(kDone));
  EXPECT_NEAR(bench.place, -8'192.0, 1.5) << "first mark above -10000";
}

TEST(HomingIndex, KeepsTheMarksWherePositionsWrap) {
  // 2^31 is a multiple of 4096: the marks stay at multiples of 4096 where the register wraps.
  AxisConfiguration configuration;
  configuration.initial_position = 2'147'480'000;
  Bench bench(configuration);
  ASSERT_NO_FATAL_FAILURE(bench.move_to(2'147'493'000.0));
  EXPECT_LT(bench.axis.actual(), 0) << "past the end of the register";
  ASSERT_NO_FATAL_FAILURE(bench.home(33, 5));
  EXPECT_NEAR(from_mark(bench.place), 0.0, 1.5);
  EXPECT_NEAR(bench.place, 2'147'483'648.0 + 8'192.0, 1.5);
  ASSERT_NO_FATAL_FAILURE(bench.move_to(bench.place + 300.0));
  ASSERT_NO_FATAL_FAILURE(bench.home(33, kLowest));
  EXPECT_NEAR(bench.place, 2'147'483'648.0 + 8'192.0, 2.0);
  EXPECT_EQ(bench.axis.actual(), kLowest);
}

TEST(HomingIndex, ARunAcrossTheEndOfTheRegisterFindsTheMark) {
  AxisConfiguration configuration;
  configuration.initial_position = 2'147'483'000;
  Bench bench(configuration);
  ASSERT_NO_FATAL_FAILURE(bench.home(34));
  EXPECT_NEAR(bench.place, 2'147'483'648.0, 1.5);
  EXPECT_EQ(bench.axis.actual(), 0);
}

TEST(HomingIndex, RepeatedRunsDoNotDrift) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(bench.home(34, 100));
  for (int i = 0; i < 5; ++i) {
    ASSERT_NO_FATAL_FAILURE(bench.move_to(bench.place - 50.0));
    ASSERT_NO_FATAL_FAILURE(bench.enter(34, 100));
    bench.start();
    std::int32_t before = bench.axis.actual();
    ASSERT_TRUE(bench.tick_until([&] {
      const bool attained = bench.phase() == kAttained;
      if (attained) {
        // Same mark, same offset: the frame must not move. 3.413 units per tick.
        EXPECT_NEAR(bench.axis.actual() - before, 3.4, 1.5);
      }
      before = bench.axis.actual();
      return attained;
    }));
    ASSERT_TRUE(bench.tick_until_phase(kDone));
    bench.axis.controlword(0x000F);
    bench.ticks(200);
  }
}

// ---- interruptions -----------------------------------------------------------------------------

/// Stages of method 1: search -, leave +, index +, and the way back.
enum class Stage { search, leave, index, back };

void run_to(Bench& bench, Stage stage) {
  bench.switches_at(-10'000.0, kNowhere);
  ASSERT_NO_FATAL_FAILURE(bench.enter(1));
  bench.start();
  switch (stage) {
    case Stage::search:
      bench.ticks(150);
      ASSERT_LT(bench.axis.demand_velocity(), -30'000);
      break;
    case Stage::leave:
      ASSERT_TRUE(bench.tick_until([&bench] {
        return bench.axis.limit_active() && bench.axis.demand_velocity() > 3'000;
      }));
      break;
    case Stage::index:
      ASSERT_TRUE(bench.tick_until([&bench] {
        return bench.place > -9'500.0 && bench.axis.demand_velocity() > 3'000;
      }));
      break;
    case Stage::back:
      ASSERT_TRUE(bench.tick_until_phase(kAttained));
      ASSERT_NE(bench.axis.demand_velocity(), 0);
      break;
  }
}

std::string stage_name(const testing::TestParamInfo<int>& stage) {
  constexpr std::array<const char*, 4> kNames{"Search", "Leave", "Index", "Back"};
  return kNames.at(static_cast<std::size_t>(stage.param));
}

class HomingInterrupted : public testing::TestWithParam<int> {
 protected:
  [[nodiscard]] static Stage stage() { return static_cast<Stage>(GetParam()); }
};

TEST_P(HomingInterrupted, ByHaltContinuesWhenHaltEndsWhileBit4Is1) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(run_to(bench, stage()));
  bench.axis.controlword(0x011F);
  ASSERT_TRUE(bench.tick_until_phase(kIdle));
  bench.ticks(500);
  EXPECT_EQ(bench.phase(), kIdle) << "interrupted, CiA 402-2";
  EXPECT_EQ(bench.axis.demand_velocity(), 0);
  bench.axis.controlword(0x001F);
  bench.tick();
  EXPECT_EQ(bench.phase(), stage() == Stage::back ? kAttained : kRunning);
  EXPECT_TRUE(bench.tick_until_phase(kDone));
  bench.ticks(100);  // the axis may be within the window of home before it arrives
  EXPECT_NEAR(bench.place, -8'192.0, 2.0);
  EXPECT_EQ(bench.axis.status().ignored_set_points, 0U);
}

TEST_P(HomingInterrupted, ByHaltEndsWhenBit4Falls) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(run_to(bench, stage()));
  bench.axis.controlword(0x011F);
  bench.tick();
  if (bench.axis.demand_velocity() != 0) {
    EXPECT_EQ(bench.phase(), kRunning) << "braking";
  }
  ASSERT_TRUE(bench.tick_until_phase(kIdle));
  const std::int32_t rest = bench.axis.demand();
  bench.axis.controlword(0x000F);
  bench.ticks(500);
  EXPECT_EQ(bench.axis.demand(), rest);
  bench.start();
  EXPECT_EQ(bench.phase(), kRunning);
  EXPECT_TRUE(bench.tick_until_phase(kDone)) << "a new edge starts anew";
  EXPECT_NEAR(bench.place, -8'192.0, 2.0);
}

TEST_P(HomingInterrupted, ByDisableOperationBrakesWithItsRamp) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(run_to(bench, stage()));
  bench.axis.write("homing_acceleration", 20'000);  // from creep speed the ramp takes 170 ticks
  bench.axis.controlword(0x0007);
  bool attained = bench.phase() == kAttained;
  ASSERT_TRUE(bench.tick_until([&] {
    attained = attained || (bench.phase() & kAttained) != 0;
    return bench.axis.state() == PowerState::switched_on;
  }));
  EXPECT_EQ(attained, stage() == Stage::back) << "no run continues during the ramp";
  bench.axis.controlword(0x000F);
  bench.ticks(500);
  EXPECT_EQ(bench.phase(), kIdle);
  EXPECT_EQ(bench.axis.demand_velocity(), 0);
}

TEST_P(HomingInterrupted, ByQuickStopDoesNotResume) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(run_to(bench, stage()));
  bench.axis.write("quick_stop_option_code", 6);
  bench.axis.controlword(0x0002);
  bench.ticks(300);
  EXPECT_EQ(bench.axis.statusword() & ~0x0800, 0x0617);
  bench.axis.controlword(0x000F);
  bench.ticks(300);
  EXPECT_EQ(bench.phase(), kIdle) << "nothing resumes after transition 16";
  EXPECT_EQ(bench.axis.demand_velocity(), 0);
}

TEST_P(HomingInterrupted, ByAFaultDoesNotResume) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(run_to(bench, stage()));
  bench.axis.write("test_over_current", 1);
  bench.ticks(300);
  EXPECT_EQ(bench.axis.statusword() & ~0x0800, 0x0218);
  bench.axis.write("test_over_current", 0);
  bench.axis.controlword(0x0080);
  bench.tick();
  bench.axis.controlword(0x000F);
  bench.ticks(300);
  EXPECT_EQ(bench.phase(), kIdle);
  EXPECT_EQ(bench.axis.demand_velocity(), 0);
}

TEST_P(HomingInterrupted, ByAModeChangeBrakesBeforeTheModeChanges) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(run_to(bench, stage()));
  bench.axis.write("op_mode_cmd", 1);
  bench.tick();
  if (bench.axis.demand_velocity() != 0) {
    EXPECT_EQ(bench.axis.read("op_mode_actual"), 6);
  }
  ASSERT_TRUE(bench.tick_until([&bench] {
    return bench.axis.read("op_mode_actual") == 1;
  }));
  EXPECT_EQ(bench.axis.demand_velocity(), 0);
  bench.axis.write("op_mode_cmd", 6);
  bench.ticks(500);
  EXPECT_EQ(bench.phase(), kIdle);
  EXPECT_EQ(bench.axis.demand_velocity(), 0);
}

INSTANTIATE_TEST_SUITE_P(Stages, HomingInterrupted, testing::Values(0, 1, 2, 3), stage_name);

TEST(HomingHalt, AfterTheEndKeepsTheResult) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(bench.home(37, 123));
  bench.axis.controlword(0x010F);
  bench.ticks(100);
  EXPECT_EQ(bench.phase(), kDone);
  bench.axis.controlword(0x000F);
  bench.ticks(100);
  EXPECT_EQ(bench.phase(), kDone);
  EXPECT_EQ(bench.axis.actual(), 123);
}

TEST(HomingHalt, AfterAnErrorKeepsTheError) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(bench.enter(0));
  bench.start();
  bench.axis.controlword(0x010F);
  bench.ticks(3);
  EXPECT_EQ(bench.phase(), kErrorStopped);
}

TEST(HomingHalt, IgnoresAndCountsAnEdgeAndAnEdgeThatEndsHaltStarts) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(bench.enter(34));
  bench.axis.controlword(0x010F);
  bench.tick();
  EXPECT_EQ(bench.axis.statusword(), 0x0637) << "bit 10 = 1 also with halt set";
  bench.axis.controlword(0x011F);
  bench.ticks(100);
  EXPECT_EQ(bench.phase(), kIdle);
  EXPECT_EQ(bench.axis.demand_velocity(), 0);
  EXPECT_EQ(bench.axis.status().ignored_set_points, 1U);
  bench.axis.controlword(0x010F);
  bench.tick();
  bench.axis.controlword(0x001F);
  bench.tick();
  EXPECT_EQ(bench.phase(), kRunning);
  EXPECT_EQ(bench.axis.status().ignored_set_points, 1U);
  EXPECT_TRUE(bench.tick_until_phase(kDone));
}

TEST(HomingStart, AnIdleAxisUnderLoadDoesNotShowARun) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(bench.enter(33));
  bench.axis.write("test_load_torque", 2'000);
  std::int32_t fastest = 0;
  for (int i = 0; i < 200; ++i) {
    bench.tick();
    fastest = std::max(fastest, std::abs(bench.axis.velocity()));
    ASSERT_EQ(bench.phase(), kIdle);
  }
  EXPECT_GT(fastest, 100);
}

TEST(HomingStart, OnTheSwitchTheAxisLeavesItAtOnce) {
  for (const int method : {1, 2, 17, 18}) {
    const int away = method == 1 || method == 17 ? 1 : -1;
    Bench bench;
    bench.switches_at(away > 0 ? 100.0 : -kNowhere, away > 0 ? kNowhere : -100.0);
    ASSERT_NO_FATAL_FAILURE(bench.enter(method));
    bench.axis.controlword(0x001F);
    ASSERT_TRUE(bench.tick_until([&bench, away] {
      EXPECT_GE(away * bench.axis.demand_velocity(), 0);
      return bench.phase() != kRunning || testing::Test::HasFailure();
    }));
    EXPECT_EQ(bench.phase(), kAttained);
  }
}

TEST(HomingStart, ASwitchThatOpensWhileTheAxisStillRunsIntoItIsNotLeftYet) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(bench.enter(17));
  bench.start();
  bench.ticks(200);
  bench.axis.write("test_negative_limit_input", 1);
  bench.ticks(2);
  bench.axis.write("test_negative_limit_input", 0);
  ASSERT_TRUE(bench.tick_until([&bench] {
    return bench.phase() != kRunning;
  }));
  EXPECT_GT(bench.axis.demand_velocity(), -300) << "not before it has turned round";
}

TEST(HomingStart, AnEdgeTogetherWithEnablingOrOutsideOperationEnabledIsNotAccepted) {
  Bench bench;
  bench.axis.write("op_mode_cmd", 6);
  bench.axis.controlword(0x001F);
  bench.ticks(100);
  EXPECT_EQ(bench.phase(), kIdle);
  EXPECT_EQ(bench.axis.status().ignored_set_points, 1U);
  bench.axis.controlword(0x0006);
  bench.tick();
  bench.axis.controlword(0x0016);
  bench.ticks(5);
  EXPECT_EQ(bench.axis.status().ignored_set_points, 2U);
}

TEST(HomingStart, Method37DuringBrakingTakesThePositionOfStandstill) {
  Bench bench;
  bench.axis.write("homing_acceleration", 50'000);
  ASSERT_NO_FATAL_FAILURE(bench.enter(17));
  bench.start();
  bench.ticks(500);
  bench.axis.write("homing_method", 37);
  bench.axis.controlword(0x010F);
  bench.tick();
  bench.axis.controlword(0x001F);
  bench.tick();
  EXPECT_EQ(bench.phase(), kRunning);
  std::int32_t last = bench.axis.demand_velocity();
  ASSERT_TRUE(bench.tick_until([&] {
    EXPECT_GE(bench.axis.demand_velocity(), last) << "it only brakes";
    EXPECT_LE(bench.axis.demand_velocity(), 0);
    last = bench.axis.demand_velocity();
    return bench.phase() == kDone;
  }));
  EXPECT_EQ(bench.axis.demand(), 0);
}

// ---- errors ------------------------------------------------------------------------------------

TEST(HomingError, OccursAtOnceWithoutAMethod) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(bench.enter(0));
  bench.start();
  EXPECT_EQ(bench.phase(), kErrorStopped);
  bench.axis.write("homing_method", 37);
  bench.axis.controlword(0x000F);
  bench.tick();
  EXPECT_EQ(bench.phase(), kErrorStopped) << "until the next start";
  bench.start();
  EXPECT_EQ(bench.phase(), kRunning);
  EXPECT_TRUE(bench.tick_until_phase(kDone));
}

TEST(HomingError, OccursWithASpeedOfZeroWhereTheMethodTravels) {
  for (const int method : kMethods) {
    for (const char* const speed : {"homing_speed_search", "homing_speed_creep"}) {
      SCOPED_TRACE(std::to_string(method) + " " + speed);
      Bench bench;
      bench.switches_at(-10'000.0, 10'000.0);
      bench.axis.write(speed, 0);
      ASSERT_NO_FATAL_FAILURE(bench.enter(method));
      bench.start();
      const bool travels = method < 35;
      EXPECT_EQ(bench.phase(), travels ? kErrorStopped : kRunning);
      bench.ticks(200);
      EXPECT_EQ(bench.phase(), travels ? kErrorStopped : kDone);
    }
  }
}

TEST(HomingError, Method37NeedsNoSpeed) {
  // A stop in profile velocity ends between two units.
  Bench bench;
  bench.axis.write("homing_speed_creep", 0);
  bench.axis.write("op_mode_cmd", 3);
  bench.axis.write("target_velocity", 7'777);
  bench.axis.controlword(0x000F);
  bench.ticks(333);
  bench.axis.write("op_mode_cmd", 6);
  bench.ticks(300);
  ASSERT_NO_FATAL_FAILURE(bench.home(37, kHighest));
  EXPECT_EQ(bench.axis.actual(), kHighest);
}

TEST(HomingError, OccursAtTheOtherLimitSwitch) {
  for (const int method : {1, 17, 2, 18}) {
    SCOPED_TRACE(method);
    const bool negative = method == 1 || method == 17;
    Bench bench;
    bench.switches_at(negative ? -10'000.0 : -kNowhere, negative ? kNowhere : 10'000.0);
    ASSERT_NO_FATAL_FAILURE(bench.enter(method));
    bench.start();
    ASSERT_TRUE(bench.tick_until([&bench, negative] {
      return bench.axis.limit_active() &&
             (negative ? 1 : -1) * bench.axis.demand_velocity() > 3'000;
    }));
    bench.axis.write(negative ? "test_positive_limit_input" : "test_negative_limit_input", 1);
    bench.tick();
    EXPECT_EQ(bench.phase(), kErrorMoving);
    ASSERT_TRUE(bench.tick_until_phase(kErrorStopped));
    bench.ticks(300);
    EXPECT_EQ(bench.phase(), kErrorStopped);
    EXPECT_EQ(bench.axis.demand_velocity(), 0);
    EXPECT_EQ(bench.axis.state(), PowerState::operation_enabled) << "no fault";
    EXPECT_EQ(bench.axis.read("error_code"), 0);
  }
}

TEST(HomingError, OccursAtALimitSwitchBeforeTheIndex) {
  for (const int method : {33, 34}) {
    SCOPED_TRACE(method);
    Bench bench;
    bench.switches_at(-2'000.0, 2'000.0);
    ASSERT_NO_FATAL_FAILURE(bench.enter(method));
    bench.start();
    ASSERT_TRUE(bench.tick_until([&bench] {
      return bench.phase() != kRunning;
    }));
    EXPECT_EQ(bench.phase(), kErrorMoving);
    EXPECT_NEAR(bench.place, method == 33 ? -2'000.0 : 2'000.0, 10.0);
    EXPECT_TRUE(bench.tick_until_phase(kErrorStopped));
  }
}

TEST(HomingError, DoesNotOccurAtALimitSwitchBehindTheAxis) {
  Bench bench;
  ASSERT_NO_FATAL_FAILURE(bench.move_to(1'000.0));
  bench.switches_at(-kNowhere, 500.0);
  ASSERT_NO_FATAL_FAILURE(bench.home(33));
  EXPECT_NEAR(bench.place, 0.0, 1.5);
}

TEST(HomingError, NeverShowsBits12And13Together) {
  for (const int method : {0, 1, 2, 17, 18, 33, 34, 35, 37}) {
    for (const double width : {1'000.0, 5'000.0}) {
      Bench bench;
      bench.switches_at(-width, width);
      ASSERT_NO_FATAL_FAILURE(bench.enter(method));
      bench.start();
      for (int i = 0; i < 1'500; ++i) {
        bench.tick();
        ASSERT_NE(bench.axis.statusword() & 0x3000, 0x3000);
      }
    }
  }
}

// CiA 402-2 reserves 15, 16, 31 and 32 and has no 36; negative methods search for mechanical stops.
TEST(HomingMethodObject, AcceptsZeroAndTheSupportedMethodsOnly) {
  AxisUnderTest axis;
  for (std::int64_t value = -128; value <= 127; ++value) {
    const bool known = (value >= -4 && value <= 14) || (value >= 17 && value <= 30) ||
                       (value >= 33 && value <= 35) || value == 37;
    EXPECT_EQ(axis.try_write("homing_method", value),
              known ? AbortCode::none : AbortCode::value_range_exceeded)
        << value;
  }
  EXPECT_EQ(axis.try_write("homing_method", 128), AbortCode::value_too_high);
  EXPECT_EQ(axis.try_write("homing_method", -129), AbortCode::value_too_low);
}

// ---- software limits ---------------------------------------------------------------------------

/// 607Dh = 10 to 1000, switched on by 3535h: bit 11 at position 0 shows whether it is in force.
Bench limited_bench(bool need_homing) {
  AxisConfiguration configuration;
  configuration.settings.limits_need_homing = need_homing;
  configuration.parameters = {{AxisUnderTest::address_of("app_position_limit_switch"), 1},
                              {AxisUnderTest::address_of("user_position_lower_limit"), 10},
                              {AxisUnderTest::address_of("user_position_upper_limit"), 1'000}};
  return Bench(configuration);
}

TEST(SoftwareLimitsAfterHoming, AreInForceOnlyAfterHomingWhereTheSettingSaysSo) {
  Bench bench = limited_bench(true);
  bench.ticks(2);
  EXPECT_FALSE(bench.axis.limit_active());
  ASSERT_NO_FATAL_FAILURE(bench.home(37));
  EXPECT_TRUE(bench.axis.limit_active());
  ASSERT_NO_FATAL_FAILURE(bench.move_to(bench.place + 5'000.0));
  EXPECT_EQ(bench.axis.demand(), 1'000) << "the target is clamped";

  bench.axis.axis().power_cycle();
  bench.ticks(5);
  EXPECT_EQ(bench.axis.actual(), 1'000);
  EXPECT_FALSE(bench.axis.limit_active()) << "a power cycle forgets that the axis was homed";
}

TEST(SoftwareLimitsAfterHoming, AreInForceAtOnceWithoutTheSetting) {
  Bench bench = limited_bench(false);
  bench.tick();
  EXPECT_TRUE(bench.axis.limit_active());
}

TEST(SoftwareLimitsAfterHoming, AreNotInForceAfterAFailedRun) {
  Bench bench = limited_bench(true);
  ASSERT_NO_FATAL_FAILURE(bench.enter(33));
  bench.start();
  bench.ticks(20);
  bench.axis.controlword(0x0007);
  bench.axis.write("test_index_pulse_input", 1);
  bench.ticks(200);
  EXPECT_FALSE(bench.axis.limit_active());
  ASSERT_NO_FATAL_FAILURE(bench.enter(0));
  bench.start();
  bench.ticks(5);
  EXPECT_FALSE(bench.axis.limit_active());
}

TEST(SoftwareLimitsAfterHoming, AreNotInForceFromTheStartOfANewRunUntilItsHome) {
  Bench bench = limited_bench(true);
  ASSERT_NO_FATAL_FAILURE(bench.home(37));
  bench.axis.write("homing_method", 0);
  bench.start();
  EXPECT_EQ(bench.phase(), kErrorStopped);
  EXPECT_FALSE(bench.axis.limit_active());
}

TEST(SoftwareLimitsAfterHoming, StayInForceThroughDisableAndFault) {
  Bench bench = limited_bench(true);
  ASSERT_NO_FATAL_FAILURE(bench.home(35));
  bench.axis.controlword(0x0000);
  bench.ticks(5);
  EXPECT_TRUE(bench.axis.limit_active());
  bench.axis.write("test_over_current", 1);
  bench.ticks(5);
  EXPECT_TRUE(bench.axis.limit_active());
}

}  // namespace
}  // namespace vdrive
