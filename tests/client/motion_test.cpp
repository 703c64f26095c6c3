// SPDX-License-Identifier: Apache-2.0
// Events that make a Motion or a waiting call fail. Of competing motions, one succeeds.
#include "client/objects.hpp"
#include "support/bench_on_wire.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/axis_group.hpp"
#include "vdrive/client/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <barrier>
#include <future>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <thread>
#include <vector>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::options_on_wire;
using testing::AllOf;
using testing::HasSubstr;

constexpr std::int32_t kFar = 50'000;  // takes 2.5 s at the speed of kSlow
constexpr CallOptions kInForce{.until = Until::in_force};
const MoveOptions kSlow{.velocity = 20'000};
const MoveOptions kQueued{.velocity = 20'000, .queue = true};

/// Two axes in lock-step; two sessions may command the first.
class MotionOfAnAxis : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(axis_.enable());
    ASSERT_TRUE(second_.enable());
  }

  /// Starts a move to kFar.
  Motion moving() {
    auto motion = axis_.start_move(kFar, kSlow).value();
    session_.step(1, 100).outcome().or_throw();
    EXPECT_FALSE(motion.has_ended().value());
    return motion;
  }

  void write(ObjectAddress object, std::int64_t value) {
    axis_.write(object, value).outcome().or_throw();
  }

 private:
  test::BenchOnWire bench_{"--clock lockstep --axes 3"};

 protected:
  Session session_{options_on_wire()};
  Session other_{options_on_wire()};
  Axis axis_ = session_.axis("1.1").value();
  Axis second_ = session_.axis("1.2").value();
  Axis others_ = other_.axis("1.1").value();
};

/// An action of this session or another one while an axis moves.
struct Deed {
  std::string name;
  void (*run)(Session& session, Axis& axis, Axis& others);
  std::string cause{};  ///< in the message of the motion; empty = the motion continues
};

std::ostream& operator<<(std::ostream& out, const Deed& result_record) {
  return out << result_record.name;
}

SetPointFrame frame_of(SetPoint point) {
  return {.tick = 0, .axes = {std::move(point)}};
}

void run_group(Session& session, Outcome (AxisGroup::*call)(const GroupCallOptions&)) {
  const std::array names{std::string("1.1")};
  AxisGroup group = AxisGroup::create(session, names).value();
  (group.*call)({}).or_throw();
}

void write(Axis& axis, ObjectAddress object, std::int64_t value) {
  axis.write(object, value).outcome().or_throw();
}

