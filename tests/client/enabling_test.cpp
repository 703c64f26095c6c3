// SPDX-License-Identifier: Apache-2.0
// After any call that enables them the axes rest, whatever another program has left in their
// targets. A jog leaves no velocity, however it ends.
#include "client/objects.hpp"
#include "support/bench_on_wire.hpp"
#include "vdrive/cia402/operating_mode.hpp"
#include "vdrive/client.hpp"
#include "vdrive/dictionary/dictionary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace vdrive::client {
namespace {

using test::options_on_wire;

/// Two axes in lock-step.
class LeftAxes : public testing::Test {
 protected:
  /// Writes a mode, and 200 to every target and offset, as a program may leave them when it dies.
  void leave(OperatingMode mode) {
    for (Axis& axis : axes_) {
      ASSERT_TRUE(axis.write(kMode, static_cast<std::int64_t>(mode)));
      for (const ObjectDescription& object : kObjectTable) {
        const bool is_target = object.role == Role::command && object.address != kControlword &&
                               object.address != kMode;
        if (is_target) ASSERT_TRUE(axis.write(object.address, 200)) << object.variable_name;
      }
    }
    ASSERT_TRUE(session_.step(1, 2));
  }

  /// @return the demands of both axes after enough time for a motion.
  std::array<std::int32_t, 2> demands_later() {
    EXPECT_TRUE(session_.step(1, 300));
    std::array<std::int32_t, 2> demands{};
    for (std::size_t i = 0; i < demands.size(); ++i) {
      const AxisSnapshot axis = axes_[i].status().value();
      EXPECT_EQ(axis.state(), PowerState::operation_enabled);
      demands.at(i) = axis.status.position_demand_value;
    }
    return demands;
  }

 private:
  test::BenchOnWire bench_{"--clock lockstep --axes 2"};

