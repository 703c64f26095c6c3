// SPDX-License-Identifier: Apache-2.0
// Touch probes: 60B8h to 60BDh, 60D0h to 60D8h. Expected values follow from CiA 402-2 (function
// group touch probe) and, where it leaves a choice, from docs/explanation/decisions.md.
#include "core/support/axis_under_test.hpp"
#include "vdrive/axis_bank.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;

// 60B8h of probe 1; the bits of probe 2 are 8 places higher.
constexpr std::int64_t kOn = 0x0001;
constexpr std::int64_t kContinuous = 0x0002;
constexpr std::int64_t kOnIndex = 0x0004;   // source 01b
constexpr std::int64_t kOnSource = 0x0008;  // source 10b: 60D0h
constexpr std::int64_t kRising = 0x0010;
constexpr std::int64_t kFalling = 0x0020;

// 60B9h of probe 1.
constexpr std::int64_t kProbeIsOn = 0x0001;
constexpr std::int64_t kRisingStored = 0x0002;
constexpr std::int64_t kFallingStored = 0x0004;

constexpr std::int64_t kTick_ns = 1'000'000;
constexpr std::int64_t kSubstep_ns = 125'000;  // 8 kHz

/// 5.12 UU per sub-step, 40.96 UU per tick.
constexpr std::int32_t kProbeSpeed = 40'960;

/// Turns at `velocity` in profile velocity, long after the ramp.
void turn_steadily(AxisUnderTest& axis, std::int32_t velocity) {
  axis.write("op_mode_cmd", 3);
  axis.command(0x000F);
  axis.write("target_velocity", velocity);
  axis.step(1'500);
}

/// Puts a home switch where it becomes active at `place` for an axis that moves in the direction
/// `sign`.
void place_home_switch(AxisUnderTest& axis, std::int32_t place, int sign) {
  constexpr std::int32_t kLength = 1'000;
  axis.write("test_switch_home", sign > 0 ? place : place - kLength);
  axis.write("test_switch_home_length", kLength);
}

std::int64_t probe_status(const AxisUnderTest& axis) {
  return axis.read("touch_probe_status");
}

/// Time of the last tick [ns], in the form of a time stamp.
std::int64_t time_now(const AxisUnderTest& axis) {
  return static_cast<std::uint32_t>(axis.ticks() * static_cast<std::uint64_t>(kTick_ns));
}

/// The values that probe 1 has latched.
struct Latched {
  std::int64_t position;
  std::int64_t time;
  std::int64_t count;
};

Latched rising_edge(const AxisUnderTest& axis) {
  return {axis.read("touch_probe_position_1_positive_value"),
          axis.read("touch_probe_time_stamp_1_positive_value"),
          axis.read("touch_probe_1_positive_edge_counter")};
}

Latched falling_edge(const AxisUnderTest& axis) {
  return {axis.read("touch_probe_position_1_negative_value"),
          axis.read("touch_probe_time_stamp_1_negative_value"),
          axis.read("touch_probe_1_negative_edge_counter")};
}

/// Writes a test bench input and runs the tick in which it takes effect.
void set_input(AxisUnderTest& axis, std::string_view input, std::int64_t value) {
  axis.write(input, value);
  axis.step();
}

void pulse_input(AxisUnderTest& axis, std::string_view input) {
  set_input(axis, input, 1);
  set_input(axis, input, 0);
}

// ---- at the sub-step ---------------------------------------------------------------------------

TEST(TouchProbe, LatchesPositionAndTimeAtTheSubstepOfTheEdge) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    turn_steadily(axis, sign * kProbeSpeed);
    for (int turn = 0; turn < 30; ++turn) {
      SCOPED_TRACE("sign " + std::to_string(sign) + ", turn " + std::to_string(turn));
      const std::int32_t place = axis.actual() + sign * (200 + 3 * turn);
      place_home_switch(axis, place, sign);
      axis.write("touch_probe_function", kOn | kRising);
      std::int32_t before = 0;
      const std::uint64_t ticks = axis.step_until(
          [&axis, &before, previous = axis.actual()]() mutable {
            before = std::exchange(previous, axis.actual());
            return (probe_status(axis) & kRisingStored) != 0;
          },
          50);
      ASSERT_GT(ticks, 0U) << "the switch is passed";
      const Latched edge = rising_edge(axis);
      // The first sub-step beyond the switch: at most 40960 UU/s x 125 us = 5.12 UU beyond it.
      EXPECT_GE(sign * (edge.position - place), 0);
      EXPECT_LE(sign * (edge.position - place), 6);
      const std::int64_t start = time_now(axis) - kTick_ns;
      EXPECT_EQ(edge.time % kSubstep_ns, 0);
      EXPECT_GT(edge.time, start);
      EXPECT_LE(edge.time, start + kTick_ns);
      const double way = sign * kProbeSpeed * 1.0e-9 * static_cast<double>(edge.time - start);
      EXPECT_NEAR(static_cast<double>(edge.position), before + way, 1.1) << "6064h at that time";
      axis.write("touch_probe_function", 0);
    }
  }
}

