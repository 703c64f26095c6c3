// SPDX-License-Identifier: Apache-2.0
// Which session has control of an axis: acquired, released, given up.
#include "support/bench_on_wire.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <stdexcept>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using test::BenchOnWire;
using test::options_on_wire;

TEST(LeavingMaster, CausesNoReactionAfterItReleasedItsAxis) {
  const BenchOnWire bench("--clock realtime --axes 1");
  Session observer(options_on_wire());
  Axis seen = *observer.axis("1.1");
  {
    Session leaving(options_on_wire());
    Axis axis = *leaving.axis("1.1");
    ASSERT_TRUE(axis.enable());
  }                                       // the end of a session releases its axes
  ASSERT_TRUE(observer.wait(1, 1500ms));  // three times the watchdog's time-out
  const auto status = seen.status();
  EXPECT_EQ(status->state(), PowerState::operation_enabled);
  EXPECT_EQ(status->status.error_code, 0);
  EXPECT_EQ(status->owner_session, 0U);
}

TEST(SessionOptions, RefuseATooShortSilenceTime) {
  SessionOptions hasty = options_on_wire();
  hasty.silence = 49ms;
  EXPECT_THROW(Session{hasty}, std::runtime_error);
}

TEST(SessionOptions, RefuseAReceiveCoalescingOutOfRange) {
  for (const auto coalescing : {-1ms, 21ms}) {
    SessionOptions late = options_on_wire();
    late.receive_coalescing = coalescing;
    EXPECT_THROW(Session{late}, std::runtime_error);
  }
}

TEST(Abandon, StopsAllSendingSoThatTheBenchDetectsALostMaster) {
  const BenchOnWire bench("--clock realtime");
  Session other(options_on_wire());
  auto axis = other.axis("1.1");
  ASSERT_TRUE(axis);
  {
    Session sut(options_on_wire());
    auto own = sut.axis("1.1");
    ASSERT_TRUE(own);
    ASSERT_TRUE(own->enable());
    sut.abandon();
    EXPECT_FALSE(own->halt());
    EXPECT_FALSE(own->acquire());
    const auto fault = axis->wait_until(
        [](const AxisSnapshot& seen) {
          return seen.status.error_code == 0x8130;
        },
        10s);
    ASSERT_TRUE(fault) << fault.outcome().message();
  }
  EXPECT_TRUE(axis->reset_fault()) << "the bench took the axis from the session that was abandoned";
}

TEST(SessionAcquire, TakesAllAxesOrNone) {
  const BenchOnWire bench("--clock lockstep");
  Session owner(options_on_wire());
  Session sut(options_on_wire());
  ASSERT_TRUE(owner.axis("1.2")->acquire());
  const std::array axes{AxisId{1, 1}, AxisId{1, 2}};
  const Outcome refused = sut.acquire(axes);
  EXPECT_EQ(refused.kind(), OutcomeKind::refused);
  EXPECT_EQ(refused.code(), 0x08000021U) << refused.message();
  EXPECT_EQ(sut.axis("1.1")->status()->owner_session, 0U);
  ASSERT_TRUE(owner.release(1));
  ASSERT_TRUE(sut.acquire(axes));
  for (const char* const name : {"1.1", "1.2"}) {
    EXPECT_EQ(sut.axis(name)->status()->owner_session, sut.id()) << name;
  }
}

TEST(SessionRelease, OfOneBenchKeepsTheAxesOfTheOtherBenches) {
  const BenchOnWire first("--clock lockstep --bench 1");
  const BenchOnWire second("--clock lockstep --bench 2");
  Session sut(options_on_wire());
  ASSERT_TRUE(sut.axis("1.1")->acquire());
  ASSERT_TRUE(sut.axis("2.1")->acquire());
  EXPECT_TRUE(sut.release(3)) << "of a bench that it has nothing of";
  ASSERT_TRUE(sut.release(1));
  EXPECT_EQ(sut.axis("1.1")->status()->owner_session, 0U);
  EXPECT_EQ(sut.axis("2.1")->status()->owner_session, sut.id());
  EXPECT_TRUE(sut.axis("1.1")->acquire()) << "it can be taken again";
}

}  // namespace
}  // namespace vdrive::client
