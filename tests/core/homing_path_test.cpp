// SPDX-License-Identifier: Apache-2.0
// The paths of the homing methods 1 to 34 against the drawings of CiA 402-2, homing mode, and those
// of the methods -1 to -4: speeds and edges in their order, from every start.
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <ostream>
#include <string>
#include <vector>

namespace vdrive {
namespace {

using test::AxisUnderTest;

constexpr double kEndless = 1.0e12;
constexpr std::int32_t kFast = 34'133;   // 6099h:01, default [UU/s]
constexpr std::int32_t kCreep = 3'413;   // 6099h:02, default [UU/s]
constexpr double kPositiveEnd = 30'000;  // positions of the limit switches
constexpr double kNegativeEnd = -30'000;

/// Where the home switch is active [UU].
struct Cam {
  double first = kEndless;
  double last = kEndless;
};

constexpr double kStop = 20'000;  // end stops at -kStop and kStop, before the limit switches

constexpr Cam kNoCam{};
constexpr Cam kMiddle{9'000, 15'000};            // methods 7 to 14
constexpr Cam kPositiveSide{9'000, kEndless};    // 3 and 4
constexpr Cam kNegativeSide{-kEndless, -9'000};  // 5 and 6

/// An axis between its switches, and a record of a run as an observer would note it:
///   > >> < <<  the demand keeps creep or search speed, positive or negative
///   H h        the home switch becomes active, inactive
///   P N        the positive or negative limit switch becomes active
///   S          the load reaches an end stop
///   .          homing attained
class HomingCourse {
 public:
  /// @param stop end stops are at -stop and stop [UU]
  explicit HomingCourse(double from, Cam cam = kNoCam, double stop = kEndless)
      : axis(at(from, stop)), place(from), cam_(cam), stop_(stop) {
    set_switches();
    axis.write("op_mode_cmd", 6);
    axis.controlword(0x000F);
    axis.step(2);
  }

  void start(int method) {
    axis.write("homing_method", method);
    axis.controlword(0x001F);
    way.clear();
    demand_ = 0;
    speed_ = 0;
    tick();
  }

  /// Starts, and steps until the record of the run is `stage`.
  void start_until(int method, const std::string& stage) {
    start(method);
    for (int i = 0; i < 20'000 && way != stage; ++i) tick();
    ASSERT_EQ(way, stage);
  }

  /// One tick; then the switches are set according to the position of the axis.
  void tick() {
    const bool was_attained = attained();
    const std::int32_t before = axis.actual();
    axis.step();
    if (attained() && !was_attained) {
      place += axis.velocity() * axis.seconds_per_tick();  // 6064h has jumped to the new frame
      note(".");
    } else {
      place += axis.actual() - before;
    }
    if (!attained()) note_speed();
    set_switches();
  }

  void ticks(int count) {
    for (int i = 0; i < count; ++i) tick();
  }

  /// @return bits 13, 12 and 10 of 6041h.
  [[nodiscard]] unsigned phase() const { return axis.statusword() & 0x3400U; }

  bool tick_until_phase(unsigned wanted) {
    for (int i = 0; i < 20'000; ++i) {
      tick();
      if (phase() == wanted) return true;
    }
    return false;
  }

  /// A complete run, and the time to settle.
  void home(int method) {
    start(method);
    ASSERT_TRUE(tick_until_phase(kDone)) << "way " << way << ", status " << std::hex << phase();
    ticks(200);
    ASSERT_EQ(phase(), kDone);
  }

  static constexpr unsigned kRunning = 0x0000;
  static constexpr unsigned kIdle = 0x0400;
  static constexpr unsigned kDone = 0x1400;
  static constexpr unsigned kErrorStopped = 0x2400;

  AxisUnderTest axis;
  double place;     ///< of the load in the frame of power-up [UU]
  std::string way;  ///< of the current run

 private:
  static AxisConfiguration at(double position, double stop) {
    AxisConfiguration configuration;
    configuration.initial_position = static_cast<std::int32_t>(position);
    if (stop < kEndless) {
      configuration.model.lower_end_stop = -stop;
      configuration.model.upper_end_stop = stop;
    }
    return configuration;
  }

  [[nodiscard]] bool attained() const { return (axis.statusword() & 0x1000U) != 0; }

  void note(const std::string& word) { way += way.empty() ? word : " " + word; }

  /// A speed that the demand keeps for two ticks is one at which the axis travels. From search
  /// speed down to creep speed 609Ah takes exactly 75 ticks ((34133 - 3413) / 409.6), so each ramp
  /// that brakes or turns round has the creep speed for only one tick.
  void note_speed() {
    const std::int32_t speed = axis.demand_velocity();
    const bool keeps = speed == demand_;
    demand_ = speed;
    if (!keeps || speed == speed_) return;
    if (std::abs(speed) != kFast && std::abs(speed) != kCreep) return;
    speed_ = speed;
    const std::string sign = speed > 0 ? ">" : "<";
    note(std::abs(speed) == kFast ? sign + sign : sign);
  }

  void set_switches() {
    set("test_home_input", place >= cam_.first && place <= cam_.last, home_, "H", "h");
    set("test_positive_limit_input", place >= kPositiveEnd, positive_, "P", "");
    set("test_negative_limit_input", place <= kNegativeEnd, negative_, "N", "");
    // 6064h is a whole number, and shows the stop within 1 UU.
    const bool stands = std::abs(place) >= stop_ - 1.5;
    if (stands && !stands_ && !attained()) note("S");
    stands_ = stands;
  }

  void set(const char* object, bool active, bool& known, const char* on, const char* off) {
    if (active == known) return;
    axis.write(object, active ? 1 : 0);
    known = active;
    const std::string word = active ? on : off;
    if (!word.empty() && !attained()) note(word);
  }

  Cam cam_;
  double stop_;
  bool stands_ = false;      // at an end stop
  std::int32_t demand_ = 0;  // of the previous tick [UU/s]
  std::int32_t speed_ = 0;   // the last one that was noted [UU/s]
  bool home_ = false;
  bool positive_ = false;
  bool negative_ = false;
};

struct PathRow {
  int method;
  Cam cam;
  double start;
  const char* way;
  double home;
  double error;            ///< tolerance: a tick at the speed at which home is passed [UU]
  double stop = kEndless;  ///< end stops at -stop and stop [UU]
};

std::ostream& operator<<(std::ostream& out, const PathRow& row) {
  return out << "method " << row.method << " from " << row.start;
}

class HomingPath : public testing::TestWithParam<PathRow> {};

TEST_P(HomingPath, IsThatOfTheDrawing) {
  HomingCourse course(GetParam().start, GetParam().cam, GetParam().stop);
  ASSERT_NO_FATAL_FAILURE(course.home(GetParam().method));
  EXPECT_EQ(course.way, GetParam().way);
  EXPECT_NEAR(course.place, GetParam().home, GetParam().error);
  EXPECT_NEAR(course.axis.actual(), 0, 1);
  EXPECT_EQ(course.axis.demand(), 0);
  EXPECT_EQ(course.axis.state(), PowerState::operation_enabled);
}

// A tick of 1 ms is 3.4 UU at creep speed and 34.1 UU at search speed; the reading of 6064h and the
// rounding to whole numbers in this test add 2. An index pulse is located by the encoder.
constexpr double kAtIndex = 1.5;
constexpr double kAtCreep = 5.5;
constexpr double kAtSearch = 36.5;
constexpr double kAtStop = 1.5;  // the stop does not give way

// Index pulses lie at multiples of 4096: -12288, -8192, -4096, 4096, 8192, 12288, 16384.
const std::vector<PathRow> kLimitPaths{
    {1, kNoCam, 0, "<< N > .", -28'672, kAtIndex},
    {1, kNoCam, -31'000, "> .", -28'672, kAtIndex},
    {1, kNoCam, 31'000, "<< N > .", -28'672, kAtIndex},
    {2, kNoCam, 0, ">> P < .", 28'672, kAtIndex},
    {2, kNoCam, 31'000, "< .", 28'672, kAtIndex},
    {2, kNoCam, -31'000, ">> P < .", 28'672, kAtIndex},
    {17, kNoCam, 0, "<< N > .", -30'000, kAtCreep},
    {17, kNoCam, -31'000, "> .", -30'000, kAtCreep},
    {17, kNoCam, 31'000, "<< N > .", -30'000, kAtCreep},
    {18, kNoCam, 0, ">> P < .", 30'000, kAtCreep},
    {18, kNoCam, 31'000, "< .", 30'000, kAtCreep},
    {18, kNoCam, -31'000, ">> P < .", 30'000, kAtCreep},
};

// A mark at which the axis starts, or which it has just passed, does not count: the next is a
// revolution away. A mark 1 UU ahead is passed before the axis has creep speed, for which it needs
// 3413² / (2 x 409600) = 14 UU.
const std::vector<PathRow> kIndexPaths{
    {33, kNoCam, 100, "< .", 0, kAtIndex},     {33, kNoCam, 1, ".", 0, kAtIndex},
    {33, kNoCam, 0, "< .", -4'096, kAtIndex},  {33, kNoCam, -1, "< .", -4'096, kAtIndex},
    {34, kNoCam, 100, "> .", 4'096, kAtIndex}, {34, kNoCam, -1, ".", 0, kAtIndex},
    {34, kNoCam, 0, "> .", 4'096, kAtIndex},   {34, kNoCam, 1, "> .", 4'096, kAtIndex},
};

// Manufacturer-specific methods, see docs/explanation/decisions.md: to the end stop at search
// speed; then -1 and -2 leave it at creep speed for the index pulse, while -3 and -4 have home at
// the stop. An axis that starts at the stop reaches the torque before it has search speed: 64 UU of
// lag take 18 ticks, in which 609Ah reaches 7241 UU/s. An axis at the other stop takes the same
// path as one between the two.
const std::vector<PathRow> kStopPaths{
    {-1, kNoCam, 0, "<< S > .", -16'384, kAtIndex, kStop},
    {-1, kNoCam, -kStop, "> .", -16'384, kAtIndex, kStop},
    {-1, kNoCam, kStop, "<< S > .", -16'384, kAtIndex, kStop},
    {-2, kNoCam, 0, ">> S < .", 16'384, kAtIndex, kStop},
    {-2, kNoCam, kStop, "< .", 16'384, kAtIndex, kStop},
    {-2, kNoCam, -kStop, ">> S < .", 16'384, kAtIndex, kStop},
    {-3, kNoCam, 0, "<< S .", -kStop, kAtStop, kStop},
    {-3, kNoCam, -kStop, ".", -kStop, kAtStop, kStop},
    {-3, kNoCam, kStop, "<< S .", -kStop, kAtStop, kStop},
    {-4, kNoCam, 0, ">> S .", kStop, kAtStop, kStop},
    {-4, kNoCam, kStop, ".", kStop, kAtStop, kStop},
    {-4, kNoCam, -kStop, ">> S .", kStop, kAtStop, kStop},
};

// The home switch extends to the end of the travel, so no limit switch is reached. Home is left of
// the edge (3), right of it (4), and mirrored (5, 6).
const std::vector<PathRow> kStepPaths{
    {3, kPositiveSide, 0, ">> H < h .", 8'192, kAtIndex},
    {3, kPositiveSide, 12'000, "< h .", 8'192, kAtIndex},
    {3, kPositiveSide, 31'000, "< h .", 8'192, kAtIndex},
    {4, kPositiveSide, 0, ">> H > .", 12'288, kAtIndex},
    {4, kPositiveSide, 12'000, "<< h > H .", 12'288, kAtIndex},
    {4, kPositiveSide, 31'000, "<< h > H .", 12'288, kAtIndex},
    {5, kNegativeSide, 0, "<< H > h .", -8'192, kAtIndex},
    {5, kNegativeSide, -12'000, "> h .", -8'192, kAtIndex},
    {5, kNegativeSide, -31'000, "> h .", -8'192, kAtIndex},
    {6, kNegativeSide, 0, "<< H < .", -12'288, kAtIndex},
    {6, kNegativeSide, -12'000, ">> h < H .", -12'288, kAtIndex},
    {6, kNegativeSide, -31'000, ">> h < H .", -12'288, kAtIndex},
    {19, kPositiveSide, 0, ">> H < h .", 9'000, kAtCreep},
    {19, kPositiveSide, 12'000, "< h .", 9'000, kAtCreep},
    {19, kPositiveSide, 31'000, "< h .", 9'000, kAtCreep},
    {20, kPositiveSide, 0, ">> H .", 9'000, kAtSearch},
    {20, kPositiveSide, 12'000, "<< h > H .", 9'000, kAtCreep},
    {20, kPositiveSide, 31'000, "<< h > H .", 9'000, kAtCreep},
    {21, kNegativeSide, 0, "<< H > h .", -9'000, kAtCreep},
    {21, kNegativeSide, -12'000, "> h .", -9'000, kAtCreep},
    {21, kNegativeSide, -31'000, "> h .", -9'000, kAtCreep},
    {22, kNegativeSide, 0, "<< H .", -9'000, kAtSearch},
    {22, kNegativeSide, -12'000, ">> h < H .", -9'000, kAtCreep},
    {22, kNegativeSide, -31'000, ">> h < H .", -9'000, kAtCreep},
};

// These methods search in positive direction first; a start at the right reaches the positive limit
// switch and turns round. Home is approached
//   7: left of the left edge, from the right     8: right of the left edge, from the left
//   9: left of the right edge, from the right   10: right of the right edge, from the left
const std::vector<PathRow> kPositivePaths{
    {7, kMiddle, 0, ">> H < h .", 8'192, kAtIndex},
    {7, kMiddle, -31'000, ">> H < h .", 8'192, kAtIndex},
    {7, kMiddle, 12'000, "< h .", 8'192, kAtIndex},
    {7, kMiddle, 20'000, ">> P << H < h .", 8'192, kAtIndex},
    {7, kMiddle, 31'000, "<< H < h .", 8'192, kAtIndex},
    {8, kMiddle, 0, ">> H > .", 12'288, kAtIndex},
    {8, kMiddle, -31'000, ">> H > .", 12'288, kAtIndex},
    {8, kMiddle, 12'000, "<< h > H .", 12'288, kAtIndex},
    {8, kMiddle, 20'000, ">> P << H h > H .", 12'288, kAtIndex},
    {8, kMiddle, 31'000, "<< H h > H .", 12'288, kAtIndex},
    {9, kMiddle, 0, ">> H h < H .", 12'288, kAtIndex},
    {9, kMiddle, -31'000, ">> H h < H .", 12'288, kAtIndex},
    {9, kMiddle, 12'000, ">> h < H .", 12'288, kAtIndex},
    {9, kMiddle, 20'000, ">> P << H < .", 12'288, kAtIndex},
    {9, kMiddle, 31'000, "<< H < .", 12'288, kAtIndex},
    {10, kMiddle, 0, ">> H > h .", 16'384, kAtIndex},
    {10, kMiddle, -31'000, ">> H > h .", 16'384, kAtIndex},
    {10, kMiddle, 12'000, "> h .", 16'384, kAtIndex},
    {10, kMiddle, 20'000, ">> P << H > h .", 16'384, kAtIndex},
    {10, kMiddle, 31'000, "<< H > h .", 16'384, kAtIndex},
    {23, kMiddle, 0, ">> H < h .", 9'000, kAtCreep},
    {23, kMiddle, -31'000, ">> H < h .", 9'000, kAtCreep},
    {23, kMiddle, 12'000, "< h .", 9'000, kAtCreep},
    {23, kMiddle, 20'000, ">> P << H < h .", 9'000, kAtCreep},
    {23, kMiddle, 31'000, "<< H < h .", 9'000, kAtCreep},
    {24, kMiddle, 0, ">> H .", 9'000, kAtSearch},
    {24, kMiddle, -31'000, ">> H .", 9'000, kAtSearch},
    {24, kMiddle, 12'000, "<< h > H .", 9'000, kAtCreep},
    {24, kMiddle, 20'000, ">> P << H h > H .", 9'000, kAtCreep},
    {24, kMiddle, 31'000, "<< H h > H .", 9'000, kAtCreep},
    {25, kMiddle, 0, ">> H h < H .", 15'000, kAtCreep},
    {25, kMiddle, -31'000, ">> H h < H .", 15'000, kAtCreep},
    {25, kMiddle, 12'000, ">> h < H .", 15'000, kAtCreep},
    {25, kMiddle, 20'000, ">> P << H .", 15'000, kAtSearch},
    {25, kMiddle, 31'000, "<< H .", 15'000, kAtSearch},
    {26, kMiddle, 0, ">> H > h .", 15'000, kAtCreep},
    {26, kMiddle, -31'000, ">> H > h .", 15'000, kAtCreep},
    {26, kMiddle, 12'000, "> h .", 15'000, kAtCreep},
    {26, kMiddle, 20'000, ">> P << H > h .", 15'000, kAtCreep},
    {26, kMiddle, 31'000, "<< H > h .", 15'000, kAtCreep},
};

// The same, mirrored: these methods search in negative direction first, and a start at the left
// reaches the negative limit switch.
const std::vector<PathRow> kNegativePaths{
    {11, kMiddle, 20'000, "<< H > h .", 16'384, kAtIndex},
    {11, kMiddle, 31'000, "<< H > h .", 16'384, kAtIndex},
    {11, kMiddle, 12'000, "> h .", 16'384, kAtIndex},
    {11, kMiddle, 0, "<< N >> H > h .", 16'384, kAtIndex},
    {11, kMiddle, -31'000, ">> H > h .", 16'384, kAtIndex},
    {12, kMiddle, 20'000, "<< H < .", 12'288, kAtIndex},
    {12, kMiddle, 31'000, "<< H < .", 12'288, kAtIndex},
    {12, kMiddle, 12'000, ">> h < H .", 12'288, kAtIndex},
    {12, kMiddle, 0, "<< N >> H h < H .", 12'288, kAtIndex},
    {12, kMiddle, -31'000, ">> H h < H .", 12'288, kAtIndex},
    {13, kMiddle, 20'000, "<< H h > H .", 12'288, kAtIndex},
    {13, kMiddle, 31'000, "<< H h > H .", 12'288, kAtIndex},
    {13, kMiddle, 12'000, "<< h > H .", 12'288, kAtIndex},
    {13, kMiddle, 0, "<< N >> H > .", 12'288, kAtIndex},
    {13, kMiddle, -31'000, ">> H > .", 12'288, kAtIndex},
    {14, kMiddle, 20'000, "<< H < h .", 8'192, kAtIndex},
    {14, kMiddle, 31'000, "<< H < h .", 8'192, kAtIndex},
    {14, kMiddle, 12'000, "< h .", 8'192, kAtIndex},
    {14, kMiddle, 0, "<< N >> H < h .", 8'192, kAtIndex},
    {14, kMiddle, -31'000, ">> H < h .", 8'192, kAtIndex},
    {27, kMiddle, 20'000, "<< H > h .", 15'000, kAtCreep},
    {27, kMiddle, 31'000, "<< H > h .", 15'000, kAtCreep},
    {27, kMiddle, 12'000, "> h .", 15'000, kAtCreep},
    {27, kMiddle, 0, "<< N >> H > h .", 15'000, kAtCreep},
    {27, kMiddle, -31'000, ">> H > h .", 15'000, kAtCreep},
    {28, kMiddle, 20'000, "<< H .", 15'000, kAtSearch},
    {28, kMiddle, 31'000, "<< H .", 15'000, kAtSearch},
    {28, kMiddle, 12'000, ">> h < H .", 15'000, kAtCreep},
    {28, kMiddle, 0, "<< N >> H h < H .", 15'000, kAtCreep},
    {28, kMiddle, -31'000, ">> H h < H .", 15'000, kAtCreep},
    {29, kMiddle, 20'000, "<< H h > H .", 9'000, kAtCreep},
    {29, kMiddle, 31'000, "<< H h > H .", 9'000, kAtCreep},
    {29, kMiddle, 12'000, "<< h > H .", 9'000, kAtCreep},
    {29, kMiddle, 0, "<< N >> H .", 9'000, kAtSearch},
    {29, kMiddle, -31'000, ">> H .", 9'000, kAtSearch},
    {30, kMiddle, 20'000, "<< H < h .", 9'000, kAtCreep},
    {30, kMiddle, 31'000, "<< H < h .", 9'000, kAtCreep},
    {30, kMiddle, 12'000, "< h .", 9'000, kAtCreep},
    {30, kMiddle, 0, "<< N >> H < h .", 9'000, kAtCreep},
    {30, kMiddle, -31'000, ">> H < h .", 9'000, kAtCreep},
};

std::string path_name(const testing::TestParamInfo<PathRow>& row) {
  const auto start = static_cast<int>(row.param.start);
  const int method = row.param.method;
  return (method < 0 ? "Minus" : "") + std::to_string(std::abs(method)) +
         (start < 0 ? "FromMinus" : "From") + std::to_string(std::abs(start));
}

INSTANTIATE_TEST_SUITE_P(LimitSwitch, HomingPath, testing::ValuesIn(kLimitPaths), path_name);
INSTANTIATE_TEST_SUITE_P(IndexPulse, HomingPath, testing::ValuesIn(kIndexPaths), path_name);
INSTANTIATE_TEST_SUITE_P(EndStop, HomingPath, testing::ValuesIn(kStopPaths), path_name);
INSTANTIATE_TEST_SUITE_P(HomeSwitchAtTheEnd, HomingPath, testing::ValuesIn(kStepPaths), path_name);
INSTANTIATE_TEST_SUITE_P(FirstPositive, HomingPath, testing::ValuesIn(kPositivePaths), path_name);
INSTANTIATE_TEST_SUITE_P(FirstNegative, HomingPath, testing::ValuesIn(kNegativePaths), path_name);

// From 34133 UU/s 609Ah = 409600 UU/s2 needs 1422 UU: the axis overruns a switch of 500 UU and
// comes back over its right edge; home is the left edge, as in the drawing.
TEST(HomingHomeSwitch, ThatIsNarrowerThanTheBrakingDistanceIsApproachedFromTheRightSide) {
  for (const int method : {7, 23}) {
    HomingCourse course(0, {.first = 9'000, .last = 9'500});
    ASSERT_NO_FATAL_FAILURE(course.home(method));
    EXPECT_EQ(course.way, ">> H h < H h .");
    EXPECT_NEAR(course.place, method == 7 ? 8'192 : 9'000, method == 7 ? kAtIndex : kAtCreep);
  }
}

TEST(HomingHomeSwitch, ThatIsMissedTwiceIsAnError) {
  for (int method = 7; method <= 14; ++method) {
    for (const int number : {method, method + 16}) {
      SCOPED_TRACE(number);
      HomingCourse course(0);
      course.start(number);
      ASSERT_TRUE(course.tick_until_phase(HomingCourse::kErrorStopped));
      EXPECT_EQ(course.way, method <= 10 ? ">> P << N" : "<< N >> P") << "both ends were searched";
      EXPECT_EQ(course.axis.state(), PowerState::operation_enabled) << "no fault";
      EXPECT_EQ(course.axis.demand_velocity(), 0);
    }
  }
}

// In these drawings the switch extends to the end of the travel, so there is no home switch to find
// beyond a limit switch.
TEST(HomingHomeSwitch, ThatIsMissedBeforeALimitSwitchIsAnErrorOfMethods3To6) {
  for (int method = 3; method <= 6; ++method) {
    for (const int number : {method, method + 16}) {
      SCOPED_TRACE(number);
      HomingCourse course(0);
      course.start(number);
      ASSERT_TRUE(course.tick_until_phase(HomingCourse::kErrorStopped));
      EXPECT_EQ(course.way, method <= 4 ? ">> P" : "<< N");
    }
  }
}

TEST(HomingHomeSwitch, WithALimitSwitchBeforeItsEdgeIsAnError) {
  // The switch stays active beyond the negative limit switch: method 7 never leaves it in that
  // direction.
  for (const int method : {7, 8, 13, 14}) {
    SCOPED_TRACE(method);
    HomingCourse course(-20'000, {.first = -kEndless, .last = -10'000});
    course.start(method);
    ASSERT_TRUE(course.tick_until_phase(HomingCourse::kErrorStopped));
    EXPECT_NE(course.way.find('N'), std::string::npos) << course.way;
  }
}

TEST(HomingHomeSwitch, IsNotSeenAgainByARunThatHasPassedItsEdge) {
  HomingCourse course(0, kMiddle);
  // On the way to the index pulse at 16384.
  ASSERT_NO_FATAL_FAILURE(course.start_until(10, ">> H > h"));
  course.axis.write("test_home_input", 1);
  course.tick();
  course.axis.write("test_home_input", 0);
  ASSERT_TRUE(course.tick_until_phase(HomingCourse::kDone));
  EXPECT_NEAR(course.place, 16'384, 2.0);
}

// Method 8 from the right: search, back from the limit switch, off the switch, onto it, index.
constexpr std::array<const char*, 5> kStagesOfMethod8{">>", ">> P <<", ">> P << H", ">> P << H h >",
                                                      ">> P << H h > H"};

TEST(HomingHomeSwitch, RunsContinueAfterAHaltInEachStage) {
  for (const char* const stage : kStagesOfMethod8) {
    SCOPED_TRACE(stage);
    HomingCourse course(20'000, kMiddle);
    ASSERT_NO_FATAL_FAILURE(course.start_until(8, stage));
    course.axis.controlword(0x011F);
    ASSERT_TRUE(course.tick_until_phase(HomingCourse::kIdle));
    course.axis.controlword(0x001F);
    ASSERT_TRUE(course.tick_until_phase(HomingCourse::kDone));
    EXPECT_NEAR(course.place, 12'288, 2.0);
  }
}

TEST(HomingHomeSwitch, RunsAreEndedByAHaltInEachStage) {
  for (const char* const stage : kStagesOfMethod8) {
    SCOPED_TRACE(stage);
    HomingCourse course(20'000, kMiddle);
    ASSERT_NO_FATAL_FAILURE(course.start_until(8, stage));
    course.axis.controlword(0x011F);
    ASSERT_TRUE(course.tick_until_phase(HomingCourse::kIdle));
    course.axis.controlword(0x000F);
    course.ticks(200);
    EXPECT_EQ(course.phase(), HomingCourse::kIdle);
    EXPECT_EQ(course.axis.demand_velocity(), 0);
    ASSERT_NO_FATAL_FAILURE(course.home(8)) << "a new edge starts anew";
    EXPECT_NEAR(course.place, 12'288, 2.0);
  }
}

TEST(HomingHomeSwitch, IsTheTestBenchInputWhereverTheAxisIs) {
  HomingCourse course(0);
  course.axis.write("test_home_input", 1);
  course.start(26);  // off it in positive direction
  course.ticks(100);
  EXPECT_EQ(course.phase(), HomingCourse::kRunning);
  EXPECT_EQ(course.axis.demand_velocity(), kCreep);
  const double place = course.place;
  course.axis.write("test_home_input", 0);
  ASSERT_TRUE(course.tick_until_phase(HomingCourse::kDone));
  EXPECT_NEAR(course.place, place, 2.0);
}

}  // namespace
}  // namespace vdrive
