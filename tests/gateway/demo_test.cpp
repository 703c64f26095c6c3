// SPDX-License-Identifier: Apache-2.0
// `vdrive demo`: a bench, the gateway, and moving axes.
#include "support/test_domain.hpp"
#include "tool/process.hpp"
#include "vdrive/client/axis.hpp"
#include "vdrive/client/session.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <string>
#include <utility>
#include <vector>

namespace vdrive::test {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::MatchesRegex;

/// Calls the tool on the domain of these tests.
Process call(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"--domain", std::to_string(test_domain())});
  return {VDRIVE_TOOL, std::move(arguments)};
}

int waits_for_position(const std::string& axis, const std::string& comparison,
                       const std::string& value) {
  return call({"wait", axis, "position", comparison, value}).wait().code;
}

TEST(Demo, MovesTwoAxesToAndFroUntilItIsEnded) {
  Process demo = call({"demo", "--listen", "127.0.0.1:0"});
  EXPECT_THAT(demo.read_line(),
              MatchesRegex("vdrive: open http://127\\.0\\.0\\.1:[0-9]+/\\?token=[0-9a-f]{32}"));
  for (const std::string axis : {"1.1", "1.2"}) {
    EXPECT_EQ(waits_for_position(axis, ">", "7000"), 0);
    EXPECT_EQ(waits_for_position(axis, "<", "1000"), 0);
  }
  demo.send(SIGTERM);
  EXPECT_EQ(demo.wait().code, 130);
}

TEST(Demo, LeavesAnAxisToWhoeverTakesIt) {
  Process demo = call({"demo", "--listen", "127.0.0.1:0"});
  ASSERT_NE(demo.read_line(), "");
  {
    client::SessionOptions options;
    options.domain = test_domain();
    options.find_timeout = 20s;
    client::Session session(options);
    auto axis = session.axis("1.1");
    ASSERT_TRUE(axis) << axis.outcome().message();
    ASSERT_TRUE(axis->take_over());
    const client::Outcome moved = axis->move_to(-1000);
    EXPECT_TRUE(moved) << moved.message();
  }
  EXPECT_EQ(waits_for_position("1.1", ">", "7000"), 0) << "it goes on when the axis is free again";
  demo.send(SIGTERM);
  EXPECT_EQ(demo.wait().code, 130);
}

TEST(Demo, EndsWhenThePageCannotBeServed) {
  const Finished finished = call({"demo", "--listen", "192.0.2.1:1"}).wait();
  EXPECT_EQ(finished.code, 1);
  EXPECT_THAT(finished.errors, HasSubstr("192.0.2.1 port 1"));
}

TEST(Demo, IsForThisMachineOnly) {
  const Finished finished = call({"demo", "--peer", "192.0.2.1"}).wait();
  EXPECT_EQ(finished.code, 2);
  EXPECT_THAT(finished.errors, HasSubstr("--peer"));
}

}  // namespace
}  // namespace vdrive::test