TEST(TouchProbe, LatchesBothEdgesOfASwitchThatIsNarrowerThanATick) {
  AxisUnderTest axis;
  turn_steadily(axis, kProbeSpeed);
  // 20 UU are four sub-steps, half a tick.
  const std::int32_t place = axis.actual() + 300;
  axis.write("test_switch_home", place);
  axis.write("test_switch_home_length", 20);
  axis.write("touch_probe_function", kOn | kRising | kFalling);
  axis.step(20);
  EXPECT_EQ(probe_status(axis), kProbeIsOn | kRisingStored | kFallingStored);
  const Latched rising = rising_edge(axis);
  const Latched falling = falling_edge(axis);
  EXPECT_NEAR(static_cast<double>(rising.position), place + 2.5, 3.5);
  EXPECT_NEAR(static_cast<double>(falling.position), place + 20 + 2.5, 3.5);
  // 20 UU at 5.12 UU per sub-step: 3.9 sub-steps.
  EXPECT_NEAR(static_cast<double>(falling.time - rising.time), 3.9 * kSubstep_ns, kSubstep_ns);
}

TEST(TouchProbe, LatchesTheIndexPulseOfTheMotorOnceARevolution) {
  for (const int sign : {1, -1}) {
    AxisUnderTest axis;
    turn_steadily(axis, sign * kProbeSpeed);
    axis.write("touch_probe_function", kOn | kContinuous | kOnIndex | kRising | kFalling);
    for (int revolution = 0; revolution < 5; ++revolution) {
      const std::int64_t count = rising_edge(axis).count;
      // 4096 UU at 40.96 UU per tick: 100 ticks.
      ASSERT_GT(axis.step_until(
                    [&axis, count] {
                      return rising_edge(axis).count != count;
                    },
                    101),
                0U);
      const Latched edge = rising_edge(axis);
      EXPECT_EQ(edge.count, count + 1);
      // Pulses are at the multiples of 4096 UU; they are seen in the first sub-step beyond them.
      const std::int64_t behind = sign * edge.position % 4'096;
      EXPECT_GE(behind, 0);
      EXPECT_LE(behind, 6);
      EXPECT_EQ(falling_edge(axis).position, edge.position) << "a pulse has no width";
      EXPECT_EQ(falling_edge(axis).time, edge.time);
    }
  }
}

