// SPDX-License-Identifier: Apache-2.0
// The black box of a service that is killed.
#include "client/session_options.hpp"
#include "support/temporary_directory.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

namespace vdrive::client {
namespace {

using namespace std::chrono_literals;
using testing::SizeIs;

constexpr ObjectAddress kOverTemperature{0x5E03, 0};  // test-bench input

TEST(WindowOfAKilledService, HasTheFaultThatTheServiceDidNotOutlive) {
  const test::TemporaryDirectory state;
  const std::string words =
      test::patient("--clock realtime --axes 2 --state " + state.path().string());
  auto service = std::make_unique<test::RunningService>(words);
  {
    Session session(test::options());
    Axis axis = session.axis("1.1").value();
    ASSERT_TRUE(axis.write(kOverTemperature, 1));
    // From the tick after the fault on, the window is being written to the disk.
    const auto is_there = [&] {
      return std::filesystem::exists(state.path() / "bench-1.window-1");
    };
    for (int round = 0; round < 1'000 && !is_there(); ++round) {
      ASSERT_TRUE(session.wait(1, 10ms));
    }
    ASSERT_TRUE(is_there());
    service->kill();
  }
  service = std::make_unique<test::RunningService>(words);
  Session session(test::options());
  const auto windows = session.windows(1);
  ASSERT_TRUE(windows) << windows.outcome().message();
  ASSERT_THAT(*windows, SizeIs(1));
  const WindowCause& cause = windows->front().causes.front();
  EXPECT_EQ(cause.kind, WindowCause::Kind::fault);
  EXPECT_EQ(cause.axis, 1);
  const std::vector<AxisId> axes{{1, 1}};
  const auto window = session.window(windows->front().number, axes);
  ASSERT_TRUE(window) << window.outcome().message();
  EXPECT_GE(window->samples.back().tick, cause.tick);
  EXPECT_EQ(window->samples.back().axes.front().status.error_code, cause.code);
}

}  // namespace
}  // namespace vdrive::client