const std::vector<Deed> kDeeds{
    {"ALaterMove",
     [](Session&, Axis& axis, Axis&) {
       axis.start_move(-5'000).outcome().or_throw();
     },
     "607Ah = -5000"},
    {"ALaterMoveToTheSameTarget",
     [](Session&, Axis& axis, Axis&) {
       axis.start_move(kFar).outcome().or_throw();
     },
     "607Ah = 50000"},
    {"AQueuedMove",
     [](Session&, Axis& axis, Axis&) {
       axis.start_move(-5'000, kQueued).outcome().or_throw();
     },
     "607Ah = -5000"},
    {"AMoveByADistance",
     [](Session&, Axis& axis, Axis&) {
       axis.move_by(100, {.call = kInForce}).or_throw();
     },
     "607Ah = 100"},
    {"AVelocity",
     [](Session&, Axis& axis, Axis&) {
       axis.run_at(1'000, {.call = kInForce}).or_throw();
     },
     "profile velocity mode (6060h = 3)"},
    {"ATorque",
     [](Session&, Axis& axis, Axis&) {
       axis.apply_torque(5, {.call = kInForce}).or_throw();
     },
     "profile torque mode (6060h = 4)"},
    {"AHomingRun",
     [](Session&, Axis& axis, Axis&) {
       axis.home({.method = 37}).or_throw();
     },
     "homing mode (6060h = 6)"},
    {"AJog",
     [](Session&, Axis& axis, Axis&) {
       axis.jog(1'000,
                [](const AxisSnapshot&) {
                  return false;
                })
           .or_throw();
     },
     "profile velocity mode (6060h = 3)"},
    {"AQuickStop",
     [](Session&, Axis& axis, Axis&) {
       axis.quick_stop().or_throw();
     },
     "quick stop (6040h = 0x0002)"},
    {"AQuickStopAndAnEnable",
     [](Session&, Axis& axis, Axis&) {
       axis.quick_stop().or_throw();
       axis.enable().or_throw();
     },
     "quick stop (6040h = 0x0002)"},
    {"ADisable",
     [](Session&, Axis& axis, Axis&) {
       axis.disable().or_throw();
     },
     "shutdown (6040h = 0x0006)"},
    {"APowerCycleAndAnEnable",
     [](Session&, Axis& axis, Axis&) {
       axis.power_cycle().or_throw();
       axis.enable().or_throw();
     },
     "a power cycle"},
    {"AHalt",
     [](Session&, Axis& axis, Axis&) {
       axis.halt().or_throw();
     },
     "was halted"},
    {"AQuickStopOfItsGroup",
     [](Session& session, Axis&, Axis&) {
       run_group(session, &AxisGroup::quick_stop_all);
     },
     "quick stop (6040h = 0x0002)"},
    {"ADisableOfItsGroup",
     [](Session& session, Axis&, Axis&) {
       run_group(session, &AxisGroup::disable_all);
     },
     "shutdown (6040h = 0x0006)"},
    {"AHaltOfItsGroup",
     [](Session& session, Axis&, Axis&) {
       run_group(session, &AxisGroup::halt_all);
     },
     "was halted"},
    {"AWrittenMode",
     [](Session&, Axis& axis, Axis&) {
       write(axis, kMode, 4);
     },
     "profile torque mode (6060h = 4)"},
    {"NoMode",
     [](Session&, Axis& axis, Axis&) {
       write(axis, kMode, 0);
     },
     "mode (6060h = 0)"},
    {"AWrittenSetPoint",
     [](Session&, Axis& axis, Axis&) {
       write(axis, kTarget, 700);
       write(axis, kControlword, 0x3F);
     },
     "a later set-point (6040h = 0x003F)"},
    {"AWrittenQuickStop",
     [](Session&, Axis& axis, Axis&) {
       write(axis, kControlword, 0x02);
     },
     "quick stop (6040h = 0x0002)"},
    {"AWrittenDisableOperation",
     [](Session&, Axis& axis, Axis&) {
       write(axis, kControlword, 0x07);
       write(axis, kControlword, 0x0F);
     },
     "disable operation (6040h = 0x0007)"},
    {"AFrameWithAMode",
     [](Session& session, Axis&, Axis&) {
       const std::array frames{frame_of(
           {.axis = 1, .mode = OperatingMode::cyclic_synchronous_position, .position = 100})};
       session.send_set_points(1, frames).or_throw();
     },
     "cyclic synchronous position mode (6060h = 8)"},
    {"AFrameWithASetPoint",
     [](Session& session, Axis&, Axis&) {
       const std::array frames{frame_of({.axis = 1, .position = 800, .controlword = 0x3F})};
       session.send_set_points(1, frames).or_throw();
     },
     "a later set-point (6040h = 0x003F, 607Ah = 800)"},
    {"ARestoredSnapshot",
     [](Session& session, Axis&, Axis&) {
       const std::uint64_t snapshot = session.take_snapshot(1).value();
       session.restore_snapshot(1, snapshot).outcome().or_throw();
     },
     "a restored snapshot"},
    {"ARelease",
     [](Session& session, Axis&, Axis&) {
       session.release(1).or_throw();
     },
     "control of it was released or taken over"},
    {"ATakeOver",
     [](Session&, Axis&, Axis& others) {
       others.take_over().or_throw();
     },
     "has taken the axis"},
    {"AMoveOfAnotherSession",
     [](Session&, Axis&, Axis& others) {
       others.take_over().or_throw();
       others.start_move(kFar).outcome().or_throw();
     },
     "has taken the axis"},
    {"AMoveOfAnotherSessionThatGaveTheAxisBack",
     [](Session& session, Axis& axis, Axis& others) {
       others.take_over().or_throw();
       others.start_move(kFar).outcome().or_throw();
       axis.take_over().or_throw();
       session.step(1, 1).outcome().or_throw();
     },
     "a new acquisition of the axis"},
    {"AMoveOfAnotherSessionBeforeAResume",
     [](Session&, Axis& axis, Axis& others) {
       others.take_over().or_throw();
       others.start_move(kFar).outcome().or_throw();
       axis.take_over().or_throw();
       axis.resume(kInForce).or_throw();
     },
     "a new acquisition of the axis"},
    {"AQuickStopOfAnotherSession",
     [](Session&, Axis& axis, Axis& others) {
       others.quick_stop().or_throw();
       axis.enable().or_throw();
     },
     "shutdown (6040h = 0x0006)"},
    {"AQuickStopOfAnotherSessionThatKeepsTheState",
     [](Session&, Axis& axis, Axis& others) {
       write(axis, {0x605A, 0}, 6);
       others.quick_stop().or_throw();
       write(axis, kControlword, 0x0F);
     },
     "was ended by something else"},
    {"AHaltOfAnotherSession",
     [](Session&, Axis&, Axis& others) {
       others.halt().or_throw();
     },
     "was halted"},
    // ---- without effect on the motion
    {"ARead",
     [](Session&, Axis& axis, Axis&) {
       axis.read(kTarget).outcome().or_throw();
     }},
    {"AnEnable",
     [](Session&, Axis& axis, Axis&) {
       axis.enable().or_throw();
     }},
    {"AnotherRamp",
     [](Session&, Axis& axis, Axis&) {
       write(axis, kDeceleration, 100'000);
     }},
    {"ATargetWithoutAnEdge",
     [](Session&, Axis& axis, Axis&) {
       write(axis, kTarget, 7);
     }},
    {"AVelocityOfAnotherMode",
     [](Session&, Axis& axis, Axis&) {
       write(axis, kTargetVelocity, 7);
     }},
    {"TheSameMode",
     [](Session&, Axis& axis, Axis&) {
       write(axis, kMode, 1);
     }},
    {"AHaltAndAResume",
     [](Session&, Axis& axis, Axis&) {
       axis.halt().or_throw();
       axis.resume(kInForce).or_throw();
     }},
    {"AHaltOfAnotherSessionAndAResume",
     [](Session&, Axis& axis, Axis& others) {
       others.halt().or_throw();
       axis.resume(kInForce).or_throw();
     }},
    {"ControlThatIsTakenTwice",
     [](Session&, Axis& axis, Axis&) {
       axis.take_over().or_throw();
     }},
    {"AnAcquisitionOfItWithAFreeAxis",
     [](Session& session, Axis&, Axis&) {
       const std::array axes{AxisId{1, 1}, AxisId{1, 3}};
       session.acquire(axes).or_throw();
     }},
    {"AModeThatTheDriveRefuses",
     [](Session& session, Axis& axis, Axis&) {
       write(axis, {0x5E20, 5}, 2);  // no 6060h while in Operation enabled
       const std::array frames{
           frame_of({.axis = 1, .mode = OperatingMode::homing, .position = kFar})};
       session.send_set_points(1, frames).or_throw();
     }},
    {"AMoveOfAnotherAxis",
     [](Session& session, Axis&, Axis&) {
       session.axis("1.2").value().start_move(100).outcome().or_throw();
     }},
    {"ARefusedLineOfItsGroup",
     [](Session& session, Axis&, Axis&) {
       const std::array names{std::string("1.1"), std::string("1.2")};
       AxisGroup group = AxisGroup::create(session, names).value();
       EXPECT_EQ(group.move_together(Eigen::Vector2d(1, 2)).code(), kRefusedInState);
     }},
    {"ARefusedCommand",
     [](Session&, Axis& axis, Axis& others) {
       EXPECT_EQ(others.run_at(1'000).kind(), OutcomeKind::refused);
       EXPECT_FALSE(axis.write(kMode, 55));
     }},
};

class OneMotion : public MotionOfAnAxis, public testing::WithParamInterface<Deed> {};

TEST_P(OneMotion, EndsByWhatComesAfterItAndSaysByWhat) {
  const Deed& result_record = GetParam();
  const Motion motion = moving();
  result_record.run(session_, axis_, others_);
  const bool is_taken = result_record.cause.find("taken the axis") != std::string::npos;
  // After 5,000 ticks everything that the deed started is over. An axis that was taken gets only
  // 50, because its new owner is silent and would lose it.
  session_.step(1, is_taken ? 50 : 5'000).outcome().or_throw();
  const auto ended = motion.has_ended();
  const Outcome waited = motion.wait();
  if (result_record.cause.empty()) {
    EXPECT_TRUE(ended && *ended) << ended.outcome().message();
    EXPECT_TRUE(waited) << waited.message();
    EXPECT_EQ(axis_.status()->status.position_demand_value, kFar);
    return;
  }
  EXPECT_EQ(waited.kind(), is_taken ? OutcomeKind::refused : OutcomeKind::failed);
  EXPECT_THAT(waited.message(), HasSubstr(result_record.cause));
  ASSERT_FALSE(ended);
  EXPECT_THAT(ended.outcome().message(), HasSubstr(result_record.cause));
}

INSTANTIATE_TEST_SUITE_P(Deeds, OneMotion, testing::ValuesIn(kDeeds), [](const auto& row) {
  return row.param.name;
});

/// A call that waits in another thread while a new move starts.
struct Waiting {
  std::string name;
  Outcome (*run)(Axis& axis);
  std::string cause;
};

TEST_F(MotionOfAnAxis, ACallThatWaitsEndsByTheCommandOfAnotherThread) {
  const std::vector<Waiting> calls{
      {"a move",
       [](Axis& axis) {
         return axis.move_to(kFar, kSlow);
       },
       "607Ah = -700"},
      {"a move by a distance",
       [](Axis& axis) {
         return axis.move_by(kFar, kSlow);
       },
       "607Ah = -700"},
      {"a velocity",
       [](Axis& axis) {
         return axis.run_at(30'000, {.acceleration = 10'000});
       },
       "profile position mode"},
      {"a homing run",
       [](Axis& axis) {
         return axis.home({.method = 1, .search_speed = 500});
       },
       "profile position mode"},
      {"a jog",
       [](Axis& axis) {
         return axis.jog(5'000, [](const AxisSnapshot&) {
           return true;
         });
       },
       "profile position mode"},
  };
  for (const Waiting& call : calls) {
    SCOPED_TRACE(call.name);
    auto waiting = std::async(std::launch::async, [&] {
      Axis axis = axis_;
      return call.run(axis);
    });
    // Only the other thread lets time pass; this one just observes.
    while (axis_.status()->status.velocity_demand_value == 0 &&
           waiting.wait_for(0s) != std::future_status::ready) {
      std::this_thread::yield();
    }
    const auto motion = axis_.start_move(-700);
    ASSERT_TRUE(motion) << motion.outcome().message();
    const Outcome ended = waiting.get();
    EXPECT_EQ(ended.kind(), OutcomeKind::failed);
    EXPECT_THAT(ended.message(), AllOf(HasSubstr("superseded by"), HasSubstr(call.cause)));
    const Outcome reached = motion->wait();
    EXPECT_TRUE(reached) << reached.message();
    EXPECT_EQ(axis_.status()->status.position_demand_value, -700);
  }
}

TEST_F(MotionOfAnAxis, AVelocityThatIsWaitedForEndsByAFrameWithAnother) {
  auto waiting = std::async(std::launch::async, [&] {
    Axis axis = axis_;
    return axis.run_at(30'000, {.acceleration = 1'000});
  });
  while (axis_.status()->status.velocity_demand_value == 0 &&
         waiting.wait_for(0s) != std::future_status::ready) {
    std::this_thread::yield();
  }
  // A target of another mode ends nothing.
  ASSERT_TRUE(axis_.write(kTarget, 5));
  const std::array frames{frame_of({.axis = 1, .velocity = 100, .torque = 5})};
  ASSERT_TRUE(session_.send_set_points(1, frames));
  const Outcome ended = waiting.get();
  EXPECT_EQ(ended.kind(), OutcomeKind::failed);
  EXPECT_THAT(ended.message(), HasSubstr("superseded by a write of target_velocity (60FFh)"));
}

TEST_F(MotionOfAnAxis, ALineLeavesAxesThatAnotherThreadHasMovedToIt) {
  const std::array all{std::string("1.1"), std::string("1.2"), std::string("1.3")};
  AxisGroup group = AxisGroup::create(session_, all).value();
  ASSERT_TRUE(group.enable_all());
  auto waiting = std::async(std::launch::async, [&] {
    return group.move_together(Eigen::Vector3d(kFar, kFar, kFar),
                               {.velocity_factor = 0.02, .call = {}});
  });
  while (axis_.status()->status.velocity_demand_value == 0 &&
         waiting.wait_for(0s) != std::future_status::ready) {
    std::this_thread::yield();
  }
  SetPointFrame frame = frame_of({.axis = 1, .position = -700, .controlword = 0x3F});
  frame.axes.push_back({.axis = 2, .position = -700, .controlword = 0x3F});
  ASSERT_TRUE(session_.send_set_points(1, {&frame, 1}));
  EXPECT_EQ(waiting.get().kind(), OutcomeKind::failed);
  ASSERT_TRUE(session_.step(1, 5'000));
  EXPECT_EQ(axis_.status()->status.position_demand_value, -700);
  EXPECT_EQ(second_.status()->status.position_demand_value, -700);
  EXPECT_NE(session_.axis("1.3")->status()->state(), PowerState::operation_enabled)
      << "it is stopped";
}

TEST_F(MotionOfAnAxis, ALineEndsAndStopsItsOtherAxesByAnotherCommandForOneOfThem) {
  const std::array names{std::string("1.1"), std::string("1.2")};
  AxisGroup group = AxisGroup::create(session_, names).value();
  for (const bool polls : {false, true}) {
    SCOPED_TRACE(polls ? "poll" : "wait_all");
    ASSERT_TRUE(group.enable_all());
    ASSERT_TRUE(group.queue_move(Eigen::Vector2d(polls ? 0 : kFar, polls ? 0 : kFar)));
    ASSERT_TRUE(group.poll());
    ASSERT_TRUE(session_.step(1, 100));
    const auto motion = axis_.start_move(1'000);
    ASSERT_TRUE(motion);
    const Outcome ended = polls ? group.poll().outcome() : group.wait_all();
    EXPECT_EQ(ended.kind(), OutcomeKind::failed);
    EXPECT_THAT(ended.message(), HasSubstr("axis 1.1: superseded by a later set-point"));
    ASSERT_TRUE(session_.step(1, 1'000));
    EXPECT_NE(second_.status()->state(), PowerState::operation_enabled) << "it is stopped";
    const Outcome reached = motion->wait();
    EXPECT_TRUE(reached) << "it is left to the later command: " << reached.message();
  }
}

TEST_F(MotionOfAnAxis, TwoThreadsThatMoveItHaveOneSuccess) {
  constexpr int kRounds = 20;
  constexpr std::array<std::int32_t, 2> kTargets{3'000, -3'000};
  for (int round = 0; round < kRounds; ++round) {
    std::barrier have_started(2);
    std::array<std::optional<Outcome>, 2> outcomes;
    std::array<std::jthread, 2> threads;
    for (std::size_t i = 0; i < threads.size(); ++i) {
      threads[i] = std::jthread([&, i] {
        Axis axis = axis_;
        const auto motion = axis.start_move(kTargets[i]);
        have_started.arrive_and_wait();
        outcomes[i] = motion ? motion->wait() : motion.outcome();
      });
    }
    for (std::jthread& thread : threads) thread.join();
    const auto successes = std::ranges::count_if(outcomes, [](const auto& outcome) {
      return static_cast<bool>(*outcome);
    });
    ASSERT_EQ(successes, 1) << outcomes[0]->message() << " / " << outcomes[1]->message();
    const std::size_t winner = *outcomes[0] ? 0 : 1;
    EXPECT_EQ(axis_.status()->status.position_demand_value, kTargets[winner]);
    EXPECT_THAT(outcomes[1 - winner]->message(), HasSubstr("superseded by a later set-point"));
  }
}

// A drive has room for one set-point besides the present one.
TEST_F(MotionOfAnAxis, GoesOnWhereALaterSetPointIsIgnored) {
  ASSERT_TRUE(axis_.start_move(20'000, kSlow));
  const auto motion = axis_.start_move(1'000, kQueued);
  ASSERT_TRUE(motion);
  EXPECT_EQ(axis_.start_move(2'000, kQueued).outcome().code(), kRefusedInState);
  const Outcome reached = motion->wait();
  EXPECT_TRUE(reached) << reached.message();
  EXPECT_EQ(axis_.status()->status.position_demand_value, 1'000);
}

TEST_F(MotionOfAnAxis, FailsWhereASoftwareLimitHasCutItOff) {
  write(kUpperLimit, 1'000);
  write(kLimitSwitch, 1);
  ASSERT_TRUE(session_.step(1, 1));
  const auto motion = axis_.start_move(8'000);
  ASSERT_TRUE(motion);
  EXPECT_THAT(motion->wait().message(),
              AllOf(HasSubstr("software limit"), HasSubstr("(607Dh:2) = 1000 UU"),
                    HasSubstr("the move to 8000 UU")));
  EXPECT_FALSE(motion->has_ended());
}

// 607Bh is 0 to below 36000, so 40000 is the same position as 4000.
TEST_F(MotionOfAnAxis, OfAModuloAxisEndsAtItsPlace) {
  write({0x607B, 1}, 0);
  write({0x607B, 2}, 36'000);
  ASSERT_TRUE(session_.step(1, 1));
  const auto motion = axis_.start_move(40'000);
  ASSERT_TRUE(motion);
  const Outcome reached = motion->wait();
  EXPECT_TRUE(reached) << reached.message();
}

TEST(MotionOfAnEarlierRun, IsLost) {
  auto bench = std::make_unique<test::BenchOnWire>("--clock lockstep");
  Session session(options_on_wire());
  Axis axis = session.axis("1.1").value();
  ASSERT_TRUE(axis.enable());
  const auto motion = axis.start_move(100);
  ASSERT_TRUE(motion);
  bench.reset();
  bench = std::make_unique<test::BenchOnWire>("--clock lockstep");
  EXPECT_EQ(motion->wait().kind(), OutcomeKind::lost);
}

TEST(MotionOfAPausedBench, GoesOnAndEndsAfterThePause) {
  const test::BenchOnWire bench("--clock realtime");
  Session session(options_on_wire());
  Axis axis = session.axis("1.1").value();
  ASSERT_TRUE(axis.enable());
  const Motion motion = axis.start_move(kFar / 10, kSlow).value();
  ASSERT_TRUE(session.set_rate(1, 0.0));
  const auto ended = motion.has_ended();
  ASSERT_TRUE(ended) << ended.outcome().message();
  ASSERT_TRUE(session.set_rate(1, 1.0));
  const Outcome reached = motion.wait();
  EXPECT_TRUE(reached) << reached.message();
}

}  // namespace
}  // namespace vdrive::client