TEST(TouchProbe, TakesTheIndexPulseWhereHomingFindsIt) {
  // Homing with method 34: to the next index pulse in positive direction, which becomes
  // 607Ch = 500.
  AxisUnderTest axis;
  axis.write("home_offset", 500);
  axis.write("homing_method", 34);
  axis.write("op_mode_cmd", 6);
  axis.command(0x000F);
  axis.command(0x001F);
  ASSERT_GT(axis.step_until_status(0x1400, 0x1400, 20'000), 0U);
  axis.command(0x000F);
  turn_steadily(axis, kProbeSpeed);
  axis.write("touch_probe_function", kOn | kOnIndex | kRising);
  axis.step(120);
  ASSERT_EQ(probe_status(axis), kProbeIsOn | kRisingStored);
  const std::int64_t behind = (rising_edge(axis).position - 500) % 4'096;
  EXPECT_GE(behind, 0);
  EXPECT_LE(behind, 6);
}

TEST(TouchProbe, SeesNoPulseInTheShiftOfAHomingRun) {
  AxisUnderTest axis;
  turn_steadily(axis, kProbeSpeed);
  axis.write("target_velocity", 0);
  axis.step(500);
  axis.write("touch_probe_function", kOn | kContinuous | kOnIndex | kRising | kFalling);
  axis.write("home_offset", 1'000'000);
  axis.write("homing_method", 37);
  axis.write("op_mode_cmd", 6);
  axis.step(2);
  axis.command(0x001F);
  ASSERT_GT(axis.step_until_status(0x1400, 0x1400, 2'000), 0U);
  ASSERT_NEAR(axis.actual(), 1'000'000, 20) << "the frame has moved";
  EXPECT_EQ(probe_status(axis), kProbeIsOn);
}

TEST(TouchProbe, DatesAWrittenEdgeAtTheStartOfItsTick) {
  AxisUnderTest axis;
  axis.step(7);
  axis.write("touch_probe_function", kOn | kRising | kFalling);
  set_input(axis, "test_home_input", 1);
  EXPECT_EQ(rising_edge(axis).time, 7 * kTick_ns);
  axis.step(2);
  set_input(axis, "test_home_input", 0);
  EXPECT_EQ(falling_edge(axis).time, 10 * kTick_ns);
}

TEST(TouchProbe, CountsTheTimeOfTicksThatAreLeftOut) {
  // While an axis has no power and does not move, its ticks are not computed, and the probe need
  // not look.
  AxisUnderTest axis;
  axis.write("touch_probe_function", kOn | kRising);
  axis.step(10'000);
  const std::int64_t time = time_now(axis);  // 10 s, beyond 2^32 ns
  set_input(axis, "test_home_input", 1);
  EXPECT_EQ(time, 10'000'000'000 % 4'294'967'296);
  EXPECT_EQ(rising_edge(axis).time, time);
}

TEST(TouchProbe, DatesSubstepsOfEveryPeriod) {
  // 3000 us have 24 sub-steps of 125 us, 125 us have one, 1001 us have 9 of 111.2 us.
  for (const int period : {125, 1'001, 3'000}) {
    AxisUnderTest axis({}, std::chrono::microseconds{period});
    axis.write("touch_probe_function", kOn | kRising);
    axis.step(5);
    set_input(axis, "test_home_input", 1);
    EXPECT_EQ(rising_edge(axis).time, 5 * period * 1'000) << period;
  }
}

// ---- 60B8h and 60B9h ---------------------------------------------------------------------------

TEST(TouchProbeFunction, IsOffByDefault) {
  AxisUnderTest axis;
  pulse_input(axis, "test_home_input");
  EXPECT_EQ(probe_status(axis), 0);
  EXPECT_EQ(rising_edge(axis).count, 0);
  EXPECT_EQ(rising_edge(axis).time, 0);
}

TEST(TouchProbeFunction, ShowsAProbeThatIsOnAtOnce) {
  AxisUnderTest axis;
  axis.write("touch_probe_function", kOn | kRising);
  EXPECT_EQ(probe_status(axis), kProbeIsOn);
  axis.write("touch_probe_function", kOn << 8);
  EXPECT_EQ(probe_status(axis), kProbeIsOn << 8);
  axis.write("touch_probe_function", 0);
  EXPECT_EQ(probe_status(axis), 0);
}

TEST(TouchProbeFunction, SamplesTheEdgesOfBits4And5Only) {
  struct Row {
    std::int64_t edges;
    std::int64_t stored;
  };

  for (const Row& row : {Row{0, 0}, Row{kRising, kRisingStored}, Row{kFalling, kFallingStored},
                         Row{kRising | kFalling, kRisingStored | kFallingStored}}) {
    AxisUnderTest axis;
    axis.write("touch_probe_function", kOn | row.edges);
    pulse_input(axis, "test_home_input");
    EXPECT_EQ(probe_status(axis), kProbeIsOn | row.stored);
  }
}

TEST(TouchProbeFunction, LatchesTheFirstEdgeOnlyWithoutBit1) {
  AxisUnderTest axis;
  axis.write("touch_probe_function", kOn | kRising | kFalling);
  pulse_input(axis, "test_home_input");
  const Latched rising = rising_edge(axis);
  const Latched falling = falling_edge(axis);
  pulse_input(axis, "test_home_input");
  EXPECT_EQ(rising_edge(axis).time, rising.time);
  EXPECT_EQ(falling_edge(axis).time, falling.time);
  EXPECT_EQ(rising_edge(axis).count, 1);
  EXPECT_EQ(falling_edge(axis).count, 1);
}

TEST(TouchProbeFunction, LatchesAndCountsEachEdgeWithBit1) {
  AxisUnderTest axis;
  axis.write("touch_probe_function", kOn | kContinuous | kRising | kFalling);
  for (std::int64_t count = 1; count <= 5; ++count) {
    const std::int64_t time = time_now(axis);
    pulse_input(axis, "test_home_input");
    EXPECT_EQ(rising_edge(axis).time, time);
    EXPECT_EQ(falling_edge(axis).time, time + kTick_ns);
    EXPECT_EQ(rising_edge(axis).count, count);
    EXPECT_EQ(falling_edge(axis).count, count);
    EXPECT_EQ(probe_status(axis), kProbeIsOn | kRisingStored | kFallingStored);
  }
}

TEST(TouchProbeFunction, LatchesAgainWhenBit1IsSetAfterTheFirstEdge) {
  AxisUnderTest axis;
  axis.write("touch_probe_function", kOn | kRising);
  pulse_input(axis, "test_home_input");
  axis.write("touch_probe_function", kOn | kContinuous | kRising);
  EXPECT_EQ(probe_status(axis), kProbeIsOn | kRisingStored);
  pulse_input(axis, "test_home_input");
  EXPECT_EQ(rising_edge(axis).count, 2);
}

TEST(TouchProbeFunction, CountersOverflowAt16Bits) {
  AxisUnderTest axis;
  axis.write("touch_probe_function", kOn | kContinuous | kFalling);
  for (int edge = 0; edge < 65'536; ++edge) pulse_input(axis, "test_home_input");
  EXPECT_EQ(falling_edge(axis).count, 0);
  pulse_input(axis, "test_home_input");
  EXPECT_EQ(falling_edge(axis).count, 1);
}

TEST(TouchProbeFunction, KeepsTheValuesAndClearsTheStatusWhenAProbeIsSwitchedOff) {
  AxisUnderTest axis;
  turn_steadily(axis, kProbeSpeed);
  axis.write("touch_probe_function", kOn | kRising | kFalling);
  pulse_input(axis, "test_home_input");
  const Latched rising = rising_edge(axis);
  const Latched falling = falling_edge(axis);
  ASSERT_NE(rising.position, 0);
  axis.write("touch_probe_function", kRising | kFalling);
  EXPECT_EQ(probe_status(axis), 0);
  pulse_input(axis, "test_home_input");
  EXPECT_EQ(rising_edge(axis).position, rising.position);
  EXPECT_EQ(rising_edge(axis).time, rising.time);
  EXPECT_EQ(rising_edge(axis).count, 1);
  EXPECT_EQ(falling_edge(axis).position, falling.position);
  EXPECT_EQ(falling_edge(axis).time, falling.time);
}

TEST(TouchProbeFunction, RearmsAProbeThatIsSwitchedOffAndOn) {
  AxisUnderTest axis;
  axis.write("touch_probe_function", kOn | kRising);
  pulse_input(axis, "test_home_input");
  const std::int64_t first = rising_edge(axis).time;
  axis.write("touch_probe_function", 0);
  axis.write("touch_probe_function", kOn | kRising);
  EXPECT_EQ(probe_status(axis), kProbeIsOn);
  EXPECT_EQ(rising_edge(axis).count, 0) << "edges count from here on";
  EXPECT_EQ(rising_edge(axis).time, first) << "until the next edge";
  pulse_input(axis, "test_home_input");
  EXPECT_EQ(probe_status(axis), kProbeIsOn | kRisingStored);
  EXPECT_EQ(rising_edge(axis).time, first + 2 * kTick_ns);
  EXPECT_EQ(rising_edge(axis).count, 1);
}

TEST(TouchProbeFunction, RearmsOneEdgeWhenItsBitGoesAndComes) {
  AxisUnderTest axis;
  axis.write("touch_probe_function", kOn | kRising | kFalling);
  pulse_input(axis, "test_home_input");
  axis.write("touch_probe_function", kOn | kFalling);
  EXPECT_EQ(probe_status(axis), kProbeIsOn | kFallingStored);
  axis.write("touch_probe_function", kOn | kRising | kFalling);
  EXPECT_EQ(probe_status(axis), kProbeIsOn | kFallingStored);
  pulse_input(axis, "test_home_input");
  EXPECT_EQ(probe_status(axis), kProbeIsOn | kRisingStored | kFallingStored);
  EXPECT_EQ(rising_edge(axis).count, 2);
  EXPECT_EQ(falling_edge(axis).count, 1);
}

TEST(TouchProbeFunction, TheSameValueAgainArmsNothing) {
  AxisUnderTest axis;
  axis.write("touch_probe_function", kOn | kRising);
  pulse_input(axis, "test_home_input");
  const std::int64_t first = rising_edge(axis).time;
  axis.write("touch_probe_function", kOn | kRising);
  EXPECT_EQ(probe_status(axis), kProbeIsOn | kRisingStored);
  pulse_input(axis, "test_home_input");
  EXPECT_EQ(rising_edge(axis).time, first);
  EXPECT_EQ(rising_edge(axis).count, 1);
}

TEST(TouchProbeFunction, ALevelThatIsThereBeforeIsNoEdge) {
  AxisUnderTest axis;
  set_input(axis, "test_home_input", 1);
  axis.write("touch_probe_function", kOn | kRising | kFalling);
  axis.step(10);
  EXPECT_EQ(probe_status(axis), kProbeIsOn);
  set_input(axis, "test_home_input", 0);
  EXPECT_EQ(probe_status(axis), kProbeIsOn | kFallingStored);
}

TEST(TouchProbeFunction, AnEdgeBelongsToTheFunctionInForceWhenItIsWritten) {
  AxisUnderTest late;
  late.write("test_home_input", 1);
  late.write("touch_probe_function", kOn | kRising);
  late.step();
  EXPECT_EQ(probe_status(late), kProbeIsOn);

  AxisUnderTest early;
  early.write("touch_probe_function", kOn | kRising);
  early.write("test_home_input", 1);
  early.write("touch_probe_function", kOn | kRising | kFalling);
  EXPECT_EQ(probe_status(early), kProbeIsOn | kRisingStored);
}

TEST(TouchProbeFunction, RefusesBitsWithoutAMeaning) {
  AxisUnderTest axis;
  axis.write("touch_probe_function", kOn | kRising);
  for (const std::int64_t bits : {0x0040, 0x0080, 0x4000, 0x8000, 0x000C, 0x0C00}) {
    EXPECT_EQ(axis.try_write("touch_probe_function", kOn | bits), AbortCode{0x06090030}) << bits;
  }
  EXPECT_EQ(axis.try_write("touch_probe_function", 0x10000), AbortCode{0x06090031});
  EXPECT_EQ(axis.try_write("touch_probe_function", -1), AbortCode{0x06090032});
  EXPECT_EQ(axis.read("touch_probe_function"), kOn | kRising);
  EXPECT_EQ(probe_status(axis), kProbeIsOn) << "a refused write arms nothing";
}

TEST(TouchProbeFunction, RefusesWritesOfWhatItLatches) {
  AxisUnderTest axis;
  for (const char* const object :
       {"touch_probe_status", "touch_probe_position_1_positive_value",
        "touch_probe_position_1_negative_value", "touch_probe_position_2_positive_value",
        "touch_probe_position_2_negative_value", "touch_probe_time_stamp_1_positive_value",
        "touch_probe_time_stamp_1_negative_value", "touch_probe_time_stamp_2_positive_value",
        "touch_probe_time_stamp_2_negative_value", "touch_probe_1_positive_edge_counter",
        "touch_probe_1_negative_edge_counter", "touch_probe_2_positive_edge_counter",
        "touch_probe_2_negative_edge_counter"}) {
    EXPECT_EQ(axis.try_write(object, 0), AbortCode{0x06010002}) << object;
  }
}

// ---- sources -----------------------------------------------------------------------------------

TEST(TouchProbeSource, ByDefaultEachProbeHasItsInput) {
  AxisUnderTest axis;
  const std::int64_t both = kOn | kRising;
  axis.write("touch_probe_function", both | both << 8);
  pulse_input(axis, "test_home_input");
  EXPECT_EQ(probe_status(axis), kProbeIsOn | kRisingStored | kProbeIsOn << 8);
  pulse_input(axis, "test_positive_limit_input");
  const std::int64_t stored = kProbeIsOn | kRisingStored;
  EXPECT_EQ(probe_status(axis), stored | stored << 8);
  EXPECT_EQ(axis.read("touch_probe_time_stamp_2_positive_value"), 2 * kTick_ns);
  EXPECT_EQ(axis.read("touch_probe_2_positive_edge_counter"), 1);
  EXPECT_EQ(axis.read("touch_probe_2_negative_edge_counter"), 0);
}

TEST(TouchProbeSource, ProbesLatchTheSameInputOnTheirOwn) {
  AxisUnderTest axis;
  axis.write("touch_probe_source_2", 1);
  const std::int64_t second = kOn | kOnSource | kFalling;
  axis.write("touch_probe_function", kOn | kRising | second << 8);
  pulse_input(axis, "test_home_input");
  EXPECT_EQ(rising_edge(axis).time, 0);
  EXPECT_EQ(axis.read("touch_probe_time_stamp_2_negative_value"), kTick_ns);
  axis.write("touch_probe_function", kOn | kRising);
  EXPECT_EQ(probe_status(axis), kProbeIsOn | kRisingStored) << "probe 1 is as it was";
}

struct SourceRow {
  std::int64_t source;
  std::string_view input;
};

constexpr std::array<SourceRow, 4> kSources{{{1, "test_home_input"},
                                             {2, "test_positive_limit_input"},
                                             {3, "test_negative_limit_input"},
                                             {5, "test_index_pulse_input"}}};

TEST(TouchProbeSource, IsChosenBy60D0hWhereBits2And3Are2) {
  for (const SourceRow& row : kSources) {
    for (const int shift : {0, 8}) {
      AxisUnderTest axis;
      axis.write("touch_probe_source_1", row.source);
      axis.write("touch_probe_source_2", row.source);
      axis.write("touch_probe_function", (kOn | kOnSource | kRising) << shift);
      for (const SourceRow& other : kSources) {
        if (other.source != row.source) pulse_input(axis, other.input);
      }
      EXPECT_EQ(probe_status(axis), kProbeIsOn << shift) << row.source;
      pulse_input(axis, row.input);
      EXPECT_EQ(probe_status(axis), (kProbeIsOn | kRisingStored) << shift) << row.source;
    }
  }
}

TEST(TouchProbeSource, DoesNotMatterWhereBits2And3AreNot2) {
  AxisUnderTest axis;
  axis.write("touch_probe_source_1", 3);
  axis.write("touch_probe_function", kOn | kRising);
  pulse_input(axis, "test_negative_limit_input");
  EXPECT_EQ(probe_status(axis), kProbeIsOn);
  pulse_input(axis, "test_home_input");
  EXPECT_EQ(probe_status(axis), kProbeIsOn | kRisingStored);
}

TEST(TouchProbeSource, AChangeOfTheSourceIsNoEdge) {
  AxisUnderTest axis;
  axis.write("touch_probe_function", kOn | kOnSource | kRising | kFalling);
  set_input(axis, "test_negative_limit_input", 1);
  axis.write("touch_probe_source_1", 3);  // from an input that is 0 to one that is 1
  axis.step(2);
  EXPECT_EQ(probe_status(axis), kProbeIsOn);
  set_input(axis, "test_negative_limit_input", 0);
  EXPECT_EQ(probe_status(axis), kProbeIsOn | kFallingStored);
}

TEST(TouchProbeSource, RefusesWhatTheDriveDoesNotHave) {
  AxisUnderTest axis;
  for (const char* const object : {"touch_probe_source_1", "touch_probe_source_2"}) {
    EXPECT_EQ(axis.try_write(object, 4), AbortCode{0x06090030}) << "a fourth input";
    EXPECT_EQ(axis.try_write(object, 0), AbortCode{0x06090032});
    EXPECT_EQ(axis.try_write(object, 6), AbortCode{0x06090031}) << "a pulse made by software";
    EXPECT_EQ(axis.try_write(object, -1), AbortCode{0x06090032});
  }
}

// ---- in every mode and state -------------------------------------------------------------------

TEST(TouchProbe, WorksInEveryMode) {
  for (const std::int64_t mode : {0, 1, 2, 3, 4, 6, 7, 8, 9, 10}) {
    AxisUnderTest axis;
    axis.write("op_mode_cmd", mode);
    axis.command(0x000F);
    axis.step(10);
    ASSERT_EQ(axis.status().op_mode_actual, mode);
    axis.write("touch_probe_function", kOn | kRising | kFalling);
    pulse_input(axis, "test_home_input");
    EXPECT_EQ(probe_status(axis), kProbeIsOn | kRisingStored | kFallingStored) << mode;
  }
}

TEST(TouchProbe, WorksInEveryPowerState) {
  using Prepare = void (*)(AxisUnderTest&);

  struct Row {
    PowerState state;
    Prepare prepare;
  };

  const std::array<Row, 6> rows{{
      {PowerState::switch_on_disabled,
       [](AxisUnderTest& axis) {
         axis.step();
       }},
      {PowerState::ready_to_switch_on,
       [](AxisUnderTest& axis) {
         axis.command(0x0006);
       }},
      {PowerState::switched_on,
       [](AxisUnderTest& axis) {
         axis.command(0x0006);
         axis.command(0x0007);
       }},
      {PowerState::operation_enabled,
       [](AxisUnderTest& axis) {
         axis.enable();
       }},
      {PowerState::quick_stop_active,
       [](AxisUnderTest& axis) {
         axis.write("quick_stop_option_code", 6);  // stays in Quick stop active
         axis.enable();
         axis.command(0x0002);
       }},
      {PowerState::fault,
       [](AxisUnderTest& axis) {
         axis.enable();
         axis.write("test_over_current", 1);
         axis.step(1'000);
       }},
  }};
  for (const Row& row : rows) {
    AxisUnderTest axis;
    row.prepare(axis);
    ASSERT_EQ(axis.state(), row.state);
    axis.write("touch_probe_function", kOn | kRising | kFalling);
    const std::int64_t time = time_now(axis);
    pulse_input(axis, "test_home_input");
    EXPECT_EQ(probe_status(axis), kProbeIsOn | kRisingStored | kFallingStored);
    EXPECT_EQ(rising_edge(axis).time, time);
    EXPECT_EQ(axis.state(), row.state);
  }
}

TEST(TouchProbe, StaysEnabledThroughDisablingAndFaults) {
  AxisUnderTest axis;
  axis.enable();
  axis.write("touch_probe_function", kOn | kRising);
  axis.command(0x0000);
  axis.write("test_over_current", 1);
  axis.step(10);
  pulse_input(axis, "test_home_input");
  EXPECT_EQ(probe_status(axis), kProbeIsOn | kRisingStored);
}

TEST(TouchProbe, IsForgottenByAPowerCycle) {
  AxisUnderTest axis;
  axis.write("touch_probe_function", kOn | kRising);
  set_input(axis, "test_home_input", 1);
  ASSERT_EQ(rising_edge(axis).count, 1);
  axis.axis().power_cycle();
  EXPECT_EQ(axis.read("touch_probe_function"), 0);
  EXPECT_EQ(probe_status(axis), 0);
  EXPECT_EQ(rising_edge(axis).count, 0);
  set_input(axis, "test_home_input", 0);
  pulse_input(axis, "test_home_input");
  EXPECT_EQ(rising_edge(axis).count, 0);
}

TEST(TouchProbe, OfAConfigurationIsEnabledFromPowerUpOn) {
  AxisConfiguration configuration;
  configuration.parameters.push_back({{0x60B8, 0}, kOn | kRising});
  AxisUnderTest axis(configuration);
  EXPECT_EQ(probe_status(axis), kProbeIsOn);
  pulse_input(axis, "test_home_input");
  EXPECT_EQ(probe_status(axis), kProbeIsOn | kRisingStored);
}

// ---- the other axes, and snapshots -------------------------------------------------------------

void put_object(AxisBank& bank, std::size_t axis, std::string_view name, std::int64_t value) {
  ASSERT_EQ(bank.write(axis, AxisUnderTest::address_of(name), value), AbortCode::none) << name;
}

std::int64_t get_object(const AxisBank& bank, std::size_t axis, std::string_view name) {
  return bank.read(axis, AxisUnderTest::address_of(name)).value;
}

/// Ten axes, more than fit in a block: every second one elastic, all in motion, with borders
/// between profile segments at different times.
AxisBank moving_bank() {
  std::vector<AxisConfiguration> axes(10);
  for (std::size_t axis = 0; axis < axes.size(); axis += 2) {
    axes[axis].model.coupling = Coupling::two_inertia;
    axes[axis].model.backlash = axis == 4 ? 0.001 : 0.0;
  }
  AxisBank bank(axes, std::chrono::milliseconds{1});
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    put_object(bank, axis, "op_mode_cmd", 1);
    put_object(bank, axis, "profile_velocity", 40'000 + 3'000 * static_cast<std::int64_t>(axis));
    put_object(bank, axis, "ds402_controlword", 0x000F);
  }
  bank.step();
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    put_object(bank, axis, "position_user_target_value",
               20'000 + 1'000 * static_cast<std::int64_t>(axis));
    put_object(bank, axis, "ds402_controlword", 0x001F);
  }
  return bank;
}

TEST(TouchProbe, ChangesNoBitOfAnyMotion) {
  AxisBank plain = moving_bank();
  AxisBank probed = moving_bank();
  for (const std::size_t axis : {2U, 3U, 4U}) {
    put_object(probed, axis, "touch_probe_function", kOn | kContinuous | kOnIndex | kRising);
  }
  for (int tick = 0; tick < 3'000; ++tick) {
    plain.step();
    probed.step();
    ASSERT_EQ(probed.status_hash(), plain.status_hash()) << tick;
  }
  for (const std::size_t axis : {2U, 3U, 4U}) {
    // Targets of 22000 to 24000 UU: five pulses, at 4096 UU to 20480 UU.
    EXPECT_EQ(get_object(probed, axis, "touch_probe_1_positive_edge_counter"), 5) << axis;
    const std::int64_t last = get_object(probed, axis, "touch_probe_position_1_positive_value");
    EXPECT_GE(last, 20'479);
    EXPECT_LE(last, 20'480 + 10) << "52000 UU/s are 6.5 UU a sub-step; a shaft twists";
  }
  EXPECT_EQ(get_object(probed, 1, "touch_probe_1_positive_edge_counter"), 0);
}

TEST(TouchProbe, IsPartOfASnapshot) {
  AxisBank bank = moving_bank();
  put_object(bank, 3, "touch_probe_function", kOn | kContinuous | kOnIndex | kRising);
  for (int tick = 0; tick < 150; ++tick) bank.step();
  const auto snapshot = bank.snapshot();
  const auto later = [&bank] {
    for (int tick = 0; tick < 1'000; ++tick) bank.step();
    return bank.snapshot().bytes();
  };
  const auto first = later();
  EXPECT_GT(get_object(bank, 3, "touch_probe_1_positive_edge_counter"), 0);
  bank.restore(snapshot);
  EXPECT_EQ(later(), first);
  bank.restore(bank.snapshot_from(snapshot.bytes()));
  EXPECT_EQ(later(), first);
}

}  // namespace
}  // namespace vdrive