 protected:
  Session session_{options_on_wire()};
  std::vector<Axis> axes_ = *session_.axes(1);
};

/// A call that enables both axes.
struct EnablingCall {
  const char* name;
  Outcome (*enable)(Session& session, std::vector<Axis>& axes, bool keep_target);
};

constexpr std::array kEnablingCalls{
    EnablingCall{"Axis",
                 [](Session& /*session*/, std::vector<Axis>& axes, bool keep_target) {
                   for (Axis& axis : axes) {
                     if (Outcome done = axis.enable({.keep_target = keep_target}); !done)
                       return done;
                   }
                   return Outcome();
                 }},
    EnablingCall{"CommandEach",
                 [](Session& session, std::vector<Axis>& axes, bool keep_target) {
                   for (Outcome& done : session.command_each(axes, EachCommand::enable,
                                                             {.keep_target = keep_target})) {
                     if (!done) return done;
                   }
                   return Outcome();
                 }},
    EnablingCall{"AxisGroup",
                 [](Session& session, std::vector<Axis>& axes, bool keep_target) {
                   auto group = AxisGroup::create(session, axes);
                   return group ? group->enable_all({.keep_target = keep_target}) : group.outcome();
                 }},
};

class Enabling : public LeftAxes, public testing::WithParamInterface<EnablingCall> {
 protected:
  void enable(bool keep_target = false) {
    const Outcome enabled = GetParam().enable(session_, axes_, keep_target);
    ASSERT_TRUE(enabled) << enabled.message();
  }
};

TEST_P(Enabling, LetsTheAxesRestInEveryMode) {
  for (const OperatingModeRow& mode : kOperatingModes) {
    SCOPED_TRACE(mode.name);
    leave(mode.mode);
    enable();
    EXPECT_THAT(demands_later(), testing::Each(0));
    for (Axis& axis : axes_) ASSERT_TRUE(axis.disable());
  }
}

// The fault or the quick stop leaves the axis in its mode, with 60FFh = 200.
TEST_P(Enabling, LetsAnAxisRestThatAFaultOrAQuickStopHasStopped) {
  enable();
  for (const bool by_fault : {true, false}) {
    ASSERT_TRUE(axes_[0].run_at(200));
    if (by_fault) {
      ASSERT_TRUE(axes_[0].disturb(Disturbance::over_current));
      ASSERT_TRUE(session_.step(1, 100));
      ASSERT_TRUE(axes_[0].disturb(Disturbance::over_current, 0));
      ASSERT_TRUE(axes_[0].reset_fault());
    } else {
      ASSERT_TRUE(axes_[0].quick_stop());
    }
    enable();
    const auto before = demands_later();
    EXPECT_EQ(demands_later(), before);
  }
}

TEST_P(Enabling, KeepsTheTargetsWhereThatIsAskedFor) {
  for (const OperatingMode mode :
       {OperatingMode::profile_velocity, OperatingMode::profile_torque}) {
    SCOPED_TRACE(to_string(mode));
    leave(mode);
    enable(true);
    EXPECT_THAT(demands_later(), testing::Each(testing::Ne(0)));
    for (Axis& axis : axes_) ASSERT_TRUE(axis.quick_stop());
  }
}

// The axis keeps running.
TEST_P(Enabling, WritesNothingToAnAxisThatIsEnabled) {
  enable();
  ASSERT_TRUE(axes_[0].run_at(200));
  enable();
  EXPECT_EQ(axes_[0].read(kTargetVelocity).value(), 200);
  EXPECT_EQ(axes_[0].status().value().status.velocity_demand_value, 200);
}

INSTANTIATE_TEST_SUITE_P(Calls, Enabling, testing::ValuesIn(kEnablingCalls), [](const auto& info) {
  return std::string(info.param.name);
});

/// Something that happens to a jog in its 50th tick.
struct EndOfJog {
  const char* name;
  void (*end)(Session& session, Axis& axis);
};

constexpr std::array kEndsOfJog{
    EndOfJog{"Nothing", [](Session& /*session*/, Axis& /*axis*/) {}},
    EndOfJog{"Interrupt",
             [](Session& session, Axis& /*axis*/) {
               session.interrupt();
             }},
    EndOfJog{"QuickStopOfAnotherProgram",
             [](Session& /*session*/, Axis& /*axis*/) {
               Session other(options_on_wire());
               EXPECT_TRUE(other.quick_stop(1, {.until = Until::in_force}));
             }},
    EndOfJog{"HaltOfAnotherProgram",
             [](Session& /*session*/, Axis& /*axis*/) {
               Session other(options_on_wire());
               EXPECT_TRUE(other.axis("1.1")->halt({.until = Until::in_force}));
             }},
    EndOfJog{"Fault",
             [](Session& /*session*/, Axis& axis) {
               EXPECT_TRUE(axis.disturb(Disturbance::over_current));
             }},
    EndOfJog{"LossOfControl",
             [](Session& /*session*/, Axis& /*axis*/) {
               Session other(options_on_wire());
               EXPECT_TRUE(other.axis("1.1")->take_over());
             }},
    EndOfJog{"Exception",
             [](Session& /*session*/, Axis& /*axis*/) {
               throw 1;
             }},
};

class JoggedAxis : public LeftAxes, public testing::WithParamInterface<EndOfJog> {};

TEST_P(JoggedAxis, HasNoVelocityLeftAndRestsWhenItIsEnabledAgain) {
  Axis& axis = axes_[0];
  ASSERT_TRUE(axis.enable());
  int ticks = 0;
  try {
    (void)axis.jog(2'048, [&](const AxisSnapshot& seen) {
      if (++ticks == 50) {
        EXPECT_NE(seen.status.velocity_demand_value, 0);
        GetParam().end(session_, axis);
      }
      return ticks < 60;  // then the operator releases the button
    });
  } catch (int) {
  }
  ASSERT_GE(ticks, 50) << "the jog ran";
  session_.end_interrupt();
  ASSERT_TRUE(session_.step(1, 500));
  EXPECT_EQ(axis.read(kTargetVelocity).value(), 0);
  ASSERT_TRUE(axis.end_disturbances());
  ASSERT_TRUE(axis.reset_fault());
  ASSERT_TRUE(axis.enable({.keep_target = true}));
  const AxisSnapshot stands = axis.status().value();
  ASSERT_TRUE(session_.step(1, 300));
  EXPECT_EQ(axis.status().value().status.position_demand_value,
            stands.status.position_demand_value);
}

INSTANTIATE_TEST_SUITE_P(Ends, JoggedAxis, testing::ValuesIn(kEndsOfJog), [](const auto& info) {
  return std::string(info.param.name);
});

}  // namespace
}  // namespace vdrive::client
