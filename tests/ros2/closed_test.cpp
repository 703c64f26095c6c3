// SPDX-License-Identifier: Apache-2.0
// vdrive-ros2 between a bench in closed mode and ROS nodes, whose topics are open.
#include "ros2/ros_peer.hpp"
#include "security/material.hpp"
#include "support/temporary_directory.hpp"
#include "support/test_domain.hpp"
#include "tool/process.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

namespace vdrive::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

namespace fs = std::filesystem;

/// A bench in closed mode, in real time, with a watchdog that does not trip on a busy machine.
class ClosedRosBench : public testing::Test {
 protected:
  ClosedRosBench() {
    const std::string file = directory_.path() / "bench.yaml";
    std::ofstream(file) << "watchdog: {timeout_ms: 10000}\naxes:\n"
                           "  - {number: 1, name: x}\n  - {number: 2, name: y}\n";
    service_.emplace(
        VDRIVE_SERVICE,
        std::vector<std::string>{"--domain", std::to_string(test_domain()), "--log-level", "error",
                                 "--config", file, "--security", member("service bench")});
  }

  void TearDown() override {
    service_->send(SIGTERM);
    (void)service_->wait();
  }

  [[nodiscard]] std::string member(const std::string& words) const {
    return authority_.member(words).string();
  }

 private:
  Authority authority_;
  TemporaryDirectory directory_;
  std::optional<Process> service_;
};

TEST_F(ClosedRosBench, MovesForABridgeWithTheIdentityOfAController) {
  RosPeer peer;
  RunningBridge bridge("--enable --security " + member("controller bridge"));
  ASSERT_TRUE(peer.wait_for_bridge());
  ASSERT_TRUE(peer.wait([&] {
    return peer.diagnosis("joint x") == "0 Operation enabled";
  })) << peer.log();
  // The limits are read after the axes are found; commands received before are ignored.
  EXPECT_TRUE(peer.wait([&] {
    peer.command({"x"}, {0.25});
    return std::abs(*peer.position("x") - 0.25) < 0.01;
  })) << peer.log();
}

TEST_F(ClosedRosBench, OnlyShowsItsStateToTheIdentityOfAViewer) {
  RosPeer peer;
  RunningBridge bridge("--enable --security " + member("viewer bridge"));
  ASSERT_TRUE(peer.wait_for_bridge()) << peer.log();
  ASSERT_TRUE(peer.wait_for_log("bench 1: cannot take control"));
  EXPECT_THAT(peer.log(), HasSubstr("the permissions of this identity do not allow commands"));
  peer.command({"x"}, {0.25});
  EXPECT_TRUE(peer.wait_for_log("joint x: is not under control of this bridge"));
  const auto state = peer.state("x");
  EXPECT_THAT(state->position, SizeIs(2));
  EXPECT_THAT(state->effort, IsEmpty()) << "the rated torque cannot be read";
  EXPECT_TRUE(peer.wait([&] {
    return peer.diagnosis("joint x") == "1 Switch on disabled";
  })) << peer.diagnosis("joint x");
}

TEST_F(ClosedRosBench, IsNotFoundWithoutCredentials) {
  RosPeer peer;
  const RunningService open("--clock realtime --bench 2");
  RunningBridge bridge;
  ASSERT_TRUE(peer.wait_for_bridge());
  EXPECT_THAT(peer.log(), Not(HasSubstr("bench 1")));
  EXPECT_EQ(peer.diagnosis("bench 1"), "");
}

}  // namespace
}  // namespace vdrive::test
