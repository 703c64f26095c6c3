// SPDX-License-Identifier: Apache-2.0
#include "jogs.hpp"

#include "support/bench_on_wire.hpp"
#include "vdrive/client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <memory>
#include <string>

namespace vdrive::gateway {
namespace {

using namespace std::chrono_literals;
using client::Outcome;
using client::OutcomeKind;
using testing::HasSubstr;

constexpr ObjectAddress kTargetVelocity{0x60FF, 0};

/// A client that jogs axis 1.1 of a bench in lock-step. The bench runs while the axis jogs.
class JogsOfAClient : public testing::Test {
 protected:
  /// @param ago age of the request, which is valid for kHeldTime; negative = in the future
  Outcome request(std::int32_t velocity, std::chrono::milliseconds ago = 0ms,
                  const std::string& axis = "1.1") {
    auto answered = std::make_shared<std::promise<Outcome>>();
    jogs_.request({.axis = axis, .velocity = velocity}, Jogs::Clock::now() - ago,
                  [answered](const CallAnswer& answer) {
                    answered->set_value(answer.outcome);
                  });
    auto answer = answered->get_future();
    if (answer.wait_for(20s) != std::future_status::ready) return Outcome::timed_out("no answer");
    return answer.get();
  }

  /// Repeats the request like a held button until it is refused.
  Outcome hold_until_refused(std::int32_t velocity) {
    const auto deadline = Jogs::Clock::now() + 20s;
    Outcome outcome = request(velocity);
    while (outcome && Jogs::Clock::now() < deadline) outcome = request(velocity);
    return outcome;
  }

  void expect_rest() {
    ASSERT_TRUE(session_->step(1, 300));
    EXPECT_EQ(axis_.status()->status.velocity_demand_value, 0);
    EXPECT_EQ(axis_.read(kTargetVelocity).value(), 0);
  }

 private:
  test::BenchOnWire bench_{"--clock lockstep"};

 protected:
  SessionPointer session_ = std::make_shared<client::Session>(test::options_on_wire());
  client::Axis axis_ = session_->axis("1.1").value();
  Jogs jogs_{session_};
};

TEST_F(JogsOfAClient, RunWhileTheButtonIsHeldAndAgainAfterItWasLetGo) {
  ASSERT_TRUE(axis_.enable());
  for (int press = 0; press < 2; ++press) {
    ASSERT_TRUE(request(1'000, -20s)) << "held for longer than a busy machine takes";
    EXPECT_TRUE(request(1'000));
    EXPECT_TRUE(request(0));
    expect_rest();
  }
}

// The page stalls for longer than the gateway waits, then continues with the button still held.
TEST_F(JogsOfAClient, NeedANewPressAfterASilence) {
  ASSERT_TRUE(axis_.enable());
  ASSERT_TRUE(request(1'000, Jogs::kHeldTime));
  const Outcome ended = request(1'000);
  EXPECT_EQ(ended.kind(), OutcomeKind::failed);
  EXPECT_THAT(ended.message(), HasSubstr("release (velocity 0), then press again"));
  jogs_.forget_ended();
  EXPECT_FALSE(request(1'000)) << "the button is still held";
  EXPECT_TRUE(request(0));
  expect_rest();
  EXPECT_TRUE(request(1'000)) << "a new press";
  EXPECT_TRUE(request(0));
}

TEST_F(JogsOfAClient, NeedANewPressAfterAStopOfAnotherProgram) {
  ASSERT_TRUE(axis_.enable());
  ASSERT_TRUE(request(1'000, -20s)) << "held for longer than the other program takes";
  client::Session other(test::options_on_wire());
  ASSERT_TRUE(other.quick_stop(1, {.until = client::Until::in_force}));
  EXPECT_EQ(hold_until_refused(1'000).kind(), OutcomeKind::failed);
  EXPECT_TRUE(request(0));
  ASSERT_TRUE(axis_.enable({.keep_target = true}));
  expect_rest();
}

// Another program enables the axis while the button is held.
TEST_F(JogsOfAClient, NeedANewPressWhereTheFirstWasRefused) {
  const Outcome refused = request(1'000);
  EXPECT_EQ(refused.kind(), OutcomeKind::refused);
  EXPECT_THAT(refused.message(), HasSubstr("a jog needs Operation enabled"));
  ASSERT_TRUE(axis_.enable());
  EXPECT_EQ(hold_until_refused(1'000).kind(), OutcomeKind::failed);
  expect_rest();
  EXPECT_TRUE(request(0));
  EXPECT_TRUE(request(1'000));
  EXPECT_TRUE(request(0));
}

// The other axes do not exist; each of their buttons is pressed once and never released.
TEST_F(JogsOfAClient, GiveAnotherAxisThePlaceOfOneWhoseRequestIsNotRepeated) {
  ASSERT_TRUE(axis_.enable());
  for (std::size_t i = 0; i < Jogs::kMostAxes; ++i) {
    EXPECT_FALSE(request(1'000, -20s, "1." + std::to_string(100 + i)));
  }
  EXPECT_THAT(request(1'000).message(), HasSubstr("32 axes are already being jogged"));
  EXPECT_TRUE(request(1'000, -60s)) << "40 s after the others";
  EXPECT_TRUE(request(0));
}

}  // namespace
}  // namespace vdrive::gateway
