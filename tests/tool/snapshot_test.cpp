// SPDX-License-Identifier: Apache-2.0
// Taking and restoring snapshots by command.
#include "support/bench_on_wire.hpp"
#include "tool/call.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace vdrive::test {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(SnapshotByTool, MakesABranchWithTheSameResult) {
  const BenchOnWire bench("--clock lockstep");
  ASSERT_EQ(call("enable 1.1").code, 0);
  EXPECT_EQ(call("snapshot take").output, "bench 1 snapshot 1\n");
  const auto branch = [](const std::string& move) {
    EXPECT_EQ(call("snapshot restore 1").code, 0);
    EXPECT_EQ(call(move).code, 0);
    std::string status = call("read 1.1 0x6064 0x6062 0x3572 0x6077 0x606C 0x6041").output;
    return status;
  };
  const std::string first = branch("move 1.1 70 --velocity 1000");
  EXPECT_NE(branch("move 1.1 -30 --velocity 1000"), first);
  EXPECT_EQ(branch("move 1.1 70 --velocity 1000"), first);
  EXPECT_EQ(call("snapshot drop 1 --json").output,
            "{\"bench\":1,\"action\":\"drop\",\"snapshot\":1}\n");
  const Finished gone = call("snapshot restore 1");
  EXPECT_EQ(gone.code, 5);
  EXPECT_THAT(gone.errors, HasSubstr("no such snapshot"));
}

TEST(SnapshotByTool, IsRefusedWhileTimePasses) {
  const BenchOnWire bench("");
  const Finished refused = call("snapshot take");
  EXPECT_EQ(refused.code, 5);
  EXPECT_THAT(refused.errors, HasSubstr("only while time stands still"));
}

TEST(SnapshotByTool, WorksOnAPausedBench) {
  const BenchOnWire bench("--rate 0");
  EXPECT_EQ(call("snapshot take").code, 0);
  EXPECT_EQ(call("write 1.1 profile_velocity 4321").code, 0);
  EXPECT_EQ(call("snapshot restore 1").code, 0);
  EXPECT_THAT(call("read 1.1 profile_velocity").output, Not(HasSubstr("4321")));
}

}  // namespace
}  // namespace vdrive::test
