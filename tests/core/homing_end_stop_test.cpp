// SPDX-License-Identifier: Apache-2.0
// Homing on a mechanical stop, methods -1 to -4, against the end stops of the model.
#include "core/support/axis_under_test.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

namespace vdrive {
namespace {

using test::AxisUnderTest;

constexpr double kEndStop = 5'000.0;  // on both sides of the start [UU]

struct EndStopRow {
  int method;
  Coupling coupling;
  double noise = 0.0;  // of both encoders, root mean square [UU]
};

class HomingEndStop : public testing::TestWithParam<EndStopRow> {
 protected:
  static AxisConfiguration machine() {
    AxisConfiguration configuration;
    configuration.model.coupling = GetParam().coupling;
    configuration.model.encoder_noise = GetParam().noise;
    configuration.model.load_encoder_noise = GetParam().noise;
    configuration.model.lower_end_stop = -kEndStop;
    configuration.model.upper_end_stop = kEndStop;
    return configuration;
  }

  /// Runs homing to its end. @return the place at which it found home, in the frame before the run.
  static double home(AxisUnderTest& axis) {
    axis.write("op_mode_cmd", 6);
    axis.write("homing_method", GetParam().method);
    axis.command(0x000F);
    axis.step();
    axis.controlword(0x001F);
    std::int32_t before = axis.actual();
    const std::uint64_t ticks = axis.step_until(
        [&axis, &before] {
          const bool attained = (axis.statusword() & 0x1000U) != 0;
          if (!attained) before = axis.actual();
          return attained;
        },
        20'000);
    EXPECT_NE(ticks, 0U) << "status " << std::hex << axis.statusword();
    // In the tick in which home is found, 6064h changes by the distance moved, and also jumps to
    // the new frame, which is 0 at home.
    const double found = before - (axis.actual() - axis.velocity() * axis.seconds_per_tick());
    EXPECT_NE(axis.step_until_status(0x3400, 0x1400, 20'000), 0U);
    axis.step(500);
    return found;
  }
};

// The load stays at the stop, which does not give way: 6064h is the position of the load, and home
// is at the stop. The index pulse that follows is exact.
TEST_P(HomingEndStop, IsFoundWhereItStands) {
  AxisUnderTest axis(machine());
  const double found = home(axis);
  const double direction = GetParam().method % 2 == 0 ? 1.0 : -1.0;
  if (GetParam().method > -3) {
    EXPECT_NEAR(found, direction * 4'096.0, 3.0);
  } else {
    EXPECT_NEAR(found, direction * kEndStop, 3.0);
  }
  EXPECT_EQ(axis.demand(), 0);
  EXPECT_NEAR(axis.actual(), 0, 100);
  EXPECT_EQ(axis.state(), PowerState::operation_enabled);
}

TEST_P(HomingEndStop, IsFoundAtTheSamePlaceAgain) {
  AxisUnderTest axis(machine());
  home(axis);
  EXPECT_NEAR(home(axis), 0.0, 3.0);
}

// Noise of 0.05 UU makes √2 · 0.05 UU / 1 ms = 71 UU/s in 606Ch, and 606Fh is 10 UU/s: standstill
// is judged from the position, which changes by less than 606Fh · 5E18h:02 = 1 UU.
INSTANTIATE_TEST_SUITE_P(
    Homing, HomingEndStop,
    testing::Values(EndStopRow{-1, Coupling::rigid}, EndStopRow{-2, Coupling::rigid},
                    EndStopRow{-3, Coupling::rigid}, EndStopRow{-4, Coupling::rigid},
                    EndStopRow{-1, Coupling::two_inertia}, EndStopRow{-2, Coupling::two_inertia},
                    EndStopRow{-3, Coupling::two_inertia}, EndStopRow{-4, Coupling::two_inertia},
                    EndStopRow{-1, Coupling::rigid, 0.05}, EndStopRow{-3, Coupling::rigid, 0.05}),
    [](const auto& row) {
      return std::string(row.param.noise != 0.0 ? "Noisy" : "") +
             (row.param.coupling == Coupling::rigid ? "Rigid" : "Elastic") + "Minus" +
             std::to_string(-row.param.method);
    });

}  // namespace
}  // namespace vdrive
